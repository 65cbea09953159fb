// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The objects that the build of a 3MF file places, with their components, for readers of what is not meshes.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "base/result.h"
#include "base/vec.h"
#include "mesh/read/threemf_extensions.h"
#include "mesh/read/threemf_model.h"
#include "mesh/read/threemf_package.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {

/// An object in its place.
struct ThreemfPlaced {
    const ThreemfModel* model = nullptr;  ///< the part that it is in
    int64_t id = 0;
    const ThreemfObject* object = nullptr;
    Affine3d map;      ///< into the build, in the file's unit
    std::string name;  ///< its own, else that of what holds it

    /// "object `NAME`", for messages.
    std::string place() const;
};

class ThreemfBuild {
  public:
    /// Decreases `*memory_bytes` by the size of the parts that are read. Both pointers are kept.
    ThreemfBuild(ZipFile zip, std::string file, int64_t* memory_bytes, ThreemfTold* told)
        : zip_(std::move(zip)),
          file_(std::move(file)),
          memory_bytes_(*memory_bytes),
          told_(*told) {}

    /// Reads the part with the build.
    Result<const ThreemfModel*> root();
    /// Calls visit for each object that is placed, and for its components after it, until one is an error.
    Result<void> each(const std::function<Result<void>(const ThreemfPlaced&)>& visit);
    /// The parts that were read, at fixed addresses.
    std::map<std::string, ThreemfModel> take_parts() { return std::move(parts_); }

  private:
    Error error(const std::string& what, const std::string& help = {}) const;
    Result<const ThreemfModel*> part(const std::string& from, const std::string& name);
    Result<void> place(const ThreemfModel& from, const std::string& path,
                       const ThreemfPlacement& placement, const Affine3d& at, size_t depth,
                       const std::string& holder);

    ZipFile zip_;
    std::string file_;
    int64_t& memory_bytes_;
    ThreemfTold& told_;
    std::optional<ThreemfPackage> package_;
    std::map<std::string, ThreemfModel> parts_;
    const std::function<Result<void>(const ThreemfPlaced&)>* visit_ = nullptr;
    int64_t placements_ = 0;
};

}  // namespace openfab::mesh
