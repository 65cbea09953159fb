// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/stand/contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mechanics/part/pieces.h"

namespace openfab::mechanics {

using HullPoint = std::array<double, 2>;

namespace {

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

/// The piece of each element, or that which it is next to: what is half full at a surface belongs to it.
std::vector<int32_t> with_surfaces(const Grid& g, const Pieces& pieces) {
    std::vector<int32_t> out = pieces.of;
    for (int64_t e = 0; e < g.element_count(); ++e) {
        int32_t& own = out[static_cast<size_t>(e)];
        const std::array<int32_t, 3> p = place_of(g, e);
        // Faces first, then edges and corners.
        for (int32_t far = 1; own < 0 && far <= 3; ++far)
            for (int32_t i = 0; own < 0 && i < 27; ++i) {
                const std::array<int32_t, 3> by{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
                if (std::abs(by[0]) + std::abs(by[1]) + std::abs(by[2]) != far) continue;
                bool inside = true;
                for (size_t a = 0; a < 3; ++a)
                    inside = inside && p[a] + by[a] >= 0 && p[a] + by[a] < g.elements[a];
                if (inside) own = pieces.of[g.element(p[0] + by[0], p[1] + by[1], p[2] + by[2])];
            }
    }
    return out;
}

/// Of the layers what is in the elements of a piece.
FootLayers layers_of_piece(const FootLayers& all, const Grid& g, const Vec3& origin_mm,
                           const Piece& piece, const std::vector<int32_t>& of, int32_t number) {
    FootLayers out;
    std::array<int32_t, 3> low{};
    for (size_t a = 0; a < 3; ++a) {
        const auto at = [&](int32_t element) {
            const double mm = origin_mm[a] + element * g.pitch_mm[a] - all.origin_mm[a];
            return std::clamp(mm / all.pitch_mm[a], 0.0, static_cast<double>(all.size[a]));
        };
        low[a] = static_cast<int32_t>(std::floor(at(piece.low[a] - 1)));
        out.size[a] = static_cast<int32_t>(std::ceil(at(piece.high[a] + 2))) - low[a];
        out.origin_mm[a] = all.origin_mm[a] + low[a] * all.pitch_mm[a];
    }
    out.pitch_mm = all.pitch_mm;
    const auto element_at = [&](int32_t voxel, size_t a) {
        const double mm = out.origin_mm[a] + (voxel + 0.5) * out.pitch_mm[a] - origin_mm[a];
        return std::clamp(static_cast<int32_t>(std::floor(mm / g.pitch_mm[a])), 0,
                          g.elements[a] - 1);
    };
    for (int32_t z = 0; z < out.size[2]; ++z)
        for (int32_t y = 0; y < out.size[1]; ++y) {
            const auto row = static_cast<size_t>(
                (int64_t{z + low[2]} * all.size[1] + y + low[1]) * all.size[0] + low[0]);
            for (int32_t x = 0; x < out.size[0]; ++x) {
                const size_t e = g.element(element_at(x, 0), element_at(y, 1), element_at(z, 2));
                const bool own = of[e] == number && all.inside[row + static_cast<size_t>(x)] != 0;
                out.inside.push_back(own ? 1 : 0);
            }
        }
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
    out.look_at(layers_of(g, v, elements, lowest));
    return out;
}

void Stand::look_at_contact(const FootLayers& layers) {
    // The ground of finer voxels is lower than that of elements, which are half full.
    const auto layer = static_cast<ptrdiff_t>(int64_t{layers.size[0]} * layers.size[1]);
    const auto lowest = std::ranges::find_if(layers.inside, [](uint8_t c) { return c != 0; });
    if (lowest == layers.inside.end()) return;
    const ptrdiff_t z = (lowest - layers.inside.begin()) / layer;
    const double dx = layers.pitch_mm[0], dy = layers.pitch_mm[1];
    floor_mm = layers.origin_mm[2] + layers.pitch_mm[2] * static_cast<double>(z);
    contact_mm2 = 0;
    std::vector<HullPoint> corners;
    auto row = layers.inside.begin() + z * layer;
    for (int32_t y = 0; y < layers.size[1]; ++y, row += layers.size[0]) {
        const auto end = row + layers.size[0];
        const auto solid = [](uint8_t c) { return c != 0; };
        contact_mm2 += dx * dy * static_cast<double>(std::count_if(row, end, solid));
        // The first and the last of a row have the hull.
        const auto first = std::find_if(row, end, solid);
        if (first == end) continue;
        auto past = end;
        while (past[-1] == 0)
            --past;
        for (const auto at : {first, past})
            for (const int32_t side : {y, y + 1})
                corners.push_back({layers.origin_mm[0] + static_cast<double>(at - row) * dx,
                                   layers.origin_mm[1] + side * dy});
    }
    hull_mm = convex_hull(std::move(corners));
}

void Stand::look_at(const FootLayers& layers) {
    look_at_contact(layers);
    const double height = centre_mm[2] - floor_mm;
    foot = foot_of(layers, {centre_mm[0], centre_mm[1]}, height);
    margin_deg = std::atan2(foot.margin_mm, height) * 180 / std::numbers::pi;
}

void Stand::look_at_pieces(const Grid& g, const Voxels& v, const PartElements& elements, bool known,
                           const FootLayers& layers) {
    const Pieces all = pieces_of(g, elements.kind);
    pieces = all.all.size();
    if (pieces < 2) return look_at(layers);
    look_at_contact(layers);
    const std::vector<int32_t> of = with_surfaces(g, all);
    std::vector<double> mass(pieces);
    std::vector<Vec3> moment(pieces);
    for (int64_t e = 0; e < g.element_count(); ++e) {
        const auto at = static_cast<size_t>(e);
        if (of[at] < 0) continue;
        const auto k = static_cast<size_t>(of[at]);
        const auto m = static_cast<double>(known ? v.density[at] : v.solid[at]);
        const std::array<int32_t, 3> p = place_of(g, e);
        mass[k] += m;
        for (size_t a = 0; a < 3; ++a)
            moment[k][a] += m * (v.origin_mm[a] + (p[a] + 0.5) * g.pitch_mm[a]);
    }
    bool first = true;
    for (size_t k = 0; k < pieces; ++k) {
        Stand one;
        for (size_t a = 0; a < 3; ++a)
            one.centre_mm[a] = moment[k][a] / std::max(mass[k], 1e-300);
        one.look_at(
            layers_of_piece(layers, g, v.origin_mm, all.all[k], of, static_cast<int32_t>(k)));
        const bool less = one.stands() == stands() ? one.margin_deg < margin_deg : stands();
        if (!std::exchange(first, false) && !less) continue;
        foot = one.foot;
        margin_deg = one.margin_deg;
        floor_mm = one.floor_mm;
        of_piece_mm = one.centre_mm;
    }
}

}  // namespace openfab::mechanics
