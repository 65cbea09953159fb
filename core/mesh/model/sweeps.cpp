// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/model/sweeps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/rotation.h"
#include "mesh/model/primitive_builder.h"

namespace openfab::mesh {
namespace {

constexpr int32_t kTop = 0, kBottom = 1, kElsewhere = 2;
constexpr int32_t kFacetsOfSection = 64;

/// Returns how far along its outline each corner is, as a share of the whole; the last is 1.
std::vector<double> shares_along(const Outline& outline) {
    std::vector<double> shares{0};
    for (size_t c = 0; c < outline.size(); ++c) {
        const Point2 &a = outline[c], &b = outline[(c + 1) % outline.size()];
        shares.push_back(shares.back() +
                         std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y)));
    }
    for (double& share : shares)
        share /= shares.back();
    shares.back() = 1;
    return shares;
}

/// Adds points of a circle's arc in equal steps, without its last.
void add_arc(const Point2& middle, double radius, double from_deg, double to_deg, int32_t steps,
             Outline* out) {
    for (int32_t i = 0; i < steps; ++i) {
        const SinCos a = sin_cos_degrees(from_deg + (to_deg - from_deg) * i / steps);
        out->push_back({middle.x + radius * a.cos, middle.y + radius * a.sin});
    }
}

}  // namespace

Mesh make_extrusion(std::vector<Outline> outlines, double height_mm) {
    orient_outlines(&outlines);
    PrimitiveBuilder b("extrusion");
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Point2 lo{kFar, kFar}, hi{-kFar, -kFar};
    for (const Outline& outline : outlines) {
        for (const Point2& p : outline) {
            lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
            hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
        }
    }
    const int32_t up = b.normal({0, 0, 1}), down = b.normal({0, 0, -1});
    // Positions of each corner: below, above. Its uv on the caps, which are numbered alike.
    std::vector<int32_t> first_position, first_uv;
    for (const Outline& outline : outlines) {
        for (size_t c = 0; c < outline.size(); ++c) {
            const Point2& p = outline[c];
            const int32_t low = b.position({p.x, p.y, 0});
            b.position({p.x, p.y, height_mm});
            const int32_t uv = b.uv((p.x - lo.x) / (hi.x - lo.x), (p.y - lo.y) / (hi.y - lo.y));
            if (c == 0) {
                first_position.push_back(low);
                first_uv.push_back(uv);
            }
        }
    }
    for (const std::array<OutlineCorner, 3>& t : triangulate_area(outlines)) {
        std::array<int32_t, 3> low{}, uv{};
        for (size_t i = 0; i < 3; ++i) {
            const auto corner = static_cast<int32_t>(t[i].corner);
            low[i] = first_position[t[i].outline] + 2 * corner;
            uv[i] = first_uv[t[i].outline] + corner;
        }
        b.triangle({low[0] + 1, low[1] + 1, low[2] + 1}, uv, {up, up, up}, kTop);
        b.triangle({low[0], low[2], low[1]}, {uv[0], uv[2], uv[1]}, {down, down, down}, kBottom);
    }
    for (size_t o = 0; o < outlines.size(); ++o) {
        const Outline& outline = outlines[o];
        const std::vector<CornerNormals> normals = corner_normals(outline);
        const std::vector<double> along = shares_along(outline);
        for (size_t c = 0; c < outline.size(); ++c) {
            const size_t next = (c + 1) % outline.size();
            const int32_t low = first_position[o] + 2 * static_cast<int32_t>(c);
            const int32_t low_next = first_position[o] + 2 * static_cast<int32_t>(next);
            const Point2 &n0 = normals[c].after, &n1 = normals[next].before;
            const int32_t n = b.normal({n0.x, n0.y, 0}), n_next = b.normal({n1.x, n1.y, 0});
            b.quad({low, low_next, low_next + 1, low + 1},
                   {b.uv(along[c], 0), b.uv(along[c + 1], 0), b.uv(along[c + 1], 1),
                    b.uv(along[c], 1)},
                   {n, n_next, n_next, n}, kElsewhere);
        }
    }
    return b.take();
}

Mesh make_revolution(Outline outline) {
    std::vector<Outline> one{std::move(outline)};
    orient_outlines(&one);
    outline = std::move(one[0]);
    PrimitiveBuilder b("revolution");
    std::vector<SinCos> turns;
    for (int32_t i = 0; i <= kFacetsAround; ++i)
        turns.push_back(sin_cos_degrees(-90.0 + 360.0 * i / kFacetsAround));
    // The positions of each corner: one on the axis, else a ring.
    std::vector<int32_t> first;
    for (const Point2& p : outline) {
        const int32_t count = p.x == 0 ? 1 : kFacetsAround;
        for (int32_t i = 0; i < count; ++i) {
            const int32_t place = b.position({turns[i].cos * p.x, turns[i].sin * p.x, p.y});
            if (i == 0) first.push_back(place);
        }
    }
    const auto at = [&](size_t corner, int32_t i) {
        return first[corner] + (outline[corner].x == 0 ? 0 : i % kFacetsAround);
    };
    const std::vector<CornerNormals> normals = corner_normals(outline);
    const std::vector<double> along = shares_along(outline);
    for (size_t c = 0; c < outline.size(); ++c) {
        const size_t next = (c + 1) % outline.size();
        if (outline[c].x == 0 && outline[next].x == 0) continue;  // on the axis
        const Point2 &n0 = normals[c].after, &n1 = normals[next].before;
        // Area on its left, z up: to the right of the way is outside.
        const bool level = outline[c].y == outline[next].y;
        const int32_t face = !level ? kElsewhere : outline[c].x > outline[next].x ? kTop : kBottom;
        std::array<int32_t, 2> n{}, uv{};
        for (int32_t i = 0; i <= kFacetsAround; ++i) {
            const std::array<int32_t, 2> n_before = n, uv_before = uv;
            const double u = static_cast<double>(i) / kFacetsAround;
            n = {b.normal({turns[i].cos * n0.x, turns[i].sin * n0.x, n0.y}),
                 b.normal({turns[i].cos * n1.x, turns[i].sin * n1.x, n1.y})};
            uv = {b.uv(u, along[c]), b.uv(u, along[c + 1])};
            if (i == 0) continue;
            const int32_t p0 = at(c, i - 1), p1 = at(c, i), p2 = at(next, i), p3 = at(next, i - 1);
            if (p0 != p1)
                b.triangle({p0, p1, p2}, {uv_before[0], uv[0], uv[1]}, {n_before[0], n[0], n[1]},
                           face);
            if (p2 != p3)
                b.triangle({p0, p2, p3}, {uv_before[0], uv[1], uv_before[1]},
                           {n_before[0], n[1], n_before[1]}, face);
        }
    }
    return b.take();
}

Mesh make_cone(double low_diameter_mm, double high_diameter_mm, double height_mm) {
    Outline outline{{0, 0}};
    if (low_diameter_mm > 0) outline.push_back({low_diameter_mm / 2, 0});
    if (high_diameter_mm > 0) outline.push_back({high_diameter_mm / 2, height_mm});
    outline.push_back({0, height_mm});
    return make_revolution(std::move(outline));
}

Mesh make_torus(double diameter_mm, double section_mm) {
    Outline outline;
    add_arc({diameter_mm / 2, section_mm / 2}, section_mm / 2, -90, 270, kFacetsOfSection,
            &outline);
    return make_revolution(std::move(outline));
}

Mesh make_capsule(double diameter_mm, double length_mm) {
    const double r = diameter_mm / 2;
    Outline outline;
    add_arc({0, r}, r, -90, 0, kFacetsOfSection / 2, &outline);
    if (length_mm > diameter_mm) outline.push_back({r, r});
    add_arc({0, length_mm - r}, r, 0, 90, kFacetsOfSection / 2, &outline);
    outline.push_back({0, length_mm});
    return make_revolution(std::move(outline));
}

}  // namespace openfab::mesh
