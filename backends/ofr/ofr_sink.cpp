// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/ofr/ofr_sink.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <utility>

namespace openfab::ofr {

Result<std::unique_ptr<backends::SliceSink>> OfrSink::create(const std::string& path) {
    Result<backends::OutputFile> file = backends::OutputFile::create(path);
    if (!file) return file.error();
    return std::unique_ptr<backends::SliceSink>(new OfrSink(std::move(*file)));
}

Error OfrSink::with_slices_kept(const Error& error) const {
    return {error.code,
            fmt::format("{}; {} whole slices were written before", error.message, entries_.size())};
}

Result<void> OfrSink::begin(const backends::PrintInfo& info) {
    return file_.write(write_header(info));
}

std::vector<uint8_t> OfrSink::encode(const backends::SliceView& slice) const {
    const size_t raw = slice.row_bytes * static_cast<size_t>(slice.height);
    const size_t bound = ZSTD_compressBound(raw);
    std::vector<uint8_t> bytes(kSliceHeadBytes + bound);
    const size_t packed =
        ZSTD_compress(bytes.data() + kSliceHeadBytes, bound, slice.data, raw, kZstdLevel);
    if (ZSTD_isError(packed) != 0U) return {};  // no memory; commit reports it
    const std::array<uint8_t, kSliceHeadBytes> head =
        write_slice_head({slice.z, static_cast<uint32_t>(packed), checksum({slice.data, raw})});
    std::copy(head.begin(), head.end(), bytes.begin());
    bytes.resize(kSliceHeadBytes + packed);
    // The bytes wait in a queue: give back what the worst case would have taken.
    bytes.shrink_to_fit();
    return bytes;
}

Result<void> OfrSink::commit(int32_t z, const std::vector<uint8_t>& bytes) {
    if (bytes.empty()) return internal_error(fmt::format("slice {} could not be compressed", z));
    const int64_t offset = file_.bytes_written();
    if (Result<void> written = file_.write(bytes); !written) {
        broken_ = true;
        file_.cut_back_to(offset);
        return with_slices_kept(written.error());
    }
    entries_.push_back({z, static_cast<uint64_t>(offset)});
    return {};
}

Result<void> OfrSink::finish(const backends::PrintTotals& totals) {
    // Without an index the file says itself that it is not complete.
    if (totals.complete && !broken_) {
        const int64_t offset = file_.bytes_written();
        const std::vector<uint8_t> index =
            write_index({std::move(entries_), totals}, static_cast<uint64_t>(offset));
        if (Result<void> written = file_.write(index); !written) {
            file_.cut_back_to(offset);
            return written;
        }
    }
    Result<void> closed = file_.close();
    // What went wrong before has been reported already, and is the reason for this too.
    return broken_ ? Result<void>() : closed;
}

}  // namespace openfab::ofr
