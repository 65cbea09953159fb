// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/readers/seal.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

#include "backends/ofr/format.h"
#include "backends/stream/message.h"
#include "backends/zarr/layout.h"
#include "backends/zarr/shard_list.h"
#include "backends/zarr/store.h"
#include "base/crc32c.h"
#include "base/hash.h"

namespace openfab::testing {
namespace {

std::span<const uint8_t> part(const std::string& bytes, size_t begin, size_t n) {
    return {reinterpret_cast<const uint8_t*>(bytes.data()) + begin, n};
}

std::optional<uint32_t> number(const std::string& bytes, size_t at) {
    uint32_t value = 0;
    if (at > bytes.size() || bytes.size() - at < sizeof value) return {};
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

/// Writes the checksum of `n` bytes behind them; false where there is no room for it.
bool seal(std::string* bytes, size_t begin, size_t n) {
    if (begin > bytes->size() || bytes->size() - begin < 8 || bytes->size() - begin - 8 < n)
        return false;
    const uint64_t sum = ofr::checksum(part(*bytes, begin, n));
    std::memcpy(bytes->data() + begin + n, &sum, sizeof sum);
    return true;
}

/// Each returns where what follows begins; nothing where that is unknown.
std::optional<size_t> seal_header(std::string* bytes, size_t at) {
    const auto fields = number(*bytes, at + ofr::kMagic.size() + 4);
    if (!fields || !seal(bytes, at, ofr::kPreambleBytes + *fields)) return {};
    return at + ofr::kPreambleBytes + *fields + 8;
}

std::optional<size_t> seal_slice(std::string* bytes, size_t at) {
    const auto frame = number(*bytes, at + 8);
    if (!frame || !seal(bytes, at, ofr::kSliceHeadBytes - 8)) return {};
    return at + ofr::kSliceHeadBytes + *frame;
}

void seal_index(std::string* bytes, size_t at) {
    if (const auto fields = number(*bytes, at + 4)) seal(bytes, at, size_t{8} + *fields);
}

}  // namespace

void seal_pyramid(std::string* bytes) {
    // As in texture/pyramid_file.h, for a file of one block.
    constexpr size_t kPlace = 64, kBehind = 72;
    if (bytes->size() < kBehind) return;
    constexpr std::array<uint8_t, kBehind - kPlace> kZeros{};
    uint64_t sum = xxh3(part(*bytes, 0, kPlace), 0);
    sum = xxh3(kZeros, sum);
    sum = xxh3(part(*bytes, kBehind, bytes->size() - kBehind), sum);
    std::memcpy(bytes->data() + kPlace, &sum, sizeof sum);
}

void seal_print(std::string* bytes) {
    for (auto at = seal_header(bytes, 0); at;) {
        const auto magic = number(*bytes, *at);
        if (magic == ofr::kIndexMagic) seal_index(bytes, *at);
        if (magic != ofr::kSliceMagic) return;
        at = seal_slice(bytes, *at);
    }
}

void seal_store(std::string* bytes) {
    constexpr std::string_view kList = "\n--- list ---\n", kShard = "\n--- shard ---\n";
    const size_t list = bytes->find(kList);
    const std::string group = bytes->substr(0, list);
    const Result<pipeline::PrintInfo> info = zarr::read_group(group, "zarr.json");
    if (list == std::string::npos || !info) return;
    const size_t head_end = bytes->find('\n', list + kList.size());
    const size_t shard = bytes->find(kShard, list);
    if (head_end > shard || shard == std::string::npos) return;
    const std::string head = zarr::list_head(zarr::identity_of(group), 0, info->size.z);
    bytes->replace(list + kList.size(), head_end + 1 - list - kList.size(), head);
    const size_t from = bytes->find(kShard, list) + kShard.size();
    const size_t index = zarr::levels_of(info->size)[0].chunks() * 16;
    if (bytes->size() < from + index + 4) return;
    const auto* const raw =
        reinterpret_cast<const uint8_t*>(bytes->data()) + bytes->size() - 4 - index;
    const uint32_t sum = crc32c({raw, index});
    std::memcpy(bytes->data() + bytes->size() - 4, &sum, sizeof sum);
}

void seal_messages(std::string* bytes) {
    size_t at = 0;
    while (const auto length = number(*bytes, at + 4)) {
        const auto kind = static_cast<stream::Kind>(*number(*bytes, at));
        at += stream::kHeadBytes;
        switch (kind) {
            case stream::Kind::kOpen: {
                // Behind the magic, the version, the mode and the sender, and the token.
                constexpr size_t kToken = stream::kMagic.size() + 4 + 4 + 8;
                if (const auto token = number(*bytes, at + kToken))
                    (void)seal_header(bytes, at + kToken + 4 + *token + 4);
                break;
            }
            case stream::Kind::kSlice:
            case stream::Kind::kBack:
                (void)seal_slice(bytes, at);
                break;
            case stream::Kind::kDone:
                seal_index(bytes, at);
                break;
            default:
                break;
        }
        at += *length;
    }
}

}  // namespace openfab::testing
