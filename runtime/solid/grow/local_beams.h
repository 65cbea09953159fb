// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The beams of a place, gathered from clumps, with the same tree, coverage and engine as beams of a file have:
// what they answer for points of that place is what all beams would.

#include <memory>

#include "runtime/solid/beams/beam_engine.h"
#include "runtime/solid/grow/grown.h"

namespace openfab::solid {

class LocalBeams {
  public:
    /// Takes beams, which are sorted as they grow unless `keep_order`. `fablet`: whose @nearest inputs the
    /// values are; null where nothing reads them.
    void set(const GatheredBeams& from, const Vec3d& center_part_mm, const openfab_fablet* fablet,
             bool keep_order = false);
    bool empty() const { return tree_ == nullptr; }
    const BeamTree& tree() const { return *tree_; }
    const BeamAttributes* attributes() const { return attributes_.get(); }

  private:
    part::PartBeams source_;
    std::unique_ptr<const BeamTree> tree_;
    std::unique_ptr<const BeamAttributes> attributes_;
};

}  // namespace openfab::solid
