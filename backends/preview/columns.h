// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Per-column data of a picture, collected while slices pass from the bottom up: the few voxels that
// a viewer sees into, and the solid thickness. Memory is bounded: of a grid with more columns than
// kMaxColumns, only every n-th along x and y is sampled.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::preview {

constexpr int64_t kMaxColumns = 2'000'000;

/// The sampled columns: (x, y) = (step / 2 + i * step, step / 2 + j * step).
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

/// Codes that a viewer sees in one column, nearest first: the outermost run of solid voxels, up to
/// the stored depth.
struct Sight {
    bool covered = false;
    int32_t z = 0;  ///< of the nearest voxel
    int32_t count = 0;
    uint8_t codes[16]{};
};

/// Rows of codes in groups of 8 columns, so that an unchanged group costs one comparison. Most
/// groups of a print are unchanged; the others make up the cost of a preview.
class ColumnGroups {
  public:
    explicit ColumnGroups(const ColumnGrid& grid)
        : per_row_((grid.width + 7) / 8),
          groups_(static_cast<size_t>(per_row_) * static_cast<size_t>(grid.height)) {}

    struct Group {
        uint64_t codes = 0;          ///< of the latest slice, first column in the lowest byte
        int32_t since = -(1 << 20);  ///< first slice that had these codes
    };
    int32_t per_row() const { return per_row_; }
    Group& at(int32_t row, int32_t group) {
        return groups_[static_cast<size_t>(row) * static_cast<size_t>(per_row_) +
                       static_cast<size_t>(group)];
    }
    uint8_t code(int32_t column, int32_t row) const {
        const size_t group = static_cast<size_t>(row) * static_cast<size_t>(per_row_) +
                             static_cast<size_t>(column / 8);
        return static_cast<uint8_t>(groups_[group].codes >> (8 * (column % 8)));
    }

  private:
    int32_t per_row_;
    std::vector<Group> groups_;
};

/// A row of codes, padded with zeros to a multiple of 8 columns.
using PaddedRow = std::vector<uint8_t>;
inline size_t padded(int32_t width) {
    return (static_cast<size_t>(width) + 7) / 8 * 8;
}

/// Columns seen from +z (the topmost run) or from -z (the lowest). A history of codes shifts
/// through one word a column: 16 codes of 4 bits, or 8 of 8 bits.
class SightColumns {
  public:
    SightColumns(const ColumnGrid& grid, int32_t bits, bool from_above);
    /// Adds the codes of row `row` at slice z. Slices come in order, without gaps, each with all
    /// its rows.
    void add_row(int32_t z, int32_t row, const PaddedRow& codes);
    Sight at(int32_t column, int32_t row) const;

  private:
    void add_above(int32_t z, size_t first, uint64_t codes);
    void add_below(int32_t z, size_t first, uint64_t codes);
    size_t index(int32_t column, int32_t row) const {
        return static_cast<size_t>(row) * width_ + static_cast<size_t>(column);
    }

    int32_t bits_;
    int32_t depth_;  ///< codes that a history holds
    bool from_above_;
    size_t width_;  ///< columns a row, padded
    int32_t latest_ = -1;
    ColumnGroups groups_;
    /// Slice of the nearest voxel, -1 for none yet. From above it lags where the column is solid at
    /// the latest slice.
    std::vector<int32_t> z_;
    std::vector<uint64_t> history_;
};

/// Counts the solid voxels of each column.
class ThicknessColumns {
  public:
    explicit ThicknessColumns(const ColumnGrid& grid);
    void add_row(int32_t z, int32_t row, const PaddedRow& codes);
    int32_t at(int32_t column, int32_t row) const;

  private:
    size_t width_;
    int32_t latest_ = -1;
    ColumnGroups groups_;
    std::vector<int32_t>
        solid_;  ///< ends less starts of the runs that have ended; a start counts at once
};

}  // namespace openfab::preview
