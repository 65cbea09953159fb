// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The loops of Squares::spread, compiled for each instruction set. Whole numbers: all sets give the same.

#include <cstddef>
#include <cstdint>

namespace openfab::inspection {

/// Whether a piece of a row holds something to spread, and something to lower.
struct Piece {
    bool gives = false, takes = false;
};

/// Of a row: pieces of so many numbers. Those far from all borders, inside or outside, cost no more than a look.
constexpr int32_t kPiece = 64;

struct SpreadKernels {
    /// Lowers each number of `rows` rows, `stride` apart, to the least of another row's with the cost of the way:
    /// costs[d] of d rows, d from -steps to steps. Numbers and costs are below 2^15. `copy` has room for kPiece numbers
    /// of each row, `pieces` for one of each.
    void (*across)(uint16_t* first, size_t stride, int32_t rows, int32_t width,
                   const uint16_t* costs, int32_t steps, uint16_t* copy, Piece* pieces);
    /// The same along one row. `copy` has room for the row and for `steps` at either end, with Squares::kFar there;
    /// `pieces` for each that begins in the row.
    void (*along)(uint16_t* row, int32_t width, const uint16_t* costs, int32_t steps,
                  uint16_t* copy, Piece* pieces);
};

/// Those of this machine's best set, up to `limit` (0 SSE4.1, 1 AVX2).
const SpreadKernels& spread_kernels(int limit = 1);

}  // namespace openfab::inspection
