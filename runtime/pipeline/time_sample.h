// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Estimates the time of a print from a few of its slabs.

#include <cstdint>
#include <functional>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::pipeline {

/// What it took to print a slab, or some of its rows, on trial.
struct SlabTrial {
    double seconds = 0, processor_seconds = 0;  ///< of the trial itself
    int64_t patches_diced = 0;                  ///< of displaced surfaces
    /// The part of these that went into coverage and culling, which are of the whole slab.
    double processor_seconds_begun = 0;
    int64_t patches_begun = 0;
    int64_t tree_bytes = 0;  ///< of the trees of patches that were built
    double share = 1;        ///< of the slab's blocks, those that were printed
    int32_t pieces = 0;      ///< that were begun, see TrySlab
    int64_t blocks = 0;      ///< that culling left in the whole slab; -1: stopped before
};

constexpr int32_t kAllPieces = INT32_MAX;

/// What to print of a slab: pieces of it, one by one, until some seconds are over. Pieces are rows
/// that lie side by side, in an order that spreads them over the slab.
struct SlabTry {
    int32_t slab = 0;
    int32_t pieces = kAllPieces;  ///< at most; 0: only counts its blocks
    double seconds = 0;
    bool drop_trees = false;  ///< the trees of displaced patches that are cached
};

using TrySlab = std::function<Result<SlabTrial>(const SlabTry&)>;

/// The displaced patches of a print.
struct PatchNeeds {
    int64_t patches = 0;
    int64_t tree_room = 0;  ///< bytes of the cache of their trees
};

/// The time of a print, estimated.
struct TimeSample {
    double seconds = 0;            ///< at least this long if `share` is 0
    double processor_seconds = 0;  ///< of all threads
    double dicing_seconds = 0;     ///< of these, for displaced patches
    double slowest_slab_seconds = 0;
    double share = 1;    ///< of the only slab, if it was stopped
    int32_t places = 0;  ///< from which there is a time; 0: stopped before
};

/// Tries slabs of [slabs.x, slabs.y) spread over the height, the middle first, for so many seconds;
/// of a low print all of them. What is diced once, and found cached by later slabs, is told from what
/// every slab takes by trying two neighbours; the whole print dices all patches; or what the trials
/// did, if that is more or they were of all slabs. Where one slab needs more trees than their cache
/// holds, what it takes to build them again counts, too. Where time is over before a place was tried,
/// its blocks count like those of the others; a slab that is none of these counts like the nearest.
Result<TimeSample> sample_time(const Vec2<int32_t>& slabs, double seconds, const PatchNeeds& needs,
                               const TrySlab& try_slab);

}  // namespace openfab::pipeline
