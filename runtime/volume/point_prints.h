// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What printf and assert say at voxels, in an order that no thread changes: rows of blocks, in a
// row parts, blocks, voxels (y, x, z), at a voxel as the program goes. Of each print only the first
// kMostLines are kept and the rest counted; since lists are joined in that order, the first of the
// whole print are among them.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/segments/handler.h"
#include "runtime/volume/print_part.h"

namespace openfab::slab {

class PointPrints {
  public:
    static constexpr int64_t kMostLines = 100;

    struct Line {
        const openfab_print* print = nullptr;
        std::string text;  ///< "a.fl:7: at (1.25, 0.5, 3) mm: value 3"
    };

    /// One step of a batch of blocks; `corners` are 3 part-relative indices each.
    void add(const PrintPart& part, const openfab_phases& phases, const int32_t* corners,
             const openfab_print& print, std::span<const int32_t> groups,
             const phases::States& states);
    /// The batch is complete: puts its lines in order.
    void end_batch();
    /// Takes over the lines of what comes after this.
    void append(PointPrints* later);
    void clear();
    bool empty() const { return counts_.empty(); }

    const std::vector<Line>& lines() const { return lines_; }
    /// Lines of `print` that are not in the list.
    std::vector<std::pair<const openfab_print*, int64_t>> left_out() const;

  private:
    struct Pending {
        int32_t place = 0;
        Line line;
    };
    struct Count {
        const openfab_print* print = nullptr;
        int64_t kept = 0, all = 0;
    };
    Count& count_of(const openfab_print* print);
    void shorten();

    std::vector<Pending> pending_;  ///< of the batch in hand, in the order of its steps
    size_t sorted_ = 0;             ///< as many pending ones after the last `shorten`
    std::vector<Line> lines_;
    std::vector<Count> counts_;
};

}  // namespace openfab::slab
