// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a picture needs to know of each column of voxels, gathered while slices pass from the bottom
// up: the few voxels that a viewer sees into, and how much lies in the column. Memory stays
// bounded: of a grid with more columns than kMaxColumns, every n-th is looked at along x and y.

#include <cstdint>
#include <span>
#include <vector>

#include "backends/common/slice_sink.h"

namespace openfab::preview {

constexpr int64_t kMaxColumns = 2'000'000;

/// Which columns are looked at: (x, y) = (step / 2 + i * step, step / 2 + j * step).
struct ColumnGrid {
    int32_t step = 1;
    int32_t width = 0;
    int32_t height = 0;

    static ColumnGrid make(const Vec3i& size);
    int32_t x(int32_t i, const Vec3i& size) const {
        return std::min(step / 2 + i * step, size.x - 1);
    }
    int32_t y(int32_t j, const Vec3i& size) const {
        return std::min(step / 2 + j * step, size.y - 1);
    }
    size_t count() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

/// Codes that a viewer meets in one column, first met first: the outermost run of solid voxels, as
/// far as it is kept.
struct Sight {
    bool covered = false;
    int32_t z = 0;  ///< of the first voxel met
    int32_t count = 0;
    uint8_t codes[16]{};
};

/// Columns seen from +z (the topmost run) or from -z (the lowest). A history of codes shifts
/// through one word a column: 16 codes of 4 bits, or 8 of 8 bits.
class SightColumns {
  public:
    SightColumns(const ColumnGrid& grid, int32_t bits, bool from_above)
        : bits_(bits), from_above_(from_above), z_(grid.count(), -1), history_(grid.count(), 0) {}
    /// The codes of one row of columns, at slice z; `first` is the row's first column.
    void add_row(int32_t z, size_t first, std::span<const uint8_t> codes);
    Sight at(size_t column) const;

  private:
    void add_row_above(int32_t z, size_t first, std::span<const uint8_t> codes);
    void add_row_below(int32_t z, size_t first, std::span<const uint8_t> codes);

    int32_t bits_;
    bool from_above_;
    std::vector<int32_t> z_;  ///< of the first voxel met, -1 for none yet
    std::vector<uint64_t> history_;
};

}  // namespace openfab::preview
