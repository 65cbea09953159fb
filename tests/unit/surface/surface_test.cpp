// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>

#include "runtime/surface/messages.h"
#include "tests/support/says/says.h"
#include "tests/support/surface/worlds.h"

namespace openfab {
namespace {

using surface::Patch;
using surface::PatchKind;
using surface::Surface;
using surface::SurfaceOptions;

std::map<PatchKind, int> kinds(const Surface& surface) {
    std::map<PatchKind, int> out;
    for (const Patch& p : surface.patches())
        ++out[p.kind];
    return out;
}

std::unique_ptr<Surface> create(const part::Part& part, double s) {
    SurfaceOptions options;
    options.micro_edge_mm = s;
    auto made = Surface::create(part, options);
    EXPECT_TRUE(made.has_value()) << made.error().text();
    return std::move(*made);
}

std::string failure(const part::Part& part, double s) {
    SurfaceOptions options;
    options.micro_edge_mm = s;
    const auto made = Surface::create(part, options);
    return made ? "" : made.error().text();
}

part::Part hand_part(const mesh::Mesh& mesh, testing::HandMode mode, float amplitude,
                     bool computed = false) {
    return make_part(testing::Scenario{"", mesh, mode, amplitude, 0, computed});
}

TEST(SurfaceTest, WithoutASurfaceStageTheBaseMeshIsTheSurface) {
    const part::Part part = testing::make_part(testing::empty_fablet(), testing::cube(2));
    const auto surface = create(part, 0.01);
    EXPECT_TRUE(surface->identity());
    ASSERT_EQ(surface->patches().size(), 12u);
    for (int32_t p = 0; p < 12; ++p) {
        const Patch& patch = surface->patches()[p];
        EXPECT_EQ(patch.kind, PatchKind::kIdentity);
        EXPECT_EQ(patch.triangle, p);
        EXPECT_EQ(patch.use, surface::kForQuery | surface::kForCoverage);
        const auto mesh = surface->micro(p);
        ASSERT_EQ(mesh->triangles.size(), 1u);
        for (size_t c = 0; c < 3; ++c) {
            const auto v = part.mesh->triangles[p][c];
            EXPECT_EQ(mesh->positions[c], vec_cast<float>(part.mesh->positions[v]));
        }
    }
}

TEST(SurfaceTest, OnlyTheBackOfACardIsDiced) {
    const part::Part part = hand_part(testing::card(7, 5, 1), testing::HandMode::kBack, 0.6f);
    const auto surface = create(part, 0.5);
    EXPECT_FALSE(surface->identity());
    const auto count = kinds(*surface);
    EXPECT_EQ(count.at(PatchKind::kIdentity), 10);
    EXPECT_EQ(count.at(PatchKind::kLattice), 2);
    EXPECT_EQ(count.at(PatchKind::kFan), 4);
    // Four strips, and the four corners of the back.
    EXPECT_EQ(count.at(PatchKind::kSeam), 8);
    for (const Patch& p : surface->patches()) {
        EXPECT_EQ(p.use == surface::kForCoverage, p.kind == PatchKind::kFan);
    }
}

TEST(SurfaceTest, SeamsOfADisplacementThatIsZeroAtTheEdgeAreEmpty) {
    // wave(uv) vanishes on the border, so the displaced back meets the sides without a strip.
    const part::Part part = hand_part(testing::card(7, 5, 1), testing::HandMode::kBack, 0.6f);
    const auto surface = create(part, 0.5);
    for (size_t p = 0; p < surface->patches().size(); ++p) {
        if (surface->patches()[p].kind == PatchKind::kSeam) {
            EXPECT_EQ(surface->micro(static_cast<int32_t>(p))->triangles.size(), 0u);
        }
    }
}

TEST(SurfaceTest, FoldedStripsOfSeveralPatchesCloseAtTheEdgesEndsAlone) {
    const part::Part part =
        hand_part(testing::card(130, 0.4, 0.3), testing::HandMode::kOffset, -0.1f);
    const auto surface = create(part, 0.12);
    std::vector<std::array<Vec3f, 3>> triangles;
    int strips = 0;
    for (size_t p = 0; p < surface->patches().size(); ++p) {
        if (surface->patches()[p].kind != PatchKind::kSeam) continue;
        const auto mesh = surface->micro(static_cast<int32_t>(p));
        if (mesh->triangles.size() > 1) ++strips;
        for (const auto& t : mesh->triangles) {
            triangles.push_back(
                {mesh->positions[t[0]], mesh->positions[t[1]], mesh->positions[t[2]]});
        }
    }
    // Four triangles between two points, one at each end; the fans of the eight vertices.
    const auto edge = [](int n) { return 4 * n + 2; };
    EXPECT_EQ(triangles.size(), static_cast<size_t>(4 * (edge(1084) + edge(4) + edge(3)) + 8));
    EXPECT_EQ(strips, 4 * (2 + 1 + 1));
    // Only the sides' own places are open.
    EXPECT_EQ(testing::open_edges(triangles), 2 * 4 * (1084 + 4 + 3));
}

TEST(SurfaceTest, FansAreSplit) {
    const part::Part part = hand_part(testing::card(100, 70, 2), testing::HandMode::kBack, 0.6f);
    const auto surface = create(part, 0.04);
    for (size_t p = 0; p < surface->patches().size(); ++p) {
        if (surface->patches()[p].kind == PatchKind::kFan) {
            EXPECT_LE(surface->micro(static_cast<int32_t>(p))->triangles.size(), 2048u);
        }
    }
    EXPECT_EQ(kinds(*surface).at(PatchKind::kFan), 2 * 2 + 2 * 1);
}

TEST(SurfaceTest, AnEdgeThatIsTooFineIsRefused) {
    const part::Part part = hand_part(testing::card(100, 70, 2), testing::HandMode::kBack, 0.6f);
    const std::string message = failure(part, 1e-3);
    EXPECT_NE(message.find("122.066"), std::string::npos) << message;
    EXPECT_NE(message.find("65535"), std::string::npos) << message;
    EXPECT_NE(message.find("0.001 mm"), std::string::npos) << message;
    // Identity triangles are not diced, so their edges do not matter.
    const part::Part plain = testing::make_part(testing::empty_fablet(), testing::card(100, 70, 2));
    EXPECT_EQ(failure(plain, 1e-6), "");
}

TEST(SurfaceTest, ADisplacementWithoutABoundIsRefused) {
    testing::PartOptions options;
    options.uniform_values = testing::hand_uniforms(testing::HandMode::kBumps, 0.2f);
    const part::Part part =
        testing::make_part(testing::hand_fablet_unbounded(), testing::cube(1), options);
    EXPECT_NE(failure(part, 0.1).find("max_displacement_mm"), std::string::npos)
        << failure(part, 0.1);
    options.max_displacement_mm = 0.5;
    const part::Part bounded =
        testing::make_part(testing::hand_fablet_unbounded(), testing::cube(1), options);
    EXPECT_EQ(failure(bounded, 0.1), "");
}

TEST(SurfaceTest, CountsWhatTheStageGotWrong) {
    testing::Scenario scenario{
        "", testing::sphere(2, 8, 5), testing::HandMode::kBroken, 0.4f, 0.2, true, 0.25};
    const part::Part part = make_part(scenario);
    const auto surface = create(part, 0.2);
    for (size_t p = 0; p < surface->patches().size(); ++p) {
        for (const Vec3f& v : surface->micro(static_cast<int32_t>(p))->positions) {
            EXPECT_TRUE(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z));
        }
    }
    EXPECT_GT(surface->counts().not_finite, 0);
    EXPECT_GT(surface->counts().cut_to_bound, 0);
    const std::vector<std::string> warnings =
        surface::displacement_warnings(part, surface->counts());
    ASSERT_EQ(warnings.size(), 2u);
    EXPECT_THAT(warnings[0], testing::Says(surface::messages::kNotFinite));
    EXPECT_THAT(warnings[1], testing::Says(surface::messages::kCutToBound, "*", "0.25"));
    EXPECT_TRUE(surface::displacement_warnings(part, {}).empty());
}

TEST(SurfaceTest, BoundsOfWhatIsCutKnowHowMuchIsLeft) {
    // Upper sides are displaced by 1 to 1.5 mm, before clamping.
    for (const double most : {0.5, 1.0, 1.5}) {
        const part::Part part = make_part(testing::Scenario{
            "", testing::cube(2), testing::HandMode::kFootprint, 1.0f, 0, false, most});
        const auto surface = create(part, 0.15);
        float top = -1e9f;
        for (const Vec3d& p : part.mesh->positions)
            top = std::max(top, static_cast<float>(p.y));
        int raised = 0;
        for (size_t p = 0; p < surface->patches().size(); ++p) {
            const Patch& patch = surface->patches()[p];
            if (patch.kind != PatchKind::kLattice) continue;
            const auto mesh = surface->micro(static_cast<int32_t>(p));
            if (std::ranges::any_of(mesh->positions, [&](const Vec3f& v) {
                    return v.y < top + 0.9f * static_cast<float>(std::min(most, 1.0));
                }))
                continue;
            ++raised;
            EXPECT_GT(patch.bounds.lo.y,
                      top + 0.66f * static_cast<float>(std::min(most, 1.0)) - 1e-3f)
                << "patch " << p << ", at most " << most;
            EXPECT_LT(patch.bounds.hi.y, top + static_cast<float>(most) + 1e-3f);
        }
        EXPECT_GT(raised, 0);
    }
}

TEST(SurfaceTest, CacheKeepsToItsBudgetAndHandlesPin) {
    const part::Part part = hand_part(testing::card(20, 15, 1), testing::HandMode::kBack, 0.6f);
    SurfaceOptions options;
    options.micro_edge_mm = 0.1;
    options.cache_bytes = 300000;
    auto surface = std::move(*Surface::create(part, options));
    std::vector<std::shared_ptr<const surface::MicroMesh>> held;
    std::vector<int32_t> tiles;
    for (size_t p = 0; p < surface->patches().size(); ++p) {
        if (surface->patches()[p].kind == PatchKind::kLattice)
            tiles.push_back(static_cast<int32_t>(p));
    }
    ASSERT_GT(tiles.size(), 20u);
    for (const int32_t p : tiles)
        held.push_back(surface->micro(p));
    const auto counts = surface->counts();
    EXPECT_LE(counts.cache_peak_bytes, 300000);
    EXPECT_GT(counts.cache_peak_bytes, 200000);
    EXPECT_GT(counts.cache_evictions, 0);
    EXPECT_EQ(counts.cache_misses, static_cast<int64_t>(tiles.size()));
    for (const auto& mesh : held)
        EXPECT_GT(mesh->triangles.size(), 0u);
    EXPECT_EQ(surface->micro(tiles.back()), held.back());
    EXPECT_EQ(surface->counts().cache_hits, counts.cache_hits + 1);
}

int failing_kernel(void**) {
    return -7;
}

TEST(SurfaceTest, AFailingKernelIsReported) {
    openfab_fablet fablet = testing::hand_fablet(true);
    fablet.surface.fn[OPENFAB_ISA_SSE41] = failing_kernel;
    testing::PartOptions options;
    options.uniform_values = testing::hand_uniforms(testing::HandMode::kBumps, 0.2f);
    const part::Part part = testing::make_part(fablet, testing::cube(1), options);
    const auto surface = create(part, 0.5);
    EXPECT_TRUE(surface->status());
    EXPECT_EQ(surface->micro(0)->triangles.size(), 0u);
    ASSERT_FALSE(surface->status());
    EXPECT_NE(surface->status().error().text().find("-7"), std::string::npos);
    fablet.surface_bounds.fn[OPENFAB_ISA_SSE41] = failing_kernel;
    EXPECT_NE(failure(part, 0.5).find("-7"), std::string::npos);
}

int (*counted_kernel)(void**) = nullptr;
std::atomic<int> kernel_calls = 0;
int counting_kernel(void** arguments) {
    ++kernel_calls;
    return counted_kernel(arguments);
}

// A draft has few points in each base triangle: calls cost more than they do.
TEST(SurfaceTest, SmallNeighboursAreDicedTogether) {
    openfab_fablet fablet = testing::hand_fablet(true);
    counted_kernel = fablet.surface.fn[OPENFAB_ISA_SSE41];
    for (auto& kernel : fablet.surface.fn)
        kernel = kernel != nullptr ? counting_kernel : nullptr;
    testing::PartOptions options;
    options.uniform_values = testing::hand_uniforms(testing::HandMode::kBumps, 0.2f);
    const part::Part part = testing::make_part(fablet, testing::torus(4, 1.5, 48, 24), options);
    const auto surface = create(part, 0.4);
    kernel_calls = 0;
    const auto patches = static_cast<int32_t>(surface->patches().size());
    ASSERT_GT(patches, 1000);
    int64_t triangles = 0;
    for (int32_t p = 0; p < patches; ++p) {
        const auto mesh = surface->micro(p);
        triangles += static_cast<int64_t>(mesh->triangles.size());
        EXPECT_EQ(surface->micro(p), mesh);
    }
    EXPECT_LT(kernel_calls, patches / 8);
    EXPECT_EQ(surface->counts().cache_misses, patches);
    EXPECT_EQ(surface->counts().micro_triangles, triangles);
}

TEST(SurfaceTest, ReadingUvWithoutUvIsRefused) {
    openfab_fablet fablet = testing::hand_fablet(true);
    std::vector<openfab_arg> args(fablet.surface.args,
                                  fablet.surface.args + fablet.surface.arg_count);
    args[3] = {OPENFAB_ARG_SURFACE_ATTR, OPENFAB_FLOAT, OPENFAB_SURFACE_UV, 0};
    fablet.surface.args = args.data();
    testing::PartOptions options;
    options.uniform_values = testing::hand_uniforms(testing::HandMode::kBumps, 0.2f);
    part::Part part = testing::make_part(fablet, testing::cube(1), options);
    EXPECT_EQ(failure(part, 0.5), "");
    auto mesh = std::make_shared<part::PartMesh>(*part.mesh);
    mesh->corner_uv.clear();
    part.mesh = mesh;
    EXPECT_NE(failure(part, 0.5).find("`uv`"), std::string::npos) << failure(part, 0.5);
}

}  // namespace
}  // namespace openfab
