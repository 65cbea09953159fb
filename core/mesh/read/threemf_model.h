// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One `.model` part of a 3MF file: its objects, property groups and build items, as written.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "mesh/model/look.h"
#include "mesh/read/threemf_extensions.h"
#include "mesh/read/threemf_fields.h"
#include "mesh/read/threemf_lattice.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {

/// A list of properties with an id, which triangles refer to.
struct ThreemfGroup {
    enum class Kind { kMaterials, kColors, kCoordinates, kComposites, kMulti };
    Kind kind = Kind::kMaterials;
    std::vector<std::string> names;    ///< materials
    std::vector<bool> colored;         ///< materials: whether there is a display colour
    std::vector<ThreemfColor> values;  ///< of materials and colours; coordinates u, v
    int64_t source = -1;               ///< coordinates: the texture; composites: the materials
    std::vector<int64_t> layers;       ///< multi: group ids; composites: indices of materials
    std::vector<bool> multiplied;      ///< multi: how layers from the second are blended
    std::vector<std::vector<int64_t>> picks;  ///< multi: for each, an index into each layer
    std::vector<std::vector<double>> shares;  ///< composites: of the materials
};

struct ThreemfTexture {
    std::string path;
    std::array<PictureWrap, 2> wrap{PictureWrap::kRepeat, PictureWrap::kRepeat};
    bool nearest = false;
};

struct ThreemfTriangle {
    std::array<int32_t, 3> vertices{};
    int64_t group = -1;                             ///< -1: the object's
    std::array<int64_t, 3> properties{-1, -1, -1};  ///< by corner; -1: the object's
};

struct ThreemfDisplaced;      // threemf_displaced.h
struct ThreemfDisplacements;  // threemf_displaced.h

/// An object placed in another, or in the build.
struct ThreemfPlacement {
    int64_t object = 0;
    std::string path;  ///< of the model part that has it; empty: the same
    Affine3d transform;
    bool printable = true;
};

struct ThreemfObject {
    std::string name;
    std::string type = "model";
    int64_t group = -1;
    int64_t property = 0;
    std::vector<Vec3d> vertices;
    std::vector<ThreemfTriangle> triangles;
    std::vector<ThreemfPlacement> components;
    /// A boolean shape: of the components the first is cut by the others, united with them, or
    /// something that is not read.
    enum class Shape { kMesh, kDifference, kUnion, kOther } shape = Shape::kMesh;
    bool stand_in = false;  ///< the mesh is coarser than what is printed, which are slices
    int32_t extruder = 0;   ///< of Cura, from 1; 0: not said
    std::string helper;     ///< what it is for in Cura, if it is not printed
    /// Triangles that a slicer's user painted, and how.
    std::vector<std::pair<int32_t, std::string>> paints;
    bool paint_escapes = false;  ///< PrusaSlicer's second version: 14 announces two digits
    /// By triangle: the filament of its paint, from 1, or 0; empty if none is painted.
    std::vector<int16_t> filaments;
    std::vector<int32_t> sources;                ///< by triangle: that of the file; empty: the same
    std::shared_ptr<ThreemfLattice> lattice;     ///< null: it has none
    std::shared_ptr<ThreemfLevelSet> level_set;  ///< null: it is none
    int64_t volume = -1;                         ///< of a mesh: its volumetric data
    std::shared_ptr<ThreemfDisplaced> displaced;  ///< null: its surface is as it is
};

struct ThreemfModel {
    double unit_mm = 1;
    std::map<int64_t, ThreemfGroup> groups;
    std::map<int64_t, ThreemfTexture> textures;
    std::map<int64_t, ThreemfObject> objects;
    ThreemfFields fields;
    std::shared_ptr<ThreemfDisplacements> displacements;  ///< null: it has none
    std::vector<ThreemfPlacement> build;
};

/// Parses a model part. Errors are `file:line:column: …`. Vertices that triangles refer to exist;
/// other ids are not checked. Decreases `*memory_bytes` by the size of the model; an error if it is
/// not enough. What is left out is added to `*told`.
Result<ThreemfModel> parse_threemf_model(std::string_view text, const std::string& file,
                                         int64_t* memory_bytes, ThreemfTold* told);

}  // namespace openfab::mesh
