// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "python/src/slice_queue.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "backends/common/tee_sink.h"
#include "base/check.h"

namespace openfab::python {

Result<void> FractionPlanes::begin(const pipeline::PrintInfo& info, int32_t materials) {
    width_ = static_cast<size_t>(info.size.x);
    height_ = static_cast<size_t>(info.size.y);
    materials_ = materials;
    return {};
}

void FractionPlanes::put(std::map<int32_t, std::vector<float>>* planes, size_t per_voxel, int32_t z,
                         int32_t y, int32_t first_x, std::span<const float> values) {
    float* plane = nullptr;
    {
        const std::lock_guard lock(mutex_);
        std::vector<float>& all = (*planes)[z];
        if (all.empty()) all.resize(width_ * height_ * per_voxel);
        plane = all.data();
    }
    const size_t at = (static_cast<size_t>(y) * width_ + static_cast<size_t>(first_x)) * per_voxel;
    OPENFAB_CHECK_LE(at + values.size(), width_ * height_ * per_voxel);
    std::copy(values.begin(), values.end(), plane + at);
}

void FractionPlanes::write(int32_t z, int32_t y, int32_t first_x,
                           std::span<const float> fractions) {
    put(&planes_, static_cast<size_t>(materials_), z, y, first_x, fractions);
}

void FractionPlanes::write_rates(int32_t z, int32_t y, int32_t first_x,
                                 std::span<const float> rates) {
    put(&rates_, static_cast<size_t>(materials_ * columns_), z, y, first_x, rates);
}

std::vector<float> FractionPlanes::take(std::map<int32_t, std::vector<float>>* planes,
                                        size_t per_voxel, int32_t z) {
    const std::lock_guard lock(mutex_);
    auto node = planes->extract(z);
    if (!node.empty()) return std::move(node.mapped());
    return std::vector<float>(width_ * height_ * per_voxel);
}

std::vector<float> FractionPlanes::take(int32_t z) {
    return take(&planes_, static_cast<size_t>(materials_), z);
}

std::vector<float> FractionPlanes::take_rates(int32_t z) {
    return take(&rates_, static_cast<size_t>(materials_ * columns_), z);
}

Result<void> SliceQueue::begin(const pipeline::PrintInfo& info) {
    bits_ = info.bits;
    return {};
}

std::vector<uint8_t> SliceQueue::encode(const pipeline::SliceView& slice) const {
    const auto width = static_cast<size_t>(slice.width);
    std::vector<uint8_t> codes(width * static_cast<size_t>(slice.height));
    for (int32_t y = 0; y < slice.height; ++y)
        backends::unpack_row(slice, y, bits_, codes.data() + static_cast<size_t>(y) * width);
    return codes;
}

Result<void> SliceQueue::commit(int32_t z, std::vector<uint8_t> bytes) {
    Slice slice{z, std::move(bytes), {}, {}};
    if (fractions_ != nullptr) slice.fractions = fractions_->take(z);
    if (fractions_ != nullptr && fractions_->rate_columns() > 0)
        slice.rates = fractions_->take_rates(z);
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || slices_.size() < kMostSlices; });
    if (closed_) return Error{ErrorCode::kInterrupted, "nobody takes the slices any more"};
    slices_.push_back(std::move(slice));
    lock.unlock();
    changed_.notify_all();
    return {};
}

std::optional<Slice> SliceQueue::take(double seconds) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::duration<double>(seconds),
                      [&] { return closed_ || !slices_.empty(); });
    if (slices_.empty()) return std::nullopt;
    Slice slice = std::move(slices_.front());
    slices_.pop_front();
    lock.unlock();
    changed_.notify_all();
    return slice;
}

void SliceQueue::close() {
    {
        const std::lock_guard lock(mutex_);
        closed_ = true;
    }
    changed_.notify_all();
}

}  // namespace openfab::python
