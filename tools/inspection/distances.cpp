// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/inspection/distances.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace openfab::inspection {

namespace {

constexpr uint16_t kFar = Squares::kFar;

/// Lowers numbers to others, each with the same cost added. Both stay below 2^15, their sum below 2^16.
void lower(const uint16_t* from, uint16_t cost, int32_t count, uint16_t* to) {
    for (int32_t i = 0; i < count; ++i) {
        const auto sum = static_cast<uint16_t>(from[i] + cost);
        to[i] = sum < to[i] ? sum : to[i];
    }
}

// Rows are looked at in pieces: those far from all borders, inside or outside, cost no more than a look.
constexpr int32_t kPiece = 64;

/// Whether a piece of a row holds something to spread, and something to lower.
struct Piece {
    bool gives = false, takes = false;
    Piece(const uint16_t* values, int32_t count) {
        uint16_t least = kFar, most = 0;
        for (int32_t i = 0; i < count; ++i)
            least = std::min(least, values[i]), most = std::max(most, values[i]);
        gives = least < kFar;
        takes = most > 0;
    }
};

int32_t pieces_of(int32_t width) {
    return (width + kPiece - 1) / kPiece;
}

/// Scratch memory of one thread.
struct Scratch {
    std::vector<uint16_t> copy;
    std::vector<Piece> pieces;
};

/// Spreads rows of numbers to each other, `stride` apart.
void spread_rows(uint16_t* first, size_t stride, int32_t rows, int32_t width,
                 const std::vector<uint16_t>& costs, Scratch* scratch) {
    const auto steps = static_cast<int32_t>(costs.size() / 2);
    const uint16_t own = costs[static_cast<size_t>(steps)];
    scratch->copy.resize(static_cast<size_t>(rows) * kPiece);
    uint16_t* const copy = scratch->copy.data();
    std::vector<Piece>& are = scratch->pieces;
    for (int32_t begin = 0; begin < width; begin += kPiece) {
        const int32_t count = std::min(kPiece, width - begin);
        const auto row = [&](int32_t r) { return first + static_cast<size_t>(r) * stride + begin; };
        are.clear();
        bool any = false;
        for (int32_t r = 0; r < rows; ++r) {
            are.emplace_back(row(r), count);
            if (!are.back().gives) continue;
            any = true;
            std::copy_n(row(r), count, copy + static_cast<ptrdiff_t>(r) * kPiece);
        }
        if (!any) continue;
        for (int32_t r = 0; r < rows; ++r) {
            // Half a voxel off, a row does not hold its own numbers any more.
            if (!are[static_cast<size_t>(r)].takes && own == 0) continue;
            uint16_t* const to = row(r);
            if (own > 0) std::fill_n(to, count, kFar);
            for (int32_t d = std::max(-steps, -r); d <= std::min(steps, rows - 1 - r); ++d) {
                if ((d == 0 && own == 0) || !are[static_cast<size_t>(r + d)].gives) continue;
                lower(copy + static_cast<ptrdiff_t>(r + d) * kPiece,
                      costs[static_cast<size_t>(d + steps)], count, to);
            }
        }
    }
}

/// Spreads the numbers of one row along it; the copy has room for the reach at both ends, and kFar there.
void spread_along(uint16_t* row, int32_t width, const std::vector<uint16_t>& costs,
                  Scratch* scratch) {
    const auto steps = static_cast<int32_t>(costs.size() / 2);
    const uint16_t own = costs[static_cast<size_t>(steps)];
    std::vector<Piece>& are = scratch->pieces;
    are.clear();
    bool gives = false, takes = false;
    for (int32_t begin = 0; begin < width; begin += kPiece) {
        are.emplace_back(row + begin, std::min(kPiece, width - begin));
        gives |= are.back().gives, takes |= are.back().takes;
    }
    if (!gives || (!takes && own == 0)) return;
    std::copy_n(row, width, scratch->copy.begin() + steps);
    for (int32_t p = 0; p < pieces_of(width); ++p) {
        if (!are[static_cast<size_t>(p)].takes && own == 0) continue;
        const int32_t begin = p * kPiece, count = std::min(kPiece, width - begin);
        if (own > 0) std::fill_n(row + begin, count, kFar);
        const int32_t reach = (steps + kPiece - 1) / kPiece;
        const auto from = are.begin() + std::max(p - reach, 0);
        const auto to = are.begin() + std::min(p + reach + 1, pieces_of(width));
        if (std::none_of(from, to, [](const Piece& piece) { return piece.gives; })) continue;
        for (int32_t d = -steps; d <= steps; ++d) {
            lower(scratch->copy.data() + steps + begin + d, costs[static_cast<size_t>(d + steps)],
                  count, row + begin);
        }
    }
}

}  // namespace

Squares::Squares(const Vec3d& pitch_mm, double reach_mm) : pitch_mm_(pitch_mm) {
    // Halves of voxels have quarters of squares.
    constexpr double kMost = 32000, kQuarters = 4;
    const double coarse = reach_mm * reach_mm / kMost;
    const bool cubes = pitch_mm.x == pitch_mm.y && pitch_mm.x == pitch_mm.z;
    const double exact = pitch_mm.x * pitch_mm.x / kQuarters;
    unit_mm2_ = cubes ? std::max(coarse, exact) : coarse;
    for (int axis = 0; axis < 3; ++axis)
        steps_[axis] = static_cast<int32_t>(std::min(reach_mm / pitch_mm[axis], 1e6)) + 2;
}

uint16_t Squares::from(double mm) const {
    constexpr double kRounding = 1e-6;
    const double square = std::ceil(mm * mm / unit_mm2_ - kRounding);
    return static_cast<uint16_t>(std::clamp(square, 0.0, double{kFar}));
}

double Squares::length(uint16_t square) const {
    return std::sqrt(square * unit_mm2_);
}

std::vector<uint16_t> Squares::costs(int axis, int32_t half) const {
    const int32_t steps = steps_[axis];
    std::vector<uint16_t> out;
    for (int32_t d = -steps; d <= steps; ++d) {
        const double mm = (d - 0.5 * half) * pitch_mm_[axis];
        out.push_back(static_cast<uint16_t>(std::min(mm * mm / unit_mm2_ + 0.5, double{kFar})));
    }
    return out;
}

void Squares::spread(Box<uint16_t>* values, const Vec3i& half) const {
    const Vec3i& size = values->size;
    const std::vector<uint16_t> x_costs = costs(0, half.x), y_costs = costs(1, half.y),
                                z_costs = costs(2, half.z);
    const auto width = static_cast<size_t>(size.x);
    tbb::parallel_for(0, size.z, [&](int32_t z) {
        Scratch along, across;
        along.copy.assign(width + x_costs.size(), kFar);
        for (int32_t y = 0; y < size.y; ++y)
            spread_along(&values->values[values->at(0, y, z)], size.x, x_costs, &along);
        spread_rows(&values->values[values->at(0, 0, z)], width, size.y, size.x, y_costs, &across);
    });
    tbb::parallel_for(0, size.y, [&](int32_t y) {
        Scratch across;
        spread_rows(&values->values[values->at(0, y, 0)], width * static_cast<size_t>(size.y),
                    size.z, size.x, z_costs, &across);
    });
}

}  // namespace openfab::inspection
