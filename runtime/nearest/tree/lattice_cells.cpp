// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/lattice_cells.h"

namespace openfab::nearest {

bool LatticeCells::read(const surface::Patch& patch, const surface::MicroMesh& mesh) {
    const auto [a0, b0, a1, b1] = patch.lattice;
    columns_ = a1 - a0;
    rows_ = b1 - b0;
    longest_ = patch.factor - a0 - b0;
    if (columns_ > surface::kTileEdges || rows_ > surface::kTileEdges) return false;
    // Row -1 and row rows_ are absent, as are the cells at both ends of a row.
    std::fill_n(triangle_.begin(), 2 * kSide * static_cast<size_t>(rows_ + 2), int16_t{-1});
    first_[0] = 0;
    for (int32_t b = 0; b < rows_; ++b)
        first_[b + 1] = first_[b] + points(b);
    if (mesh.positions.size() != static_cast<size_t>(first_[rows_] + points(rows_))) return false;
    const std::array<int32_t, 3>*next = mesh.triangles.data(), *end = next + mesh.triangles.size();
    int16_t index = 0;
    const auto take = [&](int32_t v0, int32_t v1, int32_t v2) {
        if (next == end || (*next)[0] != v0 || (*next)[1] != v1 || (*next)[2] != v2)
            return int16_t{-1};
        ++next;
        return index++;
    };
    std::fill_n(sums_.begin(), static_cast<size_t>(columns_) + 1, int16_t{0});
    for (int32_t b = 0; b < rows_; ++b) {
        const int32_t cells_here = cells(b), cells_over = cells(b + 1);
        const int16_t* below = sums_.data() + static_cast<size_t>(b) * kSide;
        int16_t* sums = sums_.data() + static_cast<size_t>(b + 1) * kSide;
        int16_t in_row = 0;
        sums[0] = 0;
        for (int32_t a = 0; a < columns_; ++a) {
            if (a < cells_here) {
                const int32_t here = vertex(a, b), over = vertex(a, b + 1);
                int16_t* of_cell = triangle_.data() + slot(a, b);
                of_cell[0] = take(here, here + 1, over);
                if (a + 1 <= cells_over) of_cell[1] = take(here + 1, over + 1, over);
                in_row = static_cast<int16_t>(in_row + (of_cell[0] >= 0 ? 1 : 0) +
                                              (of_cell[1] >= 0 ? 1 : 0));
            }
            sums[a + 1] = static_cast<int16_t>(below[a + 1] + in_row);
        }
    }
    return next == end;
}

}  // namespace openfab::nearest
