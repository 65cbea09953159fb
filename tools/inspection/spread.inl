// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The loops of spread.h, for the instruction set of the file that includes this. Included once in each. Functions of the
// standard library are not used: the linker could give those of one set to code of another.

#include "simd/target.h"
#include "tools/inspection/distances.h"
#include "tools/inspection/spread.h"

namespace openfab::inspection {
inline namespace OPENFAB_SIMD_ISA {

namespace {

constexpr uint16_t kFar = Squares::kFar;

void copy_of(const uint16_t* from, int32_t count, uint16_t* to) {
    for (int32_t i = 0; i < count; ++i)
        to[i] = from[i];
}
void fill(uint16_t* to, int32_t count) {
    for (int32_t i = 0; i < count; ++i)
        to[i] = kFar;
}

Piece piece_of(const uint16_t* values, int32_t count) {
    uint16_t least = kFar, most = 0;
    for (int32_t i = 0; i < count; ++i) {
        least = values[i] < least ? values[i] : least;
        most = values[i] > most ? values[i] : most;
    }
    return {least < kFar, most > 0};
}

/// Lowers a piece to what `row_of(d)` has, d from `first` to `last`, null for nothing, with the cost of each. A whole
/// piece stays in registers.
template <typename RowOf>
OPENFAB_INLINE void lower(uint16_t* to, int32_t count, int32_t first, int32_t last,
                          const uint16_t* cost_of, const RowOf& row_of) {
    if (count == kPiece) {
        uint16_t least[kPiece];
        for (int32_t i = 0; i < kPiece; ++i)
            least[i] = to[i];
        for (int32_t d = first; d <= last; ++d) {
            const uint16_t* from = row_of(d);
            if (!from) continue;
            const uint16_t cost = cost_of[d];
            for (int32_t i = 0; i < kPiece; ++i) {
                const auto sum = static_cast<uint16_t>(from[i] + cost);
                least[i] = sum < least[i] ? sum : least[i];
            }
        }
        for (int32_t i = 0; i < kPiece; ++i)
            to[i] = least[i];
        return;
    }
    for (int32_t d = first; d <= last; ++d) {
        const uint16_t* from = row_of(d);
        if (!from) continue;
        for (int32_t i = 0; i < count; ++i) {
            const auto sum = static_cast<uint16_t>(from[i] + cost_of[d]);
            to[i] = sum < to[i] ? sum : to[i];
        }
    }
}

void spread_across(uint16_t* first, size_t stride, int32_t rows, int32_t width,
                   const uint16_t* costs, int32_t steps, uint16_t* copy, Piece* pieces) {
    const bool moves = costs[0] > 0;  // half a voxel off, a row does not hold its own numbers any more
    for (int32_t begin = 0; begin < width; begin += kPiece) {
        const int32_t count = width - begin < kPiece ? width - begin : kPiece;
        const auto row = [&](int32_t r) OPENFAB_INLINE_LAMBDA {
            return first + static_cast<size_t>(r) * stride + begin;
        };
        bool any = false;
        for (int32_t r = 0; r < rows; ++r) {
            pieces[r] = piece_of(row(r), count);
            if (!pieces[r].gives) continue;
            any = true;
            copy_of(row(r), count, copy + static_cast<ptrdiff_t>(r) * kPiece);
        }
        if (!any) continue;
        for (int32_t r = 0; r < rows; ++r) {
            if (!pieces[r].takes && !moves) continue;
            if (moves) fill(row(r), count);
            const int32_t from = r < steps ? -r : -steps;
            const int32_t to = rows - 1 - r < steps ? rows - 1 - r : steps;
            lower(row(r), count, from, to, costs,
                  [&](int32_t d) OPENFAB_INLINE_LAMBDA -> const uint16_t* {
                      const bool gives = (d != 0 || moves) && pieces[r + d].gives;
                      return gives ? copy + static_cast<ptrdiff_t>(r + d) * kPiece : nullptr;
                  });
        }
    }
}

void spread_along(uint16_t* row, int32_t width, const uint16_t* costs, int32_t steps,
                  uint16_t* copy, Piece* pieces) {
    const bool moves = costs[0] > 0;
    const int32_t count = (width + kPiece - 1) / kPiece;
    const auto size_of = [&](int32_t p) OPENFAB_INLINE_LAMBDA {
        return width - p * kPiece < kPiece ? width - p * kPiece : kPiece;
    };
    bool gives = false, takes = false;
    for (int32_t p = 0; p < count; ++p) {
        pieces[p] = piece_of(row + p * kPiece, size_of(p));
        gives |= pieces[p].gives, takes |= pieces[p].takes;
    }
    if (!gives || (!takes && !moves)) return;
    copy_of(row, width, copy + steps);
    const int32_t reach = (steps + kPiece - 1) / kPiece;
    for (int32_t p = 0; p < count; ++p) {
        if (!pieces[p].takes && !moves) continue;
        uint16_t* const to = row + p * kPiece;
        if (moves) fill(to, size_of(p));
        bool any = false;
        for (int32_t k = p < reach ? 0 : p - reach; k <= p + reach && k < count; ++k)
            any |= pieces[k].gives;
        if (!any) continue;
        const uint16_t* const from = copy + steps + p * kPiece;
        lower(to, size_of(p), -steps, steps, costs,
              [&](int32_t d) OPENFAB_INLINE_LAMBDA { return from + d; });
    }
}

}  // namespace

extern const SpreadKernels kSpreadKernels;
const SpreadKernels kSpreadKernels{spread_across, spread_along};

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::inspection
