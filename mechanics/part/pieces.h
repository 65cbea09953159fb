// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What hangs together: elements that share faces. What shares an edge alone turns about it.

#include <span>
#include <string>
#include <vector>

#include "mechanics/part/surface.h"

namespace openfab::mechanics {

struct Piece {
    int64_t elements = 0;
    std::array<int32_t, 3> low{}, high{};  ///< of its elements
};

struct Pieces {
    std::vector<int32_t> of;  ///< of each element; -1: not solid
    std::vector<Piece> all;   ///< the largest first
};

Pieces pieces_of(const Grid& grid, std::span<const uint8_t> kind);

/// A degree of freedom that is held: its number and where it is moved.
struct Held {
    int64_t dof;
    double move_mm;
};

/// How a piece may still move though the given ones are held: "slide along x"; empty where it may not.
std::string free_motion(const Grid& grid, const Vec3& origin_mm, std::span<const Held> held);

}  // namespace openfab::mechanics
