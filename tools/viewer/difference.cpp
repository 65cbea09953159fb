// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/difference.h"

#include <algorithm>
#include <cmath>

#include "backends/common/tee_sink.h"

namespace openfab::viewer {

namespace {

constexpr uint8_t kOnlyInSecond = 254;
constexpr std::array<uint8_t, 4> kStandsOut{0xd8, 0x1b, 0x60, 0xff};

void unpack(const uint8_t* row, int32_t bits, std::vector<uint8_t>* codes) {
    const auto width = static_cast<int32_t>(codes->size());
    backends::unpack_row({0, row, 0, width, 1}, 0, bits, codes->data());
}

}  // namespace

Difference::Difference(const pipeline::PrintInfo& first, const pipeline::PrintInfo& second,
                       int32_t width)
    : first_bits_(first.bits),
      second_bits_(second.bits),
      codes_(static_cast<size_t>(width)),
      others_(static_cast<size_t>(width)),
      nothing_(static_cast<size_t>(width)) {
    as_first_.fill(kOnlyInSecond);
    as_first_[0] = 0;
    for (size_t b = 0; b < second.materials.size(); ++b) {
        for (size_t a = 0; a < first.materials.size(); ++a) {
            if (first.materials[a].name == second.materials[b].name)
                as_first_[b + 1] = static_cast<uint8_t>(a + 1);
        }
    }
}

const uint8_t* Difference::row(const uint8_t* first, const uint8_t* second) {
    if (first == nullptr && second == nullptr) return nullptr;
    unpack(first != nullptr ? first : nothing_.data(), first_bits_, &codes_);
    unpack(second != nullptr ? second : nothing_.data(), second_bits_, &others_);
    for (size_t i = 0; i < codes_.size(); ++i)
        codes_[i] = codes_[i] == as_first_[others_[i]] ? codes_[i] : kDifferent;
    return codes_.data();
}

void Difference::fade(Palette* palette) {
    for (std::array<uint8_t, 4>& rgba : *palette)
        rgba[3] = static_cast<uint8_t>(rgba[3] / 4);
    (*palette)[kDifferent] = kStandsOut;
}

void Difference::fade_through(Palette* palette, double across_mm) {
    // The page takes alpha a as an extinction of a / (1 - a) per mm.
    const double extinction = std::log(2.0) / std::max(across_mm, 1e-3);
    const double most = std::max(2.0, std::round(255 * extinction / (1 + extinction)));
    for (std::array<uint8_t, 4>& rgba : *palette)
        rgba[3] = static_cast<uint8_t>(std::min(double{1} * rgba[3], most));
    (*palette)[kDifferent] = kStandsOut;
}

}  // namespace openfab::viewer
