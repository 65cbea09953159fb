// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "inspection/distances.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace openfab::inspection {

namespace {

constexpr uint16_t kFar = Squares::kFar;

/// Lowers numbers to others, each with the same cost added. Both stay below 2^15, their sum below 2^16.
void lower(const uint16_t* from, uint16_t cost, int32_t count, uint16_t* to) {
    for (int32_t i = 0; i < count; ++i) {
        const auto sum = static_cast<uint16_t>(from[i] + cost);
        to[i] = sum < to[i] ? sum : to[i];
    }
}

/// Whether a row holds something to spread, and something to lower.
struct Row {
    bool gives = false, takes = false;
    Row(const uint16_t* values, int32_t count) {
        uint16_t least = kFar, most = 0;
        for (int32_t i = 0; i < count; ++i)
            least = std::min(least, values[i]), most = std::max(most, values[i]);
        gives = least<kFar, takes = most> 0;
    }
};

/// Spreads rows of numbers to each other, `stride` apart, with room for all of them in `copy`.
void spread_rows(uint16_t* first, size_t stride, int32_t rows, int32_t width,
                 const std::vector<uint16_t>& costs, std::vector<uint16_t>* copy) {
    copy->resize(static_cast<size_t>(rows) * static_cast<size_t>(width));
    std::vector<Row> are;
    bool any = false;
    for (int32_t r = 0; r < rows; ++r) {
        const uint16_t* from = first + static_cast<size_t>(r) * stride;
        std::copy(from, from + width,
                  copy->begin() + static_cast<ptrdiff_t>(r) * static_cast<ptrdiff_t>(width));
        are.emplace_back(from, width);
        any |= are.back().gives;
    }
    if (!any) return;
    const auto steps = static_cast<int32_t>(costs.size() / 2);
    for (int32_t r = 0; r < rows; ++r) {
        // Half a voxel off, a row does not hold its own numbers any more.
        const uint16_t own = costs[static_cast<size_t>(steps)];
        if (!are[static_cast<size_t>(r)].takes && own == 0) continue;
        uint16_t* to = first + static_cast<size_t>(r) * stride;
        if (own > 0) std::fill(to, to + width, kFar);
        for (int32_t d = std::max(-steps, -r); d <= std::min(steps, rows - 1 - r); ++d) {
            if ((d == 0 && own == 0) || !are[static_cast<size_t>(r + d)].gives) continue;
            lower(copy->data() + static_cast<size_t>(r + d) * static_cast<size_t>(width),
                  costs[static_cast<size_t>(d + steps)], width, to);
        }
    }
}

/// Spreads the numbers of one row along it; `copy` is one that has room for the reach at both ends.
void spread_along(uint16_t* row, int32_t width, const std::vector<uint16_t>& costs,
                  std::vector<uint16_t>* copy) {
    const Row is(row, width);
    const auto steps = static_cast<int32_t>(costs.size() / 2);
    const uint16_t own = costs[static_cast<size_t>(steps)];
    if (!is.gives || (!is.takes && own == 0)) return;
    std::copy(row, row + width, copy->begin() + steps);
    if (own > 0) std::fill(row, row + width, kFar);
    for (int32_t d = -steps; d <= steps; ++d)
        lower(copy->data() + steps + d, costs[static_cast<size_t>(d + steps)], width, row);
}

}  // namespace

Squares::Squares(const Vec3d& pitch_mm, double reach_mm) : pitch_mm_(pitch_mm) {
    // Halves of voxels have quarters of squares.
    constexpr double kMost = 32000, kQuarters = 4;
    const double coarse = reach_mm * reach_mm / kMost;
    const bool cubes = pitch_mm.x == pitch_mm.y && pitch_mm.x == pitch_mm.z;
    const double exact = pitch_mm.x * pitch_mm.x / kQuarters;
    unit_mm2_ = cubes ? std::max(coarse, exact) : coarse;
    for (int axis = 0; axis < 3; ++axis)
        steps_[axis] = static_cast<int32_t>(std::min(reach_mm / pitch_mm[axis], 1e6)) + 2;
}

uint16_t Squares::from(double mm) const {
    constexpr double kRounding = 1e-6;
    const double square = std::ceil(mm * mm / unit_mm2_ - kRounding);
    return static_cast<uint16_t>(std::clamp(square, 0.0, double{kFar}));
}

double Squares::length(uint16_t square) const {
    return std::sqrt(square * unit_mm2_);
}

std::vector<uint16_t> Squares::costs(int axis, int32_t half) const {
    const int32_t steps = steps_[axis];
    std::vector<uint16_t> out;
    for (int32_t d = -steps; d <= steps; ++d) {
        const double mm = (d - 0.5 * half) * pitch_mm_[axis];
        out.push_back(static_cast<uint16_t>(std::min(mm * mm / unit_mm2_ + 0.5, double{kFar})));
    }
    return out;
}

void Squares::spread(Box<uint16_t>* values, const Vec3i& half) const {
    const Vec3i& size = values->size;
    const std::vector<uint16_t> x_costs = costs(0, half.x), y_costs = costs(1, half.y),
                                z_costs = costs(2, half.z);
    const auto width = static_cast<size_t>(size.x);
    tbb::parallel_for(0, size.z, [&](int32_t z) {
        std::vector<uint16_t> row(width + x_costs.size(), kFar), copy;
        for (int32_t y = 0; y < size.y; ++y)
            spread_along(&values->values[values->at(0, y, z)], size.x, x_costs, &row);
        spread_rows(&values->values[values->at(0, 0, z)], width, size.y, size.x, y_costs, &copy);
    });
    tbb::parallel_for(0, size.y, [&](int32_t y) {
        std::vector<uint16_t> copy;
        spread_rows(&values->values[values->at(0, y, 0)], width * static_cast<size_t>(size.y),
                    size.z, size.x, z_costs, &copy);
    });
}

}  // namespace openfab::inspection
