// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Stresses at surfaces, what resolves them, and buckling, against closed forms.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanics/part/across.h"
#include "tests/unit/mechanics/loaded_box.h"

namespace openfab::mechanics {
namespace {

constexpr double kYoung = 2000;
constexpr const char* kBent =
    R"({"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": [0, 0, -0.5]}]})";

/// Of points, by eight of each element of 1 mm.
Voxels shape(std::array<int32_t, 3> size, double poisson,
             const std::function<bool(const Vec3&)>& inside) {
    return box_of(size, 1, poisson, [&](const Vec3& p) {
        int count = 0;
        for (int k = 0; k < 8; ++k)
            count += inside({p[0] + ((k & 1) - 0.5) / 2, p[1] + ((k >> 1 & 1) - 0.5) / 2,
                             p[2] + ((k >> 2) - 0.5) / 2})
                         ? 1
                         : 0;
        return std::pair(count / 8.0, kYoung);
    });
}
Voxels full(std::array<int32_t, 3> size, double poisson) {
    return shape(size, poisson, [](const Vec3&) { return true; });
}

struct Loaded {
    Solved solved;
    PartFields fields;
    PartSummary summary;
    uint8_t across(int32_t x, int32_t y, int32_t z) const {
        return solved.problem.across[solved.problem.grid.element(x, y, z)];
    }
};

Loaded loaded(Voxels voxels, const std::string& one_case) {
    PartOptions options;
    options.thin = true;
    Loaded out;
    out.solved = solved(std::move(voxels), parsed(one_case), 1e-7, options);
    out.fields = fields_of(out.solved.problem, &out.solved.solution.moved_mm);
    out.summary = summary_of(out.solved.problem, out.fields, out.solved.solution.moved_mm, 8);
    return out;
}

double worst_at(const Loaded& l, const std::function<bool(const std::array<int32_t, 3>&)>& where) {
    double most = 0;
    for (size_t e = 0; e < l.fields.von_mises_MPa.size(); ++e)
        if (where(place_of(l.solved.problem.grid, static_cast<int64_t>(e))))
            most = std::max(most, static_cast<double>(l.fields.von_mises_MPa[e]));
    return most;
}

// The stress of a bent strip and of a bent rod a third of the way along, over that of beams.
TEST(MechanicsStress, BendingIsGreatestAtTheSurface) {
    constexpr int32_t kLong = 60, kAt = 20;
    for (const auto& [thick, rod, off] : {std::tuple(2, false, 0.06),
                                          {3, false, 0.03},
                                          {4, false, 0.02},
                                          {8, false, 0.02},
                                          std::tuple(2, true, 0.06),
                                          {3, true, 0.02},
                                          {4, true, 0.02},
                                          {8, true, 0.02}})
        for (const double poisson : {0.0, 0.35}) {
            const int32_t wide = rod ? thick : 10;
            const Loaded l = loaded(full({kLong, wide, thick}, poisson), kBent);
            const double wanted =
                6 * 0.5 * (kLong - kAt - 0.5) / (wide * static_cast<double>(thick) * thick);
            EXPECT_NEAR(worst_at(l, [](const auto& p) { return p[0] == kAt; }) / wanted, 1, off)
                << thick << " " << rod << " " << poisson;
            EXPECT_EQ(l.across(kAt, 0, 0),
                      thick * kAcrossStep < kAcrossMost ? thick * kAcrossStep : kAcrossMost);
            EXPECT_EQ(verdict_of(l.summary), Verdict::kHolds);
        }
}

// A wall that ends within elements, in one direction or in all three: a force on its end strains it alike everywhere.
TEST(MechanicsStress, AForceOnTheEndOfAWallActsInItsMiddle) {
    for (const double part : {0.1, 0.25, 0.45, 0.5, 0.75, 0.9, 1.0})
        for (const double end : {0.3, 0.7, 1.0}) {
            const auto share = [&](double at, int32_t whole) {
                return std::clamp(at < whole ? 1.0 : part, 0.0, 1.0);
            };
            const Voxels v = box_of({24, 5, 4}, 1, 0, [&](const Vec3& p) {
                return std::pair((p[0] < 23 ? 1 : end) * share(p[1], 4) * share(p[2], 3), 2000.0);
            });
            const Loaded l = loaded(v, R"({"held": [{"side": "-x", "along": "x"},
                    {"side": "-y", "along": "y"}, {"side": "-z", "along": "z"}],
                    "loads": [{"side": "+x", "force_N": [100, 0, 0]}]})");
            const double wanted = 100 / ((4 + part) * (3 + part));
            for (const int32_t x : {8, 12, 16})
                EXPECT_NEAR(worst_at(l, [&](const auto& p) { return p[0] == x; }) / wanted, 1, 0.02)
                    << part << " " << end << " " << x;
        }
}

// As a print makes it: what is coarse holds only by half as much again.
TEST(MechanicsStress, WhatFourElementsDoNotLieAcrossHoldsWithAMargin) {
    // 6 P L / (b h^2) = 8.9 P at the middle of the first element; the strength is 100.
    for (const auto& [force, verdict] : {std::pair(0.5, Verdict::kHolds),
                                         {2.0, Verdict::kHolds},
                                         {8.0, Verdict::kCoarse},
                                         {20.0, Verdict::kBreaks}}) {
        const Loaded l = loaded(full({60, 10, 2}, 0.3), fmt::format(R"({{"held": [{{"side": "-x"}}],
                           "loads": [{{"side": "+x", "force_N": [0, 0, {}]}}]}})",
                                                                    -force));
        EXPECT_EQ(verdict_of(l.summary), verdict) << force << " " << l.summary.least_safety;
    }
}

TEST(MechanicsStress, WhatLessThanTwoElementsAreAcrossDoesNotHold) {
    for (const double thick : {0.6, 0.8, 1.0, 1.2, 1.5}) {
        const auto size = static_cast<int32_t>(std::ceil(thick));
        for (const bool rod : {false, true}) {
            const auto inside = [&](const Vec3& p) {
                return p[2] < thick && (!rod || p[1] < thick);
            };
            Voxels v = shape({60, rod ? size : 10, size}, 0.35, inside);
            const Result<PartProblem> refused = set_up_part(v, parsed(kBent), {}, {});
            ASSERT_FALSE(refused) << thick;
            // Of a rod of 0.6 no element is half full.
            if (rod && thick < 0.7) continue;
            const Loaded l = loaded(std::move(v), kBent);
            EXPECT_LT(l.across(20, 0, 0), kUnresolved) << thick;
            EXPECT_EQ(verdict_of(l.summary), Verdict::kUnresolved) << thick;
        }
    }
}

// Measured at each place, not of the whole: a block with a fin of one element, along each axis.
TEST(MechanicsStress, AThinWallOfAThickPartIsFound) {
    for (size_t axis = 0; axis < 3; ++axis) {
        const size_t out = (axis + 1) % 3;
        std::array<int32_t, 3> size{20, 20, 20};
        size[out] = 40;
        Voxels v = shape(size, 0.3, [&](const Vec3& p) {
            return p[out] < 20 || std::abs(p[axis] - 10.5) < 0.5;
        });
        const Result<PartProblem> p = set_up_part(
            std::move(v),
            parsed(fmt::format(
                R"({{"held": [{{"side": "-{0}"}}], "loads": [{{"side": "+{0}", "force_N": [1, 1, 1]}}]}})",
                "xyz"[out])),
            {}, {});
        ASSERT_TRUE(p) << p.error().text();
        ASSERT_EQ(p->notes.size(), 1U);
        std::array<int32_t, 3> fin{10, 10, 10}, block{10, 10, 10}, edge{0, 0, 0};
        fin[out] = 30;
        EXPECT_EQ(p->across[p->grid.element(fin[0], fin[1], fin[2])], kAcrossStep);
        EXPECT_EQ(p->across[p->grid.element(block[0], block[1], block[2])], kAcrossMost);
        EXPECT_EQ(p->across[p->grid.element(edge[0], edge[1], edge[2])], kAcrossMost);
    }
    // A stiff wall of one element in a soft block.
    Voxels v = box_of({20, 20, 20}, 1, 0.3, [](const Vec3& p) {
        return std::pair(1.0, std::abs(p[2] - 10.5) < 0.5 ? 2000.0 : 1.0);
    });
    const Result<PartProblem> p = set_up_part(std::move(v), parsed(kBent), {}, {});
    ASSERT_TRUE(p) << p.error().text();
    EXPECT_EQ(p->across[p->grid.element(10, 10, 10)], kAcrossStep);
    EXPECT_EQ(p->across[p->grid.element(10, 10, 5)], kAcrossMost);
}

// A plate that is turned by 45 degrees is as thick as it is; its edges do not count as thin.
TEST(MechanicsStress, ThicknessIsMeasuredAcrossObliqueWalls) {
    for (const double thick : {1.0, 3.0, 12.0}) {
        Voxels v = shape({60, 10, 60}, 0.3, [&](const Vec3& p) {
            return std::abs(p[0] - p[2]) < thick / std::numbers::sqrt2;
        });
        const Grid g = Grid::make(v.size, v.pitch_mm, false);
        const PartElements elements = classify(g, &v);
        const std::vector<uint8_t> across = elements_across(g, v, elements.kind, false);
        for (int32_t z = 15; z < 45; ++z)
            for (int32_t x = 15; x < 45; ++x) {
                const uint8_t a = across[g.element(x, 5, z)];
                if (a == 0) continue;
                EXPECT_NEAR(static_cast<double>(a) / kAcrossStep, std::min(thick, 4.0), 0.75)
                    << thick << " " << x << " " << z;
            }
    }
}

// A strip between one and two elements thick is that thick up to its edges and corners, however narrow, and taken.
TEST(MechanicsStress, AStripIsAsThickAtItsEdges) {
    for (const double thick : {1.6, 1.75, 1.9, 2.9})
        for (const int32_t wide : {4, 10, 40}) {
            const auto layers = static_cast<int32_t>(std::ceil(thick));
            Voxels v = box_of({60, wide, layers}, 1, 0.3, [&](const Vec3& p) {
                return std::pair(std::clamp(thick - std::floor(p[2]), 0.0, 1.0), kYoung);
            });
            const Result<PartProblem> p = set_up_part(std::move(v), parsed(kBent), {}, {});
            ASSERT_TRUE(p) << thick << " " << wide << ": " << p.error().text();
            for (const uint8_t across : p->across)
                EXPECT_NEAR(across, thick * kAcrossStep, 1) << thick << " " << wide;
        }
}

TEST(MechanicsStress, TorsionIsGreatestInTheMiddleOfSides) {
    // Saint-Venant's square shaft: T / (0.208 a^3).
    for (const auto& [n, off] : {std::pair(4, 0.1), {8, 0.03}, {12, 0.02}}) {
        const Loaded l = loaded(full({n, n, 6 * n}, 0.3),
                                R"({"held": [{"side": "-z"}],
                                    "loads": [{"side": "+z", "torque_Nmm": [0, 0, 50]}]})");
        const double wanted = std::sqrt(3.0) * 50 / (0.208 * n * n * n);
        EXPECT_NEAR(worst_at(l, [n = n](const auto& p) { return p[2] == 3 * n; }) / wanted, 1, off)
            << n;
    }
}

// A quarter of a plate that is pulled; Heywood's factor of the net section.
TEST(MechanicsStress, AHoleTriplesIt) {
    for (const auto& [radius, off] : {std::pair(8, 0.1), {16, 0.04}}) {
        const int32_t half = 5 * radius;
        const double hole = radius;
        const Loaded l =
            loaded(shape({2 * half, half, 2}, 0.3,
                         [&](const Vec3& p) { return p[0] * p[0] + p[1] * p[1] > hole * hole; }),
                   R"({"held": [{"point_mm": [0, 0, 0], "normal": [-1, 0, 0], "along": "x"},
                         {"point_mm": [0, 0, 0], "normal": [0, -1, 0], "along": "y"},
                         {"side": "-z", "along": "z"}],
                "loads": [{"side": "+x", "pressure_MPa": -1}]})");
        const double part = hole / half, wanted = (2 + std::pow(1 - part, 3)) / (1 - part);
        EXPECT_NEAR(l.summary.most_von_mises_MPa / wanted, 1, off) << radius;
    }
}

// A quarter of a thick cylinder under pressure, in plane strain: Lame.
TEST(MechanicsStress, AThickCylinderIsLames) {
    constexpr int32_t a = 12, b = 24;
    const Loaded l =
        loaded(shape({b, b, 2}, 0.3,
                     [](const Vec3& p) {
                         const double square = p[0] * p[0] + p[1] * p[1];
                         return square > a * a && square < b * b;
                     }),
               R"({"held": [{"point_mm": [0, 0, 0], "normal": [-1, 0, 0], "along": "x"},
                     {"point_mm": [0, 0, 0], "normal": [0, -1, 0], "along": "y"},
                     {"side": "-z", "along": "z"}, {"side": "+z", "along": "z"}],
            "loads": [{"box_mm": [[0.1, 0.1, -1], [12.4, 12.4, 3]], "pressure_MPa": 1}]})");
    constexpr double k = static_cast<double>(a * a) / (b * b - a * a);
    const double radial = -1, hoop = k * (1 + static_cast<double>(b * b) / (a * a)),
                 axial = 0.3 * (radial + hoop);
    const double wanted = von_mises_of({radial, hoop, axial, 0, 0, 0});
    // Its inner surface is a staircase, whose corners add some.
    EXPECT_NEAR(l.summary.most_von_mises_MPa / wanted, 1.05, 0.15);
}

// A stress does not leak from a stiff layer into a soft one: of two, pulled together, each has its own.
TEST(MechanicsStress, MaterialsAreNotAveraged) {
    Voxels v = box_of({20, 8, 8}, 1, 0,
                      [](const Vec3& p) { return std::pair(1.0, p[2] < 4 ? 100.0 : 1000.0); });
    for (size_t e = 0; e < v.code.size(); ++e)
        v.code[e] = v.mu[e] > 100 ? 2 : 1;
    v.materials = {"soft", "stiff"};
    const Loaded l = loaded(std::move(v), R"({"held": [{"side": "-x", "along": "x"},
        {"side": "-y", "along": "y"}, {"side": "-z", "along": "z"}, {"side": "+x", "move_mm": [0.2, 0, 0], "along": "x"}]})");
    for (int32_t z = 0; z < 8; ++z)
        EXPECT_NEAR(worst_at(l, [z](const auto& p) { return p[2] == z; }), z < 4 ? 1 : 10, 1e-3);
}

double buckling_factor(Loaded* l) {
    SolveOptions options;
    const Buckling b = buckling_of(&l->solved.problem, &l->solved.solution.moved_mm, 1e4, options);
    EXPECT_TRUE(b.converged);
    return b.factor;
}

TEST(MechanicsBuckling, ColumnsAreEulers) {
    constexpr double kPi = std::numbers::pi;
    for (const auto& [thick, wide, length, off] :
         {std::tuple(2, 2, 40, 0.05), {4, 4, 80, 0.02}, {2, 5, 60, 0.03}}) {
        const double inertia = wide * std::pow(thick, 3) / 12.0;
        const double euler = kPi * kPi * kYoung * inertia / (4.0 * length * length);
        Loaded l = loaded(full({length, wide, thick}, 0.3),
                          R"({"held": [{"side": "-x"}],
                              "loads": [{"side": "+x", "force_N": [-1, 0, 0]}]})");
        EXPECT_NEAR(buckling_factor(&l) / euler, 1, off) << thick << " " << wide;
        // Never above what is computed by more than thickness measured along axes may be off.
        EXPECT_LE(
            least_buckling_factor(l.solved.problem, l.fields, &l.solved.solution.moved_mm, false),
            1.1 * euler);
    }
    // Clamped at both ends, pushed together.
    Loaded l = loaded(full({120, 4, 4}, 0), R"({"held": [{"side": "-x"},
        {"side": "+x", "move_mm": [-0.001, 0, 0]}]})");
    const double force = std::abs(l.solved.solution.reactions_N[0][0]);
    const double euler = 4 * kPi * kPi * kYoung * (256.0 / 12) / (120.0 * 120);
    EXPECT_NEAR(buckling_factor(&l) * force / euler, 1, 0.02);
}

TEST(MechanicsBuckling, APlateHeldAtItsEdgesIsBryans) {
    // A quarter of it; k = 4 of a square that is held out of its plane alone.
    constexpr int32_t kHalf = 80, kThick = 4;
    Loaded l = loaded(full({kHalf, kHalf, kThick}, 0.3), R"({"held": [{"side": "-x", "along": "x"},
        {"side": "-y", "along": "y"}, {"side": "+x", "along": "z"}, {"side": "+y", "along": "z"}],
        "loads": [{"side": "+x", "pressure_MPa": 1}]})");
    const double wanted = 4 * std::numbers::pi * std::numbers::pi * kYoung / (12 * (1 - 0.09)) *
                          std::pow(kThick / (2.0 * kHalf), 2);
    EXPECT_NEAR(buckling_factor(&l) / wanted, 1, 0.07);
}

TEST(MechanicsBuckling, WhatIsPulledDoesNot) {
    Loaded l = loaded(full({40, 4, 4}, 0.3), R"({"held": [{"side": "-x"}],
        "loads": [{"side": "+x", "force_N": [1, 0, 0]}]})");
    EXPECT_EQ(buckling_factor(&l), 0);
    // Nor does it hold under 33 times the load of Euler's.
    const double euler = std::numbers::pi * std::numbers::pi * kYoung * (256.0 / 12) / (4 * 1600.0);
    Loaded pressed = loaded(full({40, 4, 4}, 0.3), fmt::format(R"({{"held": [{{"side": "-x"}}],
        "loads": [{{"side": "+x", "force_N": [{}, 0, 0]}}]}})",
                                                               -33 * euler));
    pressed.summary.least_safety = 1.5;
    pressed.summary.buckling = buckling_of(&pressed.solved.problem,
                                           &pressed.solved.solution.moved_mm, 1e4, SolveOptions());
    EXPECT_NEAR(pressed.summary.buckling->factor * 33, 1, 0.02);
    EXPECT_EQ(verdict_of(pressed.summary), Verdict::kBuckles);
}

// A rib on a block breaks at its root, whose stress is as coarse as the rib, not as fine as the block.
TEST(MechanicsStress, TheRootOfARibIsAsCoarseAsTheRib) {
    for (const int32_t thick : {1, 2, 3, 4, 5}) {
        const Loaded l =
            loaded(shape({16, 10, 16}, 0.3,
                         [&](const Vec3& p) { return p[2] < 6 || (p[0] > 6 && p[0] < 6 + thick); }),
                   R"({"held": [{"side": "-z"}],
                                    "loads": [{"side": "+z", "force_N": [1, 0, 0]}]})");
        const WeakPlace& root = l.summary.weakest.front();
        EXPECT_NEAR(root.at_mm[2], 6, 1.6) << thick;
        EXPECT_NEAR(root.across, std::min(thick, 4), 0.1) << thick;
        if (thick < 2) {
            EXPECT_GT(l.summary.least_safety_unresolved, 0);
            EXPECT_NE(verdict_of(l.summary), Verdict::kHolds);
        }
        if (thick == 2 || thick == 3) {
            EXPECT_LE(l.summary.least_safety_coarse, 0.63 * l.summary.least_safety) << thick;
        }
    }
}

// Of a round rod the elements that its surface goes through make it too stiff; what a verdict takes off is enough.
TEST(MechanicsBuckling, RoundColumnsAreNotTakenForStiffer) {
    constexpr double kPi = std::numbers::pi;
    for (const int32_t across : {3, 4, 6, 8}) {
        const double radius = across / 2.0;
        const int32_t length = 20 * across;
        const Voxels v = box_of({length, across, across}, 1, 0.3, [&](const Vec3& p) {
            constexpr int kParts = 16;
            int inside = 0;
            for (int k = 0; k < kParts * kParts; ++k) {
                const double y = p[1] - radius + (k % kParts + 0.5) / kParts - 0.5,
                             z = p[2] - radius + (k / kParts + 0.5) / kParts - 0.5;
                inside += y * y + z * z < radius * radius ? 1 : 0;
            }
            return std::pair(inside / double{kParts * kParts}, kYoung);
        });
        const double euler =
            kPi * kPi * kYoung * kPi * std::pow(radius, 4) / 4 / (4.0 * length * length);
        Loaded l = loaded(v, R"({"held": [{"side": "-x"}],
                              "loads": [{"side": "+x", "force_N": [-1, 0, 0]}]})");
        size_t where = 0;
        least_buckling_factor(l.solved.problem, l.fields, &l.solved.solution.moved_mm, false,
                              &where);
        const PartProblem& p = l.solved.problem;
        const double excess = cut_excess(p.grid, p.voxels, p.elements.kind, where);
        const double factor = buckling_factor(&l);
        // Not settled: more than Euler's, and not more by as much as is taken off.
        EXPECT_GT(factor / euler, 1.03) << across;
        EXPECT_LE(factor / euler, excess) << across;
        EXPECT_GE(factor / euler, 0.8 * excess) << across;
        // Bent at its end: 4 F L / (pi r^3).
        const Loaded bent = loaded(v, R"({"held": [{"side": "-x"}],
                              "loads": [{"side": "+x", "force_N": [0, 0, -0.1]}]})");
        const int32_t at = length / 3;
        const double wanted = 4 * 0.1 * (length - at - 0.5) / (kPi * std::pow(radius, 3));
        const double found = worst_at(bent, [&](const auto& q) { return q[0] == at; });
        EXPECT_LT(found / wanted, 0.99) << across;
        if (across >= 4) {
            EXPECT_GE(found / wanted * excess, 1) << across;
            EXPECT_LE(bent.summary.least_safety_cut * 1.05, bent.summary.least_safety) << across;
        }
    }
    // What is flat has nothing taken off.
    const Loaded flat = loaded(full({40, 4, 4}, 0.3), kBent);
    const PartProblem& p = flat.solved.problem;
    EXPECT_EQ(cut_excess(p.grid, p.voxels, p.elements.kind, p.grid.element(20, 0, 3)), 1);
    EXPECT_EQ(flat.summary.least_safety_cut, flat.summary.least_safety);
}

// A strut that is clamped at one end moves most at the other, across its axis, whatever is in the box around it.
TEST(MechanicsBuckling, TheFreeEndMovesMost) {
    constexpr int32_t kLength = 40, kBox = 10;
    constexpr double kRadius = 2;
    Loaded l = loaded(shape({kLength, kBox, kBox}, 0.3,
                            [](const Vec3& p) {
                                return std::hypot(p[1] - kBox / 2.0, p[2] - kBox / 2.0) < kRadius;
                            }),
                      R"({"held": [{"side": "-x"}],
                          "loads": [{"side": "+x", "force_N": [-1, 0, 0]}]})");
    const Buckling b =
        buckling_of(&l.solved.problem, &l.solved.solution.moved_mm, 1e4, SolveOptions());
    EXPECT_GT(b.factor, 0);
    EXPECT_EQ(b.moves_at_mm[0], kLength);
    // A corner of an element of the strut.
    EXPECT_LE(std::hypot(b.moves_at_mm[1] - kBox / 2.0, b.moves_at_mm[2] - kBox / 2.0),
              kRadius + std::numbers::sqrt2);
    EXPECT_LT(std::abs(b.moves[0]), 0.3);
}

// Elements that are long along what bends make it too stiff; what a verdict takes off is enough, and nothing of cubes.
TEST(MechanicsBuckling, LongElementsAreNotTakenForStiffer) {
    constexpr double kPi = std::numbers::pi;
    for (const auto& [across, wide, side] :
         {std::tuple(3, 1.0, 2.0), {4, 1.0, 2.0}, {8, 0.5, 2.0}, {4, 1.0, 1.0}}) {
        const double thick = across * wide, length = 20 * thick;
        Voxels v = full({static_cast<int32_t>(length / side), across, across}, 0.3);
        v.pitch_mm = {side, wide, wide};
        const double euler = kPi * kPi * kYoung * std::pow(thick, 4) / 12 / (4 * length * length);
        Loaded l = loaded(v, R"({"held": [{"side": "-x"}],
                              "loads": [{"side": "+x", "force_N": [-1, 0, 0]}]})");
        const PartProblem& p = l.solved.problem;
        const size_t middle = p.grid.element(p.grid.elements[0] / 2, 0, across - 1);
        const double excess = cut_excess(p.grid, p.voxels, p.elements.kind, middle);
        const double factor = buckling_factor(&l) / euler;
        EXPECT_LE(factor, 1.03 * excess) << across << " " << side;
        const Loaded bent = loaded(v, R"({"held": [{"side": "-x"}],
                              "loads": [{"side": "+x", "force_N": [0, 0, -0.1]}]})");
        const int32_t at = p.grid.elements[0] / 3;
        const double wanted = 6 * 0.1 * (length - (at + 0.5) * side) / std::pow(thick, 3);
        const double found = worst_at(bent, [&](const auto& q) { return q[0] == at; });
        EXPECT_GE(found / wanted * excess, 0.98) << across << " " << side;
        if (side > wide) {
            EXPECT_GT(factor, 1.04) << across;
            EXPECT_GE(factor, 0.85 * excess) << across;
        } else {
            EXPECT_EQ(excess, 1);
        }
    }
}

// In what is pulled, single voxels of a dithered mixture are pressed; it does not buckle for that, and of blocks none is.
TEST(MechanicsBuckling, ADitheredBlockThatIsPulledIsNotSearched) {
    uint32_t state = 1;
    Voxels v = box_of({24, 24, 24}, 1, 0.3, [&](const Vec3&) {
        state = state * 1664525U + 1013904223U;
        return std::pair(1.0, state >> 24 < 77 ? 2000.0 : 1.0);
    });
    Loaded l = loaded(std::move(v), R"({"held": [{"side": "-x"}],
                                        "loads": [{"side": "+x", "force_N": [100, 0, 0]}]})");
    const double alone = least_buckling_factor(l.solved.problem, l.fields,
                                               &l.solved.solution.moved_mm, false),
                 blocks = least_buckling_factor(l.solved.problem, l.fields,
                                                &l.solved.solution.moved_mm, true);
    EXPECT_LT(alone, 4);
    EXPECT_GT(blocks, 4);
    // A slender column of the same stands out in blocks, too.
    Loaded column = loaded(full({160, 4, 4}, 0.3), R"({"held": [{"side": "-x"}],
        "loads": [{"side": "+x", "force_N": [-5, 0, 0]}]})");
    EXPECT_LT(least_buckling_factor(column.solved.problem, column.fields,
                                    &column.solved.solution.moved_mm, true),
              1.1 * buckling_factor(&column));
    EXPECT_TRUE(buckling_of(&column.solved.problem, &column.solved.solution.moved_mm, 1e4,
                            SolveOptions(), 1)
                    .given_up);
}

}  // namespace
}  // namespace openfab::mechanics
