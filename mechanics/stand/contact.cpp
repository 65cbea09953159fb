// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/stand/contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace openfab::mechanics {

using HullPoint = std::array<double, 2>;

std::vector<HullPoint> convex_hull(std::vector<HullPoint> p) {
    std::ranges::sort(p);
    p.erase(std::ranges::unique(p).begin(), p.end());
    if (p.size() < 3) return p;
    const auto left = [](const HullPoint& a, const HullPoint& b, const HullPoint& c) {
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    };
    std::vector<HullPoint> out(2 * p.size());
    size_t k = 0;
    for (const HullPoint& one : p) {
        while (k >= 2 && left(out[k - 2], out[k - 1], one) <= 0)
            --k;
        out[k++] = one;
    }
    const size_t lower = k + 1;
    for (size_t i = p.size() - 1; i-- > 0;) {
        while (k >= lower && left(out[k - 2], out[k - 1], p[i]) <= 0)
            --k;
        out[k++] = p[i];
    }
    out.resize(k - 1);
    return out;
}

namespace {

/// The convex hull of a layer's solid elements.
std::vector<HullPoint> hull_of(const Grid& g, const Voxels& v, const PartElements& elements,
                               int32_t z, double* area_mm2) {
    std::vector<HullPoint> corners;
    for (int32_t y = 0; y < g.elements[1]; ++y) {
        // The first and the last of a row have the hull.
        int32_t first = -1, last = -1;
        for (int32_t x = 0; x < g.elements[0]; ++x) {
            if (elements.kind[g.element(x, y, z)] != kSolid) continue;
            if (first < 0) first = x;
            last = x;
            *area_mm2 += g.pitch_mm[0] * g.pitch_mm[1];
        }
        if (first < 0) continue;
        for (const int32_t x : {first, last + 1})
            for (const int32_t row : {y, y + 1})
                corners.push_back(
                    {v.origin_mm[0] + x * g.pitch_mm[0], v.origin_mm[1] + row * g.pitch_mm[1]});
    }
    return convex_hull(std::move(corners));
}

/// How far a point is inside of a hull, from its nearest edge; below 0 outside.
double inside_of(const std::vector<HullPoint>& hull, const Vec3& centre, HullPoint* towards) {
    double least = 1e300;
    for (size_t i = 0; i < hull.size(); ++i) {
        const HullPoint& a = hull[i];
        const HullPoint& b = hull[(i + 1) % hull.size()];
        const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
        const HullPoint outwards{(b[1] - a[1]) / length, -(b[0] - a[0]) / length};
        const double inside = outwards[0] * (a[0] - centre[0]) + outwards[1] * (a[1] - centre[1]);
        if (inside >= least) continue;
        least = inside;
        *towards = outwards;
    }
    return least;
}

/// The radius of what the lowest layers grow like, or 0 where they do not grow as a staircase does. The square
/// of a ball's section grows by twice its radius with each mm; a flat side's begins with a size of its own.
double round_of(const Grid& g, const Voxels& v, const PartElements& elements, int32_t lowest,
                const Vec3& centre) {
    // A twelfth of the part, and not a single layer, for what two layers say is as rough as voxels are.
    int32_t highest = lowest;
    for (int32_t z = lowest; z < g.elements[2]; ++z)
        for (int32_t i = 0; i < g.elements[0] * g.elements[1]; ++i)
            if (elements.kind[g.element(0, 0, z) + static_cast<size_t>(i)] == kSolid) {
                highest = z;
                break;
            }
    const int32_t far = std::max(2, (highest - lowest + 1) / 12);
    if (lowest + 2 * far > highest) return 0;
    double square[3], ignored = 0;
    HullPoint towards;
    for (int32_t k = 0; k < 3; ++k) {
        const double inside =
            inside_of(hull_of(g, v, elements, lowest + k * far, &ignored), centre, &towards);
        if (!(inside > 0) || inside > 1e200) return 0;
        square[k] = inside * inside;
    }
    const double first = square[1] - square[0], second = square[2] - square[1];
    // At the ground, half an element below the first layer's middle.
    const double ground = square[0] - first / (2 * far);
    constexpr double kGrowsOn = 0.3, kVanishes = 0.3;
    if (!(first > 0) || second < kGrowsOn * first || ground > kVanishes * square[0]) return 0;
    return first / (2 * far * g.pitch_mm[2]);
}

}  // namespace

Stand stand_of(const Grid& g, const Voxels& v, const PartElements& elements, bool known) {
    Stand out;
    const double volume = g.pitch_mm[0] * g.pitch_mm[1] * g.pitch_mm[2];
    double mass = 0;
    std::array<double, 3> moment{};
    int32_t lowest = INT32_MAX;
    for (int64_t e = 0; e < g.element_count(); ++e) {
        const auto at = static_cast<size_t>(e);
        if (!(v.solid[at] > 0)) continue;
        const double share = static_cast<double>(v.solid[at]);
        const double m = volume * (known ? static_cast<double>(v.density[at]) : share);
        const std::array<int32_t, 3> p = place_of(g, e);
        mass += m;
        out.volume_mm3 += volume * share;
        for (size_t a = 0; a < 3; ++a)
            moment[a] += m * (v.origin_mm[a] + (p[a] + 0.5) * g.pitch_mm[a]);
        if (elements.kind[at] == kSolid) lowest = std::min(lowest, p[2]);
    }
    out.mass_g = mass / 1000;
    if (!(mass > 0) || lowest == INT32_MAX) return out;
    for (size_t a = 0; a < 3; ++a)
        out.centre_mm[a] = moment[a] / mass;
    out.floor_mm = v.origin_mm[2] + lowest * g.pitch_mm[2];
    out.hull_mm = hull_of(g, v, elements, lowest, &out.contact_mm2);
    const double height = out.centre_mm[2] - out.floor_mm;
    const double least = inside_of(out.hull_mm, out.centre_mm, &out.falls_towards);
    out.margin_deg = std::atan2(least, height) * 180 / std::numbers::pi;
    out.round_mm = round_of(g, v, elements, lowest, out.centre_mm);
    return out;
}

}  // namespace openfab::mechanics
