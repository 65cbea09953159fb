// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Beams that a displacement of space moves.

#include <cstddef>
#include <functional>
#include <optional>

#include "mesh/model/beams.h"

namespace openfab::program {

/// Moves a place in the space of the beams; nothing where it has none to go to.
using MovePlace = std::function<std::optional<Vec3d>(const Vec3d& p)>;

struct MovedBeams {
    mesh::Beams beams;
    std::optional<Vec3d> lost;  ///< a place that could not be moved
    bool too_many = false;      ///< there would be more pieces than wanted
};

/// Moves beams with their nodes. Struts are divided until none is longer than `longest_mm`, as `length_mm`
/// measures them; floats of nodes are interpolated. A radius changes by the mean of what happens to
/// distances across the beam: where that is not alike all round, the surface is off by at most half the
/// difference.
MovedBeams move_beams(const mesh::Beams& from, double longest_mm, size_t most_beams,
                      const std::function<double(const Vec3d& a, const Vec3d& b)>& length_mm,
                      const MovePlace& move);

}  // namespace openfab::program
