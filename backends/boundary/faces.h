// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds the faces between voxels of different codes, and merges those alike into rectangles: across z in a whole plane, across x and y in the height of a slice.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "backends/boundary/lattice.h"
#include "backends/boundary/rectangle.h"

namespace openfab::boundary {

/// Finds rectangles, deterministically and in a fixed order. Reuses its buffers from call to call.
class FaceFinder {
  public:
    FaceFinder(int32_t width, int32_t height)
        : width_(width),
          height_(height),
          labels_(static_cast<size_t>(width) + 1 + kOverrun),
          starts_(static_cast<size_t>(width) + 1) {}

    /// Visits faces across z at lattice plane `z`. Runs along x grow along y while they are the
    /// same.
    template <typename Visit>
    void across_z(const Layer& below, const Layer& above, int32_t z, Visit visit) {
        growing_.clear();
        for (int32_t y = 0; y < height_; ++y) {
            next_.clear();
            size_t at = 0;
            const auto close = [&](int32_t before) {
                for (; at < growing_.size() && growing_[at].u0 < before; ++at)
                    visit(growing_[at]);
            };
            for_each_run(below.row(y), above.row(y), width_,
                         [&](int32_t x0, int32_t x1, uint8_t low, uint8_t high) {
                             close(x0);
                             Rectangle run{2, z, x0, x1, y, y + 1, low, high};
                             if (at < growing_.size() && same_run(growing_[at], run))
                                 run.v0 = growing_[at++].v0;
                             next_.push_back(run);
                         });
            close(width_);
            growing_.swap(next_);
        }
        for (const Rectangle& r : growing_)
            visit(r);
    }

    /// Visits faces across x and y of the slice between the lattice planes z and z + 1.
    template <typename Visit>
    void across_xy(const Layer& layer, int32_t z, Visit visit) {
        std::fill(labels_.begin(), labels_.end(), uint16_t{0});
        for (int32_t y = 0; y <= height_; ++y) {
            for_each_run(layer.row(y - 1), layer.row(y), width_,
                         [&](int32_t x0, int32_t x1, uint8_t low, uint8_t high) {
                             visit(Rectangle{1, y, x0, x1, z, z + 1, low, high});
                         });
            across_x(layer.row(y), y, z, visit);
        }
    }

  private:
    static constexpr size_t kOverrun = 8;

    static bool same_run(const Rectangle& a, const Rectangle& b) {
        return a.u0 == b.u0 && a.u1 == b.u1 && a.low == b.low && a.high == b.high;
    }

    /// Visits one row; a run along y ends where its label changes.
    template <typename Visit>
    void across_x(const uint8_t* row, int32_t y, int32_t z, Visit visit) {
        for (int32_t x = 0; x <= width_; ++x) {
            if (nothing_here(row, x)) {
                x += 7;
                continue;
            }
            const auto index = static_cast<size_t>(x);
            const uint8_t low = row[x - 1], high = row[x];
            const auto label = static_cast<uint16_t>(low != high ? low << 8 | high : 0);
            const uint16_t open = labels_[index];
            if (open == label) continue;
            if (open != 0) {
                visit(Rectangle{0, x, starts_[index], y, z, z + 1, static_cast<uint8_t>(open >> 8),
                                static_cast<uint8_t>(open)});
            }
            labels_[index] = label;
            starts_[index] = y;
        }
    }

    /// Returns whether no face and no end of a run is at the next 8 points.
    bool nothing_here(const uint8_t* row, int32_t x) const {
        if (eight_codes(row + x - 1) != eight_codes(row + x)) return false;
        uint64_t open[2];
        std::memcpy(open, &labels_[x], sizeof open);
        return (open[0] | open[1]) == 0;
    }

    int32_t width_, height_;
    std::vector<Rectangle> growing_, next_;
    std::vector<uint16_t> labels_;  ///< of the run along y that is open at x; 0: none
    std::vector<int32_t> starts_;
};

}  // namespace openfab::boundary
