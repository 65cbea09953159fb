// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes a world of a mesh file: an object for each of its bodies, with the stock fablet, materials,
// pictures and numbers that make it look as in the file.

#include <optional>
#include <string>
#include <vector>

#include "mesh/load/load_beams.h"
#include "mesh/load/load_mesh.h"
#include "tools/openfab/import_fields.h"
#include "tools/openfab/import_pictures.h"

namespace openfab::tools {

struct ImportOptions {
    std::string fablet;  ///< a stock fablet; empty: what fits each body
    std::string printer = "generic";
    bool mesh_colors = false;          ///< the printer takes them (`world::Printer`)
    std::string picture;               ///< a file instead of the mesh's own pictures
    std::string profile;               ///< a table of inks (`openfab color bake`); empty: a formula
    std::optional<double> largest_mm;  ///< size along the longest side; default: unchanged
    std::string mapping;               ///< uv, planar, box or triplanar; empty: chosen by the mesh
    std::string side;                  ///< planar: front, right, …; empty: the largest
    std::optional<double> picture_mm;  ///< size of one picture; default: that of the mesh
    bool one_material = false;         ///< all bodies of one material
    bool y_up = false;                 ///< of the file; the mesh is already rotated
    bool repair = false;               ///< write `"repair": "winding"` to the world
    std::vector<mesh::LatticeInfo> lattices;  ///< of the file, beside its bodies
    ImportedFields fields;                    ///< of the file: more objects, and fablets of bodies
    int64_t memory_bytes = mesh::kDefaultReadingBytes;  ///< limit for the picture
};

struct Import {
    std::vector<std::string> fablets;  ///< stock fablets, and those that are the file's own
    std::string world;                 ///< text of NAME.fab.json
    std::vector<ImportedFile> files;   ///< the fablets' sources and the pictures
    std::vector<std::string> notes;
};

/// Makes the files; `file` is the mesh's name in the folder. Errors: a fablet that needs
/// coordinates, colours or a picture that are missing; more than 254 materials.
Result<Import> make_import(const mesh::LoadedBodies& loaded, const Pictures& pictures,
                           const std::string& file, const ImportOptions& options);

}  // namespace openfab::tools
