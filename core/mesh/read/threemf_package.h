// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The package around the models of a 3MF file: where the model is, and which parts are encrypted.

#include <cstdint>
#include <set>
#include <string>

#include "base/result.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {

struct ThreemfPackage {
    std::string model;                ///< the part with the build, as it is written
    std::set<std::string> encrypted;  ///< keys of parts that the secure content extension hides

    /// Reads a part; one that is encrypted is an error.
    Result<std::string> read(const ZipFile& zip, const std::string& name, const std::string& file,
                             int64_t memory_bytes) const;
};

Result<ThreemfPackage> read_threemf_package(const ZipFile& zip, const std::string& file,
                                            int64_t memory_bytes);

}  // namespace openfab::mesh
