// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which pieces of a mesh lie inside which.

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mesh/model/mesh.h"

namespace openfab::mesh {

/// The nesting of closed pieces of a mesh.
struct Nesting {
    /// By piece: those that it lies in with all of its volume. What fills a hollow exactly, or
    /// touches from outside, lies in nothing.
    std::vector<std::vector<int32_t>> inside;
    /// Pairs of pieces that share volume, and neither lies in the other; the lower number first.
    std::vector<std::pair<int32_t, int32_t>> overlaps;
};

/// Samples points just inside each piece, so that crossings of small corners may be missed. Empty
/// where that takes too long. `pieces`: the piece of each triangle, -1: of none.
std::optional<Nesting> find_nesting(const Mesh& mesh, std::span<const int32_t> pieces,
                                    int32_t count);

}  // namespace openfab::mesh
