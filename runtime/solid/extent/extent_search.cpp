// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/extent/extent_search.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "base/infinity.h"

namespace openfab::solid {

namespace {

using Points = std::vector<Vec3f>;

// Points along a side of the box that are looked at first.
constexpr int32_t kFirstLook = 16;
// Boxes that may be left at once; most shapes leave a few dozen. Where nothing is found, points at the
// centres of so many more are the statement that there is nothing.
constexpr size_t kMostBoxes = size_t{1} << 14, kMostWhereEmpty = size_t{1} << 21;
constexpr int32_t kDeepest = 40;
// Of the longest side: what may be left out beyond what is reached, along the axes and between them,
// where a straight edge that is reached would be followed for its whole length.
constexpr double kExtentSlack = 0x1p-21, kTurnedSlack = 0x1p-16;
// Points from which a side is climbed to, halvings of the way to it, and steps sideways.
constexpr size_t kClimbers = 16;
constexpr int32_t kHalvings = 30, kClimbSteps = 80;
constexpr double kLeastStep = 0x1p-22;  // of the longest side
constexpr size_t kExtentChunk = 2048;   // points or boxes that a thread takes at once

class ExtentSearch {
  public:
    ExtentSearch(const SolidValue& solid, const std::array<double, 9>& turn,
                 std::span<const pieces::Side> sides)
        : solid_(solid), sides_(sides), box_(solid.box()) {
        for (size_t side = 0; side < 6; ++side) {
            const size_t row = 3 * (side / 2);
            const double sign = side % 2 == 0 ? -1 : 1;
            along_[side] = {sign * turn[row], sign * turn[row + 1], sign * turn[row + 2]};
        }
        longest_ = static_cast<double>(box_.longest_side());
    }

    Extent run() {
        look_first();
        if (reach_[0] == -kInfinity) search(0, kMostWhereEmpty);
        Extent out;
        if (reach_[0] == -kInfinity) {
            out.open = std::move(open_);
            out.spacing_mm = spacing_;
            return out;
        }
        open_.clear();
        for (size_t side = 0; side < 6; ++side)
            search(side, kMostBoxes);
        for (int axis = 0; axis < 3; ++axis) {
            out.box.lo[axis] = 0 - reach_[static_cast<size_t>(2 * axis)];
            out.box.hi[axis] = reach_[static_cast<size_t>(2 * axis + 1)];
        }
        out.open = std::move(open_);
        return out;
    }

  private:
    static double reach_of(const Vec3d& along, const Vec3f& p) {
        return dot(along, vec_cast<double>(p));
    }
    static double reach_of(const Vec3d& along, const Box3f& box) {
        double sum = 0;
        for (int a = 0; a < 3; ++a)
            sum += along[a] * static_cast<double>(along[a] > 0 ? box.hi[a] : box.lo[a]);
        return sum;
    }
    /// Returns the only axis that it runs along, or -1.
    static int only_axis(const Vec3d& along) {
        int found = -1;
        for (int a = 0; a < 3; ++a) {
            if (along[a] == 0) continue;
            if (found >= 0) return -1;
            found = a;
        }
        return found;
    }
    double beyond(size_t side) const {
        const double slack = only_axis(along_[side]) >= 0 ? kExtentSlack : kTurnedSlack;
        return reach_[side] + slack * longest_ + 0x1p-22 * std::fabs(reach_[side]);
    }
    /// Shrinks a box to one that holds what of it lies beyond a reach; false: nothing.
    static bool clip(const Vec3d& along, double limit, Box3f* box) {
        if (!std::isfinite(limit)) return true;
        const double most = reach_of(along, *box);
        if (!(most > limit)) return false;
        for (int a = 0; a < 3; ++a) {
            if (along[a] == 0) continue;
            const bool up = along[a] > 0;
            const double others =
                most - along[a] * static_cast<double>(up ? box->hi[a] : box->lo[a]);
            const auto at = static_cast<float>((limit - others) / along[a]);
            if (up) {
                box->lo[a] = std::max(box->lo[a], std::nextafter(at, -HUGE_VALF));
            } else {
                box->hi[a] = std::min(box->hi[a], std::nextafter(at, HUGE_VALF));
            }
            if (box->lo[a] > box->hi[a]) return false;
        }
        return true;
    }

    /// Returns how far beyond the side that it is farthest beyond, or 0.
    double outside(const Vec3f& p) const {
        double most = 0;
        for (const pieces::Side& side : sides_)
            most = std::max(most, 0 - side.depth(vec_cast<double>(p)));
        return most;
    }
    /// Returns the least of that over a box.
    double outside(const Box3f& box) const {
        double most = 0;
        for (const pieces::Side& side : sides_) {
            const Vec3d inwards = side.front ? side.normal : side.normal * -1.0;
            most = std::max(most,
                            (side.front ? side.offset : 0 - side.offset) - reach_of(inwards, box));
        }
        return most;
    }
    /// Returns the values at points, or only numbers with their signs.
    std::vector<float> values(const Points& points, bool signs = false) const {
        std::vector<float> out(points.size());
        in_chunks(points.size(), [&](size_t first, size_t count) {
            const std::span<const Vec3f> some(points.data() + first, count);
            signs ? solid_.signs(some, out.data() + first)
                  : solid_.values(some, out.data() + first);
            for (size_t i = first; i < first + count && !sides_.empty(); ++i) {
                const double beyond = outside(points[i]);
                if (beyond > 0) out[i] = static_cast<float>(beyond);
            }
        });
        return out;
    }
    std::vector<float> lower_bounds(const std::vector<Box3f>& boxes) const {
        std::vector<float> out(boxes.size());
        in_chunks(boxes.size(), [&](size_t first, size_t count) {
            solid_.lower_bounds({boxes.data() + first, count}, out.data() + first);
            for (size_t i = first; i < first + count && !sides_.empty(); ++i) {
                const double beyond = outside(boxes[i]);
                if (beyond > 0) out[i] = static_cast<float>(beyond);
            }
        });
        return out;
    }
    template <typename Run>
    static void in_chunks(size_t count, const Run& run) {
        tbb::parallel_for(size_t{0}, (count + kExtentChunk - 1) / kExtentChunk, [&](size_t chunk) {
            const size_t first = chunk * kExtentChunk;
            run(first, std::min(kExtentChunk, count - first));
        });
    }

    void look_first() {
        Points points;
        for (int32_t z = 0; z < kFirstLook; ++z) {
            for (int32_t y = 0; y < kFirstLook; ++y) {
                for (int32_t x = 0; x < kFirstLook; ++x) {
                    Vec3f p;
                    const Vec3i at{x, y, z};
                    for (int a = 0; a < 3; ++a) {
                        const float share = (static_cast<float>(at[a]) + 0.5f) / kFirstLook;
                        p[a] = box_.lo[a] + share * (box_.hi[a] - box_.lo[a]);
                    }
                    points.push_back(p);
                }
            }
        }
        const std::vector<float> found = values(points, true);
        std::vector<Vec3f> inside;
        for (size_t i = 0; i < found.size(); ++i) {
            if (found[i] < 0) inside.push_back(points[i]);
        }
        if (inside.empty()) return;
        for (size_t side = 0; side < 6; ++side)
            climb(side, inside);
    }

    /// Returns how far one gets from a point along a side before the box ends.
    double way_out(const Vec3d& along, const Vec3f& from) const {
        double way = kInfinity;
        for (int a = 0; a < 3; ++a) {
            if (along[a] == 0) continue;
            const auto end = static_cast<double>(along[a] > 0 ? box_.hi[a] : box_.lo[a]);
            way = std::min(way, (end - static_cast<double>(from[a])) / along[a]);
        }
        return std::max(way, 0.0);
    }
    Vec3f moved(const Vec3f& from, const Vec3d& by) const {
        Vec3f out;
        for (int a = 0; a < 3; ++a) {
            out[a] = std::clamp(static_cast<float>(static_cast<double>(from[a]) + by[a]),
                                box_.lo[a], box_.hi[a]);
        }
        return out;
    }

    /// From points inside, halves the way to the box for a zero. Returns the last point inside of the one
    /// that reaches farthest.
    Vec3f rise(size_t side, const std::vector<Vec3f>& from, double* reached) const {
        const Vec3d& along = along_[side];
        std::vector<double> low(from.size(), 0), high;
        for (const Vec3f& p : from)
            high.push_back(way_out(along, p));
        for (int32_t step = 0; step < kHalvings; ++step) {
            Points points;
            for (size_t i = 0; i < from.size(); ++i)
                points.push_back(moved(from[i], along * ((low[i] + high[i]) / 2)));
            const std::vector<float> found = values(points, true);
            for (size_t i = 0; i < from.size(); ++i)
                (found[i] < 0 ? low : high)[i] = (low[i] + high[i]) / 2;
        }
        size_t best = 0;
        const auto reach = [&](size_t i) {
            return reach_of(along, moved(from[i], along * high[i]));
        };
        for (size_t i = 1; i < from.size(); ++i) {
            if (reach(i) > reach(best)) best = i;
        }
        *reached = reach(best);
        return moved(from[best], along * low[best]);
    }

    /// Raises the reach of a side, from points inside, to a summit near the highest.
    void climb(size_t side, std::vector<Vec3f> inside) {
        const Vec3d& along = along_[side];
        const size_t climbers = std::min(inside.size(), kClimbers);
        std::partial_sort(inside.begin(), inside.begin() + static_cast<ptrdiff_t>(climbers),
                          inside.end(), [&](const Vec3f& a, const Vec3f& b) {
                              const double of_a = reach_of(along, a), of_b = reach_of(along, b);
                              return of_a != of_b
                                         ? of_a > of_b
                                         : std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
                          });
        inside.resize(climbers);
        double reached = 0;
        Vec3f at = rise(side, inside, &reached);
        const Vec3d other = std::fabs(along.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
        Vec3d u = cross(along, other);
        u = u * (1 / length(u));
        const Vec3d v = cross(along, u);
        double step = longest_ / kFirstLook;
        for (int32_t i = 0; i < kClimbSteps && step > kLeastStep * longest_; ++i) {
            Points around;
            for (int32_t y = -1; y <= 1; ++y) {
                for (int32_t x = -1; x <= 1; ++x) {
                    if (x != 0 || y != 0)
                        around.push_back(moved(at, u * (x * step) + v * (y * step)));
                }
            }
            const std::vector<float> found = values(around, true);
            std::vector<Vec3f> higher;
            for (size_t k = 0; k < found.size(); ++k) {
                if (found[k] < 0) higher.push_back(around[k]);
            }
            double now = -kInfinity;
            const Vec3f to = higher.empty() ? at : rise(side, higher, &now);
            if (now > reached + kLeastStep * longest_) {
                at = to;
            } else {
                step /= 2;
            }
            reached = std::max(reached, now);
        }
        reach_[side] = std::max(reach_[side], reached);
    }

    /// Searches for a point inside from those with the least values, downhill; none: nothing is found.
    std::vector<Vec3f> descend(const Points& points, const std::vector<float>& found,
                               double step) const {
        std::vector<size_t> order(points.size());
        std::iota(order.begin(), order.end(), size_t{0});
        std::erase_if(order, [&](size_t i) { return std::isnan(found[i]); });
        const size_t some = std::min(order.size(), kClimbers);
        std::partial_sort(
            order.begin(), order.begin() + static_cast<ptrdiff_t>(some), order.end(),
            [&](size_t a, size_t b) { return found[a] != found[b] ? found[a] < found[b] : a < b; });
        std::vector<Vec3f> at;
        std::vector<float> least;
        for (size_t i = 0; i < some; ++i)
            at.push_back(points[order[i]]), least.push_back(found[order[i]]);
        for (int32_t i = 0; i < kHalvings; ++i, step /= 2) {
            Points around;
            for (const Vec3f& p : at) {
                for (int32_t k = 0; k < 6; ++k) {
                    Vec3d by;
                    by[k / 2] = k % 2 == 0 ? -step : step;
                    around.push_back(moved(p, by));
                }
            }
            const std::vector<float> values_around = values(around);
            std::vector<Vec3f> inside;
            for (size_t k = 0; k < around.size(); ++k) {
                if (values_around[k] < 0) inside.push_back(around[k]);
                if (!(values_around[k] < least[k / 6])) continue;
                least[k / 6] = values_around[k];
                at[k / 6] = around[k];
            }
            if (!inside.empty()) return inside;
        }
        return {};
    }

    /// Halves a box along the sides that are longer than half of its longest.
    static void split(const Box3f& box, std::vector<Box3f>* out) {
        const Vec3f size = box.hi - box.lo;
        const float longest = std::max({size.x, size.y, size.z});
        std::array<Box3f, 8> parts{box};
        size_t count = 1;
        for (int a = 0; a < 3; ++a) {
            if (!(size[a] > longest / 2)) continue;
            const float middle = box.lo[a] + size[a] / 2;
            for (size_t i = 0; i < count; ++i) {
                parts[count + i] = parts[i];
                parts[i].hi[a] = middle;
                parts[count + i].lo[a] = middle;
            }
            count *= 2;
        }
        out->insert(out->end(), parts.begin(), parts.begin() + static_cast<ptrdiff_t>(count));
    }

    void search(size_t side, size_t most) {
        const Vec3d& along = along_[side];
        std::vector<Box3f> boxes{box_}, next;
        for (int32_t level = 0; level < kDeepest; ++level) {
            const bool any = reach_[side] != -kInfinity;
            next.clear();
            for (Box3f box : boxes) {
                if (!any || clip(along, beyond(side), &box)) next.push_back(box);
            }
            boxes.swap(next);
            if (boxes.empty()) return;
            const std::vector<float> value_lo = lower_bounds(boxes);
            next.clear();
            Points centres;
            for (size_t i = 0; i < boxes.size(); ++i) {
                if (value_lo[i] >= 0) continue;
                next.push_back(boxes[i]);
                centres.push_back(boxes[i].lo + (boxes[i].hi - boxes[i].lo) * 0.5f);
            }
            boxes.swap(next);
            const std::vector<float> found = values(centres, any);
            std::vector<Vec3f> inside;
            for (size_t i = 0; i < boxes.size(); ++i) {
                if (found[i] < 0) inside.push_back(centres[i]);
            }
            spacing_ = longest_ / std::exp2(level);
            if (!any && inside.empty() && !boxes.empty())
                inside = descend(centres, found, spacing_ / 2);
            if (!inside.empty()) {
                if (!any) {
                    for (size_t other = 0; other < 6; ++other)
                        climb(other, inside);
                    return;
                }
                climb(side, std::move(inside));
            }
            next.clear();
            size_t left = 0;
            for (Box3f box : boxes) {
                if (any && !clip(along, beyond(side), &box)) continue;
                next.push_back(box);
                ++left;
            }
            boxes.swap(next);
            if (left * 8 > most) break;
            next.clear();
            for (const Box3f& box : boxes)
                split(box, &next);
            boxes.swap(next);
        }
        open_.insert(open_.end(), boxes.begin(), boxes.end());
    }

    const SolidValue& solid_;
    const std::span<const pieces::Side> sides_;
    const Box3f box_;
    std::array<Vec3d, 6> along_;
    double longest_ = 0;
    std::array<double, 6> reach_{-kInfinity, -kInfinity, -kInfinity,
                                 -kInfinity, -kInfinity, -kInfinity};
    std::vector<Box3f> open_;
    double spacing_ = 0;
};

}  // namespace

Extent find_extent(const SolidValue& solid, const std::array<double, 9>& turn,
                   std::span<const pieces::Side> sides) {
    return ExtentSearch(solid, turn, sides).run();
}

}  // namespace openfab::solid
