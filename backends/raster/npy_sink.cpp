// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/npy_sink.h"

#include <array>

#include "backends/common/tee_sink.h"
#include "backends/raster/npy.h"

namespace openfab::raster {

namespace {

std::vector<uint8_t> header_of(const pipeline::PrintInfo& info, int32_t slices) {
    return npy_header("|u1", std::array<int64_t, 3>{slices, info.size.y, info.size.x});
}

}  // namespace

std::string array_json_path(const std::string& path) {
    return path + ".json";
}

Result<std::unique_ptr<pipeline::SliceSink>> NpySink::create(const std::string& path) {
    Result<backends::OutputFile> file = backends::OutputFile::create(path);
    if (!file) return file.error();
    return std::unique_ptr<pipeline::SliceSink>(new NpySink(std::move(*file)));
}

Result<void> NpySink::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    // A crash leaves an array without slices.
    if (Result<void> done = file_.write(header_of(info, 0)); !done) return done;
    return backends::write_whole_file(array_json_path(file_.name()), array_json(info, {}, 0));
}

std::vector<uint8_t> NpySink::encode(const pipeline::SliceView& slice) const {
    const auto width = static_cast<size_t>(slice.width);
    std::vector<uint8_t> codes(width * static_cast<size_t>(slice.height));
    for (int32_t y = 0; y < slice.height; ++y)
        backends::unpack_row(slice, y, info_.bits, codes.data() + width * static_cast<size_t>(y));
    return codes;
}

Result<void> NpySink::commit(int32_t, std::vector<uint8_t> bytes) {
    const int64_t end = file_.bytes_written();
    Result<void> done = file_.write(bytes);
    if (done) {
        ++written_;
    } else {
        broken_ = true;
        file_.cut_back_to(end);
    }
    return done;
}

Result<void> NpySink::finish(const pipeline::PrintTotals& totals) {
    pipeline::PrintTotals honest = totals;
    honest.complete = totals.complete && !broken_;
    Result<void> done = file_.overwrite(0, header_of(info_, written_));
    if (done) done = file_.close();
    if (done || broken_) {
        const Result<void> noted = backends::write_whole_file(array_json_path(file_.name()),
                                                              array_json(info_, honest, written_));
        if (done) done = noted;
    }
    // An earlier error has been reported already, and is the cause of this one, too.
    return broken_ ? Result<void>() : done;
}

}  // namespace openfab::raster
