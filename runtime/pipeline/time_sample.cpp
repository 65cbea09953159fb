// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/time_sample.h"

#include <algorithm>
#include <vector>

namespace openfab::pipeline {

namespace {

/// The height is divided into 2^k - 1 equal parts, whose middles are tried: 7, or more where the first
/// of them, the middle of all, takes little time.
constexpr int kLeastBits = 3, kMostBits = 6;
/// Of the time, what places may take in which the middle one's time is that of all.
constexpr double kPlaces = 0.6;
/// Of a slab that was stopped: less tells little of the whole.
constexpr double kEnough = 0.05;
/// Of the time that is left, what the first of two neighbours may take; the second finds more cached.
constexpr double kCold = 2.0 / 3;
/// Slabs of a print that is tried whole, as it would be printed.
constexpr int32_t kFewSlabs = 4;

/// What one place of the height takes.
struct Place {
    double seconds = 0;  ///< of the processor, for a whole slab
    double diced = 0;    ///< patches in that time
    double blocks = -1;  ///< -1: unknown
    bool tried = false;
};

class Sampler {
  public:
    Sampler(const Vec2<int32_t>& slabs, double seconds, int64_t patches, const TrySlab& try_slab)
        : slabs_(slabs),
          left_(seconds),
          counting_left_(seconds / 2),
          patches_(patches),
          try_slab_(try_slab) {}

    Result<TimeSample> sample() {
        const Result<void> done = count() <= kFewSlabs ? try_all() : try_places();
        if (!done) return done.error();
        return conclude();
    }

  private:
    int32_t count() const { return slabs_.y - slabs_.x; }

    /// As a deadline counts on a machine that has little time for this process.
    static double spent(const SlabTrial& trial) {
        return std::min(trial.seconds, std::max(trial.processor_seconds, trial.seconds / 10));
    }

    Result<SlabTrial> try_slab(int32_t slab, int32_t pieces, double seconds) {
        Result<SlabTrial> trial = try_slab_(slab, pieces, seconds);
        if (!trial) return trial;
        seconds_tried_ += trial->seconds;
        processor_tried_ += trial->processor_seconds;
        left_ -= spent(*trial);
        diced_ += static_cast<double>(trial->patches_diced);
        return trial;
    }

    static Place whole(const SlabTrial& trial) {
        const double share = trial.share > 0 ? trial.share : 1;
        const auto all = [&](double begun, double sum) { return begun + (sum - begun) / share; };
        return {
            all(trial.processor_seconds_begun, trial.processor_seconds),
            all(static_cast<double>(trial.patches_begun), static_cast<double>(trial.patches_diced)),
            static_cast<double>(trial.blocks), trial.share > 0};
    }

    void note_share(const SlabTrial& trial) {
        if (places_.empty()) share_ = trial.share;
    }

    /// As in the print itself: what is diced is part of each slab's time.
    Result<void> try_all() {
        for (int32_t slab = slabs_.x; slab < slabs_.y; ++slab) {
            if (slab > slabs_.x && left_ <= 0) {
                places_.push_back({});
                continue;
            }
            const Result<SlabTrial> trial = try_slab(slab, kAllPieces, left_);
            if (!trial) return trial.error();
            note_share(*trial);
            Place place = whole(*trial);
            place.diced = 0;
            place.tried = slab == slabs_.x || trial->share > kEnough;
            places_.push_back(place);
        }
        return {};
    }

    Result<void> try_places() {
        const double seconds = left_;
        double took = 0;  // the first place
        int bits = kLeastBits;
        for (int32_t i = 1; i < 1 << bits; ++i) {
            const int32_t parts = (1 << bits) - 1;
            const int32_t first =
                slabs_.x +
                static_cast<int32_t>((2 * int64_t{part_of(i, bits)} + 1) * count() / (2 * parts));
            // Little of a slab tells less than its blocks.
            if (i > 1 && left_ <= took / 2) {
                if (const Result<void> counted = count_blocks(first); !counted) return counted;
                continue;
            }
            const Result<SlabTrial> cold = try_slab(first, kAllPieces, kCold * left_);
            if (!cold) return cold.error();
            note_share(*cold);
            Place place = whole(*cold);
            place.tried = places_.empty() || cold->share > kEnough;
            if (cold->share > kEnough && first + 1 < slabs_.y && left_ > 0) {
                const Result<SlabTrial> warm =
                    try_slab(first + 1, cold->share < 1 ? cold->pieces : kAllPieces, left_);
                if (!warm) return warm.error();
                if (warm->share > kEnough * cold->share) {
                    compare(place, whole(*warm));
                    place = whole(*warm);
                }
            }
            places_.push_back(place);
            if (i == 1) took = seconds - left_;
            // Two neighbours each, so that no slab is tried twice.
            while (i == 1 && bits < kMostBits && (4 << bits) <= count() &&
                   (2 << bits) * took < kPlaces * seconds)
                ++bits;
        }
        return {};
    }

    /// Returns the i-th part to be tried, from 1, the middle of all: each prefix is spread over the
    /// height, as numbers with their bits in reverse are.
    static int32_t part_of(int32_t i, int bits) {
        int32_t part = 0;
        for (int bit = 0; bit < bits; ++bit)
            part |= (i >> bit & 1) << (bits - 1 - bit);
        return part - 1;
    }

    /// Of a place that is not tried.
    Result<void> count_blocks(int32_t slab) {
        Place place;
        if (counting_left_ > 0 && places_.front().blocks > 0) {
            const Result<SlabTrial> trial = try_slab_(slab, 0, counting_left_);
            if (!trial) return trial.error();
            counting_left_ -= spent(*trial);
            diced_ += static_cast<double>(trial->patches_diced);
            place.blocks = static_cast<double>(trial->blocks);
        }
        places_.push_back(place);
        return {};
    }

    /// Learns from two neighbours what dicing a patch takes.
    void compare(const Place& cold, const Place& warm) {
        const double like = warm.blocks > 0 ? cold.blocks / warm.blocks : 1;
        more_seconds_ += cold.seconds - warm.seconds * like;
        more_diced_ += cold.diced - warm.diced * like;
    }

    TimeSample conclude() const {
        TimeSample out;
        out.share = share_;
        const double of_patch = more_diced_ > 0 ? std::max(0.0, more_seconds_ / more_diced_) : 0.0;
        double sum = 0, blocks = 0;
        for (const Place& place : places_) {
            if (!place.tried) continue;
            ++out.places;
            sum += steady(place, of_patch);
            blocks += place.blocks;
        }
        if (processor_tried_ <= 0) {
            out.places = 0;
            return out;
        }
        double all = 0, slowest = 0;
        for (const Place& place : places_) {
            double seconds = out.places > 0 ? sum / out.places : 0;
            if (place.tried) {
                seconds = steady(place, of_patch);
            } else if (place.blocks >= 0 && blocks > 0) {
                seconds = sum / blocks * place.blocks;
            }
            all += seconds;
            slowest = std::max(slowest, place.tried ? place.seconds : seconds);
        }
        const double dicing = of_patch * std::max(static_cast<double>(patches_), diced_);
        out.processor_seconds = all / static_cast<double>(places_.size()) * count() + dicing;
        const double clock = seconds_tried_ / processor_tried_;
        out.seconds = out.processor_seconds * clock;
        out.slowest_slab_seconds = slowest * clock;
        return out;
    }

    /// Without dicing. What is left is at least something, however that was estimated.
    static double steady(const Place& place, double of_patch) {
        constexpr double kLeast = 0.1;
        return std::max(place.seconds - of_patch * place.diced, kLeast * place.seconds);
    }

    Vec2<int32_t> slabs_;
    double left_, counting_left_;  ///< seconds for trials, and then for counting blocks
    int64_t patches_;
    const TrySlab& try_slab_;
    std::vector<Place> places_;
    double seconds_tried_ = 0, processor_tried_ = 0;
    double diced_ = 0;  ///< in all trials
    double more_seconds_ = 0, more_diced_ = 0;
    double share_ = 1;
};

}  // namespace

Result<TimeSample> sample_time(const Vec2<int32_t>& slabs, double seconds, int64_t patches,
                               const TrySlab& try_slab) {
    return Sampler(slabs, seconds, patches, try_slab).sample();
}

}  // namespace openfab::pipeline
