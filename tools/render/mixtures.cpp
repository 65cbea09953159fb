// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/mixtures.h"

#include <algorithm>

namespace openfab::render {

namespace {

constexpr uint32_t kMostCodes = 255;

/// The next mixture of as many parts: the first material has most parts at first.
bool next_mixture(std::vector<uint8_t>* parts) {
    size_t last = parts->size() - 1;
    const uint8_t tail = (*parts)[last];
    (*parts)[last] = 0;
    while (last > 0 && (*parts)[last - 1] == 0)
        --last;
    if (last == 0) return false;
    --(*parts)[last - 1];
    (*parts)[last] = static_cast<uint8_t>(tail + 1);
    return true;
}

}  // namespace

Mixtures::Mixtures(int32_t materials) : materials_(static_cast<size_t>(materials)), parts_(1) {
    by_code_.resize(1);
    if (materials_ == 0) return;
    // Of one material more parts say nothing.
    const auto most = static_cast<size_t>(materials_ == 1 ? 1 : kMostCodes - 1);
    ways_.assign(materials_ + 1, std::vector<uint32_t>(most + 1, 0));
    ways_[0][0] = 1;
    for (size_t left = 1; left <= materials_; ++left) {
        ways_[left][0] = 1;
        for (size_t p = 1; p <= most; ++p)
            ways_[left][p] = std::min(ways_[left - 1][p] + ways_[left][p - 1], kMostCodes + 1);
    }
    while (static_cast<size_t>(parts_) < most &&
           ways_[materials_][static_cast<size_t>(parts_) + 1] <= kMostCodes)
        ++parts_;
    std::vector<uint8_t> mixture(materials_, 0);
    mixture[0] = static_cast<uint8_t>(parts_);
    do
        by_code_.push_back(mixture);
    while (next_mixture(&mixture));
}

uint8_t Mixtures::draw(const uint16_t* counts, uint16_t random) const {
    uint64_t total = 0;
    for (size_t m = 0; m < materials_; ++m)
        total += counts[m];
    // Parts are counted where the sum of shares passes random + 0, 1, 2 …: the mean of each is its share.
    uint32_t code = 1;
    uint64_t sum = 0;
    uint64_t before = 0;
    auto left = static_cast<uint64_t>(parts_);
    for (size_t m = 0; m + 1 < materials_ && left > 0; ++m) {
        sum += counts[m];
        const uint64_t passed =
            ((static_cast<uint64_t>(parts_) * sum << 16) + random * total) / (total << 16);
        const uint64_t taken = std::min(passed - before, left);
        before = passed;
        // Before it come the mixtures that have more of this material.
        for (uint64_t more = taken + 1; more <= left; ++more)
            code += ways_[materials_ - m - 1][left - more];
        left -= taken;
    }
    return static_cast<uint8_t>(code);
}

}  // namespace openfab::render
