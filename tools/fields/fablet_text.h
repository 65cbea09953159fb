// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Level sets and volumetric data of a 3MF file as fablets, with what a world must bind to them.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "mesh/read/threemf_build.h"

namespace openfab::tools {

struct FieldMaterial {
    std::string uniform;
    std::string name;                            ///< as in the file; empty: it says none
    std::optional<std::array<double, 3>> color;  ///< linear
};

/// A volume that is looked up: the sheets of an image, and how.
struct FieldImage {
    std::string uniform;
    int64_t image = 0;  ///< id of the image3d
    std::vector<std::string> sheets;
    std::array<int64_t, 3> size{};  ///< columns, rows, sheets
    bool repeats = false, nearest = false;
};

/// A picture of heights.
struct FieldMap {
    std::string uniform;
    std::string source;  ///< its part of the package
    std::array<mesh::PictureWrap, 2> wrap{};
    bool nearest = false;
};

/// A mesh that is written as a file: what bounds a level set, or what a function asks the distance of.
struct FieldMesh {
    std::string uniform;  ///< empty: it is the object itself
    std::string name;
    std::string obj;        ///< text of the file, in mm
    bool is_beams = false;  ///< which is of nodes and struts
};

struct FieldFablet {
    std::string name;    ///< of the object
    std::string fablet;  ///< of its fablet and file
    std::string source;
    /// Of a level set: the box that its `@Shape` is in; or it has none, and is a mesh that is void outside.
    std::optional<Box3d> box_mm;
    std::vector<FieldMesh> meshes;
    std::vector<FieldMaterial> materials;
    bool inks = false;  ///< mixes cyan, magenta, yellow, black and white
    std::vector<FieldImage> images;
    std::vector<FieldMap> maps;
    double most_displacement_mm = 0;
    std::vector<std::string> notes;
};

/// Returns the fablet of a level set; `to_mm` brings the file's build to part space, `file` is for messages.
Result<FieldFablet> level_set_fablet(const mesh::ThreemfPlaced& placed, const Affine3d& to_mm,
                                     const std::string& file, const std::string& fablet);

/// Same, of a mesh that has volumetric data, or is displaced, or both.
Result<FieldFablet> mesh_fablet(const mesh::ThreemfPlaced& placed, const Affine3d& to_mm,
                                const std::string& file, const std::string& fablet);

}  // namespace openfab::tools
