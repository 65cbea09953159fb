// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Queries of a volume stage at any point, on displaced, rotated, scaled and mirrored parts: the
// part's own surface to the bit against brute force, other objects against plain geometry in build
// space.

#include "runtime/volume/point_queries.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "base/rotation.h"
#include "runtime/nearest/engine/winding.h"
#include "runtime/solid/mesh/mesh_solid.h"
#include "runtime/volume/point_order.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/reference/brute_force.h"
#include "tests/support/reference/closest_point.h"
#include "tests/support/surface/hand_fablet.h"

namespace openfab::volume {
namespace {

using testing::HandMode;
using Triangle = std::array<Vec3f, 3>;

// States: 0 guard, 1..3 point, then the results of the queries.
constexpr int32_t kGuard = 0, kPoint = 1, kDistance = 4, kPosition = 5, kNormal = 8, kUv = 11,
                  kZone = 13, kToObject = 14, kStates = 15;

const openfab_query_output kOwnOutputs[] = {
    {OPENFAB_QUERY_DISTANCE, 0, 0, kDistance},     {OPENFAB_QUERY_POSITION, 0, 0, kPosition},
    {OPENFAB_QUERY_POSITION, 0, 1, kPosition + 1}, {OPENFAB_QUERY_POSITION, 0, 2, kPosition + 2},
    {OPENFAB_QUERY_NORMAL, 0, 0, kNormal},         {OPENFAB_QUERY_NORMAL, 0, 1, kNormal + 1},
    {OPENFAB_QUERY_NORMAL, 0, 2, kNormal + 2},     {OPENFAB_QUERY_ATTRIBUTE, 0, 0, kUv},
    {OPENFAB_QUERY_ATTRIBUTE, 0, 1, kUv + 1},      {OPENFAB_QUERY_ATTRIBUTE, 3, 0, kZone},
};
const openfab_query_output kObjectOutputs[] = {{OPENFAB_QUERY_DISTANCE, 0, 0, kToObject}};
const openfab_query kQueries[] = {
    {-1, kGuard, {kPoint, kPoint + 1, kPoint + 2}, -1, -1, 10, kOwnOutputs},
    {0, kGuard, {kPoint, kPoint + 1, kPoint + 2}, -1, -1, 1, kObjectOutputs},
};

/// The hand-written fablet with a volume stage that makes both queries.
const openfab_fablet& asking_fablet() {
    static const openfab_fablet fablet = [] {
        openfab_fablet f = testing::hand_fablet(true);
        f.object_count = 1;
        f.volume_segments.query_count = 2;
        f.volume_segments.queries = kQueries;
        return f;
    }();
    return fablet;
}

struct Scene {
    std::vector<part::Part> parts;
    std::vector<std::shared_ptr<const surface::Surface>> surfaces;
    std::vector<std::shared_ptr<solid::Solid>> solids;
    std::vector<std::unique_ptr<PlacedPart>> print;
    std::unique_ptr<nearest::Winding> winding;  ///< of the first part
    part::Grid grid;

    void add(const openfab_fablet& fablet, const mesh::Mesh& mesh, const Affine3d& transform,
             HandMode mode, float amplitude) {
        testing::PartOptions options;
        options.transform = transform;
        options.uniform_values = testing::hand_uniforms(mode, amplitude);
        options.instance = static_cast<int32_t>(parts.size());
        parts.push_back(testing::make_part(fablet, mesh, options));
    }
    void set_up() {
        grid = testing::grid_around(parts[0], {0.25, 0.2, 0.125}, 1);
        surface::SurfaceOptions options;
        options.micro_edge_mm = 0.4;
        const std::vector<int32_t> owners = solid_owners(parts);
        const auto trees = nearest::make_patch_cache(1 << 20);
        for (size_t i = 0; i < parts.size(); ++i) {
            print.push_back(std::make_unique<PlacedPart>(parts[i]));
            print[i]->index = static_cast<int32_t>(i);
            const auto owner = static_cast<size_t>(owners[i]);
            if (owner == i) {
                surfaces.push_back(std::move(*surface::Surface::create(parts[i], options)));
                solids.push_back(solid::make_solid_of(parts[i], surfaces[i]));
            } else {
                surfaces.push_back(surfaces[owner]);
                solids.push_back(solids[owner]);
            }
            print[i]->solid = solids[i];
            print[i]->set_grid(grid, {OPENFAB_ISA_AVX2, trees}, 1 << 20, *print[owner]);
        }
        resolve_object_queries(print, {OPENFAB_ISA_AVX2, trees});
        winding = std::make_unique<nearest::Winding>(*surfaces[0]);
    }
};

/// Signed distance in build space, of one part: the sign by the solid angle of the surface.
double plain_distance(const part::Part& part, const std::vector<Triangle>& triangles,
                      const Vec3d& p_build) {
    double d = 1e300, angle = 0;
    for (const Triangle& t : triangles) {
        Vec3d v[3];
        for (size_t k = 0; k < 3; ++k)
            v[k] = part.local_to_build.apply(vec_cast<double>(t[k]));
        d = std::min(d, length(p_build - reference::closest_point(p_build, v[0], v[1], v[2])));
        const Vec3d a = v[0] - p_build, b = v[1] - p_build, c = v[2] - p_build;
        const double la = length(a), lb = length(b), lc = length(c);
        angle += 2 * std::atan2(dot(a, cross(b, c)),
                                la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    const auto& m = part.local_to_build.m;
    const double turn =
        dot(cross(Vec3d{m[0], m[3], m[6]}, Vec3d{m[1], m[4], m[7]}), Vec3d{m[2], m[5], m[8]}) < 0
            ? -1
            : 1;
    return turn * angle > 2 * M_PI ? -d : d;
}

/// Points for 2 blocks: centres, points near them, random points and non-finite ones.
struct Batch {
    std::vector<int32_t> corners;
    std::vector<uint8_t> owned;
    std::vector<uint32_t> values;
    std::vector<int32_t> groups;
    std::vector<Vec3f> centres;

    Batch(const PlacedPart& part, const nearest::Winding& winding, uint32_t seed)
        : owned(128), values(kStates * 1024, 77) {
        std::mt19937 random(seed);
        const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f - 0.5f; };
        const Vec3i middle = (part.box.lo + part.box.hi);
        for (int b = 0; b < 2; ++b) {
            for (int a = 0; a < 3; ++a)
                corners.push_back(middle[a] / 2 - part.base[a] + static_cast<int>(random() % 40) -
                                  20);
        }
        // Owned are voxels that are inside, as in a print.
        for (size_t v = 0; v < 1024; ++v) {
            const size_t at = v % 512;
            Vec3f index{
                static_cast<float>(corners[v / 512 * 3] + static_cast<int>(at / 8 % 8)) + 0.5f,
                static_cast<float>(corners[v / 512 * 3 + 1] + static_cast<int>(at / 64)) + 0.5f,
                static_cast<float>(corners[v / 512 * 3 + 2] + static_cast<int>(at % 8)) + 0.5f};
            Vec3f c;
            for (int a = 0; a < 3; ++a) {
                const auto f = [&](int base) { return part.frame[static_cast<size_t>(base + a)]; };
                c[a] = ((index.x * f(OPENFAB_FRAME_STEP_I) + index.y * f(OPENFAB_FRAME_STEP_J)) +
                        index.z * f(OPENFAB_FRAME_STEP_K)) +
                       f(OPENFAB_FRAME_ORIGIN);
            }
            centres.push_back(c);
            if (winding.number(c) > 0) owned[v / 8] |= static_cast<uint8_t>(1u << (v % 8));
            Vec3f p = c;
            const uint32_t what = random() % 8;
            if (what >= 2)
                p = c + Vec3f{uniform(), uniform(), uniform()} * (what < 5 ? 0.3f : 12.0f);
            if (what == 1 && v % 5 == 0) p.y = std::numeric_limits<float>::infinity();
            values[kGuard * 1024 + v] = random() % 7 != 0 ? 1 : 0;
            for (int a = 0; a < 3; ++a)
                values[static_cast<size_t>(kPoint + a) * 1024 + v] = std::bit_cast<uint32_t>(p[a]);
        }
        for (int32_t g = 0; g < 128; ++g) {
            if (g % 9 != 4) groups.push_back(g);
        }
    }
    float at(int32_t state, size_t v) const {
        return std::bit_cast<float>(values[static_cast<size_t>(state) * 1024 + v]);
    }
    Vec3f point(int32_t state, size_t v) const {
        return {at(state, v), at(state + 1, v), at(state + 2, v)};
    }
    bool asked(size_t v) const { return values[v] != 0 && (owned[v / 8] >> (v % 8) & 1) != 0; }
};

void expect_own(const Scene& scene, const nearest::Engine& brute, const Batch& batch, size_t v) {
    const Vec3f p = batch.point(kPoint, v);
    nearest::PointPacket group;
    for (size_t a = 0; a < 3; ++a)
        group.p[a][0] = p[static_cast<int>(a)];
    group.mask = 1;
    nearest::PointAnswer answer;
    const auto scratch = brute.make_scratch();
    brute.query_points({&group, 1}, std::numeric_limits<float>::infinity(), scratch.get(), &answer);
    if (answer.item[0] < 0) {
        EXPECT_EQ(batch.at(kDistance, v), std::numeric_limits<float>::infinity());
        EXPECT_EQ(batch.at(kPosition, v), 0.0f);
        EXPECT_EQ(batch.at(kUv, v), 0.0f);
        return;
    }
    const bool inside = p == batch.centres[v] || scene.winding->number(p) > 0;
    const float d = std::sqrt(answer.distance2[0]);
    ASSERT_EQ(batch.at(kDistance, v), inside ? -d : d) << "voxel " << v;
    const auto mesh = scene.surfaces[0]->micro(answer.item[0]);
    const auto& corners = mesh->triangles[answer.in_patch.triangle[0]];
    const auto corner = [&](size_t k) { return static_cast<size_t>(corners[k]); };
    const Vec3f v0 = mesh->positions[corner(0)], v1 = mesh->positions[corner(1)],
                v2 = mesh->positions[corner(2)];
    const Vec3f at =
        v0 + (v1 - v0) * answer.in_patch.bary1[0] + (v2 - v0) * answer.in_patch.bary2[0];
    EXPECT_LT(length(batch.point(kPosition, v) - at), 1e-5f);
    EXPECT_NEAR(length(batch.point(kPosition, v) - p), d, 1e-4f);
    const Vec3d n = cross(vec_cast<double>(v1 - v0), vec_cast<double>(v2 - v0));
    if (length(n) > 1e-6) {
        EXPECT_GT(dot(vec_cast<double>(batch.point(kNormal, v)), n * (1 / length(n))), 0.9999);
    }
    // Components of the float inputs: uv.x, uv.y, height.
    for (size_t c = 0; c < 2; ++c) {
        const auto value = [&](size_t k) { return mesh->vertex_attributes[corner(k) * 3 + c]; };
        const float want = (value(0) + answer.in_patch.bary1[0] * (value(1) - value(0))) +
                           answer.in_patch.bary2[0] * (value(2) - value(0));
        EXPECT_EQ(batch.at(kUv + static_cast<int32_t>(c), v), want);
    }
    // The int inputs: face, zone.
    EXPECT_EQ(batch.values[kZone * 1024 + v],
              mesh->triangle_attributes[static_cast<size_t>(answer.in_patch.triangle[0]) * 2 + 1]);
}

void check(Scene* scene, const std::vector<int32_t>& targets, uint32_t seed) {
    scene->parts[0].objects = {targets};
    scene->set_up();
    const PlacedPart& part = *scene->print[0];
    const auto brute = reference::make_brute_force_engine(*scene->surfaces[0], part.frame);
    std::vector<std::vector<Triangle>> theirs(scene->parts.size());
    for (const int32_t t : targets) {
        theirs[t] = testing::triangles_of(*scene->surfaces[t], surface::kForQuery);
    }
    PointQueries queries(scene->print.size());
    int own = 0, near = 0;
    for (uint32_t round = 0; round < 3; ++round) {
        Batch batch(part, *scene->winding, seed + round);
        const segments::States states(batch.values.data(), 1024);
        queries.begin(part, batch.corners.data(), batch.owned.data(), OPENFAB_ISA_AVX2);
        ASSERT_TRUE(queries.answer(kQueries[0], batch.groups, states).ok());
        ASSERT_TRUE(queries.answer(kQueries[1], batch.groups, states).ok());
        for (size_t v = 0; v < 1024; ++v) {
            if (v / 8 % 9 == 4) {
                ASSERT_EQ(batch.values[kDistance * 1024 + v], 77u) << "a group that was not listed";
                continue;
            }
            if (!batch.asked(v)) {
                for (int32_t s = kDistance; s < kStates; ++s)
                    ASSERT_EQ(batch.values[static_cast<size_t>(s) * 1024 + v], 0u);
                continue;
            }
            ++own;
            expect_own(*scene, *brute, batch, v);
            if (::testing::Test::HasFatalFailure()) return;
            const Vec3d p =
                part.part->local_to_build.apply(vec_cast<double>(batch.point(kPoint, v)));
            if (!std::isfinite(p.x + p.y + p.z)) {
                EXPECT_EQ(batch.at(kToObject, v), std::numeric_limits<float>::infinity());
                continue;
            }
            if (v % 4 != 0) continue;
            double want = 1e300;
            for (const int32_t t : targets) {
                const auto at = static_cast<size_t>(t);
                want = std::min(want, plain_distance(scene->parts[at], theirs[at], p));
            }
            const double got = static_cast<double>(batch.at(kToObject, v));
            ASSERT_NEAR(std::fabs(got), std::fabs(want), 1e-4 + 1e-5 * std::fabs(want));
            if (std::fabs(want) > 1e-3) {
                ASSERT_EQ(got < 0, want < 0) << want;
            }
            near += want < 0 ? 1 : 0;
        }
    }
    EXPECT_GT(own, 100);
    EXPECT_GT(near, 10);
    EXPECT_GT(queries.counts().queried, 0);
}

TEST(PointQueries, DisplacedPartAsksRotatedAndScaledOnes) {
    Scene scene;
    scene.add(asking_fablet(), testing::sphere(5, 24, 12),
              placement_transform({1, 1, 1}, {20, -35, 60}, {3, 2, 1}), HandMode::kBumps, 0.6f);
    scene.add(testing::hand_fablet(true), testing::torus(3, 1.2),
              placement_transform({1.5, 0.7, 1.2}, {75, 10, 5}, {4, 4, 3}), HandMode::kBumps, 0.3f);
    scene.add(testing::hand_fablet(true), testing::torus(3, 1.2),
              placement_transform({1.5, 0.7, 1.2}, {0, 80, 35}, {-1, 0, 2}), HandMode::kBumps,
              0.3f);
    check(&scene, {1, 2}, 1);
}

TEST(PointQueries, MirroredAndItself) {
    Scene scene;
    scene.add(asking_fablet(), testing::cube(6),
              placement_transform({-1, 1, 1}, {15, 25, -40}, {0, 0, 0}), HandMode::kBack, 0.5f);
    scene.add(testing::hand_fablet(true), testing::sphere(4),
              placement_transform({1, -1.4, 0.8}, {45, 5, 10}, {-4, 5, 2}), HandMode::kStill, 0.0f);
    check(&scene, {0, 1}, 7);
}

TEST(PointOrder, FullPacketsOfNeighboursAndAnswersWhereTheyBelong) {
    std::mt19937 random(5);
    std::vector<nearest::PointPacket> points(300);
    size_t active = 0;
    for (nearest::PointPacket& packet : points) {
        for (auto& coordinates : packet.p) {
            for (float& x : coordinates)
                x = static_cast<float>(random() >> 8) * 0x1p-24f * 10;
        }
        packet.mask = random() & 0xffu;
        active += static_cast<size_t>(std::popcount(packet.mask));
    }
    points[7].p[1][3] = std::numeric_limits<float>::quiet_NaN();
    points[9].p[0][2] = -std::numeric_limits<float>::infinity();
    EXPECT_TRUE(PointOrder::scattered(points, 1));
    PointOrder order;
    const auto gathered = order.gather(points);
    ASSERT_EQ(gathered.size(), (active + 7) / 8);
    double extent = 0;
    std::vector<nearest::PointAnswer> answers(gathered.size()), back(points.size());
    for (size_t k = 0; k < gathered.size(); ++k) {
        const auto& p = gathered[k].p;
        if (k + 1 < gathered.size()) {
            EXPECT_EQ(gathered[k].mask, 0xffu);
        }
        const auto [low, high] = std::minmax_element(p[0], p[0] + 8);
        extent += std::isfinite(*high - *low) ? *high - *low : 0;
        for (size_t l = 0; l < 8; ++l) {
            answers[k].distance2[l] = p[0][l];
            answers[k].in_patch.bary1[l] = p[1][l];
            answers[k].in_patch.bary2[l] = p[2][l];
            answers[k].item[l] = static_cast<int32_t>(k);
            answers[k].in_patch.triangle[l] = static_cast<int32_t>(l);
        }
    }
    EXPECT_LT(extent / static_cast<double>(gathered.size()), 3);  // of 10, at random 7.8
    order.scatter(answers, back);
    const auto bits = [](float x) { return std::bit_cast<uint32_t>(x); };
    for (size_t k = 0; k < points.size(); ++k) {
        for (size_t l = 0; l < 8; ++l) {
            if ((points[k].mask >> l & 1u) == 0) {
                EXPECT_EQ(back[k].distance2[l], std::numeric_limits<float>::infinity());
                EXPECT_EQ(back[k].item[l], -1);
                continue;
            }
            EXPECT_EQ(bits(back[k].distance2[l]), bits(points[k].p[0][l]));
            EXPECT_EQ(bits(back[k].in_patch.bary1[l]), bits(points[k].p[1][l]));
            EXPECT_EQ(bits(back[k].in_patch.bary2[l]), bits(points[k].p[2][l]));
        }
    }
}

TEST(PointOrder, NeighboursStayAsTheyAre) {
    std::vector<nearest::PointPacket> points(8);
    for (size_t k = 0; k < 64; ++k)
        points[k / 8].p[2][k % 8] = 0.03f * static_cast<float>(k);
    EXPECT_FALSE(PointOrder::scattered(points, 0.5f));
    // Idle lanes are worth to be filled.
    for (nearest::PointPacket& packet : points)
        packet.mask = 0x11;
    EXPECT_TRUE(PointOrder::scattered(points, 0.5f));
}

}  // namespace
}  // namespace openfab::volume
