// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads the meshes of a world that are files. They are loaded together, in parallel, once the world has
// named all.

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "base/json.h"
#include "mesh/load/load_mesh.h"
#include "world/json_reader.h"
#include "world/world.h"
#include "world/world_files.h"

namespace openfab::world {

class MeshFilesReader {
  public:
    MeshFilesReader(JsonReader* json, WorldFiles* files, World* world)
        : json_(*json), files_(*files), world_(*world) {}

    /// Adds an empty mesh to the world, which load() fills from the file that `value` names.
    void read(const JsonMember& m, const JsonValue& value, const std::string& what, bool repair);

    /// Loads all files in parallel; warnings and errors keep the order of the world. Returns the bytes of
    /// their meshes.
    int64_t load(int64_t memory_bytes);

    /// Adds the warnings of units and sizes, once it is known where the meshes are built: not those of a mesh that each
    /// placement scales to a likely size.
    void warn_of_sizes();

    /// Returns where the last of the files is named; null if there is none.
    const JsonValue* last() const {
        return mesh_files_.empty() ? nullptr : mesh_files_.back().value;
    }

  private:
    struct MeshFile {
        size_t index = 0;  ///< in world_.meshes
        std::filesystem::path file;
        mesh::MeshOptions options;
        const JsonValue* value = nullptr;
    };
    /// The meshes of one file, which is read once: with one unit, and either all of bodies, or one of
    /// the whole.
    struct MeshLoad {
        std::vector<size_t> meshes;  ///< indices in mesh_files_
        uintmax_t file_bytes = 0;
    };
    std::vector<MeshLoad> loads() const;

    JsonReader& json_;
    WorldFiles& files_;
    World& world_;
    std::vector<MeshFile> mesh_files_;
    /// A mesh, and what is to be said of its unit and size.
    std::vector<std::pair<size_t, std::vector<std::string>>> of_size_;
};

}  // namespace openfab::world
