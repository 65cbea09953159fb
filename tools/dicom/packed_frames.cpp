// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/packed_frames.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>

#include "tools/dicom/dicom_elements.h"
#include "tools/dicom/messages.h"

namespace openfab::tools {

namespace {

constexpr int64_t kHead = 8;

/// Lists the items, the table of offsets first.
Result<std::vector<PackedItem>> list_items(const InputFile& file, int64_t at) {
    constexpr uint64_t kItem = 0xe000fffe;
    const int64_t begin = at;
    std::vector<PackedItem> items;
    while (at + kHead <= file.bytes()) {
        std::array<char, kHead> head{};
        const Result<size_t> got = file.read(at, head.data(), head.size());
        if (!got) return got.error();
        const std::vector<uint64_t> words = whole_numbers({head.data(), head.size()}, 4);
        if (words[0] != kItem) break;  // the end, or damage that decoders see
        items.push_back({at + kHead, static_cast<int64_t>(words[1])});
        at += kHead + items.back().bytes;
    }
    if (at > file.bytes())
        return user_error(fmt::format(messages::kPixelsCutShort, file.bytes() - begin, at - begin),
                          messages::kCopyItAgain);
    return items;
}

/// Whether an item begins a compressed picture: JPEG and JPEG-LS, or a stream of JPEG 2000 with or
/// without a file's boxes.
Result<bool> begins_picture(const InputFile& file, const PackedItem& item) {
    std::array<char, 8> head{};
    const Result<size_t> got = file.read(item.at, head.data(), head.size());
    if (!got) return got.error();
    const std::string_view bytes(head.data(), *got);
    constexpr std::string_view kBoxes("\0\0\0\x0cjP  ", 8);
    return bytes.starts_with("\xff\xd8\xff") || bytes.starts_with("\xff\x4f\xff\x51") ||
           bytes == kBoxes;
}

/// Groups items by where frames begin, counted from the first item behind the table. Empty where an
/// offset is none of an item.
PackedFrames by_offsets(const std::vector<PackedItem>& items,
                        const std::vector<uint64_t>& offsets) {
    PackedFrames out;
    if (offsets.empty() || offsets.front() != 0) return {};
    for (const PackedItem& item : items) {
        const auto offset = static_cast<uint64_t>(item.at - items.front().at);
        if (out.size() < offsets.size() && offset == offsets[out.size()]) out.emplace_back();
        out.back().push_back(item);
    }
    return out.size() == offsets.size() ? out : PackedFrames();
}

}  // namespace

Result<PackedFrames> find_packed_frames(const InputFile& file, int64_t at, int32_t frames,
                                        std::string_view long_offsets) {
    Result<std::vector<PackedItem>> all = list_items(file, at);
    if (!all) return all.error();
    if (all->empty()) return user_error(messages::kPackedPixelsDamaged);
    const PackedItem table = all->front();
    const std::vector<PackedItem> items(all->begin() + 1, all->end());
    const auto count = static_cast<size_t>(frames);
    if (items.size() < count)
        return user_error(fmt::format(messages::kFramesOfItems, items.size(), count),
                          messages::kCopyItAgain);
    PackedFrames out;
    if (count == 1) {
        out.push_back(items);
        return out;
    }
    if (items.size() == count) {
        for (const PackedItem& item : items)
            out.push_back({item});
        return out;
    }
    if (table.bytes == 4 * int64_t{frames}) {
        std::string offsets(static_cast<size_t>(table.bytes), '\0');
        const Result<size_t> got = file.read(table.at, offsets.data(), offsets.size());
        if (!got) return got.error();
        out = by_offsets(items, whole_numbers(offsets, 4));
    } else if (long_offsets.size() == 8 * count) {
        out = by_offsets(items, whole_numbers(long_offsets, 8));
    } else {
        for (const PackedItem& item : items) {
            const Result<bool> begins = begins_picture(file, item);
            if (!begins) return begins.error();
            if (*begins) out.emplace_back();
            if (out.empty()) break;
            out.back().push_back(item);
        }
    }
    if (out.size() == count) return out;
    return user_error(fmt::format(messages::kFramesInFragments, count, items.size()),
                      messages::kWriteUncompressed);
}

Result<std::string> read_packed_frame(const InputFile& file, const std::vector<PackedItem>& items) {
    std::string out;
    for (const PackedItem& item : items) {
        const size_t at = out.size();
        out.resize(at + static_cast<size_t>(item.bytes));
        const Result<size_t> got = file.read(item.at, out.data() + at, out.size() - at);
        if (!got) return got.error();
        if (*got < out.size() - at) return user_error(messages::kPackedPixelsDamaged);
    }
    return out;
}

Result<std::string> inflate_frame(std::string_view packed, int64_t bytes) {
    z_stream stream{};
    constexpr int kWithoutHead = -15;
    if (::inflateInit2(&stream, kWithoutHead) != Z_OK)
        return user_error(messages::kPackedPixelsDamaged);
    // One of an odd number of bytes may be filled up.
    std::string out(static_cast<size_t>(bytes) + 1, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    const int status = ::inflate(&stream, Z_FINISH);
    ::inflateEnd(&stream);
    if (status == Z_STREAM_END && stream.avail_out <= 1) return out;
    return user_error(messages::kPackedPixelsDamaged);
}

}  // namespace openfab::tools
