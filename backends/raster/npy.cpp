// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/npy.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>

#include "base/check.h"

namespace openfab::raster {

std::vector<uint8_t> npy_header(const std::string& type, std::span<const int64_t> shape) {
    constexpr std::string_view kStart("\x93NUMPY\x01\x00\x76\x00", 10);  // 1.0, 118 bytes follow
    std::string text(kStart);
    text += fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type,
                        fmt::join(shape, ", "));
    OPENFAB_CHECK(text.size() < kNpyHeaderBytes);
    text.resize(kNpyHeaderBytes - 1, ' ');
    text += '\n';
    return {text.begin(), text.end()};
}

}  // namespace openfab::raster
