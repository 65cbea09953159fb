// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/inspection/thickness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/at.h"

#include "tools/inspection/components.h"
#include "tools/inspection/distances.h"

namespace openfab::inspection {

namespace {

constexpr uint16_t kFar = Squares::kFar;

// Of a voxel.
constexpr uint8_t kSet = 1;        // it belongs to what is looked at
constexpr uint8_t kRest = 2;       // the balls of a radius leave it
constexpr uint8_t kThin = 4;       // and it is no edge
constexpr uint8_t kUncovered = 8;  // the largest balls leave it

/// The steps to the 26 neighbours, those of faces first.
struct Neighbours {
    std::array<Vec3i, 26> steps;
    std::array<double, 26> mm{};
    std::array<ptrdiff_t, 26> offsets{};

    Neighbours(const Vec3i& size, const Vec3d& pitch_mm) {
        size_t count = 0;
        for (const int32_t squares : {1, 2, 3}) {
            for (int32_t i = 0; i < 27; ++i) {
                const Vec3i d{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
                if (dot(d, d) == squares) steps[count++] = d;
            }
        }
        for (size_t i = 0; i < steps.size(); ++i) {
            const Vec3i& d = steps[i];
            mm[i] = length(Vec3d{d.x * pitch_mm.x, d.y * pitch_mm.y, d.z * pitch_mm.z});
            offsets[i] =
                (static_cast<ptrdiff_t>(d.z) * size.y + d.y) * static_cast<ptrdiff_t>(size.x) + d.x;
        }
    }
};

/// The box of voxels with a margin of one or more, so that all neighbours of what is set are in it.
class Opening {
  public:
    Opening(Bits bits, int outside, const Vec3d& pitch_mm, double below_mm)
        : pitch_(pitch_mm),
          coarse_(std::max({pitch_mm.x, pitch_mm.y, pitch_mm.z})),
          radius_(below_mm / 2),
          margin_(thin_margin(outside, pitch_mm, below_mm)),
          state_(bits.size + margin_ + margin_, outside != 0 ? kSet : uint8_t{0}),
          around_(state_.size, pitch_mm),
          depths_(pitch_mm, radius_ + coarse_) {
        for (int32_t z = 0; z < bits.size.z; ++z) {
            for (int32_t y = 0; y < bits.size.y; ++y) {
                const uint8_t* from = &bits.values[bits.at(0, y, z)];
                std::copy(from, from + bits.size.x,
                          &state_.values[state_.at(margin_.x, y + margin_.y, z + margin_.z)]);
            }
        }
    }

    /// Marks what is thin. Returns whether there is any.
    bool mark() {
        depth_ = Box<uint16_t>(state_.size);
        for (size_t i = 0; i < state_.values.size(); ++i)
            depth_.values[i] = state_.values[i] != 0 ? kFar : uint16_t{0};
        depths_.spread(&depth_);
        near_ = Box<uint16_t>(state_.size);
        mark_by(radius_);
        constexpr double kLeast = 1.5, kFiner = 0.70710678118654752;
        for (double radius = radius_ * kFiner; radius >= kLeast * coarse_; radius *= kFiner)
            mark_by(radius);
        mark_necks();
        near_ = {};
        return std::any_of(state_.values.begin(), state_.values.end(),
                           [](uint8_t s) { return (s & kThin) != 0; });
    }

    /// Returns all that belongs to what is marked: the balls in it that touch its surface.
    std::vector<Thin> collect() {
        cover();
        Box<int32_t> labels;
        const std::vector<Cluster> clusters = components(state_, Touch::kCorners, &labels, kRest);
        std::vector<Thin> out(clusters.size());
        std::vector<std::vector<Vec3i>> ridges(clusters.size());
        for (size_t i = 0; i < clusters.size(); ++i) {
            out[i].where = clusters[i];
            out[i].where.first = clusters[i].first - margin_;
            out[i].where.box = {clusters[i].box.lo - margin_, clusters[i].box.hi - margin_};
        }
        for_inner([&](const Vec3i& p, size_t at) {
            if (labels.values[at] == 0) return;
            const auto of = static_cast<size_t>(labels.values[at] - 1);
            if (on_surface(at)) out[of].voxels.push_back(p - margin_);
            if (on_ridge(at) || ridges[of].empty()) ridges[of].push_back(p);
        });
        tbb::parallel_for(size_t{0}, out.size(), [&](size_t i) {
            constexpr size_t kMost = 48;
            const size_t every = ridges[i].size() / kMost + 1;
            for (size_t k = every / 2; k < ridges[i].size(); k += every)
                out[i].middles.push_back(ridges[i][k] - margin_);
            out[i].thickness_mm = thickness(out[i].middles);
        });
        return out;
    }

  private:
    template <typename With>
    void for_inner(const With& with) const {
        for (int32_t z = 1; z + 1 < state_.size.z; ++z) {
            for (int32_t y = 1; y + 1 < state_.size.y; ++y) {
                size_t at = state_.at(1, y, z);
                for (int32_t x = 1; x + 1 < state_.size.x; ++x, ++at)
                    with(Vec3i{x, y, z}, at);
            }
        }
    }
    size_t beside(size_t at, size_t neighbour) const {
        return static_cast<size_t>(static_cast<ptrdiff_t>(at) + around_.offsets[neighbour]);
    }
    bool is_set(size_t at) const { return (state_.values[at] & kSet) != 0; }
    bool on_surface(size_t at) const {
        for (size_t n = 0; n < 6; ++n) {
            if (!is_set(beside(at, n))) return true;
        }
        return false;
    }
    bool on_ridge(size_t at) const {
        if ((state_.values[at] & kThin) == 0) return false;
        for (size_t n = 0; n < around_.offsets.size(); ++n) {
            if (depth_.values[beside(at, n)] > depth_.values[at]) return false;
        }
        return true;
    }

    /// How far the centre of a ball of a radius may be from an edge that is `depth_mm` deep.
    double edge_reach(double radius, double depth_mm) const {
        constexpr double kSlack = 1;  // voxels
        return (radius - std::max(depth_mm - coarse_, 0.0)) / kEdgeSlope + kSlack * coarse_;
    }

    void mark_by(double radius) {
        const Squares nears(pitch_, edge_reach(radius, 0));
        const uint16_t fits = depths_.from(radius), covers = nears.from(radius);
        for (size_t i = 0; i < near_.values.size(); ++i)
            near_.values[i] = depth_.values[i] >= fits ? uint16_t{0} : kFar;
        nears.spread(&near_);
        const bool largest = radius == radius_;
        if (largest) look_between(nears, fits, covers);
        std::vector<size_t> rest = rest_of(covers);
        if (largest) {
            for (const size_t at : rest)
                state_.values[at] |= kUncovered;
        }
        leave_edges(nears, radius, rest);
    }

    /// Marks what is left by balls, and returns it.
    std::vector<size_t> rest_of(uint16_t covers) {
        std::vector<std::vector<size_t>> by_slice(static_cast<size_t>(state_.size.z));
        tbb::parallel_for(0, state_.size.z, [&](int32_t z) {
            const size_t begin = state_.at(0, 0, z), end = state_.at(0, 0, z + 1);
            for (size_t at = begin; at < end; ++at) {
                state_.values[at] &= static_cast<uint8_t>(~kRest);
                if (!is_set(at) || near_.values[at] < covers) continue;
                state_.values[at] |= kRest;
                openfab::at(by_slice, z).push_back(at);
            }
        });
        std::vector<size_t> out;
        for (std::vector<size_t>& slice : by_slice) {
            out.insert(out.end(), slice.begin(), slice.end());
            slice = {};
        }
        return out;
    }

    /// Lets balls lie between voxel centres, too, where that can matter.
    void look_between(const Squares& nears, uint16_t fits, uint16_t covers) {
        const double half = 0.5 * length(pitch_);
        const uint16_t almost = depths_.from(std::max(radius_ - half, 0.0));
        Box3i where;
        for_inner([&](const Vec3i& p, size_t at) {
            if (is_set(at) && near_.values[at] >= covers && depth_.values[at] >= almost)
                where.add(p);
        });
        if (where.empty()) return;
        const double reach = edge_reach(radius_, 0) + radius_ + 2 * coarse_;
        for (int axis = 0; axis < 3; ++axis) {
            const auto steps = static_cast<int32_t>(std::min(reach / pitch_[axis], 1e6)) + 1;
            where.lo[axis] = std::max(where.lo[axis] - steps, 0);
            where.hi[axis] = std::min(where.hi[axis] + steps + 1, state_.size[axis]);
        }
        Box<uint16_t> part(where.size());
        for (int32_t parity = 1; parity < 8; ++parity) {
            const Vec3i half_steps{parity & 1, parity >> 1 & 1, parity >> 2};
            for_rows(where, part, [&](size_t from, size_t to, size_t count) {
                for (size_t i = 0; i < count; ++i)
                    part.values[to + i] = is_set(from + i) ? kFar : uint16_t{0};
            });
            depths_.spread(&part, half_steps);
            for (uint16_t& value : part.values)
                value = value >= fits ? uint16_t{0} : kFar;
            nears.spread(&part, half_steps * -1);
            for_rows(where, part, [&](size_t from, size_t to, size_t count) {
                for (size_t i = 0; i < count; ++i)
                    near_.values[from + i] = std::min(near_.values[from + i], part.values[to + i]);
            });
        }
    }
    template <typename With>
    void for_rows(const Box3i& box, const Box<uint16_t>& part, const With& with) const {
        tbb::parallel_for(box.lo.z, box.hi.z, [&](int32_t z) {
            for (int32_t y = box.lo.y; y < box.hi.y; ++y)
                with(state_.at(box.lo.x, y, z), part.at(0, y - box.lo.y, z - box.lo.z),
                     static_cast<size_t>(part.size.x));
        });
    }

    /// Marks what is left as thin, but for edges: what has a ball near enough, by a way within the body. The lengths of ways
    /// replace, in near_, the squares of distances through anything.
    void leave_edges(const Squares& nears, double radius, const std::vector<size_t>& rest) {
        const double unit = edge_reach(radius, 0) / 30000;
        const auto in_units = [&](double mm) {
            return static_cast<uint16_t>(std::min(mm / unit, double{kFar}));
        };
        for (const size_t at : rest)
            near_.values[at] = kFar;
        std::array<uint16_t, 26> steps{};
        for (size_t n = 0; n < steps.size(); ++n)
            steps[n] = in_units(around_.mm[n]);
        std::vector<size_t> reached, next;
        for (const size_t at : rest) {
            double least = 1e300;
            for (size_t n = 0; n < steps.size(); ++n) {
                const size_t other = beside(at, n);
                if ((state_.values[other] & (kSet | kRest)) == kSet)
                    least = std::min(least, nears.length(near_.values[other]) + around_.mm[n]);
            }
            if (least >= 1e300) continue;
            near_.values[at] = in_units(least);
            reached.push_back(at);
        }
        while (!reached.empty()) {
            next.clear();
            for (const size_t at : reached) {
                for (size_t n = 0; n < steps.size(); ++n) {
                    const size_t other = beside(at, n);
                    if ((state_.values[other] & kRest) == 0) continue;
                    const auto way = static_cast<uint16_t>(near_.values[at] + steps[n]);
                    if (way >= near_.values[other]) continue;
                    near_.values[other] = way;
                    next.push_back(other);
                }
            }
            reached.swap(next);
        }
        for (const size_t at : rest) {
            const double depth = depths_.length(depth_.values[at]);
            if ((state_.values[at] & kUncovered) != 0 &&
                near_.values[at] > in_units(edge_reach(radius, depth)))
                state_.values[at] |= kThin;
        }
    }

    /// Marks edges that join two places where the ball fits, which lie opposite each other.
    void mark_necks() {
        const uint16_t fits = depths_.from(radius_);
        const auto stride = std::max(static_cast<int32_t>(radius_ / coarse_ / 8), 1);
        tbb::parallel_for(1, state_.size.z - 1, [&](int32_t z) {
            for (int32_t y = 1; y + 1 < state_.size.y; ++y) {
                for (int32_t x = 1; x + 1 < state_.size.x; ++x) {
                    const size_t at = state_.at(x, y, z);
                    if ((state_.values[at] & (kUncovered | kThin)) != kUncovered) continue;
                    if (joins(Vec3i{x, y, z}, fits, stride)) state_.values[at] |= kThin;
                }
            }
        });
    }
    /// Whether the balls leave all that is set around a place, at right angles to a step.
    bool is_cut_off(const Vec3i& p, const Vec3i& d) const {
        for (const Vec3i& e : around_.steps) {
            if (dot(d, e) != 0) continue;
            for (Vec3i q = p + e; is_set(state_.at(q.x, q.y, q.z)); q = q + e) {
                if ((state_.values[state_.at(q.x, q.y, q.z)] & kUncovered) == 0) return false;
            }
        }
        return true;
    }
    bool joins(const Vec3i& p, uint16_t fits, int32_t stride) const {
        const size_t at = state_.at(p.x, p.y, p.z);
        const double reach = edge_reach(radius_, depths_.length(depth_.values[at]));
        for (size_t n = 0; n < around_.steps.size(); ++n) {
            const Vec3i& d = around_.steps[n];
            if (d.z < 0 || (d.z == 0 && (d.y < 0 || (d.y == 0 && d.x < 0)))) continue;
            const auto most = static_cast<int32_t>(reach / around_.mm[n]);
            for (int32_t k = stride; k <= most; k += stride) {
                const Vec3i a = p + d * k, b = p - d * k;
                if (!state_.holds(a.x, a.y, a.z) || !state_.holds(b.x, b.y, b.z)) break;
                const size_t i = state_.at(a.x, a.y, a.z), j = state_.at(b.x, b.y, b.z);
                if (!is_set(i) || !is_set(j)) break;
                if (depth_.values[i] < fits || depth_.values[j] < fits) continue;
                if (all_set(p, d, k) && is_cut_off(p, d)) return true;
                break;
            }
        }
        return false;
    }
    bool all_set(const Vec3i& p, const Vec3i& d, int32_t most) const {
        for (int32_t k = -most; k <= most; ++k) {
            const Vec3i q = p + d * k;
            if (!is_set(state_.at(q.x, q.y, q.z))) return false;
        }
        return true;
    }

    /// Marks, by kRest, what the balls around thin places cover, as large as these are deep.
    void cover() {
        const uint16_t most = depths_.from(radius_);
        Box<uint16_t> left(state_.size);
        for (size_t i = 0; i < left.values.size(); ++i) {
            const bool thin = (state_.values[i] & kThin) != 0;
            left.values[i] =
                thin ? static_cast<uint16_t>(most - std::min(depth_.values[i], most)) : kFar;
        }
        depths_.spread(&left);
        for (size_t i = 0; i < left.values.size(); ++i) {
            uint8_t& state = state_.values[i];
            const bool is_rest =
                (state & kThin) != 0 || ((state & kUncovered) != 0 && left.values[i] < most);
            state = static_cast<uint8_t>((state & ~kRest) | (is_rest ? kRest : 0));
        }
    }

    /// Returns the mean of the largest balls around places.
    double thickness(const std::vector<Vec3i>& places) const {
        double sum = 0, weights = 0;
        for (const Vec3i& p : places) {
            // As much as it covers: what is deepest also leads into edges.
            const double here = largest_near(p + margin_), weight = here * here * here;
            sum += weight * here, weights += weight;
        }
        return weights > 0 ? sum / weights : 0;
    }

    /// Returns the diameter of the largest ball around a place or half a voxel from it.
    double largest_near(const Vec3i& p) const {
        const double depth = depths_.length(depth_.values[state_.at(p.x, p.y, p.z)]);
        constexpr double kSmall = 12;  // voxels; half a voxel of what is larger does not matter
        if (depth > kSmall * coarse_) return 2 * depth - 0.5 * coarse_;
        const double reach = depth + length(pitch_);
        Vec3i steps;
        for (int axis = 0; axis < 3; ++axis)
            steps[axis] = static_cast<int32_t>(reach / pitch_[axis]) + 1;
        std::array<double, 27> least{};
        std::array<Vec3d, 27> to;
        least.fill(1e300);
        for (int32_t z = -steps.z; z <= steps.z; ++z) {
            for (int32_t y = -steps.y; y <= steps.y; ++y) {
                for (int32_t x = -steps.x; x <= steps.x; ++x) {
                    const Vec3i q{p.x + x, p.y + y, p.z + z};
                    if (!state_.holds(q.x, q.y, q.z) || is_set(state_.at(q.x, q.y, q.z))) continue;
                    for (int32_t c = 0; c < 27; ++c) {
                        const Vec3i corner{c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1};
                        const Vec3d d{(x - 0.5 * corner.x) * pitch_.x,
                                      (y - 0.5 * corner.y) * pitch_.y,
                                      (z - 0.5 * corner.z) * pitch_.z};
                        const double square = dot(d, d);
                        const auto i = static_cast<size_t>(c);
                        if (square < least[i]) least[i] = square, to[i] = d;
                    }
                }
            }
        }
        double largest = 0;
        for (size_t c = 0; c < least.size(); ++c)
            largest = std::max(largest, across(std::sqrt(least[c]), to[c]));
        return largest;
    }

    /// Returns the thickness of a plate between voxel centres that are nearest to its middle: less by a
    /// layer of voxels along an axis, and by about half of one where layers are nearer to each other.
    double across(double depth, const Vec3d& to) const {
        constexpr double kAside = 0.75;
        int axes = 0, along = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (std::fabs(to[axis]) >= kAside * pitch_[axis]) along = axis, ++axes;
        }
        if (axes == 1) return 2 * std::fabs(to[along]) - pitch_[along];
        return 2 * depth - 0.5 * coarse_;
    }

    const Vec3d pitch_;
    const double coarse_;
    const double radius_;
    const Vec3i margin_;
    Box<uint8_t> state_;
    const Neighbours around_;
    const Squares depths_;
    Box<uint16_t> depth_;  ///< squares of distances to what is not set
    Box<uint16_t> near_;   ///< of distances to centres of balls
};

}  // namespace

Vec3i thin_margin(int outside, const Vec3d& pitch_mm, double below_mm) {
    // Of what is set beyond the box, as far as the ball fits there for sure.
    Vec3i margin{1, 1, 1};
    for (int axis = 0; outside != 0 && axis < 3; ++axis)
        margin[axis] = static_cast<int32_t>(below_mm / 2 / pitch_mm[axis]) + 2;
    return margin;
}

std::vector<Thin> find_thin(Bits bits, int outside, const Vec3d& pitch_mm, double below_mm) {
    // A ball that fits around each voxel leaves nothing.
    if (!(below_mm / 2 > std::min({pitch_mm.x, pitch_mm.y, pitch_mm.z}))) return {};
    Opening opening(std::move(bits), outside, pitch_mm, below_mm);
    return opening.mark() ? opening.collect() : std::vector<Thin>();
}

}  // namespace openfab::inspection
