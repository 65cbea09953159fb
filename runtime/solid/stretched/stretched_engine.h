// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Queries of a stretched solid, answered by its source.

#include <array>
#include <memory>

#include "base/vec.h"
#include "runtime/nearest/engine.h"
#include "runtime/part/stretch.h"

namespace openfab::solid {

/// The map from part-local space of a source to that of the stretched part, which has no shift.
class Stretch {
  public:
    explicit Stretch(const std::array<double, 9>& by)
        : map_{by, {}}, back_{part::inverse_stretch(by), {}}, least_(part::stretch_range(by).x) {}

    const Affine3d& map() const { return map_; }
    /// What distances of the source are multiplied by.
    double least() const { return least_; }
    Vec3f to(const Vec3f& p) const {
        return vec_cast<float>(map_.apply_vector(vec_cast<double>(p)));
    }
    Vec3d back(const Vec3d& p) const { return back_.apply_vector(p); }
    /// Maps the points of all lanes; what is not finite stays so.
    nearest::PointPacket back(const nearest::PointPacket& packet) const;

  private:
    Affine3d map_, back_;
    double least_;
};

/// `source` must outlive it, as must that of a scratch, whose statistics it takes over.
std::unique_ptr<nearest::Engine> make_stretched_engine(const nearest::Engine& source,
                                                       const Stretch& stretch);
std::unique_ptr<nearest::Engine::Scratch> make_stretched_scratch(nearest::Engine::Scratch* source);

}  // namespace openfab::solid
