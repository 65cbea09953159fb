// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Contact, thickness and modes against closed forms.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>

#include "backends/ofr/ofr_reader.h"
#include "mechanics/correct/need_field.h"
#include "mechanics/part/shown.h"
#include "mechanics/stand/contact.h"
#include "mechanics/stand/growing.h"
#include "mechanics/stand/modes.h"
#include "mechanics/stand/push.h"
#include "mechanics/stand/thickness.h"

namespace openfab::mechanics {
namespace {

Voxels solid(std::array<int32_t, 3> size, double pitch,
             const std::function<bool(const Vec3&)>& of) {
    Voxels v;
    v.size = size;
    v.pitch_mm = {pitch, pitch, pitch};
    v.materials = {"stuff"};
    Material m;
    m.young_MPa = 1000;
    m.poisson = 0;
    for (int32_t z = 0; z < size[2]; ++z)
        for (int32_t y = 0; y < size[1]; ++y)
            for (int32_t x = 0; x < size[0]; ++x) {
                const bool in = of({(x + 0.5) * pitch, (y + 0.5) * pitch, (z + 0.5) * pitch});
                v.solid.push_back(in ? 1 : 0);
                v.lambda.push_back(in ? static_cast<float>(m.lambda()) : 0.F);
                v.mu.push_back(in ? static_cast<float>(m.mu()) : 0.F);
                v.density.push_back(in ? 1.F : 0.F);
                v.strength.push_back(10);
                v.code.push_back(in ? 1 : 0);
            }
    return v;
}

struct Looked {
    Grid grid;
    Voxels voxels;
    PartElements elements;
};
Looked looked(Voxels v) {
    Looked out;
    out.grid = Grid::make(v.size, v.pitch_mm, false);
    out.elements = classify(out.grid, &v);
    out.voxels = std::move(v);
    return out;
}

TEST(MechanicsStand, AColumnTiltsByItsHalfWidthOverItsHalfHeight) {
    const Looked l = looked(solid({8, 12, 40}, 0.5, [](const Vec3&) { return true; }));
    const Stand s = stand_of(l.grid, l.voxels, l.elements, true);
    EXPECT_NEAR(s.mass_g, 4 * 6 * 20 / 1000.0, 1e-9);
    EXPECT_NEAR(s.centre_mm[2], 10, 1e-9);
    EXPECT_NEAR(s.margin_deg, std::atan2(2, 10) * 180 / std::numbers::pi, 1e-9);
    EXPECT_EQ(s.hull_mm.size(), 4U);
    EXPECT_NEAR(s.contact_mm2, 24, 1e-9);
    EXPECT_NEAR(std::abs(s.foot.towards[0]), 1, 1e-12);
}

TEST(MechanicsStand, AnArmThatReachesTooFarFalls) {
    // A foot of 2 mm, an arm of 12 mm above it.
    const Looked l =
        looked(solid({24, 4, 8}, 0.5, [](const Vec3& p) { return p[0] < 2 || p[2] > 2; }));
    const Stand s = stand_of(l.grid, l.voxels, l.elements, true);
    EXPECT_LT(s.margin_deg, 0);
    EXPECT_NEAR(s.foot.towards[0], 1, 1e-12);
    // By hand: foot 2 x 2 at 1, arm 12 x 2 at 6.
    const double x = (4 * 1 + 24 * 6) / 28.0, z = (4 * 1 + 24 * 3) / 28.0;
    EXPECT_NEAR(s.margin_deg, std::atan2(2 - x, z) * 180 / std::numbers::pi, 1e-9);
}

// A box beside a ball is no foot for it, though the hull of both has their centre of mass.
TEST(MechanicsStand, EachPieceStandsByItself) {
    const auto square = [](double a) { return a * a; };
    for (const bool rolls : {true, false}) {
        const Looked l = looked(solid({130, 60, 60}, 0.1, [&](const Vec3& p) {
            if (p[0] < 4) return p[1] < 4 && p[2] < 4;
            return rolls ? square(p[0] - 9) + square(p[1] - 3) + square(p[2] - 3) < 9 : p[0] > 8;
        }));
        FootLayers layers;
        layers.size = {130, 60, kFootLayers};
        layers.pitch_mm = l.voxels.pitch_mm;
        layers.origin_mm = l.voxels.origin_mm;
        const size_t below = size_t{130} * 60 * kFootLayers;
        for (size_t e = 0; e < below; ++e)
            layers.inside.push_back(l.voxels.solid[e] > 0 ? 1 : 0);
        Stand s = stand_of(l.grid, l.voxels, l.elements, true);
        EXPECT_TRUE(s.stands());
        s.contact_mm2 = 0;  // of elements, until here
        s.look_at_pieces(l.grid, l.voxels, l.elements, true, layers);
        EXPECT_EQ(s.pieces, 2U);
        EXPECT_EQ(s.stands(), !rolls);
        // Of both, by their voxels: the ball is cut at half a voxel.
        EXPECT_NEAR(s.contact_mm2, rolls ? 16 + 3.14159 * (9 - 2.95 * 2.95) : 46,
                    rolls ? 0.1 : 1e-9);
        EXPECT_NEAR(s.of_piece_mm[0], rolls ? 9 : 10.5, 0.01);
        if (rolls) {
            EXPECT_NEAR(s.foot.round_mm, 3, 0.3);
        } else {
            EXPECT_NEAR(s.margin_deg, std::atan2(2.5, 3) * 180 / std::numbers::pi, 0.01);
        }
    }
}

// A ball rolls, a tip and an edge fall over, whatever the staircase of their voxels says; what is flat, or round
// but heavy below, stands.
TEST(MechanicsStand, AStaircaseOfVoxelsIsNoFoot) {
    const auto stands = [](std::array<int32_t, 3> size,
                           const std::function<bool(const Vec3&)>& of) {
        const Looked l = looked(solid(size, 0.5, of));
        const Stand s = stand_of(l.grid, l.voxels, l.elements, true);
        EXPECT_GE(s.margin_deg, 0);
        return std::pair(s.stands(), s.foot.round_mm);
    };
    const auto square = [](double a) { return a * a; };
    for (const int32_t n : {20, 41, 80}) {
        const double r = n / 4.0;
        const auto ball = [&](const Vec3& p) {
            return square(p[0] - r) + square(p[1] - r) + square(p[2] - r) < r * r;
        };
        const auto [stand, round] = stands({n, n, n}, ball);
        EXPECT_FALSE(stand) << n;
        EXPECT_NEAR(round / r, 1, 0.25) << n;
        // A bowl's half, and the ball cut flat below.
        EXPECT_TRUE(stands({n, n, n}, [&](const Vec3& p) { return ball(p) && p[2] < r; }).first)
            << n;
        EXPECT_TRUE(
            stands({n, n, n}, [&](const Vec3& p) { return ball(p) && p[2] > 0.2 * r; }).first)
            << n;
        // A cylinder that lies.
        EXPECT_FALSE(
            stands({n, n, n},
                   [&](const Vec3& p) { return square(p[0] - r) + square(p[2] - r) < r * r; })
                .first)
            << n;
        // A cone on its tip, and on its base.
        EXPECT_FALSE(
            stands({n, n, n},
                   [&](const Vec3& p) { return std::hypot(p[0] - r, p[1] - r) < p[2] / 2; })
                .first)
            << n;
        const auto [cone, of_cone] = stands({n, n, n}, [&](const Vec3& p) {
            return std::hypot(p[0] - r, p[1] - r) < r - p[2] / 2;
        });
        EXPECT_TRUE(cone) << n;
        EXPECT_EQ(of_cone, 0) << n;
        // A plate on a low foot, and a box with an edge cut off below.
        EXPECT_TRUE(stands({n, n, n},
                           [&](const Vec3& p) { return p[2] > 0.5 || std::abs(p[0] - r) < r / 2; })
                        .first)
            << n;
        EXPECT_TRUE(stands({n, n, n}, [&](const Vec3& p) { return p[0] + p[2] > 0.4 * r; }).first)
            << n;
    }
}

TEST(MechanicsStand, HullLeavesOutWhatLiesOnEdges) {
    const auto hull = convex_hull({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 1}, {0, 2}, {0, 1}, {2, 2}});
    EXPECT_EQ(hull, (std::vector<std::array<double, 2>>{{0, 0}, {2, 0}, {2, 2}, {0, 2}}));
}

TEST(MechanicsThickness, OfWallsOfOddAndEvenNumbers) {
    for (const int32_t wall : {1, 2, 3, 4, 5, 6}) {
        // A block of 12 with a wall on top.
        const Looked l = looked(solid({16, 16, 24}, 0.5, [&](const Vec3& p) {
            return p[2] < 6 || (p[1] > 4 && p[1] < 4 + 0.5 * wall);
        }));
        const std::vector<ThinPlace> thin = thinnest(l.grid, l.voxels, l.elements.kind, 3);
        ASSERT_FALSE(thin.empty());
        EXPECT_NEAR(thin[0].thickness_mm, 0.5 * wall, 1e-5) << wall;
        EXPECT_GT(thin[0].at_mm[2], 5.5);
    }
}

TEST(MechanicsThickness, DepthIsThatOfBruteForce) {
    const Looked l = looked(solid({9, 11, 10}, 1, [](const Vec3& p) {
        return std::fmod(p[0] * 3.7 + p[1] * 1.3 + p[2] * 2.1, 5.0) > 0.9;
    }));
    const std::vector<float> depth = squared_depth(l.grid, l.elements.kind);
    for (int64_t e = 0; e < l.grid.element_count(); ++e) {
        const auto p = place_of(l.grid, e);
        double least = 1e9;
        for (int32_t z = -1; z <= 10; ++z)
            for (int32_t y = -1; y <= 11; ++y)
                for (int32_t x = -1; x <= 9; ++x) {
                    const bool inside = x >= 0 && y >= 0 && z >= 0 && x < 9 && y < 11 && z < 10;
                    if (inside && l.elements.kind[l.grid.element(x, y, z)] == kSolid) continue;
                    const double dx = x - p[0], dy = y - p[1], dz = z - p[2];
                    least = std::min(least, dx * dx + dy * dy + dz * dz);
                }
        ASSERT_NEAR(depth[static_cast<size_t>(e)], least, 1e-6);
    }
}

TEST(MechanicsModes, ACantileverHumsAsTimoshenkoSays) {
    // 24 x 2 x 3 mm, held at its lower end.
    LoadCase held;
    held.held.emplace_back();
    held.held[0].faces.side = 4;
    Result<PartProblem> p =
        set_up_part(solid({4, 6, 48}, 0.5, [](const Vec3&) { return true; }), held, {}, {});
    ASSERT_TRUE(p) << p.error().text();
    ModeOptions options;
    options.count = 3;
    const Modes modes = softest_modes(&*p, options);
    ASSERT_TRUE(modes.converged);
    ASSERT_EQ(modes.all.size(), 3U);
    // Euler and Bernoulli: 1.8751^2 / (2 pi L^2) sqrt(E I / (rho A)); E 1e9 Pa, 1000 kg/m3.
    const auto hz = [](double thickness_m) {
        const double length = 0.024;
        return 1.8751 * 1.8751 / (2 * std::numbers::pi * length * length) *
               std::sqrt(1e9 * thickness_m * thickness_m / 12 / 1000);
    };
    // Elements lock a little in bending, shear softens a little.
    EXPECT_NEAR(modes.all[0].frequency_Hz / hz(0.002), 1, 0.05);
    EXPECT_NEAR(modes.all[1].frequency_Hz / hz(0.003), 1, 0.05);
    EXPECT_NEAR(std::abs(modes.all[0].moved[0]), 1, 1e-2);
    EXPECT_NEAR(std::abs(modes.all[1].moved[1]), 1, 1e-2);
    EXPECT_GT(modes.all[0].moved_at_mm[2], 23);
    EXPECT_LT(modes.all[0].strained_at_mm[2], 2);
    for (const Mode& m : modes.all)
        EXPECT_LT(m.residual, 0.1);
    // What was taken for the time is there again.
    EXPECT_NEAR(p->voxels.mu[0], 500, 1e-3);
}

TEST(MechanicsPush, BendsACantileverAsALeverDoes) {
    // 24 x 2 x 3 mm, held below: its softest mode bends it along x.
    LoadCase held;
    held.held.emplace_back();
    held.held[0].faces.side = 4;
    Result<PartProblem> p =
        set_up_part(solid({4, 6, 48}, 0.5, [](const Vec3&) { return true; }), held, {}, {});
    ASSERT_TRUE(p) << p.error().text();
    ModeOptions options;
    options.count = 1;
    const Modes modes = softest_modes(&*p, options);
    ASSERT_EQ(modes.all.size(), 1U);
    const Push push = worst_push(&*p, modes.all[0], {});
    ASSERT_TRUE(push.converged);
    EXPECT_NEAR(std::abs(push.along[0]), 1, 1e-12);
    EXPECT_GT(push.at_mm[2], 23);
    // F L x / I at the surface.
    const double lever = push.at_mm[2] - modes.all[0].strained_at_mm[2];
    EXPECT_NEAR(push.MPa_of_N / (lever / (3 * 2 * 2 * 2 / 12.0)), 1, 0.05);
    EXPECT_NEAR(push.breaks_at_N, 10 / push.MPa_of_N, 1e-9);
    // And so says the part that is pushed there.
    LoadCase pushed = held;
    pushed.loads.emplace_back();
    pushed.loads[0].faces.box_mm = {{{-1, push.at_mm[1] - 0.1, push.at_mm[2] - 0.1},
                                     {3, push.at_mm[1] + 0.1, push.at_mm[2] + 0.1}}};
    pushed.loads[0].faces.facing = push.along[0] < 0 ? 1 : 0;
    pushed.loads[0].force_N = push.along;
    Result<PartProblem> q =
        set_up_part(solid({4, 6, 48}, 0.5, [](const Vec3&) { return true; }), pushed, {}, {});
    ASSERT_TRUE(q) << q.error().text();
    PartSolution solution = solve_part(&*q, 1, {});
    const PartFields fields = fields_of(*q, &solution.moved_mm);
    EXPECT_NEAR(
        static_cast<double>(fields.von_mises_MPa[static_cast<size_t>(modes.all[0].strained)]) /
            push.MPa_of_N,
        1, 0.03);
}

TEST(MechanicsGrowing, WhatBeginsInTheAirIsFound) {
    // A table of two legs, a lamp that hangs from its top, and a ledge that grows out of a leg.
    const Looked l = looked(solid({20, 8, 16}, 0.5, [](const Vec3& p) {
        if (p[2] > 6 && p[2] < 7) return true;
        if (p[0] < 2 || p[0] > 8) return p[2] < 7;
        if (p[0] > 4 && p[0] < 5 && p[1] > 1 && p[1] < 2) return p[2] > 4 && p[2] < 7;
        return p[0] < 3 && p[2] > 2 && p[2] < 3;
    }));
    const std::vector<AirPlace> air =
        begins_in_the_air(l.grid, l.voxels.origin_mm, l.elements.kind);
    ASSERT_EQ(air.size(), 1U);
    EXPECT_NEAR(air[0].at_mm[0], 4.5, 1e-9);
    EXPECT_NEAR(air[0].at_mm[1], 1.5, 1e-9);
    EXPECT_NEAR(air[0].at_mm[2], 4, 1e-9);
    EXPECT_NEAR(air[0].area_mm2, 1, 1e-9);
    // Up to 5 mm the lamp hangs free.
    Voxels some = lowest_layers(l.voxels, 10);
    EXPECT_EQ(some.count(), size_t{20 * 8 * 10});
    const Looked lower = looked(some);
    EXPECT_EQ(pieces_of(lower.grid, lower.elements.kind).all.size(), 3U);
}

TEST(MechanicsShown, BandsAreAPrintOfColours) {
    LoadCase pulled;
    pulled.name = "pull";
    pulled.held.emplace_back();
    pulled.held[0].faces.side = 0;
    pulled.loads.emplace_back();
    pulled.loads[0].faces.side = 1;
    pulled.loads[0].force_N = Vec3{2, 0, 0};
    Result<PartProblem> p =
        set_up_part(solid({8, 2, 2}, 1, [](const Vec3&) { return true; }), pulled, {}, {});
    ASSERT_TRUE(p) << p.error().text();
    PartSolution solution = solve_part(&*p, 1, {});
    const PartFields fields = fields_of(*p, &solution.moved_mm);
    const Shown shown = shown_of(*p, fields, solution.moved_mm, "displacement");
    // Stretched evenly: the middle of the last element by 7.5 of 8.
    EXPECT_NEAR(shown.most, 0.5 / 1000 * 7.5, 1e-5);
    EXPECT_EQ(shown.least, 0);
    const std::filesystem::path file =
        std::filesystem::path(::testing::TempDir()) / "mechanics_bands.ofr";
    ASSERT_TRUE(write_bands(file, p->grid, p->voxels.origin_mm, p->elements.kind, shown));
    auto reader = ofr::OfrReader::open(file.string());
    ASSERT_TRUE(reader) << reader.error().text();
    EXPECT_EQ((*reader)->info().materials.size(), 20U);
    EXPECT_EQ((*reader)->info().materials[0].name, "0 to 1.9e-04 mm");
    int slices = 0;
    for (;; ++slices) {
        const Result<bool> more = (*reader)->next();
        ASSERT_TRUE(more) << more.error().text();
        if (!*more) break;
        for (int32_t x = 0; x < 8; ++x)
            EXPECT_NEAR((*reader)->slice().code(x, 1, 8), 0.5 + (x + 0.5) / 7.5 * 20, 0.51);
    }
    EXPECT_EQ(slices, 2);
    EXPECT_EQ((*reader)->totals().voxels_solid, 32);
    std::filesystem::remove(file);
    const Shown safety = shown_of(*p, fields, solution.moved_mm, "safety");
    EXPECT_EQ(safety.most, 4);
    EXPECT_TRUE(safety.low_is_bad);
}

TEST(MechanicsNeed, GrowsWhereItIsWeakAndStopsAtItsLimit) {
    PartProblem p;
    p.grid = Grid::make({20, 5, 5}, {1, 1, 1}, false);
    PartFields f;
    f.safety.assign(500, 4);
    const size_t weak = p.grid.element(10, 2, 2);
    f.safety[weak] = 0.5;
    NeedField field{p.grid, {}, std::vector<float>(500)};
    NeedRule rule;
    rule.safety = 1;
    rule.reach_mm = 2;
    NeedStep step = grow(p, f, rule, &field);
    EXPECT_EQ(step.weak, 1);
    EXPECT_EQ(step.at_limit, 0);
    EXPECT_NEAR(field.value[weak], 0.25, 1e-6);
    EXPECT_EQ(field.value[p.grid.element(2, 2, 2)], 0);
    for (int i = 0; i < 5; ++i)
        step = grow(p, f, rule, &field);
    EXPECT_EQ(field.value[weak], 1);
    EXPECT_EQ(step.at_limit, 1);
    EXPECT_LE(*std::ranges::max_element(field.value), 1);
}

}  // namespace
}  // namespace openfab::mechanics
