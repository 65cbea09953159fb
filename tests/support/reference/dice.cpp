// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference/dice.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <optional>

#include "tests/support/reference/plain_dicer.h"
#include "tests/support/reference/strip.h"

namespace openfab::reference {

std::optional<PlainDicer::Corner> PlainDicer::partner(int32_t t, int32_t side) const {
    std::vector<Corner> same, other;
    for (const Corner& c : edge(t, side))
        (up(c[0], c[1]) == up(t, side) ? same : other).push_back(c);
    const size_t k =
        static_cast<size_t>(std::find(same.begin(), same.end(), Corner{t, side}) - same.begin());
    if (k >= other.size()) return std::nullopt;
    return other[k];
}

std::vector<uint32_t> PlainDicer::input_bits(int32_t t, int32_t c) const {
    std::vector<uint32_t> bits;
    const size_t corner = static_cast<size_t>(3 * t + c % 3);
    const auto add = [&](float f) { bits.push_back(std::bit_cast<uint32_t>(f)); };
    if (!mesh_.corner_normals.empty()) {
        const Vec3f n = mesh_.corner_normals[corner];
        add(n.x), add(n.y), add(n.z);
    }
    if (!mesh_.corner_uv.empty())
        add(mesh_.corner_uv[2 * corner]), add(mesh_.corner_uv[2 * corner + 1]);
    for (const part::PartAttribute& input : mesh_.inputs) {
        for (int32_t k = 0; k < input.components; ++k) {
            if (input.scalar == OPENFAB_FLOAT) {
                add(corners_of(input, t, k)[static_cast<size_t>(c % 3)]);
            } else {
                bits.push_back(input.face_values[static_cast<size_t>(t * input.components + k)]);
            }
        }
    }
    return bits;
}

int32_t PlainDicer::corner_evaluator(int32_t t, int32_t c) const {
    int32_t best = t;
    for (const Corner& other : at_vertex_.at(key(t, c))) {
        if (displaced(other[0]) && input_bits(other[0], other[1]) == input_bits(t, c))
            best = std::min(best, other[0]);
    }
    return best;
}

int32_t PlainDicer::side_evaluator(int32_t t, int32_t side) const {
    const auto ends = [&](int32_t triangle, int32_t s) {
        const int32_t lo = up(triangle, s) ? s : s + 1, hi = up(triangle, s) ? s + 1 : s;
        return std::pair{input_bits(triangle, lo), input_bits(triangle, hi)};
    };
    int32_t best = t;
    for (const Corner& other : edge(t, side)) {
        if (displaced(other[0]) && ends(other[0], other[1]) == ends(t, side))
            best = std::min(best, other[0]);
    }
    return best;
}

Point PlainDicer::side_point(int32_t t, int32_t side, int32_t i) const {
    const int32_t lo = up(t, side) ? side : (side + 1) % 3,
                  hi = up(t, side) ? (side + 1) % 3 : side;
    if (i == 0) return {Point::kCorner, lo, 0, 0, 0};
    if (i == factor(t, side)) return {Point::kCorner, hi, 0, 0, 0};
    return {Point::kSide, side, i, 0, 0};
}

Point PlainDicer::classify(int32_t t, int32_t a, int32_t b) const {
    const int32_t n = steps(t);
    int32_t side = -1, l = 0;  // l counts from the side's first corner
    if (b == 0) {
        side = 0, l = a;
    } else if (a + b == n) {
        side = 1, l = b;
    } else if (a == 0) {
        side = 2, l = n - b;
    } else {
        return {Point::kInner, 0, 0, a, b};
    }
    if (!up(t, side)) l = n - l;
    // Rounded to the nearest, halves up.
    const int64_t twice = 2 * static_cast<int64_t>(l) * factor(t, side) + n;
    return side_point(t, side, static_cast<int32_t>(twice / (2 * static_cast<int64_t>(n))));
}

void PlainDicer::add(const Vertex& a, const Vertex& b, const Vertex& c,
                     const std::vector<uint32_t>& ints, bool query, bool coverage) {
    if (a.position == b.position || b.position == c.position || c.position == a.position) return;
    DicedTriangle triangle;
    triangle.patch = patch_;
    triangle.in_patch = in_patch_++;
    triangle.query = query;
    triangle.coverage = coverage;
    triangle.positions = {a.position, b.position, c.position};
    if (query) triangle.floats = {a.floats, b.floats, c.floats}, triangle.ints = ints;
    out_.push_back(std::move(triangle));
}

void PlainDicer::do_identity(int32_t t) {
    std::vector<int32_t> split;
    for (int32_t side = 0; side < 3; ++side) {
        if (divided(t, side) && factor(t, side) > 1) split.push_back(side);
    }
    begin_patch();
    const Vertex v0 = vertex(t, {Point::kCorner, 0, 0, 0, 0}),
                 v1 = vertex(t, {Point::kCorner, 1, 0, 0, 0}),
                 v2 = vertex(t, {Point::kCorner, 2, 0, 0, 0});
    add(v0, v1, v2, v0.ints, true, split.empty());
    if (split.empty()) return;
    Vertex apex;
    std::vector<int32_t> around{0, 1, 2};
    if (split.size() == 1) {
        apex = vertex(t, {Point::kCorner, (split[0] + 2) % 3, 0, 0, 0});
        around = split;
    } else {
        Vec3d p;
        for (int axis = 0; axis < 3; ++axis) {
            const double a = position(t, 0)[axis], b = position(t, 1)[axis],
                         c = position(t, 2)[axis];
            p[axis] =
                std::clamp(((b - a) + (c - a)) / 3 + a, std::min({a, b, c}), std::max({a, b, c}));
        }
        apex.position = {static_cast<float>(p.x) + 0.0f, static_cast<float>(p.y) + 0.0f,
                         static_cast<float>(p.z) + 0.0f};
    }
    int32_t made = 0;
    for (const int32_t side : around) {
        const bool is_split = std::find(split.begin(), split.end(), side) != split.end();
        const int32_t n = is_split ? factor(t, side) : 1;
        const auto at = [&](int32_t j) {  // counted along the boundary
            if (!is_split) return vertex(t, {Point::kCorner, (side + j) % 3, 0, 0, 0});
            return vertex(t, side_point(t, side, up(t, side) ? j : n - j));
        };
        for (int32_t j = 0; j < n; ++j) {
            if (made++ % 2048 == 0) begin_patch();
            add(apex, at(j), at(j + 1), {}, false, true);
        }
    }
}

void PlainDicer::do_displaced(int32_t t) {
    const int32_t n = steps(t);
    std::map<std::array<int32_t, 2>, Vertex> made;
    const auto at = [&](int32_t a, int32_t b) -> const Vertex& {
        const auto found = made.find({a, b});
        if (found != made.end()) return found->second;
        return made[{a, b}] = vertex(t, classify(t, a, b));
    };
    for (int32_t b0 = 0; b0 < n; b0 += 32) {
        for (int32_t a0 = 0; a0 + b0 < n; a0 += 32) {
            begin_patch();
            for (int32_t b = b0; b < b0 + 32; ++b) {
                for (int32_t a = a0; a < a0 + 32; ++a) {
                    if (a + b + 1 <= n)
                        add(at(a, b), at(a + 1, b), at(a, b + 1), at(a, b).ints, true, true);
                    if (a + b + 2 <= n) {
                        add(at(a + 1, b), at(a + 1, b + 1), at(a, b + 1), at(a + 1, b).ints, true,
                            true);
                    }
                }
            }
        }
    }
}

void PlainDicer::do_strip(const Corner& forward, const Corner& backward) {
    const int32_t n = factor(forward[0], forward[1]);
    const auto at = [&](const Corner& side, int32_t i) {
        return vertex(side[0], side_point(side[0], side[1], i));
    };
    const auto corners = [&](int32_t t) {
        return std::array<Vec3d, 3>{position(t, 0), position(t, 1), position(t, 2)};
    };
    const StripEdge edge{position(forward[0], forward[1]), position(forward[0], forward[1] + 1),
                         corners(forward[0]), corners(backward[0]), s_};
    std::map<StripPlace, std::vector<Vertex>> places;
    std::vector<StripPoint> points;
    for (int32_t i = 0; i <= n; ++i) {
        const Vertex up = at(forward, i), down = at(backward, i);
        const Vec3d p = undisplaced(forward[0], side_point(forward[0], forward[1], i));
        points.push_back({vec_cast<float>(p) + Vec3f{}, up.position, down.position});
        places[StripPlace::kUp].push_back(up), places[StripPlace::kDown].push_back(down);
        for (const auto& [place, like] :
             {std::pair{StripPlace::kEdgeUp, &up}, std::pair{StripPlace::kEdgeDown, &down}}) {
            places[place].push_back(*like);
            places[place].back().position = points.back().edge;
        }
    }
    int32_t quad = -1;
    for (const StripTriangle& t : strip_triangles(edge, points)) {
        if (t.quad != quad && t.quad % 1024 == 0) begin_patch();
        quad = t.quad;
        const auto vertex = [&](const StripTriangle::Corner& c) -> const Vertex& {
            return places[c.place][c.point];
        };
        const bool of_up = t.ints == StripTriangle::kOfLower ? forward[0] < backward[0]
                                                             : t.ints == StripTriangle::kOfUp;
        add(vertex(t.corners[0]), vertex(t.corners[1]), vertex(t.corners[2]),
            vertex({of_up ? StripPlace::kUp : StripPlace::kDown, t.ints_from}).ints, true, true);
    }
}

void PlainDicer::do_vertex(const std::vector<Corner>& corners) {
    begin_patch();
    const auto at = [&](int32_t t, int32_t c) {
        return vertex(t, {Point::kCorner, c % 3, 0, 0, 0});
    };
    const Vertex first = at(corners[0][0], corners[0][1]);
    for (const Corner& corner : corners) {
        const std::optional<Corner> other = partner(corner[0], corner[1]);
        if (!other) continue;
        add(first, at((*other)[0], (*other)[1] + 1), at(corner[0], corner[1]), first.ints, true,
            true);
    }
}

std::vector<DicedTriangle> PlainDicer::run() {
    bool any = false;
    for (int32_t t = 0; t < triangles(); ++t) {
        if (dropped(t)) continue;
        any |= displaced(t);
        if (displaced(t)) {
            do_displaced(t);
        } else {
            do_identity(t);
        }
    }
    if (!any) return std::move(out_);
    for (int32_t t = 0; t < triangles(); ++t) {
        for (int32_t side = 0; side < 3 && !dropped(t); ++side) {
            const std::optional<Corner> other = partner(t, side);
            if (!other || *other < Corner{t, side}) continue;
            const int32_t u = (*other)[0], back = (*other)[1];
            if (!displaced(t) && !displaced(u)) continue;
            const bool alike = displaced(t) && displaced(u) &&
                               input_bits(t, side) == input_bits(u, back + 1) &&
                               input_bits(t, side + 1) == input_bits(u, back);
            if (alike) continue;
            if (up(t, side)) {
                do_strip({t, side}, *other);
            } else {
                do_strip(*other, {t, side});
            }
        }
    }
    // Vertices in order of their first corner.
    std::map<Corner, const std::vector<Corner>*> vertices;
    for (const auto& [position, corners] : at_vertex_)
        vertices[corners[0]] = &corners;
    for (const auto& [first, corners] : vertices) {
        bool alike = true;
        for (const Corner& c : *corners) {
            alike &= displaced(c[0]) == displaced(first[0]);
            if (displaced(first[0]))
                alike &= input_bits(c[0], c[1]) == input_bits(first[0], first[1]);
        }
        if (!alike) do_vertex(*corners);
    }
    return std::move(out_);
}

std::vector<DicedTriangle> dice(const part::Part& part, double micro_edge_mm,
                                const std::vector<uint8_t>& identity,
                                const EvaluateMicro& evaluate) {
    return PlainDicer(part, micro_edge_mm, identity, evaluate).run();
}

}  // namespace openfab::reference
