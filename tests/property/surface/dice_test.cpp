// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Dicing against its plain twin, bit for bit: every micropolygon, its order and attributes;
// closedness; bounds.

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cctype>
#include <cstring>

#include "runtime/surface/surface.h"
#include "tests/support/surface/worlds.h"

namespace openfab {
namespace {

using surface::MicroMesh;
using surface::Patch;
using surface::Surface;
using surface::SurfaceOptions;

class Dicing : public ::testing::TestWithParam<testing::Scenario> {
  protected:
    std::unique_ptr<Surface> create(const part::Part& part, SurfaceOptions options = {}) {
        options.micro_edge_mm = GetParam().micro_edge_mm;
        auto made = Surface::create(part, options);
        EXPECT_TRUE(made.has_value()) << made.error().text();
        return std::move(*made);
    }
};

std::vector<float> corner_floats(const MicroMesh& mesh, int32_t vertex, size_t components) {
    const auto at = mesh.vertex_attributes.begin() +
                    static_cast<ptrdiff_t>(static_cast<size_t>(vertex) * components);
    return {at, at + static_cast<ptrdiff_t>(components)};
}

bool same_bits(const Vec3f& a, const Vec3f& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

void expect_equal(const Surface& surface, const std::vector<reference::DicedTriangle>& twin) {
    const size_t floats = static_cast<size_t>(surface.ranges().float_components);
    const size_t ints = static_cast<size_t>(surface.ranges().int_components);
    size_t at = 0;
    for (size_t p = 0; p < surface.patches().size(); ++p) {
        const auto mesh = surface.micro(static_cast<int32_t>(p));
        const uint8_t use = surface.patches()[p].use;
        for (size_t i = 0; i < mesh->triangles.size(); ++i, ++at) {
            ASSERT_LT(at, twin.size()) << "patch " << p << " has more triangles than the twin";
            const reference::DicedTriangle& expected = twin[at];
            ASSERT_EQ(expected.patch, static_cast<int32_t>(p)) << "triangle " << i;
            ASSERT_EQ(expected.in_patch, static_cast<int32_t>(i));
            ASSERT_EQ(expected.query, (use & surface::kForQuery) != 0) << p;
            ASSERT_EQ(expected.coverage, (use & surface::kForCoverage) != 0) << p;
            for (size_t c = 0; c < 3; ++c) {
                const int32_t v = mesh->triangles[i][c];
                const Vec3f& position = mesh->positions[v];
                ASSERT_TRUE(same_bits(position, expected.positions[c]))
                    << "patch " << p << " triangle " << i << " corner " << c << ": " << position.x
                    << " " << position.y << " " << position.z << " against "
                    << expected.positions[c].x << " " << expected.positions[c].y << " "
                    << expected.positions[c].z;
                if (expected.query) {
                    ASSERT_EQ(corner_floats(*mesh, v, floats), expected.floats[c]) << "patch " << p;
                }
            }
            if (!expected.query) continue;
            const auto first = mesh->triangle_attributes.begin() + static_cast<ptrdiff_t>(i * ints);
            ASSERT_EQ(std::vector<uint32_t>(first, first + static_cast<ptrdiff_t>(ints)),
                      expected.ints)
                << "patch " << p << " triangle " << i;
        }
    }
    EXPECT_EQ(at, twin.size());
}

TEST_P(Dicing, EqualsThePlainTwinToTheBit) {
    const part::Part part = make_part(GetParam());
    const auto surface = create(part);
    expect_equal(*surface,
                 reference::dice(part, GetParam().micro_edge_mm, testing::hand_identities(part),
                                 testing::hand_evaluate(part)));
}

TEST_P(Dicing, EqualsThePlainTwinWithoutIdentities) {
    const part::Part part = make_part(GetParam());
    SurfaceOptions options;
    options.infer_identity = false;
    const auto surface = create(part, options);
    EXPECT_FALSE(surface->identity());
    expect_equal(*surface, reference::dice(part, GetParam().micro_edge_mm,
                                           testing::hand_identities(part, false),
                                           testing::hand_evaluate(part)));
}

TEST_P(Dicing, CoverageSurfaceIsClosed) {
    const part::Part part = make_part(GetParam());
    for (const bool infer : {true, false}) {
        SurfaceOptions options;
        options.infer_identity = infer;
        const auto surface = create(part, options);
        const auto triangles = testing::triangles_of(*surface, surface::kForCoverage);
        EXPECT_GT(triangles.size(), 0u);
        EXPECT_EQ(testing::open_edges(triangles), 0) << "infer_identity " << infer;
    }
}

TEST_P(Dicing, StaysInsideItsBoundsAndRanges) {
    const part::Part part = make_part(GetParam());
    const auto surface = create(part);
    const surface::PatchRanges& r = surface->ranges();
    const size_t floats = static_cast<size_t>(r.float_components),
                 ints = static_cast<size_t>(r.int_components);
    for (size_t p = 0; p < surface->patches().size(); ++p) {
        const Patch& patch = surface->patches()[p];
        const auto mesh = surface->micro(static_cast<int32_t>(p));
        for (size_t v = 0; v < mesh->positions.size(); ++v) {
            for (int axis = 0; axis < 3; ++axis) {
                ASSERT_GE(mesh->positions[v][axis], patch.bounds.lo[axis])
                    << "patch " << p << " axis " << axis;
                ASSERT_LE(mesh->positions[v][axis], patch.bounds.hi[axis])
                    << "patch " << p << " axis " << axis;
            }
            for (size_t k = 0; k < floats && (patch.use & surface::kForQuery) != 0; ++k) {
                ASSERT_GE(mesh->vertex_attributes[v * floats + k], r.float_lo[p * floats + k])
                    << "patch " << p;
                ASSERT_LE(mesh->vertex_attributes[v * floats + k], r.float_hi[p * floats + k])
                    << "patch " << p;
            }
        }
        for (size_t i = 0; i < mesh->triangle_attributes.size(); ++i) {
            const int32_t value = static_cast<int32_t>(mesh->triangle_attributes[i]);
            ASSERT_GE(value, r.int_lo[p * ints + i % ints]) << "patch " << p;
            ASSERT_LE(value, r.int_hi[p * ints + i % ints]) << "patch " << p;
        }
    }
}

TEST_P(Dicing, IsTheSameForAnyCacheAndThreads) {
    const part::Part part = make_part(GetParam());
    const auto plenty = create(part);
    const size_t count = plenty->patches().size();
    for (const size_t bytes : {size_t{0}, size_t{20000}, size_t{200000}}) {
        SurfaceOptions options;
        options.cache_bytes = bytes;
        const auto tight = create(part, options);
        std::vector<std::shared_ptr<const MicroMesh>> pinned(3 * count);
        tbb::parallel_for(size_t{0}, 3 * count, [&](size_t i) {
            const int32_t p = static_cast<int32_t>(i * 7919 % count);
            pinned[i] = tight->micro(p);
        });
        for (size_t i = 0; i < 3 * count; ++i) {
            const auto expected = plenty->micro(static_cast<int32_t>(i * 7919 % count));
            ASSERT_EQ(pinned[i]->triangles, expected->triangles);
            ASSERT_EQ(pinned[i]->positions, expected->positions);
            ASSERT_EQ(pinned[i]->vertex_attributes, expected->vertex_attributes);
            ASSERT_EQ(pinned[i]->triangle_attributes, expected->triangle_attributes);
        }
        EXPECT_LE(tight->counts().cache_peak_bytes, static_cast<int64_t>(bytes));
    }
}

TEST_P(Dicing, ExactBoxIsThatOfAllVertices) {
    const part::Part part = make_part(GetParam());
    const auto surface = create(part);
    Affine3d turned;
    turned.m = {0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6};
    turned.t = {3, -1, 2};
    for (const Affine3d& map : {Affine3d{}, turned}) {
        Box3d expected;
        for (const auto& t : testing::triangles_of(*surface, surface::kForCoverage)) {
            for (const Vec3f& p : t)
                expected.add(map.apply(vec_cast<double>(p)));
        }
        const Box3d box = surface->exact_box(map);
        EXPECT_EQ(box, expected);
    }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Dicing, ::testing::ValuesIn(testing::scenarios()),
                         [](const auto& info) {
                             std::string name = info.param.name;
                             for (char& c : name)
                                 c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                             return name;
                         });

}  // namespace
}  // namespace openfab
