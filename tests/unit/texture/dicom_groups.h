// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Elements of DICOM files of frames: functional groups, lists of nuclear medicine, segments, items.

#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/texture/dicom_files.h"

namespace openfab::tools {

inline std::string real(double value) {
    return number(std::bit_cast<uint64_t>(value), 8);
}

inline std::string shorts(const std::vector<int>& values) {
    std::string out;
    for (const int value : values)
        out += number(static_cast<uint64_t>(value), 2);
    return out;
}

inline std::string tags(const std::vector<std::pair<uint32_t, uint32_t>>& all) {
    std::string out;
    for (const auto& [group, item] : all)
        out += number(group, 2) + number(item, 2);
    return out;
}

inline std::string at_z(double z) {
    return sequence(0x20, 0x9113, {element(0x20, 0x32, "DS", decimals({0, 0, z}))});
}

inline std::string straight() {
    return sequence(0x20, 0x9116, {element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")});
}

/// Bits of pixels in a row, the lowest first, across frames.
inline std::string bits_of(const std::vector<uint32_t>& pixels) {
    std::string out((pixels.size() + 7) / 8, '\0');
    for (size_t i = 0; i < pixels.size(); ++i)
        out[i / 8] = static_cast<char>(static_cast<uint8_t>(out[i / 8]) | pixels[i] << (i % 8));
    return out;
}

/// An element of pixels in items, behind a table of offsets.
inline std::string items_of_pixels(const std::string& table,
                                   const std::vector<std::string>& items) {
    const std::string item = number(0xfffe, 2) + number(0xe000, 2);
    std::string out = number(0x7fe0, 2) + number(0x10, 2) + "OB" + number(0, 2) +
                      number(0xffffffff, 4) + item + number(table.size(), 4) + table;
    for (const std::string& one : items)
        out += item + number(one.size(), 4) + one;
    return out + number(0xfffe, 2) + number(0xe0dd, 2) + number(0, 4);
}

}  // namespace openfab::tools
