// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/nrrd_write.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <memory>

#include "base/text.h"

namespace openfab::color {

std::string nrrd_of(const Vec3i& size, int channels, std::span<const uint16_t> values,
                    const std::string& description) {
    std::string raw;
    raw.reserve(values.size() * 2);
    for (const uint16_t value : values) {
        raw += static_cast<char>(value & 0xff);
        raw += static_cast<char>(value >> 8);
    }
    std::string out = fmt::format(
        "NRRD0004\n# {}\ntype: uint16\ndimension: 4\nsizes: {} {} {} {}\n"
        "centerings: none cell cell cell\n"
        "endian: little\nencoding: gzip\n\n",
        printable(description), channels, size.x, size.y, size.z);
    constexpr int kSmallest = 12;
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(kSmallest), libdeflate_free_compressor);
    std::string packed(libdeflate_gzip_compress_bound(compressor.get(), raw.size()), '\0');
    packed.resize(libdeflate_gzip_compress(compressor.get(), raw.data(), raw.size(), packed.data(),
                                           packed.size()));
    return out + packed;
}

}  // namespace openfab::color
