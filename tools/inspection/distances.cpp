// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/inspection/distances.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "tools/inspection/spread.h"

namespace openfab::inspection {

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
    const SpreadKernels& kernels = spread_kernels();
    const auto of = [](const std::vector<uint16_t>& costs) {
        return std::pair{costs.data() + costs.size() / 2, static_cast<int32_t>(costs.size() / 2)};
    };
    const auto [x_cost, x_steps] = of(x_costs);
    const auto [y_cost, y_steps] = of(y_costs);
    const auto [z_cost, z_steps] = of(z_costs);
    tbb::parallel_for(
        0, size.z,
        [&, x_cost = x_cost, x_steps = x_steps, y_cost = y_cost, y_steps = y_steps](int32_t z) {
            std::vector<uint16_t> along(width + x_costs.size(), kFar);
            std::vector<uint16_t> across(static_cast<size_t>(size.y) * kPiece);
            std::vector<Piece> pieces(std::max(width / kPiece + 1, static_cast<size_t>(size.y)));
            for (int32_t y = 0; y < size.y; ++y) {
                kernels.along(&values->values[values->at(0, y, z)], size.x, x_cost, x_steps,
                              along.data(), pieces.data());
            }
            kernels.across(&values->values[values->at(0, 0, z)], width, size.y, size.x, y_cost,
                           y_steps, across.data(), pieces.data());
        });
    tbb::parallel_for(0, size.y, [&, z_cost = z_cost, z_steps = z_steps](int32_t y) {
        std::vector<uint16_t> across(static_cast<size_t>(size.z) * kPiece);
        std::vector<Piece> pieces(static_cast<size_t>(size.z));
        kernels.across(&values->values[values->at(0, y, 0)], width * static_cast<size_t>(size.y),
                       size.z, size.x, z_cost, z_steps, across.data(), pieces.data());
    });
}

}  // namespace openfab::inspection
