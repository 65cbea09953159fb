// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/fraction_file.h"

#include <algorithm>
#include <array>

#include "backends/raster/npy.h"
#include "backends/raster/npy_sink.h"

namespace openfab::raster {

Result<void> FractionFile::begin(const pipeline::PrintInfo& info, int32_t materials) {
    info_ = info;
    materials_ = materials;
    Result<backends::OutputFile> file = backends::OutputFile::create(path_);
    if (!file) return file.error();
    file_.emplace(std::move(*file));
    const int64_t slices = info.slice_end - info.slice_begin;
    const std::array<int64_t, 4> shape{slices, info.size.y, info.size.x, materials_};
    const int64_t values = shape[0] * shape[1] * shape[2] * shape[3];
    if (Result<void> done = file_->write(npy_header("<f4", shape)); !done) return done;
    // All of it at once, as a hole: void.
    if (Result<void> done =
            file_->continue_at(kNpyHeaderBytes + values * static_cast<int64_t>(sizeof(float)));
        !done)
        return done;
    return backends::write_whole_file(array_json_path(path_), array_json(info, {}, 0));
}

void FractionFile::write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) {
    const auto is_some = [](float fraction) { return fraction != 0; };
    const auto first = std::find_if(fractions.begin(), fractions.end(), is_some);
    if (first == fractions.end()) return;
    const auto last = std::find_if(fractions.rbegin(), fractions.rend(), is_some).base();
    const int64_t row = int64_t{z - info_.slice_begin} * info_.size.y + y;
    const int64_t value =
        (row * info_.size.x + first_x) * materials_ + std::distance(fractions.begin(), first);
    const std::span<const float> some(first, last);
    const Result<void> done =
        file_->overwrite(kNpyHeaderBytes + value * static_cast<int64_t>(sizeof(float)),
                         {reinterpret_cast<const uint8_t*>(some.data()), some.size_bytes()});
    if (!done) fail(done.error());
}

void FractionFile::fail(const Error& error) {
    const std::lock_guard lock(mutex_);
    if (error_) error_ = error;
}

Result<void> FractionFile::status() const {
    const std::lock_guard lock(mutex_);
    return error_;
}

Result<void> FractionFile::finish(const pipeline::PrintTotals& totals) {
    if (!file_) return {};  // never began
    const Result<void> failed = status();
    pipeline::PrintTotals honest = totals;
    honest.complete = totals.complete && failed;
    Result<void> done = file_->close();
    const Result<void> noted = backends::write_whole_file(
        array_json_path(path_), array_json(info_, honest, info_.slice_end - info_.slice_begin));
    if (!failed) return {};  // has been reported
    return done ? noted : done;
}

}  // namespace openfab::raster
