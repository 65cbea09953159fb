// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/read/ofr_print.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

#include "backends/common/tee_sink.h"
#include "backends/ofr/messages.h"
#include "backends/ofr/slice_codec.h"
#include "backends/read/messages.h"

namespace openfab::prints {

namespace {

uint32_t u32_at(const uint8_t* bytes) {
    uint32_t value = 0;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

uint64_t u64_at(const uint8_t* bytes) {
    uint64_t value = 0;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

}  // namespace

int64_t OfrPrint::bytes_now() const {
    struct stat status {};
    return ::fstat(file_.descriptor(), &status) == 0 ? status.st_size : 0;
}

bool OfrPrint::read_exactly(uint64_t at, void* to, size_t bytes) const {
    if (at > static_cast<uint64_t>(bytes_now()))
        return false;  // offsets that a damaged file states
    const Result<size_t> got = file_.read(static_cast<int64_t>(at), to, bytes);
    return got && *got == bytes;
}

Result<std::unique_ptr<PrintFile>> OfrPrint::open(const std::string& path, int64_t memory_bytes) {
    Result<InputFile> file = InputFile::open(path);
    if (!file) return with_context(file.error(), fmt::format(messages::kCannotOpen, path));
    std::unique_ptr<OfrPrint> print(new OfrPrint(path, std::move(*file)));
    if (Result<void> header = print->read_header(); !header) return header.error();
    if (Result<void> fits = print->check_memory(print->slice_bytes(), memory_bytes); !fits)
        return fits.error();
    if (!print->take_index_at_end()) print->look_again();
    return std::unique_ptr<PrintFile>(std::move(print));
}

Result<void> OfrPrint::read_header() {
    std::vector<uint8_t> header(ofr::kPreambleBytes);
    if (!read_exactly(0, header.data(), header.size())) return error(ofr::messages::kNotOfr);
    const Result<size_t> left = ofr::header_bytes_left(header);
    if (!left) return error(left.error().text());
    header.resize(header.size() + *left);
    if (!read_exactly(0, header.data(), header.size()))
        return error(ofr::messages::kCutShortInHeader);
    Result<pipeline::PrintInfo> info = ofr::read_header(header);
    if (!info) return error(info.error().text());
    info_ = std::move(*info);
    row_bytes_ = backends::packed_row_bytes(info_.size.x, info_.bits);
    end_ = header.size();
    return {};
}

bool OfrPrint::take_index(uint64_t offset) {
    std::array<uint8_t, ofr::kIndexHeadBytes> head{};
    if (!read_exactly(offset, head.data(), head.size())) return false;
    const uint64_t field_bytes = u32_at(head.data() + 4);
    if (field_bytes > ofr::kMaxIndexBytes) return false;
    std::vector<uint8_t> bytes(head.size() + field_bytes + 8);
    if (offset + bytes.size() > static_cast<uint64_t>(bytes_now()) ||
        !read_exactly(offset, bytes.data(), bytes.size()))
        return false;
    Result<ofr::Index> index = ofr::read_index(bytes);
    const auto slices = static_cast<size_t>(info_.slice_end - info_.slice_begin);
    if (!index || index->slices.size() != slices) return false;
    std::vector<uint64_t> offsets;
    for (const ofr::IndexEntry& entry : index->slices) {
        const auto z = info_.slice_begin + static_cast<int32_t>(offsets.size());
        if (entry.z != z || entry.offset >= offset) return false;
        offsets.push_back(entry.offset);
    }
    const std::lock_guard lock(mutex_);
    offsets_ = std::move(offsets);
    end_ = offset;
    totals_ = std::move(index->totals);
    totals_->voxels_by_code.resize(info_.materials.size() + 1);
    return true;
}

bool OfrPrint::take_index_at_end() {
    const int64_t size = bytes_now();
    std::array<uint8_t, ofr::kIndexTailBytes> tail{};
    if (size < static_cast<int64_t>(ofr::kIndexTailBytes) ||
        !read_exactly(static_cast<uint64_t>(size) - ofr::kIndexTailBytes, tail.data(),
                      tail.size()) ||
        !std::equal(ofr::kEndMagic.begin(), ofr::kEndMagic.end(), tail.begin() + 8))
        return false;
    return take_index(u64_at(tail.data()));
}

int32_t OfrPrint::whole_slices() const {
    const std::lock_guard lock(mutex_);
    return static_cast<int32_t>(offsets_.size());
}

std::optional<pipeline::PrintTotals> OfrPrint::totals() const {
    const std::lock_guard lock(mutex_);
    return totals_;
}

bool OfrPrint::look_again() {
    const int32_t planned = info_.slice_end - info_.slice_begin;
    bool found = false;
    for (;;) {
        uint64_t at = 0;
        int32_t z = 0;
        {
            const std::lock_guard lock(mutex_);
            if (totals_) return found;
            at = end_;
            z = info_.slice_begin + static_cast<int32_t>(offsets_.size());
        }
        if (z - info_.slice_begin == planned) return take_index(at) || found;
        std::array<uint8_t, ofr::kSliceHeadBytes> bytes{};
        if (!read_exactly(at, bytes.data(), bytes.size())) return found;
        const Result<ofr::SliceHead> head = ofr::read_slice_head(bytes);
        if (!head || head->z != z) return found;
        const uint64_t next = at + ofr::kSliceHeadBytes + head->frame_bytes;
        if (next > static_cast<uint64_t>(bytes_now())) return found;
        const std::lock_guard lock(mutex_);
        // Another thread may have been here.
        if (end_ != at) continue;
        offsets_.push_back(at);
        end_ = next;
        found = true;
    }
}

bool OfrPrint::was_replaced() const {
    struct stat there {};
    struct stat mine {};
    // A file that is away for a moment, or for good, can still be read.
    if (::stat(path_.c_str(), &there) != 0 || ::fstat(file_.descriptor(), &mine) != 0) return false;
    if (there.st_ino != mine.st_ino || there.st_dev != mine.st_dev) return true;
    const std::lock_guard lock(mutex_);
    return static_cast<uint64_t>(mine.st_size) < end_;
}

Result<void> OfrPrint::read_slice(int32_t z, SliceBuffers* buffers) const {
    uint64_t offset = 0;
    {
        const std::lock_guard lock(mutex_);
        const auto place = static_cast<size_t>(z - info_.slice_begin);
        if (z < info_.slice_begin || place >= offsets_.size())
            return error(fmt::format(messages::kSliceNotThere, z));
        offset = offsets_[place];
    }
    const auto damaged = [&](const char* what) {
        return error(fmt::format(messages::kOfSlice, z, what));
    };
    std::array<uint8_t, ofr::kSliceHeadBytes> bytes{};
    if (!read_exactly(offset, bytes.data(), bytes.size())) return damaged(messages::kCannotBeRead);
    const Result<ofr::SliceHead> head = ofr::read_slice_head(bytes);
    if (!head) return damaged(head.error().message.c_str());
    const auto raw = static_cast<size_t>(slice_bytes());
    if (head->z != z || head->frame_bytes > ofr::most_frame_bytes(raw))
        return damaged(ofr::messages::kSliceHeaderDamaged);
    buffers->frame.resize(head->frame_bytes);
    if (!read_exactly(offset + bytes.size(), buffers->frame.data(), buffers->frame.size()))
        return damaged(messages::kCannotBeRead);
    buffers->rows.resize(raw);
    if (Result<void> decoded = ofr::decode_frame(*head, buffers->frame, buffers->rows); !decoded)
        return damaged(decoded.error().message.c_str());
    return {};
}

}  // namespace openfab::prints
