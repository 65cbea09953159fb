// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/model/outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/check.h"
#include "mesh/model/messages.h"
#include "mesh/model/polygon.h"

namespace openfab::mesh {
namespace {

constexpr double kSmoothCosine = 0.8660254037844386;  // of 30 degrees

Point2 minus(const Point2& a, const Point2& b) {
    return {a.x - b.x, a.y - b.y};
}

/// Twice the signed area of the triangle: above 0 where c is left of the way from a to b.
double side_of(const Point2& a, const Point2& b, const Point2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double twice_area(const Outline& outline) {
    double sum = 0;
    for (size_t i = 1; i + 1 < outline.size(); ++i)
        sum += side_of(outline[0], outline[i], outline[i + 1]);
    return sum;
}

bool boxes_meet(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
    const auto apart = [](double p, double q, double r, double s) {
        return std::max(p, q) < std::min(r, s) || std::max(r, s) < std::min(p, q);
    };
    return !apart(a.x, b.x, c.x, d.x) && !apart(a.y, b.y, c.y, d.y);
}

/// Returns whether two segments have a point in common.
bool segments_meet(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
    if (!boxes_meet(a, b, c, d)) return false;
    const double ca = side_of(c, d, a), cb = side_of(c, d, b);
    const double ac = side_of(a, b, c), ad = side_of(a, b, d);
    const auto same_side = [](double p, double q) { return (p > 0 && q > 0) || (p < 0 && q < 0); };
    return !same_side(ca, cb) && !same_side(ac, ad);
}

/// Returns whether the way from b to c lies on that from a to b.
bool runs_back(const Point2& a, const Point2& b, const Point2& c) {
    return side_of(a, b, c) == 0 && (boxes_meet(a, b, c, c) || boxes_meet(b, c, a, a));
}

/// Returns whether a point, not on the outline, is inside it.
bool is_inside(const Outline& outline, const Point2& p) {
    bool inside = false;
    for (size_t i = 0; i < outline.size(); ++i) {
        const Point2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
        if ((a.y > p.y) == (b.y > p.y)) continue;
        const double side = side_of(a, b, p);
        if (b.y > a.y ? side > 0 : side < 0) inside = !inside;
    }
    return inside;
}

/// The number of the others that an outline is within.
size_t depth_of(const std::vector<Outline>& outlines, size_t which) {
    size_t depth = 0;
    for (size_t o = 0; o < outlines.size(); ++o) {
        if (o != which && is_inside(outlines[o], outlines[which][0])) ++depth;
    }
    return depth;
}

/// The boundary of a part of an area, holes joined to it by bridges that are passed both ways.
class Ring {
  public:
    Ring(const std::vector<Outline>& outlines, size_t outer) : outlines_(outlines) {
        for (size_t c = 0; c < outlines[outer].size(); ++c)
            corners_.push_back({outer, c});
    }

    /// Joins the holes, those that reach farthest to +x first: what their farthest corners see to
    /// the right is then part of the ring.
    void join(std::vector<size_t> holes) {
        std::vector<size_t> farthest(outlines_.size());
        for (const size_t hole : holes) {
            const Outline& o = outlines_[hole];
            for (size_t c = 1; c < o.size(); ++c) {
                if (o[c].x > o[farthest[hole]].x) farthest[hole] = c;
            }
        }
        std::sort(holes.begin(), holes.end(), [&](size_t a, size_t b) {
            const double xa = outlines_[a][farthest[a]].x, xb = outlines_[b][farthest[b]].x;
            return xa != xb ? xa > xb : a < b;
        });
        for (size_t h = 0; h < holes.size(); ++h) {
            const OutlineCorner from{holes[h], farthest[holes[h]]};
            bridge(from, visible_from(
                             from, {holes.begin() + static_cast<std::ptrdiff_t>(h), holes.end()}));
        }
    }

    std::vector<std::array<OutlineCorner, 3>> triangles() const {
        std::vector<Vec3d> points;
        for (const OutlineCorner& c : corners_)
            points.push_back({place(c).x, place(c).y, 0});
        int64_t effort = std::numeric_limits<int64_t>::max();  // corners are few
        std::vector<std::array<OutlineCorner, 3>> out;
        for (const std::array<int32_t, 3>& t : triangulate(points, &effort))
            out.push_back({corners_[t[0]], corners_[t[1]], corners_[t[2]]});
        return out;
    }

  private:
    const Point2& place(const OutlineCorner& c) const { return outlines_[c.outline][c.corner]; }
    const Point2& at(size_t i) const { return place(corners_[i % corners_.size()]); }

    /// Returns whether a point is in the corner's angle, between the sides of the ring there.
    bool opens_to(size_t corner, const Point2& p) const {
        const Point2 &before = at(corner + corners_.size() - 1), &own = at(corner),
                     &after = at(corner + 1);
        const bool left_of_in = side_of(before, own, p) > 0,
                   left_of_out = side_of(own, after, p) > 0;
        return side_of(before, own, after) > 0 ? left_of_in && left_of_out
                                               : left_of_in || left_of_out;
    }

    /// Returns whether nothing lies between two points but what begins or ends at one of them.
    bool is_clear(const Point2& p, const Point2& q, const std::vector<size_t>& holes) const {
        const auto blocks = [&](const Point2& a, const Point2& b) {
            return a != p && b != p && a != q && b != q && segments_meet(p, q, a, b);
        };
        for (size_t i = 0; i < corners_.size(); ++i) {
            if (blocks(at(i), at(i + 1))) return false;
        }
        for (const size_t hole : holes) {
            const Outline& o = outlines_[hole];
            for (size_t c = 0; c < o.size(); ++c) {
                if (blocks(o[c], o[(c + 1) % o.size()])) return false;
            }
        }
        return true;
    }

    /// Returns the nearest corner of the ring that a corner of a hole sees.
    size_t visible_from(const OutlineCorner& from, const std::vector<size_t>& holes) const {
        const Point2& p = place(from);
        std::vector<std::pair<double, size_t>> order;
        for (size_t i = 0; i < corners_.size(); ++i) {
            const Point2 way = minus(at(i), p);
            order.emplace_back(way.x * way.x + way.y * way.y, i);
        }
        std::sort(order.begin(), order.end());
        for (const auto& [distance, i] : order) {
            if (opens_to(i, p) && is_clear(p, at(i), holes)) return i;
        }
        return order.front().second;  // of an area that rounding has closed here
    }

    void bridge(const OutlineCorner& from, size_t to) {
        const size_t count = outlines_[from.outline].size();
        std::vector<OutlineCorner> path{corners_[to]};
        for (size_t c = 0; c <= count; ++c)
            path.push_back({from.outline, (from.corner + c) % count});
        corners_.insert(corners_.begin() + static_cast<std::ptrdiff_t>(to), path.begin(),
                        path.end());
    }

    const std::vector<Outline>& outlines_;
    std::vector<OutlineCorner> corners_;
};

}  // namespace

Result<void> check_outlines(const std::vector<Outline>& outlines) {
    struct Side {
        size_t outline = 0, corner = 0, next = 0;
    };
    std::vector<Side> sides;
    for (size_t o = 0; o < outlines.size(); ++o) {
        const size_t count = outlines[o].size();
        if (count < 3) return user_error(messages::kPolygonFewerThan3Corners);
        for (size_t c = 0; c < count; ++c) {
            const size_t next = (c + 1) % count;
            const Point2& p = outlines[o][c];
            if (p == outlines[o][next])
                return user_error(fmt::format(messages::kPolygonTwiceAtCorner, p.x, p.y),
                                  messages::kPolygonTwiceAtCornerHelp);
            sides.push_back({o, c, next});
        }
    }
    if (sides.size() > kMostOutlineCorners) {
        return user_error(
            fmt::format(messages::kPolygonTooManyCorners, sides.size(), kMostOutlineCorners),
            messages::kPolygonTooManyCornersHelp);
    }
    for (size_t i = 0; i < sides.size(); ++i) {
        const Point2& a = outlines[sides[i].outline][sides[i].corner];
        const Point2& b = outlines[sides[i].outline][sides[i].next];
        for (size_t j = i + 1; j < sides.size(); ++j) {
            const Point2& c = outlines[sides[j].outline][sides[j].corner];
            const Point2& d = outlines[sides[j].outline][sides[j].next];
            const bool same = sides[i].outline == sides[j].outline;
            bool meet = false;
            if (same && sides[i].next == sides[j].corner) {
                meet = runs_back(a, b, d);
            } else if (same && sides[j].next == sides[i].corner) {
                meet = runs_back(c, d, b);
            } else {
                meet = segments_meet(a, b, c, d);
            }
            if (meet)
                return user_error(fmt::format(messages::kPolygonMeetsItself, a.x, a.y, b.x, b.y,
                                              c.x, c.y, d.x, d.y));
        }
    }
    return {};
}

void orient_outlines(std::vector<Outline>* outlines) {
    std::vector<bool> turns;
    for (size_t o = 0; o < outlines->size(); ++o) {
        const bool hole = depth_of(*outlines, o) % 2 == 1;
        turns.push_back((twice_area((*outlines)[o]) < 0) != hole);
    }
    for (size_t o = 0; o < outlines->size(); ++o) {
        if (turns[o]) std::reverse((*outlines)[o].begin() + 1, (*outlines)[o].end());
    }
}

std::vector<std::array<OutlineCorner, 3>> triangulate_area(const std::vector<Outline>& outlines) {
    std::vector<size_t> depths;
    for (size_t o = 0; o < outlines.size(); ++o)
        depths.push_back(depth_of(outlines, o));
    std::vector<std::array<OutlineCorner, 3>> out;
    for (size_t outer = 0; outer < outlines.size(); ++outer) {
        if (depths[outer] % 2 == 1) continue;
        std::vector<size_t> holes;
        for (size_t o = 0; o < outlines.size(); ++o) {
            if (depths[o] == depths[outer] + 1 && is_inside(outlines[outer], outlines[o][0]))
                holes.push_back(o);
        }
        Ring ring(outlines, outer);
        ring.join(std::move(holes));
        const auto triangles = ring.triangles();
        out.insert(out.end(), triangles.begin(), triangles.end());
    }
    return out;
}

std::vector<CornerNormals> corner_normals(const Outline& outline) {
    const size_t count = outline.size();
    std::vector<Point2> sides;
    for (size_t c = 0; c < count; ++c) {
        const Point2 way = minus(outline[(c + 1) % count], outline[c]);
        const double length = std::sqrt(way.x * way.x + way.y * way.y);
        OPENFAB_CHECK(length > 0);
        sides.push_back({way.y / length, -way.x / length});
    }
    std::vector<CornerNormals> out;
    for (size_t c = 0; c < count; ++c) {
        const Point2 &before = sides[(c + count - 1) % count], &after = sides[c];
        out.push_back({before, after});
        if (before.x * after.x + before.y * after.y <= kSmoothCosine) continue;
        const Point2 sum{before.x + after.x, before.y + after.y};
        const double length = std::sqrt(sum.x * sum.x + sum.y * sum.y);
        out.back().before = out.back().after = {sum.x / length, sum.y / length};
    }
    return out;
}

}  // namespace openfab::mesh
