// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The arithmetic of bleed on a dense box of voxels. Each number is the result of the same operations
// in the same order wherever the box ends (rule 1).

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::process {

/// How far two materials run into each other.
struct PairSpread {
    uint8_t a = 0, b = 0;  ///< codes; 0: void
    Vec3d sigma_vox;       ///< of a Gaussian along each axis
};

/// The point spreads of all pairs, with materials by their place among those that bleed.
struct BleedKernels {
    /// One half of a symmetric row of weights whose sum is 1: [0] in the middle.
    using Taps = std::vector<float>;
    struct Pair {
        size_t a, b, kernel;
    };

    std::vector<uint8_t> channels;           ///< by place, rising
    std::vector<std::array<Taps, 3>> taps;   ///< by kernel and axis
    std::vector<std::vector<bool>> spreads;  ///< by kernel and place: whether any pair asks for it
    std::vector<Pair> pairs;
    Vec3i radius;  ///< the largest of all kernels

    explicit BleedKernels(const std::vector<PairSpread>& of);
};

class BleedWindow {
  public:
    void reset(const Vec3i& size, size_t places);
    const Vec3i& size() const { return size_; }
    size_t at(int32_t x, int32_t y, int32_t z) const {
        return (static_cast<size_t>(z) * static_cast<size_t>(size_.y) + static_cast<size_t>(y)) *
                   static_cast<size_t>(size_.x) +
               static_cast<size_t>(x);
    }
    float* fractions(size_t place) { return now_[place].data(); }
    const float* fractions(size_t place) const { return now_[place].data(); }

    /// Undoes bleed in `steps` steps and then lets it happen, if `show`. What is nearer to the border than
    /// (steps + 1 + show) radii is undefined afterwards.
    void run(const BleedKernels& kernels, int32_t steps, bool show);

  private:
    using Field = std::vector<float>;

    void bleed(const BleedKernels& kernels, const Vec3i& border);
    void keep_possible(const Vec3i& border);
    template <typename Row>
    void for_rows(const Vec3i& border, const Row& row) const;
    void convolve(const Field& from, const std::array<BleedKernels::Taps, 3>& taps,
                  const Vec3i& border, const Vec3i& radius, Field* to);

    Vec3i size_;
    std::vector<Field> target_, now_, after_;  ///< by place
    /// By place, of one kernel; then the share of each voxel in what is undone, and fractions times these.
    std::vector<Field> spread_;
    Field along_x_, along_y_;
};

}  // namespace openfab::process
