// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/fraction_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "backends/raster/npy.h"
#include "backends/raster/npy_sink.h"
#include "base/hash.h"

namespace openfab::raster {

Result<void> FractionFile::begin(const pipeline::PrintInfo& info, int32_t materials) {
    info_ = info;
    materials_ = materials;
    Result<std::unique_ptr<backends::PartFile>> part = backends::PartFile::create(path_);
    if (!part) return part.error();
    part_ = std::move(*part);
    const Result<backends::OutputFile*> file = part_->flushed();
    if (!file) return file.error();
    file_ = *file;
    const int64_t slices = info.slice_end - info.slice_begin;
    const std::array<int64_t, 4> shape{slices, info.size.y, info.size.x, materials_};
    const int64_t values = shape[0] * shape[1] * shape[2] * shape[3];
    if (Result<void> done = file_->write(npy_header("<f4", shape)); !done) return done;
    // All of it at once, as a hole: void.
    return file_->continue_at(kNpyHeaderBytes + values * static_cast<int64_t>(sizeof(float)));
}

uint64_t fractions_hash(std::span<const float> fractions, size_t materials, int64_t first) {
    uint64_t hash = 0;
    for (size_t at = 0; at + materials <= fractions.size(); at += materials, ++first) {
        const std::span<const float> voxel = fractions.subspan(at, materials);
        if (std::all_of(voxel.begin(), voxel.end(), [](float f) { return f == 0; })) continue;
        hash += xxh3({reinterpret_cast<const uint8_t*>(voxel.data()), voxel.size_bytes()},
                     static_cast<uint64_t>(first));
    }
    return hash;
}

void FractionFile::write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) {
    const auto is_some = [](float fraction) { return fraction != 0; };
    const auto first = std::find_if(fractions.begin(), fractions.end(), is_some);
    if (first == fractions.end()) return;
    const auto last = std::find_if(fractions.rbegin(), fractions.rend(), is_some).base();
    const int64_t row = int64_t{z - info_.slice_begin} * info_.size.y + y;
    const int64_t value =
        (row * info_.size.x + first_x) * materials_ + std::distance(fractions.begin(), first);
    hash_ +=
        fractions_hash(fractions, static_cast<size_t>(materials_), row * info_.size.x + first_x);
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
    if (file_ == nullptr) return {};  // never began
    const Result<void> failed = status();
    if (!failed || !totals.complete) {
        part_.reset();
        return {};  // has been reported
    }
    // An earlier print's text must not be beside this one's array.
    std::error_code ignored;
    std::filesystem::remove(array_json_path(path_), ignored);
    if (Result<void> kept = part_->keep(); !kept) return kept;
    return backends::write_whole_file(
        array_json_path(path_),
        array_json(info_, totals, info_.slice_end - info_.slice_begin, hash_.load()));
}

}  // namespace openfab::raster
