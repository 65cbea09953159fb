// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/text/unite.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

namespace openfab::text {

namespace {

// What is decided is decided in whole numbers: of a coordinate below 2^30 all products fit 64 bits.
constexpr double kMostUnits = 1 << 30;

/// A place on the grid.
struct Place {
    int64_t x = 0, y = 0;
    auto operator<=>(const Place&) const = default;
};

Place operator-(const Place& a, const Place& b) {
    return {a.x - b.x, a.y - b.y};
}
int64_t cross(const Place& a, const Place& b) {
    return a.x * b.y - a.y * b.x;
}
int64_t dot(const Place& a, const Place& b) {
    return a.x * b.x + a.y * b.y;
}
/// Above 0 where c is left of the way from a to b.
int64_t side_of(const Place& a, const Place& b, const Place& c) {
    return cross(b - a, c - a);
}

/// A side of the outlines, from the lesser place to the greater: how often it is passed that way, less how
/// often the other way.
struct Side {
    Place a, b;
    int64_t times = 0;
};

/// Sides that have no point in common but their ends, and of which none is there twice.
class Sides {
  public:
    void add(const Place& from, const Place& to, int64_t times = 1) {
        if (from == to || times == 0) return;
        (from < to ? times_[{from, to}] : times_[{to, from}]) += from < to ? times : -times;
    }

    /// Splits sides where they meet, until none does. Returns false where rounding does not let it end.
    bool split() {
        constexpr int kMostRounds = 60;
        for (int round = 0; round < kMostRounds; ++round) {
            take();
            if (!split_once()) return true;
        }
        return false;
    }
    const std::vector<Side>& all() const { return sides_; }

  private:
    void take() {
        sides_.clear();
        for (const auto& [ends, times] : times_) {
            if (times != 0) sides_.push_back({ends.first, ends.second, times});
        }
        times_.clear();
    }

    bool split_once() {
        cuts_.assign(sides_.size(), {});
        bool any = false;
        // They are in the order of their least x.
        for (size_t i = 0; i < sides_.size(); ++i) {
            const Side& s = sides_[i];
            const auto [low, high] = std::minmax(s.a.y, s.b.y);
            for (size_t j = i + 1; j < sides_.size() && sides_[j].a.x <= s.b.x; ++j) {
                const Side& t = sides_[j];
                if (std::min(t.a.y, t.b.y) > high || std::max(t.a.y, t.b.y) < low) continue;
                any = cut(i, j) || any;
            }
        }
        for (size_t i = 0; any && i < sides_.size(); ++i) {
            const Side& s = sides_[i];
            std::vector<Place>& cuts = cuts_[i];
            std::sort(cuts.begin(), cuts.end(), [&](const Place& p, const Place& q) {
                const int64_t at_p = dot(p - s.a, s.b - s.a), at_q = dot(q - s.a, s.b - s.a);
                return at_p != at_q ? at_p < at_q : p < q;
            });
            Place from = s.a;
            for (const Place& place : cuts) {
                add(from, place, s.times);
                from = place;
            }
            add(from, s.b, s.times);
        }
        return any;
    }

    /// Notes where two sides meet elsewhere than at an end of both.
    bool cut(size_t i, size_t j) {
        const Side &s = sides_[i], &t = sides_[j];
        const int64_t a = side_of(t.a, t.b, s.a), b = side_of(t.a, t.b, s.b);
        const int64_t c = side_of(s.a, s.b, t.a), d = side_of(s.a, s.b, t.b);
        if (((a < 0) != (b < 0)) && ((c < 0) != (d < 0)) && a != 0 && b != 0 && c != 0 && d != 0) {
            const double share =
                static_cast<double>(a) / (static_cast<double>(a) - static_cast<double>(b));
            const Place way = s.b - s.a;
            const Place at{s.a.x + std::llround(share * static_cast<double>(way.x)),
                           s.a.y + std::llround(share * static_cast<double>(way.y))};
            const bool first = add_cut(i, at), second = add_cut(j, at);
            return first || second;
        }
        bool any = false;
        if (a == 0) any = add_cut_between(j, s.a) || any;
        if (b == 0) any = add_cut_between(j, s.b) || any;
        if (c == 0) any = add_cut_between(i, t.a) || any;
        if (d == 0) any = add_cut_between(i, t.b) || any;
        return any;
    }
    bool add_cut(size_t i, const Place& at) {
        if (at == sides_[i].a || at == sides_[i].b) return false;
        cuts_[i].push_back(at);
        return true;
    }
    /// Of a place in line with the side.
    bool add_cut_between(size_t i, const Place& at) {
        const Place whole = sides_[i].b - sides_[i].a;
        const int64_t along = dot(at - sides_[i].a, whole);
        return along > 0 && along < dot(whole, whole) && add_cut(i, at);
    }

    std::map<std::pair<Place, Place>, int64_t> times_;
    std::vector<Side> sides_;
    std::vector<std::vector<Place>> cuts_;
};

/// Sides that bound the area: it is on the left of the way from `from` to `to`.
struct Border {
    Place from, to;
    bool used = false;
};

/// How often the outlines go around the points just right of each side, or just below it.
std::vector<int64_t> turns_beside(const std::vector<Side>& sides) {
    std::vector<int64_t> out(sides.size());
    for (size_t i = 0; i < sides.size(); ++i) {
        const Side& s = sides[i];
        // A ray from its middle, in halves of the grid, to the right, or down from a level one. A side that
        // begins on the ray counts, one that ends there does not.
        const Place middle{s.a.x + s.b.x, s.a.y + s.b.y};
        const bool is_level = s.a.y == s.b.y;
        for (size_t j = 0; j < sides.size(); ++j) {
            const Side& t = sides[j];
            if (j == i) continue;
            if (is_level) {
                if ((2 * t.a.x <= middle.x) == (2 * t.b.x <= middle.x)) continue;
                const Place a{2 * t.a.x, 2 * t.a.y}, b{2 * t.b.x, 2 * t.b.y};
                if (side_of(a, b, middle) > 0) out[i] += t.times;  // b is right of a
            } else {
                if ((2 * t.a.y <= middle.y) == (2 * t.b.y <= middle.y)) continue;
                const bool rises = t.b.y > t.a.y;
                const Place a{2 * t.a.x, 2 * t.a.y}, b{2 * t.b.x, 2 * t.b.y};
                const int64_t left = side_of(a, b, middle);
                if (rises ? left > 0 : left < 0) out[i] += rises ? t.times : -t.times;
            }
        }
    }
    return out;
}

std::vector<Border> borders_of(const std::vector<Side>& sides) {
    const std::vector<int64_t> beside = turns_beside(sides);
    std::vector<Border> out;
    for (size_t i = 0; i < sides.size(); ++i) {
        const Side& s = sides[i];
        // The lesser end has the lesser x, and of an upright one the lesser y: right of the way from a to b
        // is below it, or to the right where it rises.
        const bool falls = s.b.y < s.a.y;
        const int64_t right = falls ? beside[i] - s.times : beside[i], left = right + s.times;
        if ((left != 0) == (right != 0)) continue;
        out.push_back(left != 0 ? Border{s.a, s.b} : Border{s.b, s.a});
    }
    return out;
}

/// A corner of the area's border; `shared` where others are at the same place.
struct Corner {
    Place at;
    bool shared = false;
};
using Loop = std::vector<Corner>;

/// Returns whether, turning clockwise from `from`, the way p comes before q.
bool comes_first(const Place& from, const Place& p, const Place& q) {
    const auto half = [&](const Place& v) {
        const int64_t side = cross(from, v);
        return side < 0 ? 0 : side == 0 && dot(from, v) < 0 ? 1 : side > 0 ? 2 : 3;
    };
    const int of_p = half(p), of_q = half(q);
    return of_p != of_q ? of_p < of_q : cross(p, q) < 0;
}

/// Joins borders to loops that leave each corner along the same part of the area as they come.
std::vector<Loop> loops_of(std::vector<Border> borders) {
    std::map<Place, std::vector<size_t>> leaving;
    for (size_t i = 0; i < borders.size(); ++i)
        leaving[borders[i].from].push_back(i);
    std::vector<Loop> out;
    for (size_t first = 0; first < borders.size(); ++first) {
        if (borders[first].used) continue;
        Loop loop;
        for (size_t at = first; !borders[at].used;) {
            Border& border = borders[at];
            border.used = true;
            const std::vector<size_t>& next = leaving[border.to];
            loop.push_back({border.to, next.size() > 1});
            if (next.empty()) break;  // of sides that still cross
            const Place back = border.from - border.to;
            at = *std::min_element(next.begin(), next.end(), [&](size_t p, size_t q) {
                return comes_first(back, borders[p].to - borders[p].from,
                                   borders[q].to - borders[q].from);
            });
        }
        out.push_back(std::move(loop));
    }
    return out;
}

/// Removes corners between sides in line, and those closer to the one before than `least`.
Loop simplified(const Loop& loop, double least) {
    Loop out;
    const auto far = [&](const Place& p, const Place& q) {
        return std::hypot(static_cast<double>(p.x - q.x), static_cast<double>(p.y - q.y)) >= least;
    };
    for (const Corner& corner : loop) {
        if (corner.shared || out.empty() || far(out.back().at, corner.at)) out.push_back(corner);
    }
    while (out.size() > 3 && !out.back().shared && !far(out.back().at, out.front().at))
        out.pop_back();
    for (size_t i = 0; i < out.size() && out.size() > 3;) {
        const Place &before = out[(i + out.size() - 1) % out.size()].at,
                    &after = out[(i + 1) % out.size()].at;
        if (!out[i].shared && side_of(before, out[i].at, after) == 0) {
            out.erase(out.begin() + static_cast<std::ptrdiff_t>(i));
        } else {
            ++i;
        }
    }
    return out;
}

double twice_area(const mesh::Outline& o) {
    double sum = 0;
    for (size_t i = 0; i < o.size(); ++i) {
        const mesh::Point2 &a = o[i], &b = o[(i + 1) % o.size()];
        sum += (a.x - o[0].x) * (b.y - o[0].y) - (a.y - o[0].y) * (b.x - o[0].x);
    }
    return sum;
}

double around(const mesh::Outline& o) {
    double sum = 0;
    for (size_t i = 0; i < o.size(); ++i) {
        const mesh::Point2 &a = o[i], &b = o[(i + 1) % o.size()];
        sum += std::hypot(b.x - a.x, b.y - a.y);
    }
    return sum;
}

bool is_inside(const mesh::Outline& o, const mesh::Point2& p) {
    bool inside = false;
    for (size_t i = 0; i < o.size(); ++i) {
        const mesh::Point2 &a = o[i], &b = o[(i + 1) % o.size()];
        if ((a.y > p.y) == (b.y > p.y)) continue;
        const double side = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
        if (b.y > a.y ? side > 0 : side < 0) inside = !inside;
    }
    return inside;
}

/// The grid of a group of glyphs.
struct Grid {
    mesh::Point2 origin;
    double unit = 1;

    Place place(const mesh::Point2& p) const {
        return {std::llround((p.x - origin.x) / unit), std::llround((p.y - origin.y) / unit)};
    }
    mesh::Point2 point(double x, double y) const {
        return {origin.x + x * unit, origin.y + y * unit};
    }
};

/// Moves a shared corner into the area, by `by` units.
mesh::Point2 parted(const Grid& grid, const Place& before, const Place& at, const Place& after,
                    double by) {
    const auto way = [&](const Place& to) {
        const double x = static_cast<double>(to.x - at.x), y = static_cast<double>(to.y - at.y);
        const double length = std::hypot(x, y);
        return mesh::Point2{x / length, y / length};
    };
    const mesh::Point2 u = way(before), w = way(after);
    const double turn =
        u.y * w.x - u.x * w.y;  // above 0 where the area's angle is below 180 degrees
    mesh::Point2 middle{u.x + w.x, u.y + w.y};
    if (turn < 0) middle = {-middle.x, -middle.y};
    double length = std::hypot(middle.x, middle.y);
    if (length < 1e-6) {
        middle = {-w.y, w.x};
        length = 1;
    }
    return grid.point(static_cast<double>(at.x) + by * middle.x / length,
                      static_cast<double>(at.y) + by * middle.y / length);
}

/// Makes areas of loops: each outline with the holes within it.
std::vector<Area> areas_of(const std::vector<Loop>& loops, const Grid& grid, double least) {
    std::vector<Area> out;
    std::vector<mesh::Outline> holes;
    for (const Loop& whole : loops) {
        const Loop loop = simplified(whole, least / grid.unit);
        mesh::Outline outline;
        for (size_t i = 0; i < loop.size(); ++i) {
            const Place& at = loop[i].at;
            const size_t n = loop.size();
            outline.push_back(
                loop[i].shared && n > 2
                    ? parted(grid, loop[(i + n - 1) % n].at, at, loop[(i + 1) % n].at,
                             least / grid.unit / 4)
                    : grid.point(static_cast<double>(at.x), static_cast<double>(at.y)));
        }
        const double area = twice_area(outline);
        if (outline.size() < 3 || std::abs(area) < least * around(outline)) continue;
        if (area > 0) {
            out.push_back({std::move(outline)});
        } else {
            holes.push_back(std::move(outline));
        }
    }
    for (mesh::Outline& hole : holes) {
        Area* within = nullptr;
        for (Area& area : out) {
            if (is_inside(area[0], hole[0]) &&
                (within == nullptr || twice_area(area[0]) < twice_area((*within)[0])))
                within = &area;
        }
        if (within != nullptr) within->push_back(std::move(hole));
    }
    return out;
}

bool are_apart(const std::vector<Area>& areas) {
    return std::all_of(areas.begin(), areas.end(), [](const Area& area) {
        size_t corners = 0;
        for (const mesh::Outline& outline : area)
            corners += outline.size();
        // More are not compared: it would take too long.
        return corners > mesh::kMostOutlineCorners || bool(mesh::check_outlines(area));
    });
}

struct Box {
    double left = std::numeric_limits<double>::infinity(), right = -left, low = left, high = -left;
};

Box box_of(const Glyph& glyph) {
    Box box;
    for (const mesh::Outline& outline : glyph) {
        for (const mesh::Point2& p : outline) {
            box.left = std::min(box.left, p.x);
            box.right = std::max(box.right, p.x);
            box.low = std::min(box.low, p.y);
            box.high = std::max(box.high, p.y);
        }
    }
    return box;
}

/// Groups of glyphs whose boxes meet, in order of their first.
std::vector<std::vector<size_t>> groups_of(const std::vector<Box>& boxes) {
    std::vector<size_t> order(boxes.size()), root(boxes.size());
    std::iota(order.begin(), order.end(), 0U);
    std::iota(root.begin(), root.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return boxes[a].left < boxes[b].left; });
    const auto find = [&](size_t i) {
        while (root[i] != i)
            i = root[i] = root[root[i]];
        return i;
    };
    std::vector<size_t> open;
    for (const size_t i : order) {
        std::erase_if(open, [&](size_t j) { return boxes[j].right < boxes[i].left; });
        for (const size_t j : open) {
            if (boxes[j].low <= boxes[i].high && boxes[j].high >= boxes[i].low)
                root[find(i)] = find(j);
        }
        open.push_back(i);
    }
    std::map<size_t, size_t> of_root;
    std::vector<std::vector<size_t>> out;
    for (size_t i = 0; i < boxes.size(); ++i) {
        const auto [at, is_new] = of_root.try_emplace(find(i), out.size());
        if (is_new) out.emplace_back();
        out[at->second].push_back(i);
    }
    return out;
}

}  // namespace

std::vector<Area> unite(const std::vector<Glyph>& glyphs, double finest, double least) {
    std::vector<Box> boxes;
    boxes.reserve(glyphs.size());
    for (const Glyph& glyph : glyphs)
        boxes.push_back(box_of(glyph));
    std::vector<Area> out;
    for (const std::vector<size_t>& group : groups_of(boxes)) {
        Box box;
        for (const size_t i : group) {
            box.left = std::min(box.left, boxes[i].left);
            box.right = std::max(box.right, boxes[i].right);
            box.low = std::min(box.low, boxes[i].low);
            box.high = std::max(box.high, boxes[i].high);
        }
        const double wide = std::max(box.right - box.left, box.high - box.low);
        // From a place on the grid on, so that glyphs apart from each other are rounded alike.
        const double unit = std::max(finest, 2 * wide / kMostUnits);
        const Grid grid{{std::floor(box.left / unit) * unit, std::floor(box.low / unit) * unit},
                        unit};
        Sides sides;
        for (const size_t i : group) {
            for (const mesh::Outline& outline : glyphs[i]) {
                for (size_t k = 0; k < outline.size(); ++k)
                    sides.add(grid.place(outline[k]),
                              grid.place(outline[(k + 1) % outline.size()]));
            }
        }
        // Where it does not end, what is left is told of by who draws it out.
        (void)sides.split();
        const std::vector<Loop> loops = loops_of(borders_of(sides.all()));
        std::vector<Area> areas = areas_of(loops, grid, least);
        // What is left out to simplify them may lead a side across another.
        constexpr double kFiner = 1.0 / 16;
        for (double finer = kFiner * least; !are_apart(areas) && finer > unit; finer *= kFiner)
            areas = areas_of(loops, grid, finer);
        std::move(areas.begin(), areas.end(), std::back_inserter(out));
    }
    return out;
}

}  // namespace openfab::text
