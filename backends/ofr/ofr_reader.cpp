// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/ofr/ofr_reader.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "backends/common/tee_sink.h"
#include "backends/ofr/messages.h"
#include "backends/ofr/slice_codec.h"
#include "base/input_file.h"
#include "base/system_reason.h"
#include "base/units.h"
#include "runtime/pipeline/print_hash.h"

namespace openfab::ofr {

namespace {

/// Opens a regular file, or what this process has open already, as shells hand pipes on: opening a
/// named pipe would wait for its writer.
Result<std::FILE*> open_file(const std::string& path) {
    const auto cannot_open = [&](const std::string& why) {
        return fmt::format(messages::kCannotOpen, path, why);
    };
    if (path.starts_with("/dev/fd/")) {
        if (std::FILE* const opened = std::fopen(path.c_str(), "rb")) return opened;
        return user_error(cannot_open(system_reason(errno)));
    }
    const Result<InputFile> file = InputFile::open(path);
    if (!file) return Error{file.error().code, cannot_open(file.error().text())};
    const int own = ::dup(file->descriptor());
    std::FILE* opened = own >= 0 ? ::fdopen(own, "rb") : nullptr;
    if (opened != nullptr) return opened;
    const int why = errno;
    if (own >= 0) ::close(own);
    return outside_error(cannot_open(system_reason(why)));
}

}  // namespace

Result<std::unique_ptr<OfrReader>> OfrReader::open(const std::string& path, int64_t memory_bytes) {
    Result<std::FILE*> file = path == "-" ? stdin : open_file(path);
    if (!file) return file.error();
    std::unique_ptr<OfrReader> reader(new OfrReader(*file, path == "-" ? "standard input" : path));
    reader->memory_bytes_ = memory_bytes;
    if (Result<void> header = reader->read_header(); !header) return header.error();
    if (reader->slice_bytes() > memory_bytes) return reader->memory_error(reader->slice_bytes());
    return reader;
}

Result<pipeline::PrintTotals> OfrReader::read_totals(const std::string& path) {
    const Result<std::FILE*> opened = open_file(path);
    if (!opened) return opened.error();
    std::FILE* const file = *opened;
    OfrReader reader(file, path);
    uint64_t offset = 0;
    if (std::fseek(file, -static_cast<long>(kIndexTailBytes), SEEK_END) != 0 ||
        !reader.read_bytes(kIndexTailBytes) ||
        !std::equal(kEndMagic.begin(), kEndMagic.end(), reader.buffer_.begin() + 8)) {
        return reader.error(messages::kNoIndex);
    }
    const auto end = static_cast<uint64_t>(std::ftell(file)) - kIndexTailBytes;
    std::memcpy(&offset, reader.buffer_.data(), 8);
    if (offset > end || end - offset > kMaxIndexBytes ||
        std::fseek(file, static_cast<long>(offset), SEEK_SET) != 0 ||
        !reader.read_bytes(end - offset)) {
        return reader.error(messages::kIndexDamaged);
    }
    const Result<Index> index = ofr::read_index(reader.buffer_);
    if (!index) return reader.error(messages::kIndexDamaged);
    return index->totals;
}

OfrReader::~OfrReader() {
    if (file_ != stdin) std::fclose(file_);
}

Error OfrReader::error(const std::string& what) const {
    return user_error(fmt::format("{}: {}", name_, what));
}

Error OfrReader::slice_error(const std::string& what) const {
    return error(fmt::format(messages::kWholeSlices, info_.slice_begin + whole_slices(), what,
                             whole_slices(), info_.slice_end - info_.slice_begin));
}

Error OfrReader::memory_error(int64_t bytes) const {
    return user_error(fmt::format(messages::kTooMuchMemory, name_, info_.size.x, info_.size.y,
                                  format_bytes(bytes), format_bytes(memory_bytes_)));
}

bool OfrReader::read_bytes(size_t n) {
    // In steps, so that a false length costs no more memory than the file has bytes.
    constexpr size_t kStep = 1U << 20;
    buffer_.clear();
    while (buffer_.size() < n) {
        const size_t had = buffer_.size();
        const size_t step = std::min(kStep, n - had);
        buffer_.resize(had + step);
        const size_t got = std::fread(buffer_.data() + had, 1, step, file_);
        offset_ += got;
        if (got < step) {
            disk_failed_ = std::ferror(file_) != 0;
            return false;
        }
    }
    return true;
}

Result<void> OfrReader::read_header() {
    if (!read_bytes(kPreambleBytes)) return error(messages::kTooShort);
    std::vector<uint8_t> header = buffer_;
    const Result<size_t> left = header_bytes_left(header);
    if (!left) return error(left.error().text());
    if (!read_bytes(*left)) return error(messages::kCutShortInHeader);
    header.insert(header.end(), buffer_.begin(), buffer_.end());
    Result<pipeline::PrintInfo> info = ofr::read_header(header);
    if (!info) return error(info.error().text());
    info_ = std::move(*info);
    row_bytes_ = backends::packed_row_bytes(info_.size.x, info_.bits);
    counts_.assign(info_.materials.size() + 1, 0);
    slices_end_ = offset_;
    return {};
}

Result<bool> OfrReader::next() {
    if (info_.slice_begin + whole_slices() == info_.slice_end) {
        if (Result<void> index = read_index(); !index) return index.error();
        return false;
    }
    const uint64_t offset = offset_;
    if (!read_bytes(kSliceHeadBytes)) {
        return slice_error(offset == offset_ ? messages::kSliceMissing : messages::kSliceCutShort);
    }
    const std::vector<uint8_t> head = buffer_;
    if (Result<void> slice = read_slice(head); !slice) return slice.error();
    entries_.push_back({view_.z, offset});
    slices_end_ = offset_;
    for (size_t code = 0; code < counts_.size(); ++code)
        counts_[code] += slice_counts_[code];
    hash_ += pipeline::slice_hash(view_.z, view_.data, view_.row_bytes, view_.height);
    return true;
}

Result<void> OfrReader::read_slice(std::span<const uint8_t> head_bytes) {
    Result<SliceHead> head = read_slice_head(head_bytes);
    if (!head) return slice_error(head.error().text());
    if (head->z != info_.slice_begin + whole_slices()) {
        return slice_error(fmt::format(messages::kOtherSlice, head->z));
    }
    if (head->frame_bytes > most_frame_bytes(row_bytes_ * static_cast<size_t>(info_.size.y))) {
        return slice_error(messages::kSliceHeaderDamaged);
    }
    if (const int64_t bytes = slice_bytes() + head->frame_bytes; bytes > memory_bytes_)
        return memory_error(bytes);
    if (!read_bytes(head->frame_bytes)) return slice_error(messages::kSliceCutShort);
    return decode(*head);
}

Result<void> OfrReader::decode(const SliceHead& head) {
    rows_.resize(row_bytes_ * static_cast<size_t>(info_.size.y));
    if (Result<void> decoded = decode_frame(head, buffer_, rows_); !decoded)
        return slice_error(decoded.error().text());
    view_ = {head.z, rows_.data(), row_bytes_, info_.size.x, info_.size.y};
    if (!count_codes()) {
        return slice_error(fmt::format(messages::kCodesBeyond, info_.materials.size()));
    }
    return {};
}

bool OfrReader::count_codes() {
    const std::array<int64_t, 256> counts = ofr::count_codes(rows_, info_.bits);
    const auto beyond = counts.begin() + static_cast<std::ptrdiff_t>(counts_.size());
    slice_counts_.assign(counts.begin(), beyond);
    return std::all_of(beyond, counts.end(), [](int64_t count) { return count == 0; });
}

Result<void> OfrReader::read_index() {
    const uint64_t offset = offset_;
    const std::string all = fmt::format(messages::kAllWholeButIndex, whole_slices());
    if (!read_bytes(kIndexHeadBytes)) {
        return error(all + (offset == offset_ ? messages::kIndexMissing : messages::kCutShort));
    }
    std::vector<uint8_t> bytes = buffer_;
    uint32_t field_bytes = 0;
    std::memcpy(&field_bytes, bytes.data() + 4, 4);
    // At most 256 codes, plus the fields beside the two lists.
    const size_t most = entries_.size() * 12 + 256 * 8 + 64;
    if (field_bytes > most) return error(all + messages::kDamaged);
    if (!read_bytes(field_bytes + 8)) return error(all + messages::kCutShortOrDamaged);
    bytes.insert(bytes.end(), buffer_.begin(), buffer_.end());
    if (!read_bytes(kIndexTailBytes)) return error(all + messages::kCutShort);
    uint64_t stated_offset = 0;
    std::memcpy(&stated_offset, buffer_.data(), 8);
    const Result<Index> index = ofr::read_index(bytes);
    if (!index || stated_offset != offset ||
        !std::equal(kEndMagic.begin(), kEndMagic.end(), buffer_.begin() + 8)) {
        return error(all + messages::kDamaged);
    }
    return check_index(*index);
}

Result<void> OfrReader::check_index(const Index& index) {
    if (index.slices != entries_) return error(messages::kIndexListsOthers);
    // Void is not compared: an odd row's unused half counts as void here.
    const std::vector<int64_t>& stated = index.totals.voxels_by_code;
    for (size_t code = 1; code < std::max(stated.size(), counts_.size()); ++code) {
        const int64_t listed = code < stated.size() ? stated[code] : 0;
        const int64_t found = code < counts_.size() ? counts_[code] : 0;
        if (listed == found) continue;
        return error(fmt::format(messages::kIndexCountsOthers, listed, code, found));
    }
    if (index.totals.hash != hash_) return error(messages::kIndexHashOther);
    if (std::fgetc(file_) != EOF) return error(messages::kBytesAfterEnd);
    totals_ = index.totals;
    return {};
}

}  // namespace openfab::ofr
