// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A dense box of voxels with a number each, as inspections look at prints, and what they find.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::inspection {

/// Values of all voxels, x fastest.
template <typename T>
struct Box {
    Vec3i size;
    std::vector<T> values;

    Box() = default;
    explicit Box(const Vec3i& of, T value = {})
        : size(of),
          values(static_cast<size_t>(of.x) * static_cast<size_t>(of.y) * static_cast<size_t>(of.z),
                 value) {}
    size_t at(int32_t x, int32_t y, int32_t z) const {
        return (static_cast<size_t>(z) * static_cast<size_t>(size.y) + static_cast<size_t>(y)) *
                   static_cast<size_t>(size.x) +
               static_cast<size_t>(x);
    }
    bool holds(int32_t x, int32_t y, int32_t z) const {
        return x >= 0 && y >= 0 && z >= 0 && x < size.x && y < size.y && z < size.z;
    }
};

using Bits = Box<uint8_t>;  ///< 0 or 1

/// Voxels that belong together.
struct Cluster {
    int64_t voxels = 0;
    Box3i box;               ///< hi exclusive
    Vec3i first;             ///< the lowest one, in order of z, y, x
    bool at_border = false;  ///< of the whole box

    /// Adds `count` voxels of a box along x; in order of z, y, x.
    void add(const Vec3i& p, int32_t count, const Vec3i& size) {
        if (voxels == 0) first = p;
        voxels += count;
        const Box3i added{p, {p.x + count, p.y + 1, p.z + 1}};
        box.add(added);
        for (int axis = 0; axis < 3; ++axis)
            at_border |= added.lo[axis] == 0 || added.hi[axis] == size[axis];
    }
};

}  // namespace openfab::inspection
