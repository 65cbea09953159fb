// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/trays.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace openfab::tools {

namespace {

constexpr double kSlack_mm = 1e-6;
constexpr double kNowhere = 1e300;

/// A tray that is filled from the front: what is free lies behind a skyline of steps along x.
class Tray {
  public:
    Tray(const Vec3d& size, double gap) : size_(size), gap_(gap) {
        steps_.push_back({0, size.x + gap, 0});
    }

    /// Returns where the back of a box would be, as far to the front and then to the left as it goes; kNowhere
    /// where there is no room.
    double find(const Vec3d& box, Vec3d* at) const {
        double best = kNowhere;
        for (size_t i = 0; i < steps_.size(); ++i) {
            const double x = steps_[i].from;
            if (x + box.x > size_.x + kSlack_mm) break;
            double y = 0;
            for (size_t j = i; j < steps_.size() && steps_[j].from < x + box.x + gap_ - kSlack_mm;
                 ++j)
                y = std::max(y, steps_[j].y);
            const double back = y + box.y;
            if (back > size_.y + kSlack_mm || !(back < best - kSlack_mm)) continue;
            best = back;
            *at = {x, y, 0};
        }
        return best;
    }

    /// Raises the skyline by a box and the gap around it.
    void put(const Vec3d& box, const Vec3d& at) {
        const double to = at.x + box.x + gap_, y = at.y + box.y + gap_;
        std::vector<Step> made;
        const auto add = [&](const Step& step) {
            if (step.to - step.from < kSlack_mm) return;
            if (!made.empty() && made.back().y == step.y) {
                made.back().to = step.to;
            } else {
                made.push_back(step);
            }
        };
        for (const Step& step : steps_) {
            add({step.from, std::min(step.to, at.x), step.y});
            if (step.from <= at.x && at.x < step.to) add({at.x, to, y});
            add({std::max(step.from, to), step.to, step.y});
        }
        steps_ = std::move(made);
    }

  private:
    struct Step {
        double from, to, y;
    };
    Vec3d size_;
    double gap_;
    std::vector<Step> steps_;  ///< along x
};

}  // namespace

std::vector<std::array<double, 9>> right_angled(Turns turns) {
    std::vector<std::array<double, 9>> all{
        {1, 0, 0, 0, 1, 0, 0, 0, 1},  {0, -1, 0, 1, 0, 0, 0, 0, 1}, {1, 0, 0, 0, 0, -1, 0, 1, 0},
        {0, 0, 1, 0, 1, 0, -1, 0, 0}, {0, 0, 1, 1, 0, 0, 0, 1, 0},  {0, -1, 0, 0, 0, -1, 1, 0, 0}};
    all.resize(turns == Turns::kNone ? 1 : turns == Turns::kUpright ? 2 : all.size());
    return all;
}

namespace {

constexpr size_t kUprightPoses = 2;

/// In which order things are put, and whether one that fits as it is is turned.
struct Way {
    bool by_longest_side = false;
    bool keep_poses = false;
};

class Filler {
  public:
    Filler(const std::vector<std::vector<Pose>>& things, const Vec3d& tray_mm, double gap_mm)
        : things_(things), tray_mm_(tray_mm), gap_mm_(gap_mm) {}

    std::vector<Spot> run(const Way& way) {
        trays_.clear();
        std::vector<Spot> out;
        for (const size_t thing : order(way)) {
            Spot spot;
            spot.thing = static_cast<int32_t>(thing);
            if (put(things_[thing], way, &spot)) out.push_back(spot);
        }
        return out;
    }

    /// Returns how many trays a filling takes, and how far its last one is filled.
    std::pair<int32_t, double> taken(const std::vector<Spot>& spots) const {
        int32_t trays = 0;
        double back = 0;
        for (const Spot& spot : spots) {
            const Box3d& box = things_[static_cast<size_t>(spot.thing)][spot.pose].box;
            if (spot.tray + 1 > trays) trays = spot.tray + 1, back = 0;
            if (spot.tray + 1 == trays) back = std::max(back, box.hi.y + spot.move_mm.y);
        }
        return {trays, back};
    }

  private:
    bool fits(const Pose& pose) const {
        const Vec3d size = pose.box.size();
        return size.x <= tray_mm_.x + kSlack_mm && size.y <= tray_mm_.y + kSlack_mm &&
               size.z <= tray_mm_.z + kSlack_mm;
    }

    std::vector<size_t> order(const Way& way) const {
        std::vector<double> measure(things_.size());
        for (size_t i = 0; i < measure.size(); ++i) {
            const Vec3d size = things_[i][0].box.size();
            measure[i] = way.by_longest_side ? std::max(size.x, size.y) : size.x * size.y;
        }
        std::vector<size_t> out(things_.size());
        std::iota(out.begin(), out.end(), size_t{0});
        std::stable_sort(out.begin(), out.end(),
                         [&](size_t a, size_t b) { return measure[a] > measure[b]; });
        return out;
    }

    /// Returns the poses that may be taken: on its side only what fits no other way.
    std::vector<size_t> possible(const std::vector<Pose>& poses, const Way& way) const {
        std::vector<size_t> out;
        for (size_t p = 0; p < poses.size(); ++p) {
            if (p >= kUprightPoses && !out.empty()) break;
            if (fits(poses[p])) out.push_back(p);
            if (way.keep_poses && !out.empty()) break;
        }
        return out;
    }

    bool put(const std::vector<Pose>& poses, const Way& way, Spot* spot) {
        const std::vector<size_t> possible_poses = possible(poses, way);
        if (possible_poses.empty()) return false;
        for (size_t t = 0;; ++t) {
            if (t == trays_.size()) trays_.emplace_back(tray_mm_, gap_mm_);
            double best = kNowhere;
            Vec3d where;
            for (const size_t p : possible_poses) {
                Vec3d at;
                const double back = trays_[t].find(poses[p].box.size(), &at);
                if (!(back < best)) continue;
                best = back;
                where = at;
                spot->pose = p;
            }
            if (best == kNowhere) continue;
            spot->tray = static_cast<int32_t>(t);
            spot->move_mm = where - poses[spot->pose].box.lo;
            trays_[t].put(poses[spot->pose].box.size(), where);
            return true;
        }
    }

    const std::vector<std::vector<Pose>>& things_;
    const Vec3d tray_mm_;
    const double gap_mm_;
    std::vector<Tray> trays_;
};

}  // namespace

std::vector<Spot> put_on_trays(const std::vector<std::vector<Pose>>& things, const Vec3d& tray_mm,
                               double gap_mm) {
    Filler filler(things, tray_mm, gap_mm);
    std::vector<Spot> best;
    std::pair<int32_t, double> least;
    for (const Way& way :
         {Way{false, true}, Way{false, false}, Way{true, true}, Way{true, false}}) {
        std::vector<Spot> made = filler.run(way);
        const std::pair<int32_t, double> taken = filler.taken(made);
        if (!best.empty() && !(taken < least)) continue;
        least = taken;
        best = std::move(made);
    }
    return best;
}

}  // namespace openfab::tools
