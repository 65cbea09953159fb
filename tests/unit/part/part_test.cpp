// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "base/rotation.h"
#include "runtime/part/messages.h"
#include "runtime/part/part_mesh.h"
#include "tests/support/meshes/meshes.h"

namespace openfab {
namespace {

using testing::make_part;
using Matrix = std::array<double, 9>;

TEST(Rotation, AgreesWithLibmAndIsExactAtQuarterTurns) {
    constexpr double kArgument = 4e-15;  // error of the reference due to rounded radians
    for (double degrees = -725; degrees < 725; degrees += 0.37) {
        const SinCos sc = sin_cos_degrees(degrees);
        const double x = degrees * 3.14159265358979323846 / 180;
        EXPECT_NEAR(sc.sin, std::sin(x), kArgument);
        EXPECT_NEAR(sc.cos, std::cos(x), kArgument);
    }
    for (int quarter = -9; quarter <= 9; ++quarter) {
        const SinCos sc = sin_cos_degrees(quarter * 90.0);
        const int phase = (quarter % 4 + 4) % 4;
        EXPECT_EQ(sc.sin, phase == 1 ? 1 : phase == 3 ? -1 : 0);
        EXPECT_EQ(sc.cos, phase == 0 ? 1 : phase == 2 ? -1 : 0);
    }
}

TEST(Rotation, TurnsAboutXThenYThenZ) {
    const Affine3d t = placement_transform({2, 1, 1}, {90, 0, 90}, {10, 0, 0});
    // x is scaled to 2, fixed by the rotation about x, and rotated to y.
    EXPECT_EQ(t.apply({1, 0, 0}), (Vec3d{10, 2, 0}));
    // y goes to z, which the rotation about z fixes.
    EXPECT_EQ(t.apply({0, 1, 0}), (Vec3d{10, 0, 1}));
}

void expect_polar(const Matrix& m) {
    const Result<PolarFactors> polar = polar_factors(m);
    ASSERT_TRUE(polar) << polar.error().text();
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j) {
            double rtr = 0;
            double rs = 0;
            for (size_t k = 0; k < 3; ++k) {
                rtr += polar->r[k * 3 + i] * polar->r[k * 3 + j];
                rs += polar->r[i * 3 + k] * polar->s[k * 3 + j];
            }
            EXPECT_NEAR(rtr, i == j ? 1 : 0, 1e-13);
            EXPECT_NEAR(rs, m[i * 3 + j], 1e-9 * 10);
            EXPECT_EQ(polar->s[i * 3 + j], polar->s[j * 3 + i]);
        }
        EXPECT_GT(polar->s[i * 3 + i], 0);
    }
}

TEST(Polar, SplitsRotationScaleAndShear) {
    expect_polar({1, 0, 0, 0, 1, 0, 0, 0, 1});
    expect_polar({2, 0, 0, 0, 3, 0, 0, 0, 0.1});
    expect_polar({1, 0.4, 0, 0, 1, -0.2, 0.1, 0, 1.5});
    expect_polar({-1, 0, 0, 0, 1, 0, 0, 0, 1});
    expect_polar(placement_transform({2, 3, 4}, {10, 20, 30}, {}).m);
    expect_polar(placement_transform({25.4, -25.4, 25.4}, {-77, 120, 3}, {}).m);
}

TEST(Polar, GivesEqualBitsOfSUnderAnyRotation) {
    for (double angle = 0; angle < 360; angle += 17) {
        const Result<PolarFactors> unit =
            polar_factors(placement_transform({1, 1, 1}, {angle, 2 * angle, -angle}, {}).m);
        const Result<PolarFactors> scaled =
            polar_factors(placement_transform({0.1, 2, 7.3}, {angle, 5, 1}, {}).m);
        ASSERT_TRUE(unit && scaled);
        EXPECT_EQ(unit->s, (Matrix{1, 0, 0, 0, 1, 0, 0, 0, 1}));
        EXPECT_EQ(scaled->s, (Matrix{0.1, 0, 0, 0, 2, 0, 0, 0, 7.3}));
    }
}

TEST(Polar, LeavesRotationOfAxisAlignedScaleExact) {
    const Result<PolarFactors> polar = polar_factors({0, -3, 0, 2, 0, 0, 0, 0, -5});
    ASSERT_TRUE(polar);
    EXPECT_EQ(polar->r, (Matrix{0, -1, 0, 1, 0, 0, 0, 0, -1}));
    EXPECT_EQ(polar->s, (Matrix{2, 0, 0, 0, 3, 0, 0, 0, 5}));
}

TEST(Polar, RefusesSingularAndNonFiniteMatrices) {
    EXPECT_FALSE(polar_factors({1, 0, 0, 0, 1, 0, 0, 0, 0}));
    EXPECT_FALSE(polar_factors({1, 0, 0, 0, 1, 0, 1, 1, 0}));
    EXPECT_FALSE(polar_factors({1e-5, 0, 0, 0, 1e-5, 0, 0, 0, 1e-5}));
    EXPECT_FALSE(polar_factors({1e6, 0, 0, 0, 1e6, 0, 0, 0, 1e-6}));
    EXPECT_FALSE(polar_factors({std::nan(""), 0, 0, 0, 1, 0, 0, 0, 1}));
    EXPECT_FALSE(polar_factors({std::numeric_limits<double>::infinity(), 0, 0, 0, 1, 0, 0, 0, 1}));
}

/// Every directed edge must be met by its opposite exactly once.
void expect_closed(const mesh::Mesh& mesh) {
    std::map<std::pair<int32_t, int32_t>, int> edges;
    for (const auto& t : mesh.triangles) {
        for (size_t i = 0; i < 3; ++i)
            ++edges[{t[i], t[(i + 1) % 3]}];
    }
    for (const auto& [edge, count] : edges) {
        ASSERT_EQ(count, 1) << mesh.name;
        ASSERT_TRUE(edges.contains({edge.second, edge.first})) << mesh.name;
    }
    for (const mesh::MeshAttribute& a : mesh.attributes) {
        ASSERT_EQ(a.is_int ? a.faces.size() : a.corners.size(), mesh.triangles.size());
        for (const auto& corners : a.corners) {
            for (int32_t corner : corners) {
                ASSERT_GE(corner, 0);
                ASSERT_LT(static_cast<size_t>(corner) * static_cast<size_t>(a.components),
                          a.values.size());
            }
        }
    }
}

TEST(Primitives, AreClosedAndOutward) {
    constexpr double kPi = 3.14159265358979323846;
    const std::vector<std::pair<mesh::Mesh, double>> cases = {
        {mesh::make_box({2, 3, 4}), 24},
        {mesh::make_sphere(2), 4 * kPi / 3},
        {mesh::make_cylinder(2, 5), 5 * kPi},
        {mesh::make_plane(2, 3), 0},
        {testing::cube(2), 8},
        {testing::card(100, 70, 2), 14000},
        {testing::sphere(1, 128, 64), 4 * kPi / 3},
        {testing::torus(3, 1, 128, 64), 2 * kPi * kPi * 3},
    };
    for (const auto& [mesh, volume] : cases) {
        expect_closed(mesh);
        EXPECT_NEAR(testing::signed_volume(mesh), volume, 3e-3 * volume) << mesh.name;
    }
}

TEST(Primitives, NormalsPointOutAndUvFollowThePicture) {
    for (const mesh::Mesh& mesh : {mesh::make_box({2, 3, 4}), mesh::make_sphere(2),
                                   mesh::make_cylinder(2, 5), testing::torus(3, 1)}) {
        const mesh::MeshAttribute& n = *mesh.find("n");
        for (size_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto& p = mesh.positions;
            const auto& tri = mesh.triangles[t];
            const auto at = [&](size_t i) { return p[tri[i]]; };
            const Vec3d geometric = cross(at(1) - at(0), at(2) - at(0));
            for (size_t c = 0; c < 3; ++c) {
                const float* v = &n.values[static_cast<size_t>(n.corners[t][c]) * 3];
                EXPECT_NEAR(v[0] * v[0] + v[1] * v[1] + v[2] * v[2], 1, 1e-6);
                EXPECT_GT(dot(geometric, Vec3d{v[0], v[1], v[2]}), 0) << mesh.name;
            }
        }
    }
    // Front and back of a card have the same uv at the same (x, y).
    const mesh::Mesh card = testing::card(10, 6, 1);
    const mesh::MeshAttribute& uv = *card.find("uv");
    for (size_t t = 0; t < 4; ++t) {
        EXPECT_EQ(card.find("face")->faces[t], t < 2 ? 0 : 1);
        for (size_t c = 0; c < 3; ++c) {
            const Vec3d& p = card.positions[static_cast<size_t>(card.triangles[t][c])];
            EXPECT_EQ(p.z, t < 2 ? 1 : 0);
            const float* v = &uv.values[static_cast<size_t>(uv.corners[t][c]) * 2];
            EXPECT_EQ(v[0], p.x > 0 ? 1 : 0);
            EXPECT_EQ(v[1], p.y > 0 ? 1 : 0);
        }
    }
}

TEST(Frame, VoxelCentresAgreeWithTheVoxelMap) {
    testing::PartOptions options;
    options.transform = placement_transform({1, 2, 1}, {30, 40, 50}, {300, 200, 100});
    const part::Part part = make_part(testing::empty_fablet(), testing::card(10, 8, 2), options);
    const part::Grid grid = testing::grid_around(part, {0.042, 0.085, 0.027}, 1);
    const Affine3d to_voxel = part::local_to_voxel(part, grid);
    const Vec3i base = part::part_base_voxel(part, grid);
    const std::array<float, OPENFAB_FRAME_COUNT> frame = part::make_frame(part, grid);
    for (const Vec3i& index : {Vec3i{0, 0, 0}, Vec3i{40, -30, 17}, Vec3i{-100, 50, -60}}) {
        const Vec3<float> x = vec_cast<float>(index) + Vec3f{0.5f, 0.5f, 0.5f};
        Vec3d local;
        Vec3d build;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<size_t>(axis);
            local[axis] =
                ((x.x * frame[OPENFAB_FRAME_STEP_I + a] + x.y * frame[OPENFAB_FRAME_STEP_J + a]) +
                 x.z * frame[OPENFAB_FRAME_STEP_K + a]) +
                frame[OPENFAB_FRAME_ORIGIN + a];
            build[axis] = frame[OPENFAB_FRAME_BUILD_ORIGIN + a] +
                          x[axis] * frame[OPENFAB_FRAME_VOXEL_SIZE + a];
        }
        const Vec3d voxel = to_voxel.apply(local);
        const Vec3d placed = part.local_to_build.apply(local);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(voxel[axis], base[axis] + index[axis] + 0.5, 1e-3);
            EXPECT_NEAR(placed[axis], build[axis], 1e-3);
        }
    }
    EXPECT_EQ(frame[OPENFAB_FRAME_MAX_DISPLACEMENT], std::numeric_limits<float>::infinity());
}

TEST(Part, PlacesTheMeshWhereTheTransformPutsIt) {
    testing::PartOptions options;
    options.transform = placement_transform({1, 2, -3}, {12, 34, 56}, {7, 8, 9});
    const mesh::Mesh mesh = testing::torus(3, 1, 128, 64);
    const part::Part part = make_part(testing::empty_fablet(), mesh, options);
    Box3d box;
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vec3d want = options.transform.apply(mesh.positions[i]);
        const Vec3d got = part.local_to_build.apply(part.mesh->positions[i]);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(got[axis], want[axis], 1e-9);
        box.add(part.mesh->positions[i]);
    }
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(box.center()[axis], 0, 1e-12);
    // A stretched sphere's normals are not stretched with it: they stay perpendicular to the
    // surface.
    EXPECT_EQ(part.mesh->corner_normals.size(), mesh.triangles.size() * 3);
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto at = [&](size_t i) {
            return part.mesh->positions[static_cast<size_t>(mesh.triangles[t][i])];
        };
        const Vec3d flat = cross(at(1) - at(0), at(2) - at(0));
        for (size_t c = 0; c < 3; ++c) {
            EXPECT_GT(dot(flat, vec_cast<double>(part.mesh->corner_normals[t * 3 + c])),
                      0.9 * length(flat));
        }
    }
}

/// compiler/OPENFL.md, section 1: a mirror is part of how a part is turned. Part space is stretched by the magnitude of
/// the scale, and has the mesh's own axes.
TEST(Part, MirrorsAreTurningsAndNotOfPartSpace) {
    const mesh::Mesh mesh = testing::torus(3, 1, 16, 8);
    for (const Vec3d& scale : {Vec3d{-1.5, 2, -3}, Vec3d{-1, 1, 1}, Vec3d{2, -2, 0.5}}) {
        testing::PartOptions options;
        options.transform = placement_transform(scale, {25, 40, -70}, {3, -2, 5});
        const part::Part part = make_part(testing::empty_fablet(), mesh, options);
        for (size_t i = 0; i < mesh.positions.size(); ++i) {
            const Vec3d at = part.mesh->positions[i] + part.mesh->center_part_mm;
            const Vec3d placed = options.transform.apply(mesh.positions[i]);
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_NEAR(at[axis], std::abs(scale[axis]) * mesh.positions[i][axis], 1e-9);
                EXPECT_NEAR(part.local_to_build.apply(part.mesh->positions[i])[axis], placed[axis],
                            1e-9);
            }
        }
    }
}

const openfab_varying kInputs[] = {
    {"uv", "float2", OPENFAB_FLOAT, 2, -1, nullptr},
    {"face", "int", OPENFAB_INT, 1, -1, nullptr},
};

openfab_fablet postcard_like() {
    openfab_fablet f = testing::empty_fablet();
    f.name = "Card";
    f.has_surface = 1;
    f.surface_input_count = 2;
    f.surface_inputs = kInputs;
    return f;
}

TEST(Part, ResolvesAttributesOrNamesTheMesh) {
    const openfab_fablet fablet = postcard_like();
    const Matrix s{1, 0, 0, 0, 1, 0, 0, 0, 1};
    const mesh::Mesh card = testing::card(4, 2, 1);
    const auto mesh = part::make_part_mesh(card, fablet, s);
    ASSERT_TRUE(mesh) << mesh.error().text();
    EXPECT_EQ((*mesh)->inputs[0].corner_values.size(), 12u * 6);
    EXPECT_EQ((*mesh)->inputs[0].corner_values, (*mesh)->corner_uv);
    EXPECT_EQ((*mesh)->inputs[1].face_values,
              (std::vector<uint32_t>{0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5}));

    const auto lacking = part::make_part_mesh(testing::without(card, "face"), fablet, s);
    ASSERT_FALSE(lacking);
    EXPECT_EQ(lacking.error().text(),
              fmt::format(part::messages::kNoSuchAttribute, "card", "face", "Card", "int", "face") +
                  "; " + part::messages::kAttributes + "`uv` (float2), `n` (float3)");

    mesh::Mesh wrong = testing::without(card, "uv");
    wrong.attributes.push_back(*card.find("n"));
    wrong.attributes.back().name = "uv";
    const auto mistyped = part::make_part_mesh(wrong, fablet, s);
    ASSERT_FALSE(mistyped);
    EXPECT_EQ(mistyped.error().text(), fmt::format(part::messages::kAttributeType, "uv", "card",
                                                   "float3", "Card", "float2", "uv") +
                                           "; " + part::messages::kAttributeTypeHelp);
}

TEST(Part, TakesTheDefaultWhereTheMeshLacksAnInput) {
    const uint32_t bits[] = {0x3f000000u, 0x3e800000u};  // 0.5, 0.25
    const openfab_varying input = {"tint", "float2", OPENFAB_FLOAT, 2, -1, bits};
    openfab_fablet fablet = testing::empty_fablet();
    fablet.surface_input_count = 1;
    fablet.surface_inputs = &input;
    const auto mesh = part::make_part_mesh(testing::cube(1), fablet, {1, 0, 0, 0, 1, 0, 0, 0, 1});
    ASSERT_TRUE(mesh);
    ASSERT_EQ((*mesh)->inputs[0].corner_values.size(), 12u * 3 * 2);
    EXPECT_EQ((*mesh)->inputs[0].corner_values[70], 0.5f);
    EXPECT_EQ((*mesh)->inputs[0].corner_values[71], 0.25f);
}

TEST(Part, HasFlatNormalsWithoutMeshNormals) {
    const auto mesh = part::make_part_mesh(testing::without(testing::cube(1), "n"),
                                           testing::empty_fablet(), {1, 0, 0, 0, 1, 0, 0, 0, 1});
    ASSERT_TRUE(mesh);
    EXPECT_EQ((*mesh)->corner_normals[0], (Vec3f{0, 0, 1}));
    EXPECT_EQ((*mesh)->corner_normals[35], (Vec3f{-1, 0, 0}));
}

}  // namespace
}  // namespace openfab
