// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes a world from a mesh file and its appearance: which stock fablet, with which materials,
// pictures and numbers.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/load/load_mesh.h"
#include "tools/openfab/appearance.h"

namespace openfab::tools {

struct ImportOptions {
    std::string fablet;  ///< a stock fablet; empty: chosen by the mesh's attributes
    std::string printer = "generic";
    std::string picture;               ///< a file instead of the mesh's own pictures
    std::string profile;               ///< a table of inks (`openfab color bake`); empty: a formula
    std::optional<double> largest_mm;  ///< size along the longest side; default: unchanged
    std::string mapping;               ///< uv, planar, box or triplanar; empty: chosen by the mesh
    std::string side;                  ///< planar: front, right, …; empty: the largest
    std::optional<double> picture_mm;  ///< size of one picture; default: that of the mesh
    bool y_up = false;                 ///< of the file; the mesh is already rotated
    bool repair = false;               ///< write `"repair": "winding"` to the world
    int64_t memory_bytes = mesh::kDefaultReadingBytes;  ///< limit for the picture
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

/// Makes the files; `file` is the mesh's name in the folder. Errors: a fablet that needs
/// coordinates, colours or a picture that are missing; more than 64 materials.
Result<Import> make_import(const mesh::LoadedMesh& mesh, const Appearances& appearances,
                           const std::string& file, const ImportOptions& options);

}  // namespace openfab::tools
