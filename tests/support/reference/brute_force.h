// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The reference that nearest-point engines are compared with: plain loops over all micropolygons,
// no pruning.

#include <array>
#include <memory>

#include "runtime/nearest/engine.h"

namespace openfab::reference {

/// Makes an engine that searches every micropolygon of `surface`, which must outlive it. `frame` is
/// from part::make_frame.
std::unique_ptr<nearest::Engine> make_brute_force_engine(
    const surface::Surface& surface, const std::array<float, OPENFAB_FRAME_COUNT>& frame);

}  // namespace openfab::reference
