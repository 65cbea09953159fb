// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The least number of pieces of a box, by trying all cuts that can matter.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "base/vec.h"
#include "pieces/tree.h"

namespace openfab::pieces {

/// Cuts a box by planes across it, each through all of what it cuts, into as few pieces as fit a tray in any
/// right-angled pose. A plane may always be moved until what is behind it is as long as trays' sides in a row, so
/// that only sums of these are tried.
class BoxPlan {
  public:
    explicit BoxPlan(const Vec3d& tray_mm) : tray_(tray_mm) {}

    /// Returns the number of pieces; 0 where there are too many ways to try them all.
    int32_t least(const Vec3d& size_mm);
    /// Returns the cuts, after least(box.size()) has found them. Pieces have no names.
    Tree tree(const Box3d& box);

  private:
    struct Best {
        int32_t pieces = 0;
        int axis = 0;
        double at_mm = 0;
    };
    using Key = std::array<int64_t, 3>;

    const Best& best(const Vec3d& size_mm);
    std::vector<double> sums(double most_mm) const;
    void cut(const Box3d& box, int32_t leaf, Tree* tree);

    Vec3d tray_;
    std::map<Key, Best> known_;
};

}  // namespace openfab::pieces
