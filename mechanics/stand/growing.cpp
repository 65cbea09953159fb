// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/stand/growing.h"

#include <algorithm>

namespace openfab::mechanics {

std::vector<AirPlace> begins_in_the_air(const Grid& g, const Vec3& origin,
                                        std::span<const uint8_t> kind) {
    std::vector<AirPlace> out;
    int32_t ground = 0;
    const size_t plane = static_cast<size_t>(g.elements[0]) * static_cast<size_t>(g.elements[1]);
    while (ground < g.elements[2] &&
           std::ranges::find(kind.subspan(static_cast<size_t>(ground) * plane, plane), kSolid) ==
               kind.begin() + static_cast<ptrdiff_t>((static_cast<size_t>(ground) + 1) * plane))
        ++ground;
    std::vector<uint8_t> seen(plane);
    std::vector<size_t> waiting;
    for (int32_t z = ground + 1; z < g.elements[2]; ++z) {
        std::ranges::fill(seen, uint8_t{0});
        const uint8_t* layer = kind.data() + static_cast<size_t>(z) * plane;
        const uint8_t* below = layer - plane;
        for (size_t start = 0; start < plane; ++start) {
            if (layer[start] != kSolid || seen[start]) continue;
            waiting.assign(1, start);
            seen[start] = 1;
            bool carried = false;
            double x_sum = 0, y_sum = 0;
            int64_t count = 0;
            while (!waiting.empty()) {
                const size_t i = waiting.back();
                waiting.pop_back();
                carried = carried || below[i] == kSolid;
                const auto x = static_cast<int32_t>(i % static_cast<size_t>(g.elements[0]));
                const auto y = static_cast<int32_t>(i / static_cast<size_t>(g.elements[0]));
                x_sum += x + 0.5;
                y_sum += y + 0.5;
                ++count;
                const auto visit = [&](bool inside, size_t other) {
                    if (!inside || layer[other] != kSolid || seen[other]) return;
                    seen[other] = 1;
                    waiting.push_back(other);
                };
                visit(x > 0, i - 1);
                visit(x + 1 < g.elements[0], i + 1);
                visit(y > 0, i - static_cast<size_t>(g.elements[0]));
                visit(y + 1 < g.elements[1], i + static_cast<size_t>(g.elements[0]));
            }
            if (carried) continue;
            const auto n = static_cast<double>(count);
            out.push_back({{origin[0] + x_sum / n * g.pitch_mm[0],
                            origin[1] + y_sum / n * g.pitch_mm[1], origin[2] + z * g.pitch_mm[2]},
                           n * g.pitch_mm[0] * g.pitch_mm[1],
                           count});
        }
    }
    std::ranges::stable_sort(out, std::ranges::greater{}, &AirPlace::area_mm2);
    return out;
}

Voxels lowest_layers(const Voxels& v, int32_t layers) {
    Voxels out;
    out.size = {v.size[0], v.size[1], layers};
    out.pitch_mm = v.pitch_mm;
    out.origin_mm = v.origin_mm;
    out.materials = v.materials;
    out.share = v.share;
    const size_t n = static_cast<size_t>(v.size[0]) * static_cast<size_t>(v.size[1]) *
                     static_cast<size_t>(layers);
    out.make_of(v, [&](const auto& from, auto* to) {
        to->assign(from.begin(), from.begin() + static_cast<ptrdiff_t>(std::min(n, from.size())));
    });
    return out;
}

}  // namespace openfab::mechanics
