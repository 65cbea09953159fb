// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Triangle meshes with named attributes, in millimetres of mesh space.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"

namespace openfab::mesh {

/// Default memory limit of reading.
constexpr int64_t kDefaultReadingBytes = 8'000'000'000;

/// A named attribute. Float attributes are per corner, indexed by values/indices, so that a UV seam
/// is two indices at one vertex; int attributes are per face.
struct MeshAttribute {
    std::string name;
    bool is_int = false;
    int32_t components = 1;
    std::vector<float> values;  ///< is_int false: components per value
    std::vector<std::array<int32_t, 3>>
        corners;                 ///< is_int false: value index of each triangle's corners
    std::vector<int32_t> faces;  ///< is_int true: components per triangle
};

/// A triangle mesh.
struct Mesh {
    std::string name;
    std::vector<Vec3d> positions;                   ///< mm
    std::vector<std::array<int32_t, 3>> triangles;  ///< counter-clockwise seen from outside
    std::vector<MeshAttribute> attributes;  ///< "uv" (2), "n" (3), "face" (int), … by name

    const MeshAttribute* find(const std::string& attribute) const {
        for (const MeshAttribute& a : attributes) {
            if (a.name == attribute) return &a;
        }
        return nullptr;
    }
};

}  // namespace openfab::mesh
