// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Ranges of the @nearest inputs below each node of a tree, for bounds of cubes.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/nearest/engine.h"
#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

class LazyTreelets;
class PatchUnits;

/// The ranges of all nodes of one tree.
class NodeRanges {
  public:
    /// Computes the ranges bottom-up. `treelets` and `units` are those that leaves of the tree name,
    /// or null.
    NodeRanges(const Tree& tree, const surface::PatchRanges& patches, const LazyTreelets* treelets,
               const PatchUnits* units);

    /// Adds the case of a node to `out`.
    void add_case(size_t node, float distance_lo, BoxBounds* out) const;
    size_t bytes() const;

  private:
    void add(size_t node, const float* float_lo, const float* float_hi, const int32_t* int_lo,
             const int32_t* int_hi);
    void add_patch(size_t node, int32_t patch, const surface::PatchRanges& r);

    size_t floats_, ints_;
    std::vector<float> float_lo_, float_hi_;  // [node][component]
    std::vector<int32_t> int_lo_, int_hi_;
};

}  // namespace openfab::nearest
