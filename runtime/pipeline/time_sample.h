// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Estimates the time of a print from a few of its slabs.

#include <atomic>
#include <cstdint>
#include <functional>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::pipeline {

/// The time that one slab took on trial.
struct SlabTrial {
    double seconds = 0;  ///< of the whole slab, scaled up from the share
    double share = 1;    ///< of the slab's blocks, those that were printed before it was stopped
    int64_t blocks = 0;  ///< that culling left
};

/// The time of a print, estimated.
struct TimeSample {
    double seconds = 0;  ///< at least this long if `share` is 0
    double share = 1;    ///< of the only slab, if it was stopped
    int32_t places = 0;  ///< from which there is a time; 0: stopped before
};

/// Tries slabs of [slabs.x, slabs.y) spread over the height, the middle first, until there is a
/// time from each of a few places or `stop` is set. A slab that is tried first builds what later
/// slabs find cached, so two neighbours are tried and the second one counts. Where time is
/// over before that, the blocks of the first count like those of the places before.
Result<TimeSample> sample_time(const Vec2<int32_t>& slabs, const std::atomic<bool>& stop,
                               const std::function<Result<SlabTrial>(int32_t slab)>& try_slab);

}  // namespace openfab::pipeline
