// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a mesh file and its looks to a world: which stock fablet, with which materials, pictures and
// numbers.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/load/load_mesh.h"
#include "tools/openfab/looks.h"

namespace openfab::tool {

struct ImportOptions {
    std::string fablet;  ///< a stock fablet; empty: by what the mesh has
    std::string printer = "generic";
    std::string picture;               ///< a file instead of the mesh's own pictures
    std::optional<double> largest_mm;  ///< size along the longest side; else as it is
    std::string mapping;  ///< uv, planar, box or triplanar; empty: by what the mesh has
    std::string side;     ///< planar: front, right, …; empty: the largest
    std::optional<double> picture_mm;  ///< size of one picture; else as large as the mesh
    bool y_up = false;                 ///< of the file; the mesh stands already
    bool repair = false;               ///< the world says `"repair": "winding"`
    int64_t memory_bytes = scene::kReadingBytes;  ///< that the picture may take
};

/// A file to be written into the folder.
struct ImportedFile {
    std::string name;
    SharedBytes bytes;
};

struct Import {
    std::string fablet;
    std::string world;                ///< text of NAME.fab.json
    std::vector<ImportedFile> files;  ///< the fablet's source and the pictures
    std::vector<std::string> notes;
};

/// `file` is the mesh's name in the folder. Errors: a fablet that needs coordinates, colours or a
/// picture which are not there; more than 64 materials.
Result<Import> make_import(const scene::LoadedMesh& mesh, const Looks& looks,
                           const std::string& file, const ImportOptions& options);

}  // namespace openfab::tool
