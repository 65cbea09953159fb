// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One `.model` part of a 3MF file: its objects, property groups and build items, as written.

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::mesh {

/// A list of properties with an id, which triangles refer to.
struct ThreemfGroup {
    enum class Kind { kMaterials, kColors, kCoordinates, kMulti, kOther };
    Kind kind = Kind::kOther;
    std::vector<std::string> names;             ///< materials
    std::vector<std::array<double, 3>> values;  ///< colours, linear; coordinates u, v
    std::vector<int64_t> layers;                ///< multi: group ids
    std::vector<std::vector<int64_t>> picks;    ///< multi: for each, an index into each layer
};

struct ThreemfTriangle {
    std::array<int32_t, 3> vertices{};
    int64_t group = -1;                             ///< -1: the object's
    std::array<int64_t, 3> properties{-1, -1, -1};  ///< by corner; -1: the object's
};

/// An object placed in another, or in the build.
struct ThreemfPlacement {
    int64_t object = 0;
    std::string path;  ///< of the model part that has it; empty: the same
    Affine3d transform;
};

struct ThreemfObject {
    std::string name;
    std::string type = "model";
    int64_t group = -1;
    int64_t property = 0;
    std::vector<Vec3d> vertices;
    std::vector<ThreemfTriangle> triangles;
    std::vector<ThreemfPlacement> components;
};

struct ThreemfModel {
    double unit_mm = 1;
    std::map<int64_t, ThreemfGroup> groups;
    std::map<int64_t, ThreemfObject> objects;
    std::vector<ThreemfPlacement> build;
    bool has_beams = false;
};

/// Returns the material name of faces with texture group `id` and no base material.
inline std::string threemf_texture_name(const std::string& id) {
    return "texture " + id;
}

/// Parses a model part. Errors are `file:line:column: …`. Vertices that triangles refer to exist;
/// other ids are not checked. Decreases `*memory_bytes` by the size of the model; an error if it is
/// not enough.
Result<ThreemfModel> parse_threemf_model(std::string_view text, const std::string& file,
                                         int64_t* memory_bytes);

}  // namespace openfab::mesh
