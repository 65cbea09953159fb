// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/vertex_table.h"

#include <bit>

namespace openfab::boundary {

void VertexTable::begin() {
    begins_.clear();
    entries_.clear();
}

void VertexTable::begin_word() {
    begins_.push_back(static_cast<uint32_t>(entries_.size()));
}

void VertexTable::add(uint8_t code, int32_t bit, int32_t count, uint32_t first) {
    size_t at = begins_.back();
    while (at < entries_.size() && entries_[at].code != code)
        ++at;
    if (at == entries_.size()) entries_.push_back({0, 0, 0, first, code});
    Entry& entry = entries_[at];
    entry.ones |= static_cast<uint64_t>(count & 1) << bit;
    entry.twos |= static_cast<uint64_t>(count >> 1 & 1) << bit;
    entry.fours |= static_cast<uint64_t>(count >> 2 & 1) << bit;
}

uint32_t VertexTable::first(size_t word, int32_t bit, uint8_t code) const {
    const uint64_t before = (uint64_t{1} << bit) - 1;
    for (size_t at = begins_[word];; ++at) {
        const Entry& entry = entries_[at];
        if (entry.code != code) continue;
        const auto rank = static_cast<uint32_t>(std::popcount(entry.ones & before) +
                                                2 * std::popcount(entry.twos & before) +
                                                4 * std::popcount(entry.fours & before));
        return entry.first + rank;
    }
}

}  // namespace openfab::boundary
