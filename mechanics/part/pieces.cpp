// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mechanics/messages.h"
#include "mechanics/part/eigen.h"

namespace openfab::mechanics {

Pieces pieces_of(const Grid& g, std::span<const uint8_t> kind) {
    Pieces out;
    out.of.assign(kind.size(), -1);
    std::vector<int64_t> waiting;
    for (int64_t start = 0; start < g.element_count(); ++start) {
        const auto s = static_cast<size_t>(start);
        if (kind[s] != kSolid || out.of[s] >= 0) continue;
        const auto number = static_cast<int32_t>(out.all.size());
        Piece piece{0, place_of(g, start), place_of(g, start)};
        waiting.assign(1, start);
        out.of[s] = number;
        while (!waiting.empty()) {
            const int64_t e = waiting.back();
            waiting.pop_back();
            ++piece.elements;
            const std::array<int32_t, 3> p = place_of(g, e);
            for (size_t a = 0; a < 3; ++a) {
                piece.low[a] = std::min(piece.low[a], p[a]);
                piece.high[a] = std::max(piece.high[a], p[a]);
                for (const int step : {-1, 1}) {
                    std::array<int32_t, 3> q = p;
                    q[a] += step;
                    if (q[a] < 0 || q[a] >= g.elements[a]) continue;
                    const size_t other = g.element(q[0], q[1], q[2]);
                    if (kind[other] != kSolid || out.of[other] >= 0) continue;
                    out.of[other] = number;
                    waiting.push_back(static_cast<int64_t>(other));
                }
            }
        }
        out.all.push_back(piece);
    }
    std::vector<int32_t> order(out.all.size()), rank(out.all.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, [&](int32_t a, int32_t b) {
        return out.all[static_cast<size_t>(a)].elements > out.all[static_cast<size_t>(b)].elements;
    });
    std::vector<Piece> sorted;
    for (size_t i = 0; i < order.size(); ++i) {
        rank[static_cast<size_t>(order[i])] = static_cast<int32_t>(i);
        sorted.push_back(out.all[static_cast<size_t>(order[i])]);
    }
    out.all = std::move(sorted);
    for (int32_t& p : out.of)
        if (p >= 0) p = rank[static_cast<size_t>(p)];
    return out;
}

std::string free_motion(const Grid& g, const Vec3& origin, std::span<const Held> held) {
    if (held.empty()) return messages::kMoveFreely;
    const auto place = [&](int64_t dof) {
        const int64_t node = dof / 3;
        return Vec3{
            origin[0] + static_cast<double>(node % g.nodes[0]) * g.pitch_mm[0],
            origin[1] + static_cast<double>(node / g.nodes[0] % g.nodes[1]) * g.pitch_mm[1],
            origin[2] + static_cast<double>(node / g.nodes[0] / g.nodes[1]) * g.pitch_mm[2]};
    };
    Vec3 middle{};
    for (const Held& h : held)
        for (size_t a = 0; a < 3; ++a)
            middle[a] += place(h.dof)[a] / static_cast<double>(held.size());
    double size = 0;
    for (const Held& h : held)
        for (size_t a = 0; a < 3; ++a)
            size = std::max(size, std::abs(place(h.dof)[a] - middle[a]));
    // One node alone holds nothing against turning.
    size = std::max(size, 1e-3 * g.pitch_mm[0]);
    std::vector<double> gram(36);
    for (const Held& h : held) {
        const auto c = static_cast<size_t>(h.dof % 3), a = (c + 1) % 3, b = (c + 2) % 3;
        const Vec3 p = place(h.dof);
        // Of the turns about a and b: (w x r)_c = w_a r_b - w_b r_a.
        double mode[6] = {};
        mode[c] = 1;
        mode[3 + a] = (p[b] - middle[b]) / size;
        mode[3 + b] = -(p[a] - middle[a]) / size;
        for (size_t i = 0; i < 6; ++i)
            for (size_t j = 0; j < 6; ++j)
                gram[i * 6 + j] += mode[i] * mode[j];
    }
    const Eigen e = eigen_of(gram, 6);
    constexpr double kNothing = 1e-9;
    if (e.values[0] > kNothing * e.values[5]) return {};
    // The motion that costs nothing, by its largest part.
    size_t most = 0;
    for (size_t i = 0; i < 6; ++i)
        if (std::abs(e.vectors[i]) > std::abs(e.vectors[most])) most = i;
    return fmt::format("{} {}", most < 3 ? messages::kSlideAlong : messages::kTurnAbout,
                       "xyz"[most % 3]);
}

}  // namespace openfab::mechanics
