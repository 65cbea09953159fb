// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Boundary meshes against a list of all faces, for voxels of every kind.

#include "backends/boundary/mesher.h"

#include <gmock/gmock.h>

#include <functional>
#include <random>

#include "tests/support/boundary/voxel_meshes.h"

namespace openfab::testing {
namespace {

#ifdef OPENFAB_SANITIZED
constexpr int kRounds = 40;
#else
constexpr int kRounds = 400;
#endif

using Random = std::mt19937;

int32_t below(Random* random, int32_t end) {
    return static_cast<int32_t>((*random)() % static_cast<uint32_t>(end));
}

VoxelBlock filled(Vec3i size, const std::function<uint8_t(Vec3i)>& code) {
    VoxelBlock block(size);
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x)
                block.at({x, y, z}) = code({x, y, z});
        }
    }
    return block;
}

int64_t triangles(const CollectedMeshes& meshes) {
    int64_t count = 0;
    for (const auto& [code, mesh] : meshes)
        count += static_cast<int64_t>(mesh.triangles.size());
    return count;
}

std::string trouble(const VoxelBlock& block, Crossings crossings = Crossings::kLookedFor) {
    const std::string wrong = check_meshes(block, mesh_block(block));
    if (!wrong.empty()) return wrong;
    const std::string painted = check_painted(block, mesh_block_together(block));
    if (!painted.empty()) return "as a solid: " + painted;
    return check_meshes_by_position(block, mesh_block_by_position(block), crossings);
}

void expect_fine(const VoxelBlock& block) {
    EXPECT_EQ(trouble(block), "");
}

TEST(BoundaryMesher, OneVoxelIsACube) {
    VoxelBlock block({1, 1, 1});
    block.at({0, 0, 0}) = 1;
    const CollectedMeshes meshes = mesh_block(block);
    EXPECT_EQ(check_meshes(block, meshes), "");
    EXPECT_EQ(meshes.at(1).points.size(), 8u);
    EXPECT_EQ(meshes.at(1).triangles.size(), 12u);
}

TEST(BoundaryMesher, ABoxHasFlatFaces) {
    const VoxelBlock block = filled({70, 40, 3}, [](Vec3i) { return 1; });
    const CollectedMeshes meshes = mesh_block(block);
    EXPECT_EQ(check_meshes(block, meshes), "");
    // Two at the bottom and at the top, and eight around each slice.
    EXPECT_EQ(meshes.at(1).triangles.size(), 4u + 3 * 8);
}

TEST(BoundaryMesher, AllBlocksOfTwoVoxels) {
    for (uint32_t mask = 1; mask < 256; ++mask) {
        const VoxelBlock block = filled({2, 2, 2}, [&](Vec3i v) {
            return static_cast<uint8_t>(mask >> (v.x + 2 * v.y + 4 * v.z) & 1);
        });
        ASSERT_EQ(trouble(block), "") << mask;
    }
}

/// Two materials and void in every arrangement around a point.
TEST(BoundaryMesher, AllBlocksOfTwoMaterials) {
    for (uint32_t pick = 1; pick < 6561; pick += kRounds == 400 ? 1 : 17) {
        uint32_t rest = pick;
        const VoxelBlock block = filled({2, 2, 2}, [&](Vec3i) {
            const auto code = static_cast<uint8_t>(rest % 3);
            rest /= 3;
            return code;
        });
        ASSERT_EQ(trouble(block), "") << pick;
    }
}

TEST(BoundaryMesher, Checkerboards) {
    for (uint8_t other : {0, 2}) {
        expect_fine(filled({9, 7, 6}, [&](Vec3i v) {
            return static_cast<uint8_t>((v.x + v.y + v.z) % 2 != 0 ? 1 : other);
        }));
        // Columns along each axis.
        for (int axis = 0; axis < 3; ++axis) {
            expect_fine(filled({6, 6, 6}, [&](Vec3i v) {
                return static_cast<uint8_t>((v.x + v.y + v.z - v[axis]) % 2 != 0 ? 1 : other);
            }));
        }
    }
}

/// Two voxels that touch along an edge, between plates that join them: both ends of the edge have
/// one fan for both sheets.
TEST(BoundaryMesher, AnEdgeBetweenPlates) {
    for (int axis = 0; axis < 3; ++axis) {
        for (int32_t length = 1; length < 4; ++length) {
            Vec3i size{2, 2, 2};
            size[axis] = length + 2;
            const VoxelBlock block = filled(size, [&](Vec3i v) {
                const bool plate = v[axis] == 0 || v[axis] == length + 1;
                const int32_t rest = v.x + v.y + v.z - v[axis];
                return static_cast<uint8_t>(plate || rest % 2 == 0 ? 1 : 0);
            });
            expect_fine(block);
        }
    }
}

TEST(BoundaryMesher, RandomVoxels) {
    Random random(1);
    for (int round = 0; round < kRounds; ++round) {
        const Vec3i size{1 + below(&random, 12), 1 + below(&random, 12), 1 + below(&random, 12)};
        const int32_t materials = 1 + below(&random, 5), void_of_ten = below(&random, 10);
        const VoxelBlock block = filled(size, [&](Vec3i) {
            return static_cast<uint8_t>(
                below(&random, 10) < void_of_ten ? 0 : 1 + below(&random, materials));
        });
        const auto crossings = round % 8 == 0 ? Crossings::kLookedFor : Crossings::kNotLookedFor;
        ASSERT_EQ(trouble(block, crossings), "") << round;
    }
}

/// Overlapping boxes: flat faces, with corners of one in the sides of another.
TEST(BoundaryMesher, RandomBoxes) {
    Random random(2);
    for (int round = 0; round < kRounds / 4; ++round) {
        const Vec3i size{1 + below(&random, 140), 1 + below(&random, 30), 1 + below(&random, 12)};
        VoxelBlock block(size);
        for (int32_t box = below(&random, 9); box >= 0; --box) {
            Vec3i lo, hi;
            for (int a = 0; a < 3; ++a) {
                lo[a] = below(&random, size[a]);
                hi[a] = lo[a] + 1 + below(&random, size[a] - lo[a]);
            }
            const auto code = static_cast<uint8_t>(below(&random, 4));
            for (int32_t z = lo.z; z < hi.z; ++z) {
                for (int32_t y = lo.y; y < hi.y; ++y) {
                    for (int32_t x = lo.x; x < hi.x; ++x)
                        block.at({x, y, z}) = code;
                }
            }
        }
        ASSERT_EQ(trouble(block), "") << round;
    }
}

/// More than a word of points in a row, and more than 127 materials.
TEST(BoundaryMesher, WideRowsAndManyMaterials) {
    Random random(3);
    expect_fine(
        filled({200, 3, 3}, [&](Vec3i) { return static_cast<uint8_t>(below(&random, 3)); }));
    expect_fine(
        filled({66, 5, 4}, [&](Vec3i) { return static_cast<uint8_t>(below(&random, 256)); }));
}

/// Two plates of voxels, one above the other, that differ in a few voxels: rectangles of any length
/// with sheets that touch at some of their points.
TEST(BoundaryMesher, LongRectanglesWithFewContacts) {
    Random random(4);
    int64_t rims = 0;
    for (int round = 0; round < kRounds / 20; ++round) {
        Vec3i size{3, 3, 3};
        size[round % 3] = 400;
        if (round % 2 == 0) size[(round + 1) % 3] = 9;
        VoxelBlock block(size);
        const int32_t half = size[(round + 2) % 3] / 2;
        for (int32_t z = 0; z < size.z; ++z) {
            for (int32_t y = 0; y < size.y; ++y) {
                for (int32_t x = 0; x < size.x; ++x) {
                    const Vec3i v{x, y, z};
                    const bool odd = below(&random, 200) == 0;
                    block.at(v) = static_cast<uint8_t>((v[(round + 2) % 3] >= half) != odd ? 1 : 2);
                    if (below(&random, 400) == 0) block.at(v) = 0;
                }
            }
        }
        ASSERT_EQ(trouble(block), "") << round;
        rims += triangles(mesh_block_by_position(block)) - triangles(mesh_block(block));
    }
    EXPECT_GT(rims, 0);
}

/// A bar with a contact just before its end: a triangle from the other end to it is so thin that a
/// step of one corner would flip it.
TEST(BoundaryMesher, AStepTurnsNoTriangleOver) {
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            Vec3i size{2, 2, 2};
            size[axis] = 1500;
            VoxelBlock block(size);
            Vec3i v;
            for (v[axis] = 0; v[axis] < 1500; ++v[axis])
                block.at(v) = 1;
            Vec3i touching{1, 1, 1};
            touching[axis] = side == 0 ? 1498 : 1;
            block.at(touching) = 1;
            EXPECT_EQ(trouble(block), "") << axis << side;
        }
    }
}

/// Around a single contact only its vertices are not at voxel corners.
TEST(BoundaryMesher, OnlyVerticesThatCoincideMove) {
    VoxelBlock block({9, 9, 3});
    for (int32_t z = 0; z < 3; ++z) {
        for (int32_t i = 0; i < 16; ++i) {
            block.at({i % 4, i / 4, z}) = 1;
            block.at({4 + i % 4, 4 + i / 4, z}) = 1;
        }
    }
    const CollectedMeshes meshes = mesh_block_by_position(block);
    EXPECT_EQ(check_meshes_by_position(block, meshes), "");
    int moved = 0;
    for (const Vec3i& p : meshes.at(1).points) {
        if (p.x % boundary::kSteps == 0 && p.y % boundary::kSteps == 0) continue;
        EXPECT_EQ(std::abs(p.x - 4 * boundary::kSteps), 1);
        EXPECT_EQ(std::abs(p.y - 4 * boundary::kSteps), 1);
        EXPECT_EQ(p.x > 4 * boundary::kSteps, p.y > 4 * boundary::kSteps) << "into its own voxels";
        const bool end = p.z < 2 || p.z > 3 * boundary::kSteps - 2;  // the sheets' own ends
        EXPECT_EQ(p.z % boundary::kSteps, end ? (p.z < 2 ? 1 : boundary::kSteps - 1) : 0);
        ++moved;
    }
    EXPECT_EQ(moved, 8) << "of both sheets, at four heights";
}

/// Flat faces are not cut into voxels: a ball of 60 voxels across has fewer triangles than faces.
TEST(BoundaryMesher, ABallHasFewTriangles) {
    const VoxelBlock block = filled({60, 60, 60}, [](Vec3i v) {
        const Vec3i c{2 * v.x - 59, 2 * v.y - 59, 2 * v.z - 59};
        return static_cast<uint8_t>(dot(c, c) <= 59 * 59 ? 1 : 0);
    });
    const CollectedMeshes meshes = mesh_block(block);
    EXPECT_EQ(check_meshes(block, meshes), "");
    EXPECT_LT(triangles(meshes), 22'000);
    std::printf("%d triangles\n", static_cast<int>(triangles(meshes)));
}

/// The same triangles as with numbers for each material.
TEST(BoundaryMesher, NumbersOfAllTogetherAreTheSameMeshes) {
    Random random(5);
    const VoxelBlock block =
        filled({20, 15, 10}, [&](Vec3i) { return static_cast<uint8_t>(below(&random, 4)); });
    const PaintedMesh painted = mesh_block_together(block);
    EXPECT_EQ(check_painted(block, painted), "");
    size_t points = 0, triangles = 0;
    for (const auto& [code, mesh] : mesh_block(block)) {
        points += mesh.points.size();
        triangles += mesh.triangles.size();
    }
    EXPECT_EQ(painted.mesh.points.size(), points);
    EXPECT_EQ(painted.mesh.triangles.size(), triangles);
}

TEST(BoundaryCheck, FindsDamageOfMeshesTogether) {
    const VoxelBlock block =
        filled({3, 3, 3}, [](Vec3i v) { return static_cast<uint8_t>(v.x == 1 ? 2 : 1); });
    const PaintedMesh fine = mesh_block_together(block);
    ASSERT_EQ(check_painted(block, fine), "");
    PaintedMesh repainted = fine;
    repainted.codes[3] = static_cast<uint8_t>(3 - repainted.codes[3]);
    EXPECT_NE(check_painted(block, repainted), "");
    PaintedMesh open = fine;
    open.mesh.triangles.pop_back();
    open.codes.pop_back();
    EXPECT_NE(check_painted(block, open), "");
}

/// The checker itself reports each kind of damage.
TEST(BoundaryCheck, FindsDamage) {
    const VoxelBlock block =
        filled({3, 3, 3}, [](Vec3i v) { return static_cast<uint8_t>(v.x == 1 ? 2 : 1); });
    const CollectedMeshes fine = mesh_block(block);
    ASSERT_EQ(check_meshes(block, fine), "");
    CollectedMeshes open = fine;
    open[1].triangles.pop_back();
    EXPECT_NE(check_meshes(block, open), "");
    CollectedMeshes turned = fine;
    for (auto& t : turned[1].triangles)
        std::swap(t[0], t[1]);
    EXPECT_NE(check_meshes(block, turned), "");
    CollectedMeshes moved = fine;
    moved[2].points[0].x += 1;
    EXPECT_NE(check_meshes(block, moved), "");
    CollectedMeshes missing = fine;
    missing.erase(2);
    EXPECT_NE(check_meshes(block, missing), "");
    // Two cubes that share their vertices where they touch.
    VoxelBlock two({2, 2, 1});
    two.at({0, 0, 0}) = two.at({1, 1, 0}) = 1;
    CollectedMeshes joined = mesh_block(two);
    ASSERT_EQ(check_meshes(two, joined), "");
    std::vector<Vec3i>& points = joined[1].points;
    for (auto& t : joined[1].triangles) {
        for (uint32_t& v : t)
            v = static_cast<uint32_t>(std::find(points.begin(), points.end(), points[v]) -
                                      points.begin());
    }
    EXPECT_NE(check_manifold(joined[1]), "");
    // By position they are one, unless they are separated.
    CollectedMeshes parted = mesh_block_by_position(two);
    ASSERT_EQ(check_meshes_by_position(two, parted), "");
    for (Vec3i& p : parted[1].points) {
        for (int a = 0; a < 3; ++a)
            p[a] += p[a] % boundary::kSteps == 1 ? -3 : 0;
    }
    EXPECT_THAT(check_crossings(parted[1]), ::testing::HasSubstr("cross"));
}

}  // namespace
}  // namespace openfab::testing
