// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What inspections find in voxels of shapes whose measures are known.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "inspection/components.h"
#include "inspection/thickness.h"

namespace openfab::inspection {
namespace {

/// Sets the voxels whose centres, in mm from the middle, are inside.
Bits sample(const Vec3i& size, const Vec3d& pitch_mm,
            const std::function<bool(const Vec3d& p)>& inside) {
    Bits bits(size);
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                const Vec3d p{(x + 0.5 - size.x * 0.5) * pitch_mm.x,
                              (y + 0.5 - size.y * 0.5) * pitch_mm.y,
                              (z + 0.5 - size.z * 0.5) * pitch_mm.z};
                bits.values[bits.at(x, y, z)] = inside(p) ? 1 : 0;
            }
        }
    }
    return bits;
}

Vec3d random_direction(std::mt19937* random) {
    std::normal_distribution<double> normal;
    Vec3d v{normal(*random), normal(*random), normal(*random)};
    return v * (1 / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z));
}

double along(const Vec3d& a, const Vec3d& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

TEST(Thickness, WallsBelowTheLimitAreFoundAtAnyAngleAndNoOthers) {
    constexpr uint32_t kSeed = 7;
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<double> shift(-0.5, 0.5);
    constexpr double kLimit = 4, kFine = 1.0 / 3;
    const Vec3d pitch{kFine, kFine, kFine};
    for (int trial = 0; trial < 12; ++trial) {
        Vec3d n = random_direction(&random);
        if (trial == 0) n = {0, 0, 1};
        if (trial == 1) n = {std::sqrt(0.5), 0, std::sqrt(0.5)};
        if (trial == 2) n = {std::sqrt(1.0 / 3), std::sqrt(1.0 / 3), std::sqrt(1.0 / 3)};
        const double offset = shift(random);
        for (const double k : {1.0, 2.0, 3.0, 4.0, 5.0}) {
            const Bits bits = sample({60, 60, 60}, pitch, [&](const Vec3d& p) {
                const double d = along(p, n) - offset;
                return d >= -k / 2 && d < k / 2 && along(p, p) < 9 * 9;
            });
            const std::vector<Thin> found = find_thin(bits, 0, pitch, {kLimit, kLimit, 0.4});
            if (k >= kLimit) {
                EXPECT_TRUE(found.empty())
                    << "seed " << kSeed << ", trial " << trial << ", wall " << k << ": "
                    << found[0].thickness_mm << " of " << found[0].where.voxels;
                continue;
            }
            ASSERT_FALSE(found.empty()) << "trial " << trial << ", wall " << k;
            const auto largest = std::max_element(
                found.begin(), found.end(),
                [](const Thin& a, const Thin& b) { return a.where.voxels < b.where.voxels; });
            EXPECT_FALSE(largest->in_all_ways);
            EXPECT_NEAR(largest->thickness_mm, k, 0.3) << "trial " << trial;
            EXPECT_GT(static_cast<double>(largest->where.voxels), 900) << "trial " << trial;
        }
    }
}

TEST(Thickness, GapsAreWallsOfWhatIsNotThere) {
    const Vec3d n{0.6, 0, 0.8};
    for (const double k : {1.0, 2.0, 3.0, 5.0}) {
        const Bits bits = sample({36, 36, 36}, {1, 1, 1}, [&](const Vec3d& p) {
            const double d = along(p, n) - 0.2;
            return d >= -k / 2 && d < k / 2;
        });
        const std::vector<Thin> found = find_thin(bits, 0, {1, 1, 1}, {4, 4, 0.25});
        EXPECT_EQ(found.empty(), k > 4) << k;
    }
}

TEST(Thickness, EdgesAndCornersOfThickBodiesAreNotThin) {
    std::mt19937 random(11);
    for (int trial = 0; trial < 12; ++trial) {
        const Vec3d a = trial == 0 ? Vec3d{1, 0, 0} : random_direction(&random);
        Vec3d b = random_direction(&random);
        b = trial == 0 ? Vec3d{0, 1, 0} : b - a * along(a, b);
        b = b * (1 / std::sqrt(along(b, b)));
        const Vec3d c{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
        const Bits bits = sample({44, 44, 44}, {1, 1, 1}, [&](const Vec3d& p) {
            return std::fabs(along(p, a)) < 12 && std::fabs(along(p, b)) < 12 &&
                   std::fabs(along(p, c)) < 12;
        });
        const std::vector<Thin> found = find_thin(bits, 0, {1, 1, 1}, {6, 6, 0.25});
        EXPECT_TRUE(found.empty()) << "trial " << trial << ": " << found.size() << ", "
                                   << found[0].thickness_mm << " of " << found[0].where.voxels;
    }
}

TEST(Thickness, WiresAreThinInAllWays) {
    const Vec3d axis{0.48, 0.6, 0.64};
    for (const double diameter : {2.0, 3.0, 6.0}) {
        const Bits bits = sample({40, 40, 40}, {1, 1, 1}, [&](const Vec3d& p) {
            const Vec3d r = p - axis * along(p, axis);
            return along(r, r) < diameter * diameter / 4;
        });
        const std::vector<Thin> found = find_thin(bits, 0, {1, 1, 1}, {0, 4.5, 0.25});
        ASSERT_EQ(found.empty(), diameter > 4) << diameter;
        if (!found.empty()) {
            EXPECT_TRUE(found[0].in_all_ways);
        }
    }
}

TEST(Thickness, VoxelsNeedNotBeCubes) {
    const Vec3d pitch{0.042, 0.084, 0.027}, n{0.5, std::sqrt(0.5), 0.5};
    for (const double mm : {0.15, 0.25, 0.45}) {
        const Bits bits = sample({60, 40, 80}, pitch,
                                 [&](const Vec3d& p) { return std::fabs(along(p, n)) < mm / 2; });
        const std::vector<Thin> found = find_thin(bits, 0, pitch, {0.4, 0, 0.04});
        ASSERT_EQ(found.empty(), mm > 0.4) << mm;
        if (!found.empty()) {
            EXPECT_NEAR(found[0].thickness_mm, mm, 0.05);
        }
    }
}

TEST(Components, AreCountedByWhatTheyTouchWith) {
    Bits bits({4, 4, 4});
    for (const Vec3i& p : {Vec3i{0, 0, 0}, Vec3i{1, 1, 0}, Vec3i{3, 3, 3}, Vec3i{3, 3, 2}})
        bits.values[bits.at(p.x, p.y, p.z)] = 1;
    Box<int32_t> labels;
    EXPECT_EQ(components(bits, Touch::kFaces, &labels).size(), 3u);
    const std::vector<Cluster> found = components(bits, Touch::kCorners, &labels);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[1].voxels, 2);
    EXPECT_EQ(labels.values[labels.at(3, 3, 3)], 2);
    EXPECT_TRUE(found[0].at_border);
    EXPECT_EQ(found[1].box.lo, (Vec3i{3, 3, 2}));
}

TEST(Components, ASpiralIsOne) {
    // Its arms meet late in the order of voxels.
    const Bits bits = sample({41, 41, 3}, {1, 1, 1}, [](const Vec3d& p) {
        const double angle = std::atan2(p.y, p.x) / 6.283185307;
        const double turn = std::hypot(p.x, p.y) / 4 - angle;
        return turn - std::floor(turn) < 0.5;
    });
    Box<int32_t> labels;
    const std::vector<Cluster> found = components(bits, Touch::kFaces, &labels);
    EXPECT_LE(found.size(), 12u);
    int64_t largest = 0, all = 0;
    for (const Cluster& cluster : found)
        largest = std::max(largest, cluster.voxels), all += cluster.voxels;
    EXPECT_GT(largest * 2, all);
}

}  // namespace
}  // namespace openfab::inspection
