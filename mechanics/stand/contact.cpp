// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/stand/contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace openfab::mechanics {

using HullPoint = std::array<double, 2>;

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

/// The lowest layers of solid elements.
FootLayers layers_of(const Grid& g, const Voxels& v, const PartElements& elements, int32_t lowest) {
    FootLayers out;
    out.size = {g.elements[0], g.elements[1], std::min(kFootLayers, g.elements[2] - lowest)};
    out.pitch_mm = g.pitch_mm;
    out.origin_mm = {v.origin_mm[0], v.origin_mm[1], v.origin_mm[2] + lowest * g.pitch_mm[2]};
    for (int32_t z = lowest; z < lowest + out.size[2]; ++z)
        for (int32_t y = 0; y < g.elements[1]; ++y)
            for (int32_t x = 0; x < g.elements[0]; ++x)
                out.inside.push_back(elements.kind[g.element(x, y, z)] == kSolid ? 1 : 0);
    return out;
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
    out.look_at(layers_of(g, v, elements, lowest));
    return out;
}

void Stand::look_at(const FootLayers& layers) {
    // The ground of finer voxels is lower than that of elements, which are half full.
    const auto lowest = std::ranges::find_if(layers.inside, [](uint8_t c) { return c != 0; });
    if (lowest != layers.inside.end())
        floor_mm =
            layers.origin_mm[2] +
            layers.pitch_mm[2] * static_cast<double>((lowest - layers.inside.begin()) /
                                                     (int64_t{layers.size[0]} * layers.size[1]));
    const double height = centre_mm[2] - floor_mm;
    foot = foot_of(layers, {centre_mm[0], centre_mm[1]}, height);
    margin_deg = std::atan2(foot.margin_mm, height) * 180 / std::numbers::pi;
}

}  // namespace openfab::mechanics
