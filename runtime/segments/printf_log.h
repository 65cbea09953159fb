// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lines of printf and assert, in an order that does not depend on threads: first those of surfaces,
// by part, triangle and vertex (see surface::Surface::log), then those at voxels, by row of blocks,
// part, block, voxel (y, x, z); each then in program order. Only the first lines of each
// printf are kept and the rest counted; since logs are joined in that order, the first of the whole
// print are among them.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/segments/handler.h"

namespace openfab::segments {

class PrintfLog {
  public:
    /// How many lines of each printf are kept. Changed before a print, for all of the process.
    static int64_t most_lines() { return most_lines_; }
    static void keep_lines(int64_t most) { most_lines_ = most; }

    struct Line {
        const openfab_printf* print = nullptr;
        std::string text;  ///< "a.fl:7: at (1.25, 0.5, 3) mm: value 3"
    };

    /// Returns the point that the value at an index of the batch is about, mm in part space; nothing
    /// where it has no line.
    using PointAt = std::function<std::optional<std::array<float, 3>>(int32_t index)>;

    /// Adds the lines of one step of a batch.
    void add(const openfab_segments& segments, const openfab_printf& print,
             std::span<const int32_t> groups, const States& states, const PointAt& point_at);
    /// Ends a batch: sorts its lines by index.
    void end_batch();
    /// Appends the lines of a later log, which is emptied.
    void append(PrintfLog* later);
    void clear();
    bool empty() const { return counts_.empty(); }

    const std::vector<Line>& lines() const { return lines_; }
    /// Returns for each printf how many lines are not in the list.
    std::vector<std::pair<const openfab_printf*, int64_t>> left_out() const;

  private:
    struct Pending {
        int32_t index = 0;
        Line line;
    };
    struct Count {
        const openfab_printf* print = nullptr;
        int64_t kept = 0, all = 0;
    };
    Count& count_of(const openfab_printf* print);
    void shorten();

    inline static int64_t most_lines_ = 100;
    std::vector<Pending> pending_;  ///< of the current batch, in the order of its steps
    size_t sorted_ = 0;             ///< number of pending lines after the last `shorten`
    std::vector<Line> lines_;
    std::vector<Count> counts_;
};

}  // namespace openfab::segments
