// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/time_sample.h"

#include <array>

namespace openfab::pipeline {

Result<TimeSample> sample_time(const Vec2<int32_t>& slabs, const std::atomic<bool>& stop,
                               const std::function<Result<SlabTrial>(int32_t slab)>& try_slab) {
    // Of equal parts of the height; each prefix is spread over all of it.
    constexpr std::array<int32_t, 7> kParts{3, 0, 6, 1, 5, 2, 4};
    // Of a slab that was stopped: less tells little of the whole.
    constexpr double kEnough = 0.1;
    const int32_t count = slabs.y - slabs.x;
    const auto parts = static_cast<int32_t>(kParts.size());
    TimeSample sample;
    double sum = 0, blocks = 0;
    for (const int32_t part : kParts) {
        // In low prints several places are in one slab.
        if (stop.load() || sample.places == count) break;
        const int32_t first = slabs.x + (2 * part + 1) * count / (2 * parts);
        Result<SlabTrial> trial = try_slab(first);
        if (!trial) return trial.error();
        bool warm = false;
        if (trial->share == 1 && first + 1 < slabs.y && !stop.load()) {
            const Result<SlabTrial> second = try_slab(first + 1);
            if (!second) return second.error();
            warm = second->share > kEnough;
            if (warm) trial = second;
        }
        if (sample.places == 0) {
            sample.share = trial->share;
        } else if (!warm && stop.load() && blocks > 0) {
            trial->seconds = sum / blocks * static_cast<double>(trial->blocks);
        }
        sum += trial->seconds;
        blocks += static_cast<double>(trial->blocks);
        ++sample.places;
    }
    if (sample.places > 0) sample.seconds = sum / sample.places * count;
    return sample;
}

}  // namespace openfab::pipeline
