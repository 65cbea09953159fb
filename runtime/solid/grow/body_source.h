// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A source of clumps that knows solids by number, of which copies stand in what grows.

#include <memory>
#include <vector>

#include "runtime/part/shape_stage.h"
#include "runtime/solid/grow/clump.h"
#include "runtime/solid/kind.h"

namespace openfab::solid {

class BodySource : public ClumpSource {
  public:
    /// `bodies`: solids of the stage's bodies; null ones cannot be placed.
    BodySource(const part::ShapeStage& stage, const Bodies& bodies, openfab_isa isa);

    bool has_bodies() const override { return !standing_.empty(); }
    Result<void> status() const override;
    void set_stop(const std::atomic<bool>* stop) const override;
    size_t share_bytes(size_t bytes) const override;

  protected:
    const std::vector<std::shared_ptr<const Standing>>& standing() const { return standing_; }
    const QuerySetUp& queries() const { return queries_; }
    /// Returns whether a box lies in another, but for what floats lose.
    static bool holds(const Box3f& outer, const Box3f& inner);
    /// Returns a point as messages have it.
    static std::string text(const Vec3f& p);

  private:
    const QuerySetUp queries_;
    std::vector<std::shared_ptr<const Standing>> standing_;
};

}  // namespace openfab::solid
