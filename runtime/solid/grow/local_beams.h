// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The beams of a place, gathered from clumps, with the same tree, coverage and engine as beams of a file have:
// what they answer for points of that place is what all beams would.

#include <memory>
#include <vector>

#include "runtime/nearest/targets.h"
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
    size_t size() const { return tree_ == nullptr ? 0 : tree_->beams().size(); }
    const BeamTree& tree() const { return *tree_; }
    const BeamAttributes* attributes() const { return attributes_.get(); }

  private:
    part::PartBeams source_;
    std::unique_ptr<const BeamTree> tree_;
    std::unique_ptr<const BeamAttributes> attributes_;
};

/// The bodies of a place, gathered from clumps, likewise.
class LocalBodies {
  public:
    struct Body {
        GrownBody body;
        Box3f box;        ///< part space
        Vec3f normal;     ///< where a point was answered last
        size_t from = 0;  ///< its place among the gathered
    };

    /// As LocalBeams::set.
    void set(const GatheredBeams& from, const openfab_fablet* fablet, bool keep_order = false);
    bool empty() const { return bodies_.empty(); }
    size_t size() const { return bodies_.size(); }
    std::vector<Body>& bodies() { return bodies_; }
    const std::vector<Body>& bodies() const { return bodies_; }

    /// Writes the values of @nearest inputs to [component][place] where `body` is one, and leaves others.
    void read(size_t body, size_t place, const nearest::AttributeTargets& targets) const;
    /// Adds a body's values to the cases of a box.
    void add_case(size_t body, float distance_lo, nearest::BoxBounds* out) const;
    size_t floats() const { return floats_; }
    size_t ints() const { return ints_; }

  private:
    std::vector<Body> bodies_;
    size_t floats_ = 0, ints_ = 0;
    std::vector<float> values_;
    std::vector<uint32_t> flat_;
};

}  // namespace openfab::solid
