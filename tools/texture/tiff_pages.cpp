// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/tiff_pages.h"

#include <algorithm>
#include <optional>
#include <set>

namespace openfab::tools {
namespace {

/// The layouts of the two kinds of TIFF.
struct Kind {
    bool big_endian = false;
    int64_t header_at = 4;  ///< position of the first directory's offset
    int offset_bytes = 4;   ///< size of an offset
    int count_bytes = 2;    ///< size of the number of a directory's entries
    uint64_t entry_bytes = 12;
};

std::optional<uint64_t> number_at(const InputFile& file, uint64_t at, int bytes, bool big_endian) {
    std::array<uint8_t, 8> raw{};
    const Result<size_t> got =
        at > static_cast<uint64_t>(file.bytes())
            ? Result<size_t>(size_t{0})
            : file.read(static_cast<int64_t>(at), raw.data(), static_cast<size_t>(bytes));
    if (!got || *got < static_cast<size_t>(bytes)) return {};
    uint64_t value = 0;
    for (int k = 0; k < bytes; ++k) {
        const int shift = 8 * (big_endian ? bytes - 1 - k : k);
        value |= uint64_t{raw[k]} << shift;
    }
    return value;
}

Kind kind_of(const InputFile& file) {
    std::array<char, 4> head{};
    (void)file.read(0, head.data(), head.size());
    Kind kind;
    kind.big_endian = head[0] == 'M';
    constexpr char kLarge = '+';  // 43, of files beyond 4 GB; others have 42
    if (head[kind.big_endian ? 3 : 2] == kLarge) kind = {kind.big_endian, 8, 8, 8, 20};
    return kind;
}

}  // namespace

std::vector<uint64_t> tiff_pages(const InputFile& file, size_t most, bool* cut) {
    if (cut != nullptr) *cut = true;
    const Kind kind = kind_of(file);
    std::vector<uint64_t> pages;
    std::set<uint64_t> known;
    std::optional<uint64_t> next =
        number_at(file, static_cast<uint64_t>(kind.header_at), kind.offset_bytes, kind.big_endian);
    while (next && *next != 0 && pages.size() < most && known.insert(*next).second) {
        const uint64_t page = *next;
        const std::optional<uint64_t> entries =
            number_at(file, page, kind.count_bytes, kind.big_endian);
        if (!entries || *entries > static_cast<uint64_t>(file.bytes()) / kind.entry_bytes)
            return pages;
        pages.push_back(page);
        next = number_at(
            file, page + static_cast<uint64_t>(kind.count_bytes) + *entries * kind.entry_bytes,
            kind.offset_bytes, kind.big_endian);
    }
    if (cut != nullptr) *cut = !next;
    return pages;
}

bool is_reduced_page(const InputFile& file, uint64_t directory) {
    const Kind kind = kind_of(file);
    const std::optional<uint64_t> entries =
        number_at(file, directory, kind.count_bytes, kind.big_endian);
    constexpr uint64_t kMostEntries = 4096, kNewSubfileType = 254, kSubfileType = 255;
    constexpr uint64_t kReducedOrMask = 1 | 4, kReduced = 2;  // of each of the two
    if (!entries || *entries > kMostEntries) return false;
    const uint64_t begin = directory + static_cast<uint64_t>(kind.count_bytes);
    for (uint64_t i = 0; i < *entries; ++i) {
        const uint64_t at = begin + i * kind.entry_bytes;
        const std::optional<uint64_t> tag = number_at(file, at, 2, kind.big_endian);
        if (!tag) return false;
        // Entries should be in the order of their tags, but not all writers keep it.
        if (*tag != kNewSubfileType && *tag != kSubfileType) continue;
        const bool is_old = *tag == kSubfileType;
        const std::optional<uint64_t> value =
            number_at(file, at + kind.entry_bytes - static_cast<uint64_t>(kind.offset_bytes),
                      is_old ? 2 : 4, kind.big_endian);
        if (value && (is_old ? *value == kReduced : (*value & kReducedOrMask) != 0)) return true;
    }
    return false;
}

TiffHeader::TiffHeader(const InputFile& file, uint64_t directory) {
    const Kind kind = kind_of(file);
    begin_ = kind.header_at;
    for (int k = 0; k < kind.offset_bytes; ++k) {
        const int shift = 8 * (kind.big_endian ? kind.offset_bytes - 1 - k : k);
        offset_.push_back(static_cast<char>(directory >> shift & 0xff));
    }
}

void TiffHeader::put(int64_t at, size_t bytes, char* to) const {
    const int64_t end = at + static_cast<int64_t>(bytes);
    const auto header_end = begin_ + static_cast<int64_t>(offset_.size());
    for (int64_t k = std::max(at, begin_); k < std::min(end, header_end); ++k)
        to[k - at] = offset_[static_cast<size_t>(k - begin_)];
}

size_t TiffPage::read(void* to, size_t bytes) {
    const size_t got = pread(to, bytes, m_pos);
    m_pos += static_cast<int64_t>(got);
    return got;
}

size_t TiffPage::pread(void* to, size_t bytes, int64_t at) {
    if (at < 0) return 0;
    const Result<size_t> got = file_.read(at, to, bytes);
    if (!got) return 0;
    header_.put(at, *got, static_cast<char*>(to));
    return *got;
}

}  // namespace openfab::tools
