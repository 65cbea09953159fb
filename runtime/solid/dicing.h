// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/surface/surface.h"

namespace openfab::solid {

/// What of a solid is made where something comes near, and kept in a cache: patches that are diced, clumps that
/// grow.
class Dicing {
  public:
    virtual ~Dicing() = default;
    /// Changes the budget of what is kept; call while no other thread uses it.
    virtual void set_cache_bytes(size_t bytes) const = 0;
    /// Returns whether bounds of the distances of points and blocks may have to make it, as queries may.
    virtual bool for_bounds() const { return true; }
    /// Returns how many patches would be diced if all were needed.
    virtual int64_t patches() const { return 0; }
    /// Returns how many micropolygons may lie around a point (surface/crowding.h).
    virtual double crowding() const { return 0; }
    /// Returns the bytes that indices over it will take, before they are made; queries need more.
    virtual int64_t index_bytes(bool /*asked*/) const { return 0; }
    virtual surface::SurfaceCounts counts() const { return {}; }
};

}  // namespace openfab::solid
