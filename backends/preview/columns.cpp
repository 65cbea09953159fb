// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/preview/columns.h"

#include <cstring>

#include "base/check.h"

namespace openfab::preview {

ColumnGrid ColumnGrid::make(const Vec3i& size) {
    ColumnGrid grid;
    for (grid.step = 1;; ++grid.step) {
        grid.width = (size.x + grid.step - 1) / grid.step;
        grid.height = (size.y + grid.step - 1) / grid.step;
        if (static_cast<int64_t>(grid.width) * grid.height <= kMaxColumns) return grid;
    }
}

namespace {

uint64_t load_codes(const PaddedRow& codes, int32_t group) {
    uint64_t word = 0;
    std::memcpy(&word, codes.data() + 8 * static_cast<size_t>(group), 8);
    return word;
}

uint8_t code_of(uint64_t codes, size_t i) {
    return static_cast<uint8_t>(codes >> (8 * i));
}

}  // namespace

SightColumns::SightColumns(const ColumnGrid& grid, int32_t bits, bool from_above)
    : bits_(bits),
      depth_(64 / bits),
      from_above_(from_above),
      width_(padded(grid.width)),
      groups_(grid),
      z_(width_ * static_cast<size_t>(grid.height), -1),
      history_(z_.size(), 0) {}

void SightColumns::add_row(int32_t z, int32_t row, const PaddedRow& codes) {
    OPENFAB_CHECK(latest_ < 0 || z == latest_ || z == latest_ + 1);
    latest_ = z;
    for (int32_t g = 0; g < groups_.per_row(); ++g) {
        ColumnGroups::Group& group = groups_.at(row, g);
        const uint64_t now = load_codes(codes, g);
        const size_t first = index(8 * g, row);
        // Histories that are full of one code stay unchanged; from above only the top moves, which
        // is deferred to the end of the run.
        const bool full = z - group.since >= depth_;
        if (now == group.codes && full) continue;
        if (now != group.codes) {
            for (size_t i = 0; from_above_ && full && i < 8; ++i) {
                if (code_of(group.codes, i) != 0) z_[first + i] = z - 1;
            }
            group = {now, z};
        }
        if (from_above_) {
            add_above(z, first, now);
        } else {
            add_below(z, first, now);
        }
    }
}

// Seen from above, the latest code is in the lowest bits; a void in between restarts the history.
void SightColumns::add_above(int32_t z, size_t first, uint64_t codes) {
    for (size_t i = 0; i < 8; ++i) {
        const uint64_t code = code_of(codes, i);
        if (code == 0) continue;
        const uint64_t earlier = z_[first + i] == z - 1 ? history_[first + i] : 0;
        history_[first + i] = (earlier << bits_) | code;
        z_[first + i] = z;
    }
}

// Seen from below, the first code is in the lowest bits; a void leaves a 0, at which at() stops.
void SightColumns::add_below(int32_t z, size_t first, uint64_t codes) {
    for (size_t i = 0; i < 8; ++i) {
        const uint64_t code = code_of(codes, i);
        if (code == 0) continue;
        int32_t& bottom = z_[first + i];
        if (bottom < 0) bottom = z;
        if (z - bottom < depth_) history_[first + i] |= code << ((z - bottom) * bits_);
    }
}

Sight SightColumns::at(int32_t column, int32_t row) const {
    Sight sight;
    const size_t at = index(column, row);
    const bool still_solid = from_above_ && groups_.code(column, row) != 0;
    sight.covered = z_[at] >= 0;
    sight.z = still_solid ? latest_ : z_[at];
    const uint64_t mask = (uint64_t{1} << bits_) - 1;
    for (uint64_t rest = history_[at]; (rest & mask) != 0; rest >>= bits_) {
        sight.codes[sight.count++] = static_cast<uint8_t>(rest & mask);
    }
    return sight;
}

ThicknessColumns::ThicknessColumns(const ColumnGrid& grid)
    : width_(padded(grid.width)),
      groups_(grid),
      solid_(width_ * static_cast<size_t>(grid.height), 0) {}

void ThicknessColumns::add_row(int32_t z, int32_t row, const PaddedRow& codes) {
    latest_ = z;
    for (int32_t g = 0; g < groups_.per_row(); ++g) {
        ColumnGroups::Group& group = groups_.at(row, g);
        const uint64_t now = load_codes(codes, g);
        if (now == group.codes) continue;
        int32_t* solid =
            solid_.data() + static_cast<size_t>(row) * width_ + 8 * static_cast<size_t>(g);
        for (size_t i = 0; i < 8; ++i) {
            const bool was = code_of(group.codes, i) != 0;
            const bool is = code_of(now, i) != 0;
            if (was != is) solid[i] += was ? z : -z;
        }
        group = {now, z};
    }
}

int32_t ThicknessColumns::at(int32_t column, int32_t row) const {
    const int32_t ended = solid_[static_cast<size_t>(row) * width_ + static_cast<size_t>(column)];
    return groups_.code(column, row) != 0 ? ended + latest_ + 1 : ended;
}

}  // namespace openfab::preview
