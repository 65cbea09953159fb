// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/preview/columns.h"

namespace openfab::preview {

ColumnGrid ColumnGrid::make(const Vec3i& size) {
    ColumnGrid grid;
    for (grid.step = 1;; ++grid.step) {
        grid.width = (size.x + grid.step - 1) / grid.step;
        grid.height = (size.y + grid.step - 1) / grid.step;
        if (static_cast<int64_t>(grid.width) * grid.height <= kMaxColumns) return grid;
    }
}

void SightColumns::add_row(int32_t z, size_t first, std::span<const uint8_t> codes) {
    if (from_above_) {
        add_row_above(z, first, codes);
    } else {
        add_row_below(z, first, codes);
    }
}

// Seen from above, the latest code stands in the lowest bits; a void in between starts the history
// anew. Selects instead of branches, so that the compiler can take several columns at once.
void SightColumns::add_row_above(int32_t z, size_t first, std::span<const uint8_t> codes) {
    int32_t* top = z_.data() + first;
    uint64_t* history = history_.data() + first;
    for (size_t i = 0; i < codes.size(); ++i) {
        const uint64_t code = codes[i];
        const uint64_t earlier = top[i] == z - 1 ? history[i] : 0;
        history[i] = code != 0 ? (earlier << bits_) | code : history[i];
        top[i] = code != 0 ? z : top[i];
    }
}

// Seen from below, the first code stands in the lowest bits; a void leaves a 0, at which at()
// stops.
void SightColumns::add_row_below(int32_t z, size_t first, std::span<const uint8_t> codes) {
    int32_t* bottom = z_.data() + first;
    uint64_t* history = history_.data() + first;
    for (size_t i = 0; i < codes.size(); ++i) {
        if (bottom[i] < 0) {
            if (codes[i] == 0) continue;
            bottom[i] = z;
        }
        const int64_t shift = static_cast<int64_t>(z - bottom[i]) * bits_;
        if (shift < 64) history[i] |= static_cast<uint64_t>(codes[i]) << shift;
    }
}

Sight SightColumns::at(size_t column) const {
    Sight sight;
    sight.covered = z_[column] >= 0;
    sight.z = z_[column];
    const uint64_t mask = (uint64_t{1} << bits_) - 1;
    for (uint64_t rest = history_[column]; (rest & mask) != 0; rest >>= bits_) {
        sight.codes[sight.count++] = static_cast<uint8_t>(rest & mask);
    }
    return sight;
}

}  // namespace openfab::preview
