// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/trays.h"

#include <algorithm>
#include <numeric>

namespace openfab::tools {

namespace {

constexpr double kSlack_mm = 1e-6;

/// Things in a row, from the left; rows follow each other to the back.
struct Row {
    double y = 0, depth = 0, x = 0;
};

struct Tray {
    std::vector<Row> rows;

    /// Returns whether there is room for a box of that size, and where.
    bool take(const Vec3d& size, const Vec3d& tray, double gap, Vec3d* at) {
        for (Row& row : rows) {
            if (size.y > row.depth + kSlack_mm || row.x + size.x > tray.x + kSlack_mm) continue;
            *at = {row.x, row.y, 0};
            row.x += size.x + gap;
            return true;
        }
        const double y = rows.empty() ? 0 : rows.back().y + rows.back().depth + gap;
        if (y + size.y > tray.y + kSlack_mm) return false;
        rows.push_back({y, size.y, size.x + gap});
        *at = {0, y, 0};
        return true;
    }
};

}  // namespace

std::vector<std::array<double, 9>> right_angled() {
    return {{1, 0, 0, 0, 1, 0, 0, 0, 1},  {0, -1, 0, 1, 0, 0, 0, 0, 1},
            {1, 0, 0, 0, 0, -1, 0, 1, 0}, {0, 0, 1, 0, 1, 0, -1, 0, 0},
            {0, 0, 1, 1, 0, 0, 0, 1, 0},  {0, -1, 0, 0, 0, -1, 1, 0, 0}};
}

std::vector<Spot> put_on_trays(const std::vector<std::vector<Pose>>& things, const Vec3d& tray_mm,
                               double gap_mm) {
    const auto fits = [&](const Pose& pose) {
        const Vec3d size = pose.box.size();
        return size.x <= tray_mm.x + kSlack_mm && size.y <= tray_mm.y + kSlack_mm &&
               size.z <= tray_mm.z + kSlack_mm;
    };
    std::vector<size_t> order(things.size());
    std::iota(order.begin(), order.end(), size_t{0});
    const auto area = [&](size_t i) {
        const Vec3d size = things[i][0].box.size();
        return size.x * size.y;
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return area(a) > area(b); });
    std::vector<Tray> trays;
    std::vector<Spot> out;
    for (const size_t thing : order) {
        Spot spot;
        spot.thing = static_cast<int32_t>(thing);
        bool put = false;
        for (size_t t = 0; t <= trays.size() && !put; ++t) {
            if (t == trays.size()) {
                if (!std::any_of(things[thing].begin(), things[thing].end(), fits)) break;
                trays.emplace_back();
            }
            for (size_t p = 0; p < things[thing].size() && !put; ++p) {
                const Pose& pose = things[thing][p];
                if (!fits(pose)) continue;
                Vec3d at;
                if (!trays[t].take(pose.box.size(), tray_mm, gap_mm, &at)) continue;
                spot.tray = static_cast<int32_t>(t);
                spot.pose = p;
                spot.move_mm = at - pose.box.lo;
                put = true;
            }
        }
        if (put) out.push_back(spot);
    }
    return out;
}

}  // namespace openfab::tools
