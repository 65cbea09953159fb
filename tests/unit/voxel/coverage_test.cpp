// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/voxel/coverage.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "runtime/voxel/crossings.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/surface/hand_fablet.h"

namespace openfab {
namespace {

part::Grid grid(const Vec3i& size, double pitch = 1) {
    return {{0, 0, 0}, {pitch, pitch, pitch}, size};
}

Affine3d moved(double x, double y, double z) {
    Affine3d out;
    out.t = {x, y, z};
    return out;
}

/// Voxels of a part on a grid: [(z * ny + y) * nx + x].
std::vector<uint8_t> voxels(const part::Part& part, const part::Grid& grid) {
    auto surface = std::move(*surface::Surface::create(part, {}));
    const voxel::Voxeliser voxeliser(part, *surface, grid);
    std::vector<uint8_t> out(static_cast<size_t>(grid.size.x * grid.size.y * grid.size.z), 0);
    voxel::SlabMask mask;
    for (int32_t g = 0; 8 * g < grid.size.z; ++g) {
        voxeliser.coverage(g, &mask);
        EXPECT_EQ(mask.x0 % 8, 0);
        EXPECT_EQ(mask.y0 % 8, 0);
        EXPECT_EQ(mask.width % 8, 0);
        EXPECT_EQ(mask.height % 8, 0);
        EXPECT_EQ(mask.mask.size(), static_cast<size_t>(mask.width * mask.height));
        for (int32_t y = 0; y < mask.height; ++y) {
            for (int32_t x = 0; x < mask.width; ++x) {
                for (int32_t k = 0; k < 8; ++k) {
                    if (((mask.mask[static_cast<size_t>(y * mask.width + x)] >> k) & 1) == 0)
                        continue;
                    const Vec3i at{mask.x0 + x, mask.y0 + y, 8 * g + k};
                    EXPECT_TRUE(at.x < grid.size.x && at.y < grid.size.y && at.z < grid.size.z);
                    out[static_cast<size_t>((at.z * grid.size.y + at.y) * grid.size.x + at.x)] = 1;
                }
            }
        }
    }
    return out;
}

int64_t count(const std::vector<uint8_t>& v) {
    int64_t n = 0;
    for (const uint8_t x : v)
        n += x;
    return n;
}

bool at(const std::vector<uint8_t>& v, const part::Grid& g, int32_t x, int32_t y, int32_t z) {
    return v[static_cast<size_t>((z * g.size.y + y) * g.size.x + x)] != 0;
}

TEST(Coverage, SnapsToTheNearestUnitHalvesUp) {
    EXPECT_EQ(voxel::snap(0.49), 0);
    EXPECT_EQ(voxel::snap(0.5), 1);
    EXPECT_EQ(voxel::snap(-0.5), 0);
    EXPECT_EQ(voxel::snap(-0.51), -1);
    EXPECT_EQ(voxel::snap(-3.0), -3);
    EXPECT_EQ(voxel::snap(1e30), voxel::kFarthest);
    EXPECT_EQ(voxel::snap(-1e30), -voxel::kFarthest);
}

TEST(Coverage, ABoxOfWholeVoxelsHasJustThese) {
    const part::Part part = testing::make_part(testing::empty_fablet(), testing::cube(3),
                                               {.transform = moved(2, 5, 7)});
    const part::Grid g = grid({20, 20, 20});
    const auto v = voxels(part, g);
    EXPECT_EQ(count(v), 27);
    EXPECT_TRUE(at(v, g, 2, 5, 7));
    EXPECT_TRUE(at(v, g, 4, 7, 9));
    EXPECT_FALSE(at(v, g, 5, 7, 9));
}

TEST(Coverage, ACentreOnAFaceBelongsToTheSolidAboveIt) {
    // Faces at 2.5 and 5.5 pass through the centers of voxels 2 and 5.
    const part::Part part = testing::make_part(testing::empty_fablet(), testing::cube(3),
                                               {.transform = moved(2.5, 2.5, 2.5)});
    const part::Grid g = grid({10, 10, 10});
    const auto v = voxels(part, g);
    EXPECT_EQ(count(v), 27);
    EXPECT_TRUE(at(v, g, 2, 2, 2));
    EXPECT_FALSE(at(v, g, 5, 2, 2));
    EXPECT_FALSE(at(v, g, 2, 5, 2));
    EXPECT_FALSE(at(v, g, 2, 2, 5));
}

TEST(Coverage, AMirroredPartIsSolidToo) {
    Affine3d mirror = moved(8, 1, 1);
    mirror.m[0] = -1;
    const part::Part part =
        testing::make_part(testing::empty_fablet(), testing::cube(3), {.transform = mirror});
    const part::Grid g = grid({10, 10, 10});
    const auto v = voxels(part, g);
    EXPECT_EQ(count(v), 27);
    EXPECT_TRUE(at(v, g, 5, 1, 1));
    EXPECT_TRUE(at(v, g, 7, 3, 3));
}

TEST(Coverage, APartIsCutAtTheGrid) {
    const part::Part part = testing::make_part(testing::empty_fablet(), testing::cube(30),
                                               {.transform = moved(-10, -10, -10)});
    const part::Grid g = grid({13, 9, 11});
    EXPECT_EQ(count(voxels(part, g)), 13 * 9 * 11);
    const part::Part beside = testing::make_part(testing::empty_fablet(), testing::cube(3),
                                                 {.transform = moved(50, 0, 0)});
    EXPECT_EQ(count(voxels(beside, g)), 0);
}

TEST(Coverage, AnEmptyGroupHasNoMask) {
    const part::Part part = testing::make_part(testing::empty_fablet(), testing::cube(3),
                                               {.transform = moved(2, 2, 2)});
    auto surface = std::move(*surface::Surface::create(part, {}));
    const voxel::Voxeliser voxeliser(part, *surface, grid({10, 10, 40}));
    voxel::SlabMask mask;
    for (const int32_t slab : {-1, 1, 4, 5, 1000}) {
        mask.width = 8;
        voxeliser.coverage(slab, &mask);
        EXPECT_EQ(mask.width, 0) << slab;
        EXPECT_EQ(mask.height, 0) << slab;
    }
    EXPECT_EQ(voxeliser.voxel_box(), (Box3i{{2, 2, 2}, {5, 5, 5}}));
}

TEST(Coverage, EndsWhenItIsStopped) {
    const part::Part part = testing::make_part(testing::empty_fablet(), testing::cube(3),
                                               {.transform = moved(2, 5, 7)});
    auto surface = std::move(*surface::Surface::create(part, {}));
    const voxel::Voxeliser voxeliser(part, *surface, grid({16, 16, 16}));
    std::atomic<bool> stop{false};
    voxel::SlabMask mask;
    voxeliser.coverage(0, &mask, &stop);
    EXPECT_EQ(mask.width, 8);
    stop = true;
    voxeliser.coverage(0, &mask, &stop);
    EXPECT_EQ(mask.width, 0);
}

/// A surface whose patches are diced, each for a while.
class SlowSurface final : public surface::Surface {
  public:
    static constexpr double kSeconds = 0.01;  ///< a patch

    explicit SlowSurface(std::unique_ptr<surface::Surface> of)
        : of_(std::move(of)), patches_(of_->patches()) {
        for (surface::Patch& patch : patches_)
            patch.kind = surface::PatchKind::kLattice;
    }
    const std::vector<surface::Patch>& patches() const override { return patches_; }
    const surface::PatchRanges& ranges() const override { return of_->ranges(); }
    bool identity() const override { return false; }
    std::shared_ptr<const surface::MicroMesh> micro(int32_t patch) const override {
        ++diced;
        std::this_thread::sleep_for(std::chrono::duration<double>(kSeconds));
        return of_->micro(patch);
    }
    bool identity_corners(int32_t patch, std::array<Vec3f, 3>* out) const override {
        return of_->identity_corners(patch, out);
    }
    void displacement_bounds(int32_t patch,
                             std::vector<surface::GrownPolygon>* out) const override {
        of_->displacement_bounds(patch, out);
    }
    Box3d exact_box(const Affine3d& map) const override { return of_->exact_box(map); }
    surface::SurfaceCounts counts() const override { return {}; }

    mutable std::atomic<int> diced{0};

  private:
    std::unique_ptr<surface::Surface> of_;
    std::vector<surface::Patch> patches_;
};

TEST(Coverage, TheSecondsOfThreadsThatHelpCount) {
    const part::Part part = testing::make_part(testing::empty_fablet(), testing::cube(3),
                                               {.transform = moved(2, 2, 2)});
    const SlowSurface surface(std::move(*surface::Surface::create(part, {})));
    const voxel::Voxeliser voxeliser(part, surface, grid({10, 10, 8}));
    constexpr size_t kThreads = 4;  // so many wait at once, on however many cores
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, kThreads);
    tbb::task_arena arena(kThreads);
    voxel::SlabMask mask;
    double seconds = 0;
    arena.execute([&] { voxeliser.coverage(0, &mask, nullptr, &seconds); });
    EXPECT_EQ(mask.width, 8);
    EXPECT_GT(surface.diced, 4);  // more than one thread takes
    EXPECT_GE(seconds, surface.diced * SlowSurface::kSeconds);
}

TEST(Coverage, HugeTrianglesDoNotOverflow) {
    // 12000 voxels along x and 10000 along y: plane tests pass 64 bits.
    Affine3d turned = moved(6000, 100, 20);
    turned.m = {0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1};
    const part::Part part = testing::make_part(
        testing::empty_fablet(), mesh::make_box({9000, 8000, 12}), {.transform = turned});
    const part::Grid g = {{0, 3000, 16}, {1, 1, 1}, {12000, 3, 8}};
    auto surface = std::move(*surface::Surface::create(part, {}));
    const voxel::Voxeliser voxeliser(part, *surface, g);
    voxel::SlabMask mask;
    voxeliser.coverage(0, &mask);
    const auto triangles = reference::snap_triangles(part::local_to_voxel(part, g),
                                                     testing::covering_triangles(part, *surface));
    for (int32_t x = 0; x < 12000; ++x) {
        for (int32_t y = 0; y < 3; ++y) {
            for (int32_t k = 3; k < 6; ++k) {
                const bool inside =
                    x >= mask.x0 && x < mask.x0 + mask.width &&
                    ((mask.mask[static_cast<size_t>(y * mask.width + x - mask.x0)] >> k) & 1) != 0;
                ASSERT_EQ(inside, reference::winding(triangles, {x, y, k}) > 0)
                    << x << " " << y << " " << k;
            }
        }
    }
}

}  // namespace
}  // namespace openfab
