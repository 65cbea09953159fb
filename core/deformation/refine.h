// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Divides triangles, so that what moves their corners moves what lies between them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/vec.h"

namespace openfab::deformation {

/// A triangle soup with shared corners, and others that come with it, such as texture coordinates.
struct Surface {
    std::vector<Vec3d> positions;
    std::vector<std::array<int32_t, 3>> triangles;
    /// Values of so many numbers each at the corners of triangles.
    struct Attribute {
        int32_t components = 1;
        std::vector<float> values;
        std::vector<std::array<int32_t, 3>> corners;
    };
    std::vector<Attribute> attributes;
};

/// Divides edges in the middle until none is longer than `longest_mm`. Neighbours agree about their edge, so
/// that a closed surface stays closed. Returns the triangle that each came from; nothing where there would be
/// more than `most` triangles.
std::optional<std::vector<int32_t>> refine(double longest_mm, size_t most, Surface* surface);

}  // namespace openfab::deformation
