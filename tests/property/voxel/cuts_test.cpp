// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Assemblies of pieces that were cut from one mesh: no voxel is in two pieces, and together they
// have exactly the voxels of the mesh that was cut, if it has the vertices that the cut made on its
// edges. Compared with the mesh without these vertices, only voxels next to such an edge differ: a
// vertex that is rounded to float and snapped to 1/256 voxel is not on the edge any more.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "mesh/model/primitives.h"
#include "runtime/voxel/coverage.h"
#include "tests/support/mesh_surface.h"
#include "tests/support/meshes/cut.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/places/places.h"
#include "tests/support/reference/closest_point.h"

namespace openfab {
namespace {

using testing::CutPiece;
using testing::CutPlane;

constexpr int kRounds =
#ifdef OPENFAB_SANITIZED
    3;
#else
    25;
#endif

/// The placement of the assembly, and its grid.
struct Stage {
    Affine3d transform;
    part::Grid grid;

    /// A rotated, translated assembly of about `voxels` voxels along the longest side.
    Stage(const mesh::Mesh& mesh, std::mt19937* random, int32_t voxels, bool turned) {
        const auto number = [&] { return static_cast<double>((*random)() % 100001) / 100000; };
        if (turned) {
            Vec3d axis{number() - 0.5, number() - 0.5, number() + 0.1};
            axis = axis * (1 / length(axis));
            const double a = 6 * number(), c = std::cos(a), s = std::sin(a), d = 1 - c;
            transform.m = {c + axis.x * axis.x * d,          axis.x * axis.y * d - axis.z * s,
                           axis.x * axis.z * d + axis.y * s, axis.y * axis.x * d + axis.z * s,
                           c + axis.y * axis.y * d,          axis.y * axis.z * d - axis.x * s,
                           axis.z * axis.x * d - axis.y * s, axis.z * axis.y * d + axis.x * s,
                           c + axis.z * axis.z * d};
            transform.t = {100 * number(), -70 * number(), 30 * number()};
        }
        Box3d box;
        for (const Vec3d& p : mesh.positions)
            box.add(transform.apply(p));
        const Vec3d size = box.size();
        const double pitch = std::max({size.x, size.y, size.z}) / voxels;
        grid.pitch_mm = {pitch, 1.5 * pitch, 0.8 * pitch};
        for (int a = 0; a < 3; ++a) {
            grid.origin_mm[a] = std::floor(box.lo[a] / grid.pitch_mm[a] - 1) * grid.pitch_mm[a];
            grid.size[a] = static_cast<int32_t>(
                               std::ceil((box.hi[a] - grid.origin_mm[a]) / grid.pitch_mm[a])) +
                           2;
        }
    }
};

/// Returns 1 for each voxel that the mesh's part covers.
std::vector<uint8_t> voxels(const mesh::Mesh& mesh, const Stage& stage) {
    const Vec3i size = stage.grid.size;
    std::vector<uint8_t> out(static_cast<size_t>(size.x) * static_cast<size_t>(size.y) *
                             static_cast<size_t>(size.z));
    if (mesh.triangles.empty()) return out;
    testing::PartOptions options;
    options.transform = stage.transform;
    const part::Part part = testing::make_part(testing::empty_fablet(), mesh, options);
    const auto surface = std::move(*surface::Surface::create(part, {}));
    const voxel::Voxeliser voxeliser(part, *surface, stage.grid);
    voxel::SlabMask mask;
    for (int32_t g = 0; 8 * g < size.z; ++g) {
        voxeliser.coverage(g, &mask);
        for (int32_t y = 0; y < mask.height; ++y) {
            for (int32_t x = 0; x < mask.width; ++x) {
                const uint8_t bits = mask.mask[static_cast<size_t>(y * mask.width + x)];
                for (int32_t k = 0; k < 8 && bits != 0; ++k) {
                    if ((bits >> k & 1) == 0) continue;
                    const auto z = static_cast<size_t>(8 * g + k);
                    out[(z * static_cast<size_t>(size.y) + static_cast<size_t>(mask.y0 + y)) *
                            static_cast<size_t>(size.x) +
                        static_cast<size_t>(mask.x0 + x)] = 1;
                }
            }
        }
    }
    return out;
}

struct Compared {
    int64_t solid = 0;
    int64_t twice = 0;        ///< voxels of two pieces or more
    int64_t gaps = 0;         ///< of no piece, but of the mesh with the cut's vertices
    int64_t extra = 0;        ///< of a piece, but not of that mesh
    int64_t moved = 0;        ///< that differ from the mesh without the cut's vertices
    std::vector<size_t> odd;  ///< the voxels of all of these
};

/// `all_cut`: every cut passes through all pieces that it meets, so that their outsides match.
/// Otherwise there is no mesh with all vertices, and the one without is used instead.
Compared compare(const mesh::Mesh& mesh, const std::vector<CutPiece>& pieces, const Stage& stage,
                 bool all_cut = true) {
    CutPiece refined;
    std::vector<uint8_t> owners = voxels({}, stage);
    for (const CutPiece& piece : pieces) {
        refined.outer.insert(refined.outer.end(), piece.outer.begin(), piece.outer.end());
        const std::vector<uint8_t> own = voxels(piece.mesh(), stage);
        for (size_t v = 0; v < own.size(); ++v)
            owners[v] = static_cast<uint8_t>(owners[v] + own[v]);
    }
    const std::vector<uint8_t> without = voxels(testing::whole(mesh).mesh(), stage);
    const std::vector<uint8_t> with = all_cut ? voxels(refined.mesh(), stage) : without;
    Compared out;
    for (size_t v = 0; v < owners.size(); ++v) {
        out.solid += with[v];
        out.twice += owners[v] > 1 ? 1 : 0;
        out.gaps += owners[v] == 0 && with[v] != 0 ? 1 : 0;
        out.extra += owners[v] != 0 && with[v] == 0 ? 1 : 0;
        const bool moved = (owners[v] != 0) != (without[v] != 0);
        out.moved += moved ? 1 : 0;
        if (moved || owners[v] > 1 || (owners[v] != 0) != (with[v] != 0)) out.odd.push_back(v);
    }
    return out;
}

/// Returns the largest distance of these voxels' centers from the surfaces of all pieces, in 1/256
/// voxel. Snapping moves a surface by at most 0.87, and is the only permitted cause.
double farthest(const std::vector<size_t>& voxels, const std::vector<CutPiece>& pieces,
                const Stage& stage) {
    const auto units = [&](const Vec3d& p) {
        Vec3d q = stage.transform.apply(p) - stage.grid.origin_mm;
        for (int a = 0; a < 3; ++a)
            q[a] *= 256 / stage.grid.pitch_mm[a];
        return q;
    };
    const auto width = static_cast<size_t>(stage.grid.size.x),
               height = static_cast<size_t>(stage.grid.size.y);
    double most = 0;
    for (const size_t v : voxels) {
        const Vec3d center{256 * (static_cast<double>(v % width) + 0.5),
                           256 * (static_cast<double>(v / width % height) + 0.5),
                           256 * (static_cast<double>(v / (width * height)) + 0.5)};
        double least = std::numeric_limits<double>::infinity();
        for (const CutPiece& piece : pieces) {
            for (const auto* triangles : {&piece.outer, &piece.caps}) {
                for (const testing::CutTriangle& t : *triangles) {
                    const Vec3d q =
                        reference::closest_point(center, units(t[0]), units(t[1]), units(t[2]));
                    least = std::min(least, length(q - center));
                }
            }
        }
        most = std::max(most, least);
    }
    return most;
}

std::vector<CutPiece> cut_all(const std::vector<CutPiece>& pieces, const CutPlane& plane) {
    std::vector<CutPiece> out;
    for (const CutPiece& piece : pieces) {
        for (CutPiece& half : testing::cut(piece, plane)) {
            if (!half.empty()) out.push_back(std::move(half));
        }
    }
    return out;
}

CutPlane random_plane(const mesh::Mesh& mesh, std::mt19937* random) {
    const auto number = [&] { return static_cast<double>((*random)() % 10001) / 10000; };
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    CutPlane plane{{number() - 0.5, number() - 0.5, number() - 0.5}};
    Vec3d through;
    for (int a = 0; a < 3; ++a) {
        // In any direction of a box that may be far from a cube.
        plane.normal[a] /= box.size()[a];
        through[a] = box.lo[a] + (0.3 + 0.4 * number()) * box.size()[a];
    }
    plane.offset = dot(plane.normal, through);
    return plane;
}

/// Long ones, whose coordinates use most bits of a float.
std::vector<mesh::Mesh> convex_meshes() {
    std::vector<mesh::Mesh> out{mesh::make_box({300, 11, 9}), testing::sphere(20, 24, 15),
                                mesh::make_cylinder(14, 90)};
    mesh::Mesh egg = testing::sphere(10, 17, 11);
    for (Vec3d& p : egg.positions)
        p = {13.37 * p.x + 0.1 * p.y, p.y + 0.02 * p.x, 0.7 * p.z};
    out.push_back(egg);
    return out;
}

void expect_exact(const mesh::Mesh& mesh, const std::vector<CutPiece>& pieces, const Stage& stage,
                  const std::string& what, int64_t* solid, int64_t* moved) {
    const Compared c = compare(mesh, pieces, stage);
    EXPECT_EQ(c.twice, 0) << what;
    EXPECT_EQ(c.gaps, 0) << what;
    EXPECT_EQ(c.extra, 0) << what;
    EXPECT_GT(c.solid, 100) << what;
    EXPECT_LT(farthest(c.odd, pieces, stage), 1) << what;
    *solid += c.solid;
    *moved += c.moved;
}

TEST(Cuts, InAnyDirectionLeaveTheVoxelsOfTheUncutPart) {
    int64_t solid = 0, moved = 0;
    const std::vector<mesh::Mesh> meshes = convex_meshes();
    for (uint32_t seed = 1; seed <= kRounds; ++seed) {
        std::mt19937 random(seed);
        for (const mesh::Mesh& mesh : meshes) {
            // 3000 voxels along the box and 50 across: far from its center floats are coarse.
            const bool bar = &mesh == &meshes[0] && seed % 2 == 0;
            const Stage stage(mesh, &random, bar ? 3000 : 60, seed % 4 != 0 && !bar);
            const CutPlane plane = random_plane(mesh, &random);
            expect_exact(mesh, cut_all({testing::whole(mesh)}, plane), stage,
                         "seed " + std::to_string(seed), &solid, &moved);
        }
    }
    printf("%ld voxels, %ld of them otherwise without the vertices of the cut\n",
           static_cast<long>(solid), static_cast<long>(moved));
    EXPECT_LT(moved, solid / 10'000);
}

// Three metres long: relative to the center of each half, an ulp of a float would exceed 1/256
// voxel.
TEST(Cuts, FarFromTheMiddleLeaveTheVoxelsOfTheUncutPart) {
    mesh::Mesh mesh = testing::sphere(1, 24, 16);
    for (Vec3d& p : mesh.positions)
        p = {1500 * p.x, 3 * p.y, 2 * p.z};
    int64_t solid = 0, moved = 0;
    for (uint32_t seed = 1; seed <= 2 * kRounds; ++seed) {
        std::mt19937 random(seed);
        const auto number = [&] { return static_cast<double>(random() % 10001) / 10000 - 0.5; };
        CutPlane plane{{1, number(), number()}};
        plane.offset = 2400 * number();
        Stage stage(mesh, &random, 60, false);
        stage.grid.pitch_mm = {0.25, 0.08, 0.06};
        stage.grid.origin_mm = {std::floor(plane.offset - 5), -3.2, -2.1};
        stage.grid.size = {40, 80, 70};
        expect_exact(mesh, cut_all({testing::whole(mesh)}, plane), stage,
                     "seed " + std::to_string(seed), &solid, &moved);
    }
}

TEST(Cuts, IntoManyPiecesLeaveTheVoxelsOfTheUncutPart) {
    int64_t solid = 0, moved = 0;
    for (uint32_t seed = 1; seed <= kRounds; ++seed) {
        std::mt19937 random(seed);
        for (const mesh::Mesh& mesh : convex_meshes()) {
            const Stage stage(mesh, &random, 50, seed % 3 != 0);
            std::vector<CutPiece> pieces{testing::whole(mesh)};
            for (int k = 0; k < 3; ++k)
                pieces = cut_all(std::move(pieces), random_plane(mesh, &random));
            EXPECT_GT(pieces.size(), 3u);
            expect_exact(mesh, pieces, stage, "seed " + std::to_string(seed), &solid, &moved);
        }
    }
    EXPECT_LT(moved, solid / 5'000);
}

/// Planes through one point of the mesh, or through one line.
std::vector<CutPlane> planes_through_one(const mesh::Mesh& mesh, size_t count, bool line,
                                         std::mt19937* random) {
    const auto number = [&] { return static_cast<double>((*random)() % 10001) / 10000 - 0.5; };
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    Vec3d point = box.center();
    for (int a = 0; a < 3; ++a)
        point[a] += 0.4 * number() * box.size()[a];
    const Vec3d axis{number(), number(), number()};
    std::vector<CutPlane> out;
    while (out.size() < count) {
        Vec3d n{number(), number(), number()};
        if (line) n = cross(n, axis);
        for (int a = 0; a < 3 && !line; ++a)
            n[a] /= box.size()[a];
        out.push_back({n, dot(n, point)});
    }
    return out;
}

// Whichever piece owns them, no voxel is lost or added, however many pieces meet there.
TEST(Cuts, ThatMeetAtALineOrAtAPointLeaveTheVoxelsOfTheUncutPart) {
    int64_t solid = 0, moved = 0;
    for (uint32_t seed = 1; seed <= kRounds; ++seed) {
        std::mt19937 random(seed);
        for (const mesh::Mesh& mesh : convex_meshes()) {
            const Stage stage(mesh, &random, 50, seed % 3 != 0);
            for (const bool line : {true, false}) {
                std::vector<CutPiece> pieces{testing::whole(mesh)};
                for (const CutPlane& plane : planes_through_one(mesh, 3, line, &random))
                    pieces = cut_all(std::move(pieces), plane);
                EXPECT_GE(pieces.size(), line ? 5u : 7u) << "seed " << seed;
                expect_exact(mesh, pieces, stage, "seed " + std::to_string(seed), &solid, &moved);
            }
        }
    }
    EXPECT_LT(moved, solid / 5'000);
}

// The second cut passes through one half only, so the other half's side of the first cut lacks its
// vertices: at such T-junctions a voxel may be lost or doubled, if its center is within 1/256 voxel
// of the cut.
TEST(Cuts, OfOneHalfOnlyStayNextToTheCut) {
    Compared sum;
    for (uint32_t seed = 1; seed <= 2 * kRounds; ++seed) {
        std::mt19937 random(seed);
        for (const mesh::Mesh& mesh : convex_meshes()) {
            const Stage stage(mesh, &random, 50, seed % 3 != 0);
            std::vector<CutPiece> halves =
                cut_all({testing::whole(mesh)}, random_plane(mesh, &random));
            std::vector<CutPiece> pieces = cut_all({halves[0]}, random_plane(mesh, &random));
            if (pieces.size() < 2) continue;
            pieces.push_back(halves[1]);
            const Compared c = compare(mesh, pieces, stage, false);
            EXPECT_LT(farthest(c.odd, pieces, stage), 1) << "seed " << seed;
            sum.solid += c.solid, sum.twice += c.twice, sum.gaps += c.gaps, sum.extra += c.extra;
            sum.odd.insert(sum.odd.end(), c.odd.begin(), c.odd.end());
        }
    }
    printf("%ld voxels, %ld lost, %ld of two pieces, %ld beside\n", static_cast<long>(sum.solid),
           static_cast<long>(sum.gaps), static_cast<long>(sum.twice), static_cast<long>(sum.extra));
    EXPECT_LT(sum.gaps + sum.extra, sum.solid / 20'000);
    EXPECT_GT(sum.odd.size(), 0u) << "nothing shows that these are the cuts that are meant";
}

// Nothing moves where the cut edges run along an axis: the new vertices are exactly on them.
TEST(Cuts, OfAnUprightBoxLeaveItsVoxels) {
    for (uint32_t seed = 1; seed <= kRounds; ++seed) {
        std::mt19937 random(seed);
        const mesh::Mesh mesh = mesh::make_box({61.7, 23.3, 9.1});
        const Stage stage(mesh, &random, 150, false);
        // The diagonals of its faces are edges, too; these are inside flat faces.
        const std::vector<CutPiece> pieces =
            cut_all(cut_all({testing::whole(mesh)}, random_plane(mesh, &random)),
                    random_plane(mesh, &random));
        const Compared c = compare(mesh, pieces, stage);
        EXPECT_EQ(c.twice + c.gaps + c.extra + c.moved, 0) << "seed " << seed;
    }
}

TEST(Cuts, ThroughVerticesLeaveTheVoxelsOfTheUncutPart) {
    int64_t solid = 0, moved = 0;
    for (uint32_t seed = 1; seed <= kRounds; ++seed) {
        std::mt19937 random(seed);
        for (const mesh::Mesh& mesh : convex_meshes()) {
            const Stage stage(mesh, &random, 50, seed % 2 == 0);
            const CutPiece all = testing::whole(mesh);
            const auto vertex = [&] {
                return all.outer[random() % all.outer.size()][random() % 3];
            };
            const Vec3d a = vertex(), b = vertex(), c = vertex();
            const Vec3d n = cross(b - a, c - a);
            if (!(length(n) > 1e-3)) continue;
            // Rounding moves the other two beside the plane or onto it.
            expect_exact(mesh, cut_all({all}, {n, dot(n, a)}), stage,
                         "seed " + std::to_string(seed), &solid, &moved);
        }
    }
    EXPECT_LT(moved, solid / 5'000);
}

// All coordinates in halves of voxels, the cuts through the centers of voxels and of edges.
TEST(Cuts, ThroughVoxelCentresLeaveTheVoxelsOfTheUncutPart) {
    for (uint32_t seed = 1; seed <= kRounds; ++seed) {
        std::mt19937 random(seed);
        const mesh::Mesh mesh = mesh::make_box({16, 12, 8});
        Stage stage(mesh, &random, 64, false);
        stage.grid.pitch_mm = {0.25, 0.25, 0.25};
        stage.grid.origin_mm = {-9, -7, -1};
        stage.grid.size = {72, 56, 40};
        std::vector<CutPiece> pieces{testing::whole(mesh)};
        for (int k = 0; k < 3; ++k) {
            CutPlane plane;
            const int axis = static_cast<int>(random() % 3);
            plane.normal[axis] = 1;
            if (k == 2) plane.normal[(axis + 1) % 3] = random() % 2 == 0 ? 1 : -2;
            plane.offset = 0.125 + 0.25 * static_cast<double>(random() % 12);
            pieces = cut_all(std::move(pieces), plane);
        }
        const Compared c = compare(mesh, pieces, stage);
        EXPECT_EQ(c.twice + c.gaps + c.extra + c.moved, 0) << "seed " << seed;
        EXPECT_EQ(c.solid, 64 * 48 * 32);
    }
}

class MeshCuts : public ::testing::TestWithParam<const char*> {};

// Their sections are not star-shaped, so caps overlap themselves; within 1/256 voxel of the cut a
// voxel beside the mesh may be covered, as with any cap that leaves the solid. None is lost or
// doubled.
TEST_P(MeshCuts, LoseAndDoubleNoVoxel) {
    const std::string file =
        (testing::source_dir() / "tests/data/meshes/").string() + GetParam() + ".obj";
    const testing::TriangleMesh read = testing::read_obj(file, 60);
    ASSERT_FALSE(read.triangles.empty());
    mesh::Mesh mesh;
    for (const Vec3f& p : read.positions)
        mesh.positions.push_back(vec_cast<double>(p));
    mesh.triangles = read.triangles;
    Compared sum;
    for (uint32_t seed = 1; seed <= (kRounds + 7) / 8; ++seed) {
        std::mt19937 random(seed);
        const Stage stage(mesh, &random, 110, true);
        const std::vector<CutPiece> pieces =
            cut_all({testing::whole(mesh)}, random_plane(mesh, &random));
        ASSERT_EQ(pieces.size(), 2u);
        const Compared c = compare(mesh, pieces, stage);
        EXPECT_EQ(c.twice, 0);
        EXPECT_EQ(c.gaps, 0);
        sum.solid += c.solid, sum.extra += c.extra, sum.moved += c.moved;
    }
    printf("%s: %ld voxels, %ld beside, %ld otherwise without the vertices of the cut\n",
           GetParam(), static_cast<long>(sum.solid), static_cast<long>(sum.extra),
           static_cast<long>(sum.moved));
    EXPECT_LE(sum.extra, sum.solid / 50'000);
    EXPECT_LE(sum.moved, sum.solid / 50'000);
}

INSTANTIATE_TEST_SUITE_P(Data, MeshCuts,
                         ::testing::Values("spot", "goathead", "koala", "scorpion"));

}  // namespace
}  // namespace openfab
