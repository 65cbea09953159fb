// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/mixtures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

namespace openfab::testing {
namespace {

using render::Mixtures;

TEST(Mixtures, HaveAsManyPartsAsCodesTellApart) {
    const std::vector<std::pair<int32_t, int32_t>> parts_of{{1, 1},  {2, 254}, {3, 21}, {4, 9},
                                                            {5, 6},  {6, 5},   {8, 3},  {10, 3},
                                                            {22, 2}, {23, 1},  {255, 1}};
    for (const auto& [materials, parts] : parts_of) {
        const Mixtures mixtures(materials);
        EXPECT_EQ(mixtures.parts(), parts) << materials;
        ASSERT_LE(mixtures.by_code().size(), 256u) << materials;
        EXPECT_TRUE(mixtures.by_code()[0].empty());
        std::set<std::vector<uint8_t>> seen;
        for (size_t code = 1; code < mixtures.by_code().size(); ++code) {
            const std::vector<uint8_t>& one = mixtures.by_code()[code];
            EXPECT_EQ(one.size(), static_cast<size_t>(materials));
            EXPECT_EQ(std::accumulate(one.begin(), one.end(), 0), parts);
            EXPECT_TRUE(seen.insert(one).second) << materials << " materials, code " << code;
        }
        // Whatever a cell holds has a code: the number of ways to put equal parts into materials.
        EXPECT_EQ(static_cast<double>(seen.size()),
                  std::round(std::exp(std::lgamma(parts + materials) - std::lgamma(materials) -
                                      std::lgamma(parts + 1))))
            << materials;
    }
    EXPECT_EQ(Mixtures(0).by_code().size(), 1u);
}

TEST(Mixtures, ThatHaveOnePartAreMaterials) {
    const Mixtures many(40);
    for (uint16_t m = 0; m < 40; ++m) {
        std::vector<uint16_t> counts(40, 0);
        counts[m] = 7;
        EXPECT_EQ(many.draw(counts.data(), 12345), m + 1);
    }
}

TEST(Mixtures, AreTheSharesInTheMean) {
    const std::vector<std::vector<uint16_t>> cells{{5},
                                                   {3, 1},
                                                   {0, 8},
                                                   {1, 2, 4},
                                                   {0, 0, 9},
                                                   {65535, 1, 65535, 65535},
                                                   {7, 0, 11, 0, 5, 1},
                                                   {1, 1, 1, 1, 1, 1, 1, 1},
                                                   {0, 3, 0, 0, 2, 0, 0, 64}};
    for (const std::vector<uint16_t>& counts : cells) {
        const Mixtures mixtures(static_cast<int32_t>(counts.size()));
        const double total = std::accumulate(counts.begin(), counts.end(), 0.0);
        std::vector<double> mean(counts.size(), 0);
        for (uint32_t u = 0; u < 65536; ++u) {
            const uint8_t code = mixtures.draw(counts.data(), static_cast<uint16_t>(u));
            ASSERT_GT(code, 0);
            const std::vector<uint8_t>& parts = mixtures.by_code()[code];
            for (size_t m = 0; m < counts.size(); ++m) {
                mean[m] += parts[m] / 65536.0;
                ASSERT_LT(std::abs(parts[m] - mixtures.parts() * counts[m] / total), 1.0);
            }
        }
        for (size_t m = 0; m < counts.size(); ++m)
            EXPECT_NEAR(mean[m], mixtures.parts() * counts[m] / total, 1e-4) << m;
    }
}

}  // namespace
}  // namespace openfab::testing
