// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts voxels that two parts of equal priority both cover: the later part gets them, which the
// world does not state.

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "runtime/part/part.h"

namespace openfab::pipeline {

/// Counts by pairs of parts, as indices in the build list; the second one gets the voxels.
class Overlaps {
  public:
    struct Count {
        int64_t voxels = 0;
        Vec3i block;  ///< the first block with any, in voxels: lowest, then front, then left
    };

    /// Adds a count; pairs beyond the first 1,000 are dropped.
    void add(int32_t earlier, int32_t later, const Count& count);
    void add(const Overlaps& other);
    bool empty() const { return counts_.empty(); }
    void clear() { counts_.clear(); }
    const std::map<std::pair<int32_t, int32_t>, Count>& counts() const { return counts_; }

    /// Returns a line for each pair, those of most voxels first, at most 8 and one for the rest.
    std::vector<std::string> report(const std::vector<part::Part>& parts,
                                    const part::Grid& grid) const;

  private:
    std::map<std::pair<int32_t, int32_t>, Count> counts_;
};

/// Tracks which voxels of a row of blocks are claimed, while parts are processed in descending
/// priority.
class RowClaims {
  public:
    /// Starts a row with blocks first to end - 1 of `columns`.
    void reset(int32_t columns, int32_t first, int32_t end);
    /// Must be called before each part's blocks.
    void begin_part(const part::Part& part, int32_t index);

    /// Claims the voxels of one row y of a block; returns those that this part gets.
    uint64_t take(int32_t block, int32_t y, uint64_t voxels);
    /// Ends a block after its 8 rows: counts its overlap with a part of equal priority.
    void end_block(int32_t block, const Vec3i& corner, Overlaps* overlaps);

  private:
    size_t row_index(int32_t block, int32_t y) const {
        return static_cast<size_t>((block - first_) * 8 + y);
    }

    int32_t first_ = 0;
    std::vector<uint64_t> claimed_;    ///< a byte a column of 8 voxels, 8 columns a row
    std::vector<uint64_t> explained_;  ///< those of parts of higher priority
    std::vector<int32_t> claimant_;    ///< by block: the last part of this priority; -1
    int32_t priority_ = 0, index_ = -1;
    int64_t shared_ = 0;
};

}  // namespace openfab::pipeline
