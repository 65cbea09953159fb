// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/volume.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/render_fixture.h"

namespace openfab::testing {
namespace {

using render::Volume;
using render::VolumeBuilder;
using render::VolumeGrid;

/// The voxel of a volume at a place in millimetres.
Vec3i voxel_at(const Volume& volume, const Vec3d& mm) {
    Vec3i out;
    for (int a = 0; a < 3; ++a)
        out[a] = static_cast<int32_t>(
            std::floor((mm[a] - volume.origin_mm()[a]) / volume.pitch_mm()[a]));
    return out;
}

TEST(Volume, HasTheCodesOfThePrint) {
    const Vec3i size{19, 23, 21};
    const Vec3d pitch{0.05, 0.08, 0.03};
    const auto code = [](int32_t x, int32_t y, int32_t z) {
        return static_cast<uint8_t>(1 + (x * 31 + y * 17 + z * 7) % 5);
    };
    const Volume volume = make_volume(size, pitch, code);
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                const Vec3i at = voxel_at(
                    volume, {(x + 0.5) * pitch.x, (y + 0.5) * pitch.y, (z + 0.5) * pitch.z});
                ASSERT_EQ(volume.code(at.x, at.y, at.z), code(x, y, z));
            }
        }
    }
    for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(volume.solid_mm().lo[a], 0, 1e-12);
        EXPECT_NEAR(volume.solid_mm().hi[a], size[a] * pitch[a], 1e-12);
    }
}

TEST(Volume, HasItsSurfaceAtTheFaces) {
    const Volume volume = make_volume({40, 40, 40}, {0.05, 0.08, 0.03},
                                      [](int32_t, int32_t, int32_t) { return uint8_t{1}; });
    const Vec3i middle = voxel_at(volume, {1, 1.6, 0.6});
    EXPECT_EQ(volume.coverage(middle.x, middle.y, middle.z), Volume::kFull);
    for (int a = 0; a < 3; ++a) {
        // The two centers beside a face are equally far from one half.
        Vec3d mm{1, 1.6, 0.6};
        mm[a] = 0.5 * volume.pitch_mm()[a];
        Vec3i in = voxel_at(volume, mm);
        Vec3i out = in;
        --out[a];
        EXPECT_NEAR(volume.coverage(in.x, in.y, in.z) + volume.coverage(out.x, out.y, out.z),
                    Volume::kFull, 20)
            << a;
        EXPECT_GT(volume.coverage(in.x, in.y, in.z), Volume::kSurface);
        // Nobody asks for the code there, but at edges: it is the neighbour's.
        EXPECT_EQ(volume.code(out.x, out.y, out.z), 1);
    }
    EXPECT_EQ(volume.blocks().x % Volume::kGroup, 0);
}

TEST(Volume, KeepsMixturesInLargerCells) {
    // Three of four voxels are 1, the others 2; the last column of cells is cut by the border.
    const auto code = [](int32_t x, int32_t y, int32_t z) {
        return static_cast<uint8_t>((x + y + z) % 4 == 0 ? 2 : 1);
    };
    const Vec3i cell{4, 2, 3};
    const Volume volume = make_volume({162, 80, 120}, {0.02, 0.04, 0.03}, code, cell);
    EXPECT_NEAR(volume.pitch_mm().x, 0.08, 1e-12);
    const render::Mixtures mixtures(5);  // as many as the fixture has
    ASSERT_EQ(mixtures.parts(), 6);
    int32_t ones = 0;
    int32_t all = 0;
    for (int32_t z = 0; z < 40; ++z) {
        for (int32_t y = 0; y < 40; ++y) {
            for (int32_t x = 0; x < 40; ++x) {
                const Vec3i at =
                    voxel_at(volume, {(x + 0.5) * 0.08, (y + 0.5) * 0.08, (z + 0.5) * 0.09});
                const std::vector<uint8_t>& parts =
                    mixtures.by_code()[volume.code(at.x, at.y, at.z)];
                ASSERT_EQ(parts[0] + parts[1], mixtures.parts());
                // 18 of 24 voxels: four and a half of six parts.
                ASSERT_TRUE(parts[0] == 4 || parts[0] == 5);
                ones += parts[0];
                all += mixtures.parts();
            }
        }
    }
    // 64,000 draws: a standard deviation is 0.0003.
    EXPECT_NEAR(static_cast<double>(ones) / all, 0.75, 0.0015);
}

TEST(Volume, LeavesOutSlicesThatAreNotThere) {
    VolumeBuilder builder({{16, 16, 40}, {0.1, 0.1, 0.1}, {0, 0, 0}, {1, 1, 1}, {3}}, 100'000'000,
                          0);
    const std::vector<uint8_t> slice(256, 3);
    for (int32_t z = 10; z < 30; ++z)
        ASSERT_TRUE(builder.add(z, slice.data()));
    Volume volume;
    ASSERT_TRUE(builder.finish(&volume));
    EXPECT_NEAR(volume.solid_mm().lo.z, 1, 1e-12);
    EXPECT_NEAR(volume.solid_mm().hi.z, 3, 1e-12);
    const Vec3i low = voxel_at(volume, {0.8, 0.8, 0.3});
    EXPECT_EQ(volume.coverage(low.x, low.y, low.z), 0);
}

TEST(Volume, SaysWhereMemoryDoesNotSuffice) {
    const VolumeGrid grid{{200, 200, 200}, {0.1, 0.1, 0.1}, {0, 0, 0}, {1, 1, 1}, {1, 2}};
    const auto fits = [&](int64_t bytes) {
        VolumeBuilder builder(grid, bytes, 0);
        std::vector<uint8_t> slice(40000);
        for (size_t i = 0; i < slice.size(); ++i)
            slice[i] = static_cast<uint8_t>(1 + i % 2);
        for (int32_t z = 0; z < 200; ++z) {
            if (!builder.add(z, slice.data())) return false;
        }
        Volume volume;
        if (!builder.finish(&volume)) return false;
        EXPECT_LT(volume.bytes(), bytes);
        return true;
    };
    EXPECT_FALSE(fits(VolumeBuilder::least_bytes(grid) + 1'000'000));
    EXPECT_TRUE(fits(60'000'000));
}

}  // namespace
}  // namespace openfab::testing
