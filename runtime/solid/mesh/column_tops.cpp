// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "runtime/solid/mesh/mesh_tops.h"
#include "runtime/surface/transform_box.h"
#include "runtime/voxel/crossings.h"
#include "runtime/voxel/snapping.h"

namespace openfab::solid {

namespace {

using voxel::Crossing;

constexpr int32_t kNone = std::numeric_limits<int32_t>::min();

/// The two highest crossings of a column with the surface, each with the sum of its turns. The
/// winding number is 0 far above and increases by the sum at each; the solid nearly always begins
/// at one of the two.
struct Highest {
    int32_t first = kNone, turn = 0;
    int32_t second = kNone, second_turn = 0;
    bool more = false;  ///< there are further ones below

    void add(int32_t c, int32_t t) {
        if (c == first) {
            turn += t;
        } else if (c > first) {
            more |= second != kNone;
            second = first, second_turn = turn;
            first = c, turn = t;
        } else if (c == second) {
            second_turn += t;
        } else if (c > second) {
            more |= second != kNone;
            second = c, second_turn = t;
        } else {
            more = true;
        }
    }
};

/// Scratch memory, reused from call to call.
struct ColumnScratch {
    std::vector<Highest> highest;
    std::vector<uint8_t> open;  ///< columns that the two highest crossings do not decide
    std::vector<Crossing> crossings, open_crossings;
};

class CoveredTops {
  public:
    CoveredTops(const GridSurface& on, const Columns& columns, ColumnScratch* scratch,
                TopRows* rows)
        : on_(on),
          columns_(columns),
          snapping_(on.part, on.grid, true),
          scratch_(*scratch),
          rows_(*rows) {
        window_ = {{columns.x0, columns.y0, 0}, {columns.x1, columns.y1, on.grid.size.z}};
    }

    void run() {
        scratch_.highest.assign(columns_.count(), {});
        for_crossings([&](const Crossing& x) { scratch_.highest[column_of(x)].add(x.c, x.turn); });
        if (decide()) return;
        scratch_.open_crossings.clear();
        for_crossings([&](const Crossing& x) {
            if (scratch_.open[column_of(x)] != 0) scratch_.open_crossings.push_back(x);
        });
        sweep();
    }

  private:
    size_t column_of(const Crossing& x) const {
        return static_cast<size_t>(x.k - columns_.y0) * static_cast<size_t>(columns_.width()) +
               static_cast<size_t>(x.j - columns_.x0);
    }
    /// Slices [0, c) lie below a crossing; the highest of them is c - 1.
    void raise(int32_t x, int32_t y, int32_t c) { rows_.raise(x, y, std::max(c - 1, 0)); }

    template <typename Visit>
    void for_crossings(const Visit& visit) {
        const auto meets = [&](const Box3f& bounds) {
            const Box3d b = surface::transform_box(snapping_.map(), bounds);
            // One unit for rounding to float.
            return voxel::first_row(voxel::snap(b.lo.x - 1)) < columns_.x1 &&
                   voxel::first_row(voxel::snap(b.hi.x + 1)) > columns_.x0 &&
                   voxel::first_row(voxel::snap(b.lo.y - 1)) < columns_.y1 &&
                   voxel::first_row(voxel::snap(b.hi.y + 1)) > columns_.y0;
        };
        on_.patches.find(meets, [&](int32_t p) {
            const std::array<Vec3i, 3> v = snapping_.triangle(on_.surface.patches()[p].triangle);
            scratch_.crossings.clear();
            voxel::add_column_crossings(v[0], v[1], v[2], snapping_.turn(), window_,
                                        &scratch_.crossings);
            for (const Crossing& x : scratch_.crossings)
                visit(x);
        });
    }

    /// Returns false if columns remain undecided.
    bool decide() {
        bool all = true;
        size_t at = 0;
        scratch_.open.assign(columns_.count(), 0);
        for (int32_t y = columns_.y0; y < columns_.y1; ++y) {
            for (int32_t x = columns_.x0; x < columns_.x1; ++x, ++at) {
                const Highest& h = scratch_.highest[at];
                if (h.turn > 0) {
                    raise(x, y, h.first);
                } else if (h.turn + h.second_turn > 0) {
                    raise(x, y, h.second);
                } else if (h.more) {
                    scratch_.open[at] = 1;
                    all = false;
                }
            }
        }
        return all;
    }

    void sweep() {
        std::vector<Crossing>& all = scratch_.open_crossings;
        std::sort(all.begin(), all.end(), [&](const Crossing& a, const Crossing& b) {
            const size_t pa = column_of(a), pb = column_of(b);
            return pa != pb ? pa < pb : a.c > b.c;
        });
        for (size_t i = 0; i < all.size();) {
            const size_t column = column_of(all[i]);
            const Crossing first = all[i];
            int32_t winding = 0;
            bool found = false;
            while (i < all.size() && column_of(all[i]) == column) {
                const int32_t c = all[i].c;
                for (; i < all.size() && column_of(all[i]) == column && all[i].c == c; ++i)
                    winding += all[i].turn;
                if (winding <= 0 || found) continue;
                found = true;
                raise(first.j, first.k, c);
            }
        }
    }

    const GridSurface& on_;
    const Columns columns_;
    const voxel::Snapping snapping_;
    ColumnScratch& scratch_;
    TopRows& rows_;
    voxel::Window window_;
};

}  // namespace

void raise_to_covered(const GridSurface& on, const Columns& columns, TopRows* rows) {
    // Scratch memory is by columns.
    constexpr int32_t kChunk = 256;
    ColumnScratch scratch;
    for (int32_t x = columns.x0; x < columns.x1; x += kChunk) {
        const Columns some{x, columns.y0, std::min(x + kChunk, columns.x1), columns.y1};
        if (!some.empty()) CoveredTops(on, some, &scratch, rows).run();
    }
}

}  // namespace openfab::solid
