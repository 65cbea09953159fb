// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/fraction_average.h"

#include <algorithm>
#include <atomic>

#include "base/check.h"

namespace openfab::raster {

namespace {

constexpr float kWhole = 65535;  // of a fraction

}  // namespace

Result<void> FractionAverage::begin(const pipeline::PrintInfo& fine, int32_t materials) {
    OPENFAB_CHECK_EQ(fine.size.x, coarse_.size.x * times_.x);
    OPENFAB_CHECK_EQ(fine.size.y, coarse_.size.y * times_.y);
    OPENFAB_CHECK_EQ(fine.size.z, (coarse_.slice_end - coarse_.slice_begin) * times_.z);
    materials_ = materials;
    return to_.begin(coarse_, materials);
}

uint32_t* FractionAverage::layer(int32_t z) {
    const std::lock_guard lock(mutex_);
    std::vector<uint32_t>& sums = layers_[z];
    if (sums.empty()) {
        sums.resize(static_cast<size_t>(coarse_.size.x) * static_cast<size_t>(coarse_.size.y) *
                    static_cast<size_t>(materials_));
    }
    return sums.data();
}

void FractionAverage::write(int32_t z, int32_t y, int32_t first_x,
                            std::span<const float> fractions) {
    if (std::all_of(fractions.begin(), fractions.end(), [](float f) { return f == 0; })) return;
    const auto materials = static_cast<size_t>(materials_);
    uint32_t* row = layer(z / times_.z) + static_cast<size_t>(y / times_.y) *
                                              static_cast<size_t>(coarse_.size.x) * materials;
    const auto count = static_cast<int32_t>(fractions.size() / materials);
    for (int32_t i = 0; i < count;) {
        const int32_t x = (first_x + i) / times_.x;
        const int32_t end = std::min(count, (x + 1) * times_.x - first_x);
        for (size_t m = 0; m < materials; ++m) {
            uint32_t sum = 0;
            for (int32_t k = i; k < end; ++k) {
                const float fraction = fractions[static_cast<size_t>(k) * materials + m];
                sum += static_cast<uint32_t>(fraction * kWhole + 0.5f);
            }
            // Other threads add other rows and slices of the same coarse voxels.
            if (sum == 0) continue;
            std::atomic_ref(row[static_cast<size_t>(x) * materials + m])
                .fetch_add(sum, std::memory_order_relaxed);
        }
        i = end;
    }
}

int32_t FractionAverage::passed(int32_t z) {
    if ((z + 1) % times_.z != 0) return -1;
    const int32_t coarse_z = coarse_.slice_begin + z / times_.z;
    std::vector<uint32_t> sums;
    {
        const std::lock_guard lock(mutex_);
        const auto found = layers_.find(z / times_.z);
        if (found == layers_.end()) return coarse_z;
        sums = std::move(found->second);
        layers_.erase(found);
    }
    const size_t width = static_cast<size_t>(coarse_.size.x) * static_cast<size_t>(materials_);
    const double whole = double{kWhole} * times_.x * times_.y * times_.z;
    std::vector<float> row(width);
    for (int32_t y = 0; y < coarse_.size.y; ++y) {
        const uint32_t* from = sums.data() + static_cast<size_t>(y) * width;
        std::transform(from, from + width, row.begin(),
                       [&](uint32_t sum) { return static_cast<float>(sum / whole); });
        to_.write(coarse_z, y, 0, row);
    }
    return coarse_z;
}

Result<void> FractionAverage::finish(const pipeline::PrintTotals& totals) {
    complete_ = totals.complete;
    return {};
}

int64_t FractionAverage::bytes_per_fraction(const Vec3i& times, int32_t slabs) {
    const int64_t layers = (8 * int64_t{slabs} + times.z - 1) / times.z + 2;
    const int64_t columns = int64_t{times.x} * times.y;
    return (layers * static_cast<int64_t>(sizeof(uint32_t)) + columns - 1) / columns;
}

}  // namespace openfab::raster
