// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/stored_profile.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace openfab::tools {
namespace {

/// Tables of presses have a few megabytes.
constexpr int64_t kLargest = 16'000'000;

std::vector<uint8_t> bytes_at(const InputFile& file, int64_t at, int64_t bytes) {
    if (bytes <= 0 || bytes > kLargest || at > file.bytes() - bytes) return {};
    std::vector<uint8_t> out(static_cast<size_t>(bytes));
    const Result<size_t> got = file.read(at, out.data(), out.size());
    return got && *got == out.size() ? out : std::vector<uint8_t>();
}

/// Returns what a stream of zlib's holds; empty where it is damaged, or larger than a profile.
std::vector<uint8_t> inflated(const uint8_t* packed, size_t bytes) {
    constexpr size_t kStep = 65536;
    z_stream stream{};
    if (::inflateInit(&stream) != Z_OK) return {};
    stream.next_in = const_cast<uint8_t*>(packed);
    stream.avail_in = static_cast<uInt>(bytes);
    std::vector<uint8_t> out;
    int status = Z_OK;
    while (status == Z_OK && out.size() < static_cast<size_t>(kLargest)) {
        const size_t before = out.size();
        out.resize(before + kStep);
        stream.next_out = out.data() + before;
        stream.avail_out = static_cast<uInt>(kStep);
        status = ::inflate(&stream, Z_NO_FLUSH);
        out.resize(before + kStep - stream.avail_out);
    }
    ::inflateEnd(&stream);
    return status == Z_STREAM_END ? out : std::vector<uint8_t>();
}

}  // namespace

// A name, a zero, the method of compression, which is zlib's, and the data (PNG, third edition, 11.3.2.3).
std::vector<uint8_t> png_profile(const InputFile& file, int64_t at, int64_t bytes) {
    const std::vector<uint8_t> chunk = bytes_at(file, at, bytes);
    const auto end = std::find(chunk.begin(), chunk.end(), 0);
    constexpr ptrdiff_t kBehindName = 2;
    if (chunk.end() - end <= kBehindName || end[1] != 0) return {};
    const auto packed = static_cast<size_t>(end - chunk.begin() + kBehindName);
    return inflated(chunk.data() + packed, chunk.size() - packed);
}

// RIFF: of each chunk a name, its length in four bytes, the lowest first, and the data, to an even number of bytes. The
// profile is before the pixels.
WebpProfile webp_profile(const InputFile& file) {
    constexpr int64_t kFirst = 12, kHead = 8;
    constexpr int kMostChunks = 16;
    int64_t at = kFirst;
    for (int k = 0; k < kMostChunks; ++k) {
        std::array<uint8_t, kHead> head{};
        const Result<size_t> got = file.read(at, head.data(), head.size());
        if (!got || *got < head.size()) return {};
        const std::string_view type(reinterpret_cast<const char*>(head.data()), 4);
        const int64_t bytes = uint32_t{head[4]} | uint32_t{head[5]} << 8 | uint32_t{head[6]} << 16 |
                              uint32_t{head[7]} << 24;
        if (type == "ICCP") return {true, bytes_at(file, at + kHead, bytes)};
        if (type != "VP8X") return {};
        at += kHead + bytes + bytes % 2;
    }
    return {};
}

}  // namespace openfab::tools
