// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Bleed, against closed forms and against the whole grid computed at once.

#include "runtime/process/bleed/bleed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "abi/stage_table.h"

namespace openfab::process {
namespace {

double error_of(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - b[i]) * static_cast<double>(a[i] - b[i]);
    return std::sqrt(sum);
}

/// Two materials whose fractions add up to 1, the first given, on a margin of the background.
class Plane {
  public:
    Plane(int32_t width, int32_t margin, double low, double high)
        : width_(width), margin_(margin), low_(low), high_(high), wanted_(box(), 0) {
        for (int32_t y = 0; y < width; ++y) {
            for (int32_t x = 0; x < width; ++x)
                wanted_[at(x, y)] = static_cast<float>(is_line(x, y) || is_dot(x, y) ? high : low);
        }
    }

    /// What is printed where `steps` undo a bleed of `sigma` voxels, and what becomes of it.
    std::vector<float> come_out(double sigma, int32_t steps, std::vector<float>* printed) const {
        const BleedKernels kernels({{1, 2, {sigma, sigma, 0}}});
        BleedWindow window;
        load(wanted_, &window);
        window.run(kernels, steps, false);
        *printed = unload(window);
        load(*printed, &window);
        window.run(kernels, 0, true);
        return unload(window);
    }
    const std::vector<float>& wanted() const { return wanted_; }

  private:
    bool is_line(int32_t x, int32_t y) const {
        if (y >= width_ / 2) return false;
        for (int32_t line = 1, left = 4; line <= 6; left += 3 * line, ++line) {
            if (x >= left && x < left + line) return true;
        }
        return false;
    }
    bool is_dot(int32_t x, int32_t y) const {
        const double r = 1 + x / 14, dx = x % 14 - 6, dy = y % 14 - 6;
        return y >= width_ / 2 && dx * dx + dy * dy <= r * r;
    }
    size_t box() const { return static_cast<size_t>(width_) * static_cast<size_t>(width_); }
    size_t at(int32_t x, int32_t y) const {
        return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
    }
    void load(const std::vector<float>& first, BleedWindow* window) const {
        window->reset({width_ + 2 * margin_, width_ + 2 * margin_, 1}, 2);
        for (int32_t y = -margin_; y < width_ + margin_; ++y) {
            for (int32_t x = -margin_; x < width_ + margin_; ++x) {
                const bool inside = x >= 0 && y >= 0 && x < width_ && y < width_;
                const float value = inside ? first[at(x, y)] : static_cast<float>(low_);
                const size_t to = window->at(x + margin_, y + margin_, 0);
                window->fractions(0)[to] = value;
                window->fractions(1)[to] = 1 - value;
            }
        }
    }
    std::vector<float> unload(const BleedWindow& window) const {
        std::vector<float> out(box());
        for (int32_t y = 0; y < width_; ++y) {
            for (int32_t x = 0; x < width_; ++x)
                out[at(x, y)] = window.fractions(0)[window.at(x + margin_, y + margin_, 0)];
        }
        return out;
    }

    int32_t width_, margin_;
    double low_, high_;
    std::vector<float> wanted_;
};

double sum_of(const std::vector<float>& v) {
    double sum = 0;
    for (const float one : v)
        sum += static_cast<double>(one);
    return sum;
}

TEST(Bleed, UndoneHasHalfTheErrorAndTheVolume) {
    for (const double sigma : {0.4, 0.5, 0.6}) {
        const Plane chart(84, 16, 0.3, 0.7);
        std::vector<float> printed;
        const double none = error_of(chart.come_out(sigma, 0, &printed), chart.wanted());
        const double undone = error_of(chart.come_out(sigma, 2, &printed), chart.wanted());
        EXPECT_LT(undone, none / 2) << sigma;
        EXPECT_NEAR(sum_of(printed) / sum_of(chart.wanted()), 1, 0.005) << sigma;
        std::vector<float> more;
        EXPECT_LT(error_of(chart.come_out(sigma, 4, &more), chart.wanted()), undone) << sigma;
    }
}

TEST(Bleed, AnEdgeBecomesTheErrorFunction) {
    constexpr double kSigma = 2.5;
    const BleedKernels kernels({{0, 1, {kSigma, 0, 0}}});
    BleedWindow window;
    window.reset({64, 1, 1}, 2);
    for (int32_t x = 0; x < 64; ++x) {
        window.fractions(0)[x] = x < 32 ? 1.0f : 0.0f;
        window.fractions(1)[x] = x < 32 ? 0.0f : 1.0f;
    }
    window.run(kernels, 0, true);
    for (int32_t x = 12; x < 52; ++x) {
        const double wanted = 0.5 * std::erfc((32 - x - 0.5) / kSigma / std::sqrt(2.0));
        // The tails beyond three sigma are missing.
        EXPECT_NEAR(window.fractions(1)[x], wanted, 0.003) << x;
        EXPECT_NEAR(window.fractions(0)[x] + window.fractions(1)[x], 1, 1e-6);
    }
}

TEST(Bleed, PairsExchangeAsMuchAsTheyGet) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0, 1);
    const BleedKernels kernels({{1, 2, {1, 0.5, 0}}, {2, 3, {0.3, 1, 0}}, {1, 3, {2, 2, 0}}});
    BleedWindow window;
    const Vec3i size{60, 60, 1};
    window.reset(size, 3);
    double before[3]{}, after[3]{};
    for (int32_t y = 0; y < size.y; ++y) {
        for (int32_t x = 0; x < size.x; ++x) {
            const size_t at = window.at(x, y, 0);
            const bool inside = x >= 20 && x < 40 && y >= 20 && y < 40;
            const float a = uniform(random), b = (1 - a) * uniform(random);
            window.fractions(0)[at] = inside ? a : 0;
            window.fractions(1)[at] = inside ? b : 0;
            window.fractions(2)[at] = inside ? 1 - a - b : 1;
            for (size_t m = 0; m < 3; ++m)
                before[m] += window.fractions(m)[at];
        }
    }
    window.run(kernels, 0, true);
    for (int32_t y = 6; y < size.y - 6; ++y) {
        for (int32_t x = 6; x < size.x - 6; ++x) {
            for (size_t m = 0; m < 3; ++m)
                after[m] += window.fractions(m)[window.at(x, y, 0)];
        }
    }
    EXPECT_NEAR(after[0], before[0], 1e-3 * before[0]);
    EXPECT_NEAR(after[1], before[1], 1e-3 * before[1]);
}

/// A grid of codes and mixtures, as bands of slabs.
class Grid {
  public:
    Grid(const Vec3i& size, int32_t materials, uint32_t seed)
        : size_(size), channels_(materials + 1) {
        std::mt19937 random(seed);
        const Vec3i blocks{(size.x + 7) / 8, (size.y + 7) / 8, (size.z + 7) / 8};
        bands_.resize(static_cast<size_t>(blocks.y * blocks.z));
        present_.resize(bands_.size());
        for (int32_t slab = 0; slab < blocks.z; ++slab) {
            for (int32_t row = 0; row < blocks.y; ++row) {
                dither::RowBand& band = bands_[static_cast<size_t>(slab * blocks.y + row)];
                band.reset(row, blocks.x, channels_, 0, blocks.x);
                for (int32_t block = 0; block < blocks.x; ++block)
                    fill(block, slab, &random, &band);
            }
        }
    }

    NearBands near(const Bleed& bleed, int32_t slab, int32_t row) {
        NearBands out{{}, slab, row};
        const Vec3i reach = bleed.reach_blocks();
        const int32_t rows = (size_.y + 7) / 8, slabs = (size_.z + 7) / 8;
        for (int32_t s = slab - reach.z; s <= slab + reach.z; ++s) {
            for (int32_t r = row - reach.y; r <= row + reach.y; ++r) {
                if (s < 0 || s >= slabs || r < 0 || r >= rows) {
                    out.bands.emplace_back();
                    continue;
                }
                const auto i = static_cast<size_t>(s * rows + r);
                bleed.note(bands_[i], &present_[i]);
                out.bands.push_back({&bands_[i], &present_[i]});
            }
        }
        return out;
    }

    /// The amount of a channel in 65535ths.
    static int32_t amount(const dither::RowBand& band, int32_t channel, int32_t x, int32_t y,
                          int32_t z) {
        const auto voxel = static_cast<size_t>(y * band.width() + x);
        if ((band.mixed_row(y)[x] >> z & 1) == 0)
            return band.codes[voxel * 8 + static_cast<size_t>(z)] == channel ? 65535 : 0;
        return band.fractions[static_cast<size_t>(band.columns[voxel] * 8 * band.channels +
                                                  8 * channel + z)];
    }
    int32_t amount_at(int32_t channel, int32_t x, int32_t y, int32_t z) const {
        if (x < 0 || y < 0 || z < 0 || x >= size_.x || y >= size_.y || z >= size_.z)
            return channel == 0 ? 65535 : 0;
        const int32_t rows = (size_.y + 7) / 8;
        return amount(bands_[static_cast<size_t>(z / 8 * rows + y / 8)], channel, x, y % 8, z % 8);
    }

  private:
    /// Blocks of one material, of single voxels, of one mixture, and of many.
    void fill(int32_t block, int32_t slab, std::mt19937* random, dither::RowBand* band) {
        const uint32_t kind = (*random)() % 4;
        const auto one = static_cast<uint8_t>((*random)() % static_cast<uint32_t>(channels_));
        int32_t column = -1;
        for (int32_t y = 0; y < 8; ++y) {
            for (int32_t x = 8 * block; x < 8 * block + 8; ++x) {
                uint8_t* codes = band->codes_at(x, y);
                const bool outside = x >= size_.x || 8 * band->row + y >= size_.y;
                for (int32_t z = 0; z < 8; ++z) {
                    codes[z] =
                        kind == 0
                            ? one
                            : static_cast<uint8_t>((*random)() % static_cast<uint32_t>(channels_));
                    if (outside || 8 * slab + z >= size_.z) codes[z] = 0;
                }
                if (outside || kind < 2) continue;
                if (column < 0 || kind == 3) {
                    column = band->add_columns(1);
                    for (int32_t z = 0; z < 8; ++z) {
                        int32_t left = 65535;
                        for (int32_t c = 0; c < channels_; ++c) {
                            const int32_t part =
                                c + 1 == channels_
                                    ? left
                                    : static_cast<int32_t>((*random)() %
                                                           static_cast<uint32_t>(left + 1));
                            band->fractions_at(column)[8 * c + z] = static_cast<uint16_t>(part);
                            left -= part;
                        }
                    }
                }
                for (int32_t z = 0; z < 8; ++z) {
                    if (8 * slab + z >= size_.z || (*random)() % 3 == 0) continue;
                    codes[z] = OPENFAB_CODE_MIXED;
                    band->mixed_row(y)[x] = static_cast<uint8_t>(band->mixed_row(y)[x] | 1 << z);
                    band->columns[static_cast<size_t>(y * band->width() + x)] = column;
                    band->any_mixed = true;
                    band->mixed_blocks[static_cast<size_t>(block)] = 1;
                }
            }
        }
    }

    Vec3i size_;
    int32_t channels_;
    std::vector<dither::RowBand> bands_;
    std::vector<std::vector<uint64_t>> present_;
};

/// Rows of slabs are those of the whole grid in one window, to the last bit.
void expect_rows_of_the_whole(const std::vector<PairSpread>& pairs, int32_t steps, bool show,
                              uint32_t seed) {
    const Vec3i size{90, 21, 19};
    constexpr int32_t kMaterials = 3;
    Grid grid(size, kMaterials, seed);
    const Bleed bleed(pairs, steps, show);
    const Vec3i reach = bleed.reach();
    const BleedKernels kernels(pairs);
    BleedWindow whole;
    whole.reset({size.x + 2 * reach.x, size.y + 2 * reach.y, size.z + 2 * reach.z},
                kernels.channels.size());
    for (int32_t z = -reach.z; z < size.z + reach.z; ++z) {
        for (int32_t y = -reach.y; y < size.y + reach.y; ++y) {
            for (int32_t x = -reach.x; x < size.x + reach.x; ++x) {
                for (size_t place = 0; place < kernels.channels.size(); ++place) {
                    whole.fractions(place)[whole.at(x + reach.x, y + reach.y, z + reach.z)] =
                        static_cast<float>(grid.amount_at(kernels.channels[place], x, y, z)) /
                        65535.0f;
                }
            }
        }
    }
    whole.run(kernels, steps, show);
    dither::RowBand out;
    int64_t changed = 0;
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t row = 0; row < 3; ++row) {
            bleed.spread(grid.near(bleed, z / 8, row), size, &out);
            for (int32_t y = 0; y < std::min(8, size.y - 8 * row); ++y) {
                for (int32_t x = 0; x < size.x; ++x) {
                    int32_t sum = 0;
                    for (int32_t c = 0; c <= kMaterials; ++c) {
                        const int32_t got = Grid::amount(out, c, x, y, z % 8);
                        sum += got;
                        const auto place =
                            std::find(kernels.channels.begin(), kernels.channels.end(), c);
                        const int32_t before = grid.amount_at(c, x, 8 * row + y, z);
                        if (place == kernels.channels.end()) {
                            ASSERT_EQ(got, before);
                            continue;
                        }
                        const float wanted = whole.fractions(
                            static_cast<size_t>(place - kernels.channels.begin()))[whole.at(
                            x + reach.x, 8 * row + y + reach.y, z + reach.z)];
                        // The largest takes what rounding leaves.
                        ASSERT_NEAR(got, wanted * 65535.0, 2.5)
                            << "seed " << seed << ": " << c << " at " << x << ", " << 8 * row + y
                            << ", " << z;
                        changed += std::abs(got - before) > 100 ? 1 : 0;
                    }
                    ASSERT_EQ(sum, 65535);
                }
            }
        }
    }
    EXPECT_GT(changed, 1000);
}

TEST(Bleed, RowsOfSlabsAreThoseOfTheWholeGrid) {
    expect_rows_of_the_whole({{1, 2, {0.9, 0.6, 0.5}}}, 2, false, 1);
    expect_rows_of_the_whole({{1, 2, {0.9, 0.6, 0}}, {1, 3, {0.4, 1.1, 0}}, {2, 3, {1, 1, 0}}}, 1,
                             false, 2);
    expect_rows_of_the_whole({{0, 1, {1, 1, 1}}, {0, 2, {1, 1, 1}}, {1, 2, {0.5, 0.5, 2}}}, 1, true,
                             3);
    expect_rows_of_the_whole({{0, 3, {0, 0, 1.2}}}, 0, true, 4);
}

TEST(Bleed, DoesNothingWhereNothingMeets) {
    const Vec3i size{24, 24, 24};
    const Bleed bleed({{1, 2, {1, 1, 1}}}, 2, false);
    Grid grid(size, 1, 5);  // has no 2
    dither::RowBand out;
    for (int32_t slab = 0; slab < 3; ++slab) {
        const NearBands near = grid.near(bleed, slab, 1);
        bleed.spread(near, size, &out);
        const dither::RowBand& own = *near.bands[near.bands.size() / 2].band;
        EXPECT_EQ(out.codes, own.codes);
        EXPECT_EQ(out.fractions, own.fractions);
    }
}

}  // namespace
}  // namespace openfab::process
