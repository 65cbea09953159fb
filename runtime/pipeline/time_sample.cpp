// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/time_sample.h"

#include <algorithm>
#include <map>
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
/// Of the pieces tried, the part that is tried again without trees, which takes longer.
constexpr int32_t kRebuiltPieces = 2;
/// Slabs of a print that is tried whole, as it would be printed.
constexpr int32_t kFewSlabs = 4;

/// What one slab takes.
struct Place {
    int32_t slab = 0;
    double seconds = 0;  ///< of the processor, for a whole slab
    double diced = 0;    ///< patches in that time
    double blocks = -1;  ///< -1: unknown
    bool tried = false;
    bool typical = true;  ///< of slabs near it: what they share with others is cached
};

class Sampler {
  public:
    Sampler(const Vec2<int32_t>& slabs, double seconds, const PatchNeeds& needs,
            const TrySlab& try_slab)
        : slabs_(slabs),
          left_(seconds),
          counting_left_(seconds / 2),
          needs_(needs),
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

    Result<SlabTrial> try_slab(const SlabTry& wanted) {
        Result<SlabTrial> trial = try_slab_(wanted);
        if (!trial) return trial;
        seconds_tried_ += trial->seconds;
        processor_tried_ += trial->processor_seconds;
        left_ -= spent(*trial);
        diced_ += static_cast<double>(trial->patches_diced);
        return trial;
    }

    static Place whole(int32_t slab, const SlabTrial& trial) {
        const double share = trial.share > 0 ? trial.share : 1;
        const auto all = [&](double begun, double sum) { return begun + (sum - begun) / share; };
        return {
            slab, all(trial.processor_seconds_begun, trial.processor_seconds),
            all(static_cast<double>(trial.patches_begun), static_cast<double>(trial.patches_diced)),
            static_cast<double>(trial.blocks), trial.share > 0};
    }

    void note_share(const SlabTrial& trial) {
        if (places_.empty()) share_ = trial.share;
    }

    bool is_tried(int32_t slab) const {
        return std::any_of(places_.begin(), places_.end(),
                           [&](const Place& p) { return p.slab == slab && p.tried; });
    }

    /// As in the print itself: what is diced is part of each slab's time.
    Result<void> try_all() {
        for (int32_t slab = slabs_.x; slab < slabs_.y; ++slab) {
            if (slab > slabs_.x && left_ <= 0) continue;
            const Result<SlabTrial> trial = try_slab({slab, kAllPieces, left_});
            if (!trial) return trial.error();
            note_share(*trial);
            Place place = whole(slab, *trial);
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
            const bool late = i > 1 && left_ <= took / 2;
            const Result<void> done = late ? count_blocks(first) : try_neighbours(first);
            if (!done) return done;
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

    /// Tries `first` and the slab above it, as far as they were not; in low prints places meet.
    Result<void> try_neighbours(int32_t first) {
        const int32_t second = first + 1;
        const bool has_second = second < slabs_.y && !is_tried(second);
        if (is_tried(first)) return has_second ? try_alone(second) : Result<void>();
        const Result<SlabTrial> cold = try_slab({first, kAllPieces, kCold * left_});
        if (!cold) return cold.error();
        note_share(*cold);
        Place place = whole(first, *cold);
        place.tried = places_.empty() || cold->share > kEnough;
        if (cold->share > kEnough && has_second && left_ > 0) {
            const int32_t pieces = cold->share < 1 ? cold->pieces : kAllPieces;
            const Result<SlabTrial> warm = try_slab({second, pieces, left_});
            if (!warm) return warm.error();
            if (warm->share > kEnough * cold->share) {
                place.typical = false;
                const Place above = whole(second, *warm);
                compare(place, above);
                places_.push_back(above);
                if (const Result<void> done = rebuild(*cold, second, *warm); !done) return done;
            }
        }
        places_.push_back(place);
        return {};
    }

    /// Tries a slab whose neighbour was tried.
    Result<void> try_alone(int32_t slab) {
        const Result<SlabTrial> trial = try_slab({slab, kAllPieces, left_});
        if (!trial) return trial.error();
        places_.push_back(whole(slab, *trial));
        places_.back().tried = trial->share > kEnough;
        return {};
    }

    /// Of a place that is not tried.
    Result<void> count_blocks(int32_t slab) {
        if (is_tried(slab)) return {};
        Place place;
        place.slab = slab;
        if (counting_left_ > 0 && places_.front().blocks > 0) {
            const Result<SlabTrial> trial = try_slab_({slab, 0, counting_left_});
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

    /// Returns the seconds that dicing a patch takes.
    double of_patch() const {
        return more_diced_ > 0 ? std::max(0.0, more_seconds_ / more_diced_) : 0.0;
    }

    /// Learns what it takes to build the trees of a patch again, from the first place whose slab needs
    /// more than there is room for: there a print builds those of each patch twice, whole ones first,
    /// and once these are evicted smaller ones of its pieces. Of the pieces of a slab that fill a part
    /// of the room, about that part is evicted before it is needed again, and built once more.
    Result<void> rebuild(const SlabTrial& cold, int32_t slab, const SlabTrial& warm) {
        const auto bytes_of_slab = static_cast<double>(cold.tree_bytes) / cold.share;
        if (of_rebuilt_ > 0 || left_ <= 0 || bytes_of_slab <= static_cast<double>(needs_.tree_room))
            return {};
        const int32_t pieces = std::max(cold.pieces / kRebuiltPieces, 1);
        const Result<SlabTrial> again = try_slab({slab, pieces, left_, true});
        if (!again) return again.error();
        const auto of_blocks = [&](const SlabTrial& trial) {
            const auto diced = static_cast<double>(trial.patches_diced - trial.patches_begun);
            return trial.processor_seconds - trial.processor_seconds_begun - of_patch() * diced;
        };
        const double seconds =
            of_blocks(*again) - std::max(0.0, of_blocks(warm)) * again->share / warm.share;
        // By bytes: of the patches at the ends of pieces only some trees are built again.
        if (again->tree_bytes > 0 && cold.patches_diced > 0) {
            const auto bytes = static_cast<double>(again->tree_bytes);
            const double filled =
                std::min(1.0, bytes / again->share / static_cast<double>(needs_.tree_room));
            of_rebuilt_ = (1 + filled) * std::max(0.0, seconds / bytes) *
                          static_cast<double>(cold.tree_bytes) /
                          static_cast<double>(cold.patches_diced);
        }
        return {};
    }

    TimeSample conclude() const {
        TimeSample out;
        out.share = share_;
        double sum = 0, blocks = 0;
        std::map<int32_t, double> tried;
        for (const Place& place : places_) {
            if (!place.tried) continue;
            tried[place.slab] = steady(place);
            if (!place.typical) continue;
            ++out.places;
            sum += tried[place.slab];
            blocks += place.blocks;
        }
        if (processor_tried_ <= 0) {
            out.places = 0;
            return out;
        }
        const double mean = out.places > 0 ? sum / out.places : 0;
        std::map<int32_t, double> typical;
        double slowest = 0;
        for (const Place& place : places_) {
            if (!place.typical) continue;
            double seconds = mean;
            if (place.tried) {
                seconds = tried[place.slab];
            } else if (place.blocks >= 0 && blocks > 0) {
                seconds = sum / blocks * place.blocks;
            }
            typical[place.slab] = seconds;
            slowest = std::max(slowest, place.tried ? place.seconds : seconds);
        }
        // Some patches are never needed, which is known where all slabs were tried.
        const bool all = static_cast<int32_t>(tried.size()) == count();
        const double patches = all ? diced_ : std::max(static_cast<double>(needs_.patches), diced_);
        out.dicing_seconds = (of_patch() + of_rebuilt_) * patches;
        out.processor_seconds = all_slabs(tried, typical) + out.dicing_seconds;
        const double clock = seconds_tried_ / processor_tried_;
        out.seconds = out.processor_seconds * clock;
        out.slowest_slab_seconds = slowest * clock;
        return out;
    }

    /// Returns the seconds of all slabs, each like itself or the nearest typical one.
    double all_slabs(const std::map<int32_t, double>& tried,
                     const std::map<int32_t, double>& typical) const {
        double all = 0;
        auto near = typical.begin();
        for (int32_t slab = slabs_.x; slab < slabs_.y; ++slab) {
            for (auto next = near; ++next != typical.end();) {
                if (next->first - slab > slab - near->first) break;
                near = next;
            }
            const auto found = tried.find(slab);
            all += found != tried.end() ? found->second : near->second;
        }
        return all;
    }

    /// Without dicing. What is left is at least something, however that was estimated.
    double steady(const Place& place) const {
        constexpr double kLeast = 0.1;
        return std::max(place.seconds - of_patch() * place.diced, kLeast * place.seconds);
    }

    Vec2<int32_t> slabs_;
    double left_, counting_left_;  ///< seconds for trials, and then for counting blocks
    PatchNeeds needs_;
    const TrySlab& try_slab_;
    std::vector<Place> places_;  ///< each slab at most once
    double seconds_tried_ = 0, processor_tried_ = 0;
    double diced_ = 0;  ///< in all trials
    double more_seconds_ = 0, more_diced_ = 0;
    double of_rebuilt_ = 0;  ///< seconds for the trees of a patch that are built again
    double share_ = 1;
};

}  // namespace

Result<TimeSample> sample_time(const Vec2<int32_t>& slabs, double seconds, const PatchNeeds& needs,
                               const TrySlab& try_slab) {
    return Sampler(slabs, seconds, needs, try_slab).sample();
}

}  // namespace openfab::pipeline
