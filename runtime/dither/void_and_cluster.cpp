// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/dither/void_and_cluster.h"

#include <algorithm>
#include <cstdlib>
#include <span>

#include "abi/voxel_hash.h"
#include "base/vec.h"

namespace openfab::dither {

namespace {

constexpr double kOne = 0x1p32;

/// `at_one` is the value at a distance of one pixel, exp(-1 / (2 sigma²)).
struct Gaussian {
    double at_one, weight;
};
// Among all pixels: sigma = 1.5, Ulichney's choice, and 2.7 and 4.86 for low fractions.
constexpr Gaussian kAmongAll[] = {
    {0.8007374029168081, 1}, {0.9337121249837848, 0.25}, {0.9790536278493406, 0.0625}};
/// The last ranks, a part of all: sigma = 0.65 of their mean distance.
struct Window {
    int32_t part;
    Gaussian gaussian;
    double line, rod;  ///< weights
};
// Most for 1 %, of which a rod of 8 x 8 x 64 has 41 voxels; rods of more are even enough.
constexpr Window kAmongLast[] = {
    {200, {0.9941003121481687, 0.3}, 0.03, 0.025}, {100, {0.9882354306130865, 0.3}, 0.09, 0.075},
    {50, {0.9766092663190326, 0.3}, 0.03, 0.025},  {20, {0.94254501678533, 0.3}, 0.03, 0.005},
    {10, {0.888391108666858, 0.3}, 0.03, 0},       {4, {0.7438930621376464, 0.3}, 0.03, 0}};
constexpr double kLineAmongAll = 0.06, kRodAmongAll = 0.015;

// A rod, what is left of it within its sides, and its length.
constexpr int32_t kWidth = 8, kInnerWidth = kWidth - 2, kLength = 64;
// Weights of the Gaussian, one and two slices up or down.
constexpr double kNextSlice = 0.15, kSecondSlice = 0.04;
// Added to pixels before they are hashed, by use: of 192 pairs of masks, one that errs least.
constexpr uint32_t kTies[] = {47, 41};

/// How much a pixel repels each of the following ones.
class Repulsion {
  public:
    Repulsion(int32_t row, MaskUse use, int32_t slice_step)
        : row_(row), pixels_(row * row + 1), slice_step_(slice_step), use_(use) {
        const auto count = static_cast<size_t>(pixels_);
        squares_.assign(count, row * row);
        for (int32_t y = -row; y <= row; ++y) {
            for (int32_t x = -row; x <= row; ++x) {
                int32_t& square = squares_[pixel(x, y, 0)];
                square = std::min(square, x * x + y * y);
            }
        }
        lines_.assign(count, 0.0);
        rods_.assign(count, 0.0);
        add_boxes({kLength, 1, 1}, 1, &lines_);
        add_boxes({1, kLength, 1}, 1, &lines_);
        if (use == MaskUse::kSides) {
            // A rod along z has four upright strips; those along x and y have two each.
            add_boxes({kWidth, kLength, 1}, 2, &rods_);
            add_boxes({kInnerWidth, kLength, 1}, 2, &rods_);
            add_boxes({kLength, kWidth, 1}, 4, &rods_);
        } else {
            add_boxes({1, 1, kLength}, 1, &lines_);
            add_boxes({kInnerWidth, kInnerWidth, kLength}, 1, &rods_);
            add_boxes({kLength, kInnerWidth, kWidth}, 1, &rods_);
            add_boxes({kInnerWidth, kLength, kWidth}, 1, &rods_);
        }
    }

    std::vector<int64_t> energies(std::span<const Gaussian> gaussians, double line,
                                  double rod) const {
        std::vector<double> sums;
        for (size_t p = 0; p < lines_.size(); ++p)
            sums.push_back(line * lines_[p] + rod * rods_[p]);
        for (const Gaussian& gaussian : gaussians)
            add_gaussian(gaussian, &sums);
        std::vector<int64_t> rounded;
        for (double sum : sums)
            rounded.push_back(static_cast<int64_t>(kOne * sum));
        return rounded;
    }

  private:
    size_t pixel(int32_t x, int32_t y, int32_t z) const {
        const int32_t rest = (x - row_ * y + slice_step_ * z) % pixels_;
        return static_cast<size_t>(rest < 0 ? rest + pixels_ : rest);
    }

    /// Adds the boxes that hold a pixel and the one at each distance, a kLength-th of them.
    void add_boxes(const Vec3i& size, int32_t weight, std::vector<double>* boxes) const {
        for (int32_t z = 1 - size.z; z < size.z; ++z) {
            for (int32_t y = 1 - size.y; y < size.y; ++y) {
                for (int32_t x = 1 - size.x; x < size.x; ++x) {
                    const int32_t both =
                        (size.x - std::abs(x)) * (size.y - std::abs(y)) * (size.z - std::abs(z));
                    (*boxes)[pixel(x, y, z)] += weight * both * (1.0 / kLength);
                }
            }
        }
    }

    void add_gaussian(const Gaussian& gaussian, std::vector<double>* sums) const {
        // By multiplication: libm may differ between machines.
        std::vector<double> power(static_cast<size_t>(pixels_), gaussian.weight);
        for (size_t square = 1; square < power.size(); ++square)
            power[square] = power[square - 1] * gaussian.at_one;
        const auto near = [&](int32_t p, int32_t slices) {
            return power[static_cast<size_t>(squares_[pixel(p, 0, slices)])];
        };
        for (int32_t p = 0; p < pixels_; ++p) {
            double& sum = (*sums)[static_cast<size_t>(p)];
            sum += near(p, 0);
            if (use_ == MaskUse::kSides) continue;
            sum +=
                kNextSlice * (near(p, 1) + near(p, -1)) + kSecondSlice * (near(p, 2) + near(p, -2));
        }
    }

    int32_t row_, pixels_, slice_step_;
    MaskUse use_;
    std::vector<int32_t> squares_;  ///< of the distance, by pixel
    std::vector<double> lines_, rods_;
};

/// The energies of all pixels.
class Energies {
  public:
    explicit Energies(size_t pixels) : energies_(pixels, 0), taken_(pixels, false) {}

    /// Adds `weight` times what a pixel adds to those that follow it.
    void add(const std::vector<int64_t>& of_one, size_t pixel, int64_t weight) {
        const size_t pixels = energies_.size();
        for (size_t p = 0; p < pixel; ++p)
            energies_[p] += weight * of_one[p + pixels - pixel];
        for (size_t p = pixel; p < pixels; ++p)
            energies_[p] += weight * of_one[p - pixel];
    }

    /// Takes the free pixel of least energy. Ties are common at first and are broken by a hash: the
    /// first in order would form a lattice.
    size_t take_largest_void(uint32_t ties) {
        const auto hash = [&](size_t p) { return abi::mix32(static_cast<uint32_t>(p) + ties); };
        size_t best = energies_.size();
        for (size_t p = 0; p < energies_.size(); ++p) {
            if (taken_[p]) continue;
            if (best == energies_.size() || energies_[p] < energies_[best] ||
                (energies_[p] == energies_[best] && hash(p) < hash(best))) {
                best = p;
            }
        }
        taken_[best] = true;
        return best;
    }

  private:
    std::vector<int64_t> energies_;
    std::vector<bool> taken_;
};

}  // namespace

std::vector<uint16_t> void_and_cluster(int32_t row, MaskUse use, int32_t slice_step) {
    const Repulsion repulsion(row, use, slice_step);
    const std::vector<int64_t> among_all =
        repulsion.energies(kAmongAll, kLineAmongAll, kRodAmongAll);
    std::vector<std::vector<int64_t>> among_last;
    for (const Window& window : kAmongLast)
        among_last.push_back(repulsion.energies({&window.gaussian, 1}, window.line, window.rod));
    const size_t pixels = among_all.size();
    Energies energies(pixels);
    std::vector<size_t> order;
    std::vector<uint16_t> ranks(pixels, 0);
    for (size_t rank = 0; rank < pixels; ++rank) {
        const size_t pixel = energies.take_largest_void(kTies[static_cast<size_t>(use)]);
        order.push_back(pixel);
        ranks[pixel] = static_cast<uint16_t>(rank);
        energies.add(among_all, pixel, 1);
        for (size_t w = 0; w < std::size(kAmongLast); ++w) {
            const size_t length = pixels / static_cast<size_t>(kAmongLast[w].part);
            energies.add(among_last[w], pixel, 1);
            if (rank >= length) energies.add(among_last[w], order[rank - length], -1);
        }
    }
    return ranks;
}

}  // namespace openfab::dither
