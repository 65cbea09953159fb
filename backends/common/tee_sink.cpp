// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/common/tee_sink.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "base/check.h"

namespace openfab::backends {

Result<void> TeeSink::begin(const pipeline::PrintInfo& info) {
    width_ = info.size.x;
    height_ = info.size.y;
    row_bytes_ = packed_row_bytes(info.size.x, info.bits);
    for (const std::unique_ptr<SliceObserver>& observer : observers_) {
        if (Result<void> done = observer->begin(info); !done) return done;
    }
    sink_begun_ = true;
    Result<void> done = sink_->begin(info);
    observed_ = static_cast<bool>(done);
    return done;
}

Result<int32_t> TeeSink::resume(const std::function<bool(const pipeline::SliceView&)>& show) {
    Result<int32_t> resumed = sink_->resume([&](const pipeline::SliceView& slice) {
        for (const std::unique_ptr<SliceObserver>& observer : observers_)
            observer->observe(slice);
        return show(slice);
    });
    observed_ = static_cast<bool>(resumed);
    return resumed;
}

std::vector<uint8_t> TeeSink::encode(const pipeline::SliceView& slice) const {
    const std::vector<uint8_t> encoded = sink_->encode(slice);
    const size_t raw = slice.row_bytes * static_cast<size_t>(slice.height);
    std::vector<uint8_t> both;
    both.reserve(raw + encoded.size());
    both.insert(both.end(), slice.data, slice.data + raw);
    both.insert(both.end(), encoded.begin(), encoded.end());
    return both;
}

Result<void> TeeSink::commit(int32_t z, std::vector<uint8_t> bytes) {
    const size_t raw = row_bytes_ * static_cast<size_t>(height_);
    OPENFAB_CHECK_GE(bytes.size(), raw);
    std::vector<uint8_t> encoded(bytes.begin() + static_cast<std::ptrdiff_t>(raw), bytes.end());
    // The sink first, so that a picture shows no slice that could not be written.
    if (Result<void> done = sink_->commit(z, std::move(encoded)); !done) return done;
    const pipeline::SliceView slice{z, bytes.data(), row_bytes_, width_, height_};
    for (const std::unique_ptr<SliceObserver>& observer : observers_)
        observer->observe(slice);
    return {};
}

Result<void> TeeSink::finish(const pipeline::PrintTotals& totals) {
    Result<void> result = sink_begun_ ? sink_->finish(totals) : Result<void>();
    if (!observed_) return result;
    for (const std::unique_ptr<SliceObserver>& observer : observers_) {
        Result<void> done = observer->finish(totals);
        if (result && !done) result = done;
    }
    return result;
}

namespace {

typedef uint8_t Bytes __attribute__((vector_size(16)));
constexpr int32_t kLanes = 16;

}  // namespace

void unpack_row(const pipeline::SliceView& slice, int32_t y, int32_t bits, uint8_t* codes) {
    const uint8_t* row = slice.data + static_cast<size_t>(y) * slice.row_bytes;
    if (bits == 8) {
        std::memcpy(codes, row, static_cast<size_t>(slice.width));
        return;
    }
    const int32_t pairs = slice.width / 2;
    int32_t i = 0;
    for (; i + kLanes <= pairs; i += kLanes) {
        Bytes packed;
        std::memcpy(&packed, row + i, sizeof packed);
        const Bytes low = packed & 15, high = packed >> 4;
        const std::array<Bytes, 2> both{
            __builtin_shufflevector(low, high, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7,
                                    23),
            __builtin_shufflevector(low, high, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30,
                                    15, 31)};
        std::memcpy(codes + 2 * static_cast<size_t>(i), both.data(), sizeof both);
    }
    for (; i < pairs; ++i) {
        codes[2 * i] = row[i] & 15;
        codes[2 * i + 1] = row[i] >> 4;
    }
    if (slice.width % 2 != 0) codes[slice.width - 1] = row[pairs] & 15;
}

std::vector<uint8_t> unpack_slice(const pipeline::SliceView& slice, int32_t bits) {
    const auto width = static_cast<size_t>(slice.width);
    std::vector<uint8_t> codes(width * static_cast<size_t>(slice.height));
    for (int32_t y = 0; y < slice.height; ++y)
        unpack_row(slice, y, bits, codes.data() + static_cast<size_t>(y) * width);
    return codes;
}

void pack_row(std::span<const uint8_t> codes, int32_t bits, uint8_t* row) {
    if (bits == 8) {
        std::copy(codes.begin(), codes.end(), row);
        return;
    }
    const size_t pairs = codes.size() / 2;
    for (size_t i = 0; i < pairs; ++i)
        row[i] = static_cast<uint8_t>(codes[2 * i] | codes[2 * i + 1] << 4);
    if (codes.size() % 2 != 0) row[pairs] = codes.back();
}

}  // namespace openfab::backends
