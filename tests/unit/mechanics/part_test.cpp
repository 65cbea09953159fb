// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Loaded parts against closed forms.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "mechanics/messages.h"
#include "mechanics/part/eigen.h"
#include "tests/support/says/says.h"
#include "tests/unit/mechanics/loaded_box.h"

namespace openfab::mechanics {
namespace {

std::string case_refused(const std::string& text) {
    const Result<LoadCase> c = parse_load_case("{\"cases\": {\"one\": " + text + "}}", "test", "");
    return c ? std::string() : c.error().text();
}

TEST(MechanicsPart, GradedBarIsTheIntegralOfItsCompliance) {
    // Poisson's ratio 0: one-dimensional. E changes from element to element; the sum is exact.
    constexpr int32_t kLong = 80;
    double compliance = 0;
    for (int32_t x = 0; x < kLong; ++x)
        compliance += 0.5 / (1 + 4 * (x + 0.5) / kLong);
    const Solved s =
        solved(box_of({kLong, 4, 4}, 0.5, 0,
                      [](const Vec3& p) { return std::pair(1.0, 1 + 4 * p[0] / (0.5 * kLong)); }),
               parsed(R"({"held": [{"side": "-x"}],
                                       "loads": [{"side": "+x", "force_N": [3, 0, 0]}]})"));
    const double wanted = 3.0 / 4 * compliance;  // a section of 2 x 2 mm
    EXPECT_NEAR(moved(s, kLong, 2, 2, 0) / wanted, 1, 1e-4);
    // The integral itself: 1 / E summed by middles is its midpoint rule.
    const double integral = 0.5 * kLong / 4 * std::log(5.0);
    EXPECT_NEAR(moved(s, kLong, 2, 2, 0) / (3.0 / 4 * integral), 1, 1e-4);
    EXPECT_NEAR(s.solution.reactions_N[0][0], -3, 1e-6);
    EXPECT_NEAR(s.solution.work_Nmm, 0.5 * 3 * wanted, 1e-4 * wanted);
}

TEST(MechanicsPart, CasesOfAWorldThatPrintsAreRead) {
    const std::string file = ::testing::TempDir() + "large.fab.json";
    std::ofstream(file) << std::string(17 << 20, ' ')
                        << R"({"cases": {"one": {"held": [{"side": "-x"}],
        "loads": [{"side": "+x", "force_N": [3, 0, 0]}]}}})";
    const Result<LoadCase> read = read_load_case(file, "one");
    EXPECT_TRUE(read) << read.error().text();
    std::filesystem::remove(file);
}

TEST(MechanicsPart, GapsWithinElementsAreTold) {
    const auto notes_of = [](const std::function<double(const Vec3&)>& share) {
        const Solved s = solved(
            box_of({12, 6, 6}, 1, 0, [&](const Vec3& p) { return std::pair(share(p), 100.0); }),
            parsed(R"({"held": [{"side": "-x"}],
                                           "loads": [{"side": "+x", "force_N": [1, 0, 0]}]})"));
        return s.problem.notes;
    };
    const auto gap = [](size_t axis, double low, double share, double high) {
        return [=](const Vec3& p) { return p[axis] > low && p[axis] < high ? share : 1; };
    };
    const std::string of_36 = fmt::format(messages::kGapsJoined, 36, 1.0, 4.5, 0.5, 0.5);
    EXPECT_THAT(notes_of(gap(0, 4, 0.7, 5)), ::testing::ElementsAre(of_36));
    EXPECT_THAT(notes_of(gap(0, 4, 0.9, 6)),
                ::testing::ElementsAre(::testing::HasSubstr("72 ele")));
    EXPECT_THAT(notes_of(gap(1, 2, 0.8, 3)),
                ::testing::ElementsAre(::testing::HasSubstr("72 ele")));
    EXPECT_THAT(notes_of(gap(2, 2, 0.8, 3)),
                ::testing::ElementsAre(::testing::HasSubstr("72 ele")));
    // No gaps: the part's surface, what is less than full all over, a gap of which an element is empty.
    EXPECT_THAT(notes_of(gap(1, 5, 0.6, 7)), ::testing::IsEmpty());
    EXPECT_THAT(notes_of([](const Vec3&) { return 0.8; }), ::testing::IsEmpty());
    EXPECT_THAT(notes_of([](const Vec3& p) {
                    return p[1] > 2 && p[1] < 3 ? 0 : p[1] > 3 && p[1] < 4 ? 0.7 : 1;
                }),
                ::testing::Not(::testing::Contains(::testing::HasSubstr("within them"))));
}

/// Deflection of the end of a cantilever of 8 x 1 x 1 mm.
double deflection(int32_t across) {
    const double pitch = 1.0 / across;
    // Poisson's ratio 0: no corner of the held end is singular.
    const Solved s = solved(box_of({8 * across, across, across}, pitch, 0,
                                   [](const Vec3&) { return std::pair(1.0, 1000.0); }),
                            parsed(R"({"held": [{"side": "-x"}],
                                       "loads": [{"side": "+x", "force_N": [0, 0, -0.1]}]})"));
    return -moved(s, 8 * across, across / 2, across / 2, 2);
}

TEST(MechanicsPart, CantileverIsTimoshenkosAndOfSecondOrder) {
    const double length = 8, inertia = 1.0 / 12, young = 1000, shear = young / 2, force = 0.1;
    const double timoshenko = force * length * length * length / (3 * young * inertia) +
                              force * length / (5.0 / 6 * shear);
    const double coarse = deflection(4), fine = deflection(8), finest = deflection(16);
    // What halving changes falls by four.
    EXPECT_NEAR((fine - coarse) / (finest - fine), 4, 0.4);
    // The held end does not warp as the theory of beams has it.
    EXPECT_NEAR((finest + (finest - fine) / 3) / timoshenko, 1, 0.004);
}

TEST(MechanicsPart, HollowSphereUnderPressureIsLames) {
    // An eighth of it, held by its planes of symmetry; 60 elements across the whole.
    constexpr double a = 5, b = 10, young = 2000, poisson = 0.35, pressure = 1;
    constexpr int32_t n = 30;
    const double pitch = b / n;
    const auto share = [&](const Vec3& p) {
        constexpr int kParts = 4;
        int inside = 0;
        for (int i = 0; i < kParts * kParts * kParts; ++i) {
            const double x = p[0] + ((i % kParts + 0.5) / kParts - 0.5) * pitch,
                         y = p[1] + ((i / kParts % kParts + 0.5) / kParts - 0.5) * pitch,
                         z = p[2] + ((i / kParts / kParts + 0.5) / kParts - 0.5) * pitch;
            const double r = std::sqrt(x * x + y * y + z * z);
            inside += r > a && r < b ? 1 : 0;
        }
        return inside / 64.0;
    };
    const Solved s =
        solved(box_of({n, n, n}, pitch, poisson,
                      [&](const Vec3& p) { return std::pair(share(p), young); }),
               parsed(R"({"held": [{"point_mm": [0, 0, 0], "normal": [-1, 0, 0], "along": "x"},
                            {"point_mm": [0, 0, 0], "normal": [0, -1, 0], "along": "y"},
                            {"point_mm": [0, 0, 0], "normal": [0, 0, -1], "along": "z"}],
                   "loads": [{"box_mm": [[0.1, 0.1, 0.1], [5.2, 5.2, 5.2]], "pressure_MPa": 1}]})"),
               1e-7);
    // Along the diagonal and near an axis, in the middle of the wall.
    const auto exact = [&](double r) {
        const double k = pressure * a * a * a / (b * b * b - a * a * a);
        return k / young * ((1 - 2 * poisson) * r + (1 + poisson) * b * b * b / (2 * r * r));
    };
    for (const std::array<int32_t, 3> at : {std::array{22, 0, 0}, {13, 13, 13}, {16, 16, 2}}) {
        const double x = at[0] * pitch, y = at[1] * pitch, z = at[2] * pitch;
        const double r = std::sqrt(x * x + y * y + z * z);
        double u = 0;
        for (size_t c = 0; c < 3; ++c)
            u += moved(s, at[0], at[1], at[2], c) * (at[c] * pitch) / r;
        EXPECT_NEAR(u / exact(r), 1, 0.02) << r;
    }
}

TEST(MechanicsPart, TorqueTurnsAShaft) {
    // A square shaft: Saint-Venant's 0.1406 a^4 G.
    constexpr int32_t n = 12;
    const Solved s =
        solved(box_of({n, n, 4 * n}, 0.25, 0.3, [](const Vec3&) { return std::pair(1.0, 1000.0); }),
               parsed(R"({"held": [{"side": "-z"}],
                                       "loads": [{"side": "+z", "torque_Nmm": [0, 0, 50]}]})"));
    for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(s.problem.total_force_N[c], 0, 1e-9);
        EXPECT_NEAR(s.solution.reactions_N[0][c], 0, 1e-6);
    }
    // Between sections away from both ends.
    const auto turn = [&](int32_t z) {
        return (moved(s, n, n / 2, z, 1) - moved(s, 0, n / 2, z, 1)) / (n * 0.25);
    };
    const double twist = (turn(3 * n) - turn(n)) / (2 * n * 0.25);
    const double shear = 1000 / 2.6;
    EXPECT_NEAR(twist * shear * 0.1406 * std::pow(3.0, 4) / 50, 1, 0.02);
}

TEST(MechanicsPart, WeightStandsOnItsHold) {
    const Solved s =
        solved(box_of({6, 6, 12}, 1, 0, [](const Vec3&) { return std::pair(1.0, 10.0); }),
               parsed(R"({"held": [{"side": "-z"}], "gravity_m_s2": [0, 0, -10]})"));
    const double weight = 6 * 6 * 12 * 1e-6 * 10;
    EXPECT_NEAR(s.solution.reactions_N[0][2] / weight, 1, 1e-6);
    // rho g h^2 / (2 E), exact at nodes.
    EXPECT_NEAR(moved(s, 3, 3, 12, 2), -1e-6 * 10 * 144 / 2 / 10, 1e-9);
}

TEST(MechanicsPart, WhatIsMovedIsStretched) {
    const Solved s =
        solved(box_of({10, 4, 4}, 1, 0, [](const Vec3&) { return std::pair(1.0, 100.0); }),
               parsed(R"({"held": [{"side": "-x"}, {"side": "+x", "move_mm": [0.1, 0, 0]}]})"));
    EXPECT_NEAR(s.solution.reactions_N[1][0], 100 * 0.01 * 16, 1e-4);
    PartFields f = fields_of(s.problem, const_cast<Field<double, 3>*>(&s.solution.moved_mm));
    EXPECT_NEAR(f.von_mises_MPa[85], 1, 1e-5);
    EXPECT_NEAR(f.tension_MPa[85], 1, 1e-5);
    EXPECT_NEAR(f.safety[85], 100, 1e-2);
}

TEST(MechanicsPart, WhatDoesNotHoldIsSaid) {
    const auto cube = [](const Vec3&) { return std::pair(1.0, 1.0); };
    const auto error = [](Voxels v, const std::string& text, const PartOptions& o = {}) {
        const Result<PartProblem> p = set_up_part(std::move(v), parsed(text), {}, o);
        return p ? std::string() : p.error().text();
    };
    const std::string push = R"("loads": [{"side": "+x", "force_N": [1, 0, 0]}])";
    const std::string slides = error(box_of({4, 4, 4}, 1, 0, cube),
                                     R"({"held": [{"side": "-x", "along": "x"}], )" + push + "}");
    EXPECT_THAT(slides, testing::Says(messages::kSlideAlong));
    const std::string turns = error(
        box_of({4, 4, 1}, 1, 0, cube),
        R"({"held": [{"side": "-x", "along": "xz"}, {"side": "+x", "along": "xy", "facing": "+x"}], )" +
            push + "}",
        {false, true});
    EXPECT_EQ(turns, "");  // both sides hold it
    const std::string nothing =
        error(box_of({4, 4, 4}, 1, 0, cube),
              R"({"held": [{"box_mm": [[9, 9, 9], [10, 10, 10]]}], )" + push + "}");
    EXPECT_THAT(nothing, testing::Says(messages::kNothingHeldHere));
    const std::string miss = error(
        box_of({4, 4, 4}, 1, 0, cube),
        R"({"held": [{"side": "-x"}], "loads": [{"side": "+x", "facing": "-x", "force_N": [1, 0, 0]}]})");
    EXPECT_THAT(miss, testing::Says(messages::kLoadOnNothing));
    const auto halves = [](const Vec3& p) {
        return std::pair(std::abs(p[0] - 4) < 1 ? 0.0 : 1.0, 1.0);
    };
    const std::string pieces =
        error(box_of({8, 4, 4}, 1, 0, halves), R"({"held": [{"side": "-x"}], )" + push + "}");
    EXPECT_THAT(pieces, testing::Says(messages::kPieceNotHeld, 2));
    // Left out, the load meets what remains.
    EXPECT_EQ(error(box_of({8, 4, 4}, 1, 0, halves), R"({"held": [{"side": "-x"}], )" + push + "}",
                    {true, false}),
              "");
    // Walls of a third of an element everywhere.
    const auto foam = [](const Vec3& p) {
        return std::pair(static_cast<int>(p[0]) % 2 == 0 ? 0.6 : 0.0, 1.0);
    };
    const std::string thin =
        error(box_of({8, 4, 4}, 1, 0, foam), R"({"held": [{"side": "-x"}], )" + push + "}");
    EXPECT_THAT(thin, testing::Says(messages::kThinWalls));
}

// The tip of a rod with a round end is as large as elements are; flat ends, bosses and blunt feet are what they are.
TEST(MechanicsPart, WhatIsHeldByATipIsTold) {
    const auto notes = [](std::array<int32_t, 3> size,
                          const std::function<bool(const Vec3&)>& inside, const char* held) {
        const std::string text = fmt::format(
            R"({{"held": [{}], "loads": [{{"side": "+x", "force_N": [1, 0, 0]}}]}})", held);
        PartOptions options;
        options.thin = true;
        Result<PartProblem> p = set_up_part(
            box_of(size, 1, 0.3,
                   [&](const Vec3& at) { return std::pair(inside(at) ? 1.0 : 0.0, 1e3); }),
            parsed(text), {}, options);
        EXPECT_TRUE(p) << p.error().text();
        std::erase_if(p->notes, [](const std::string& note) {
            return !testing::says(note, messages::kHeldByTip);
        });
        return p->notes.size();
    };
    for (const int32_t r : {3, 4, 8, 16}) {
        const auto rod = [r](double begin) {
            return [r, begin](const Vec3& p) {
                const double along = std::min(0.0, p[0] - begin);
                return std::hypot(along, p[1] - r, p[2] - r) < r;
            };
        };
        const std::array<int32_t, 3> size{6 * r, 2 * r, 2 * r};
        EXPECT_EQ(notes(size, rod(r), R"({"side": "-x"})"), 1) << r;
        EXPECT_EQ(notes(size, rod(-1), R"({"side": "-x"})"), 0) << r;
        // Across its section, and along an axis alone.
        EXPECT_EQ(notes(size, rod(r),
                        fmt::format(R"({{"box_mm": [[-1, -1, -1], [{}, 99, 99]]}})", r).c_str()),
                  0);
        EXPECT_EQ(notes(size, rod(r), R"({"side": "-x", "along": "x"}, {"side": "+x"})"), 0) << r;
    }
    const auto square = [](const Vec3& p, double half) {
        return std::max(std::abs(p[1] - 20), std::abs(p[2] - 20)) < half;
    };
    const std::array<int32_t, 3> size{20, 40, 40};
    // A point, a boss on a plate of one element and of three, and a foot with its edges off.
    EXPECT_EQ(notes(
                  size, [&](const Vec3& p) { return square(p, 1 + p[0]); }, R"({"side": "-x"})"),
              1);
    for (const int high : {1, 3})
        EXPECT_EQ(notes(
                      size, [&](const Vec3& p) { return p[0] > high || square(p, 4); },
                      R"({"side": "-x"})"),
                  0)
            << high;
    EXPECT_EQ(notes(
                  size, [&](const Vec3& p) { return square(p, 17 + std::min(2.0, p[0])); },
                  R"({"side": "-x"})"),
              0);
}

TEST(MechanicsPart, ALoadThatDoesNothingIsTold) {
    const auto notes = [](const std::string& text) {
        Result<PartProblem> p = set_up_part(
            box_of({8, 8, 8}, 1, 0.3, [](const Vec3&) { return std::pair(1.0, 1000.0); }),
            parsed(text), {}, {});
        EXPECT_TRUE(p) << p.error().text();
        return p ? p->notes : std::vector<std::string>();
    };
    const std::string held = R"({"held": [{"side": "-z"}], "loads": [)";
    EXPECT_THAT(notes(held + R"({"side": "+z", "force_N": [0, 0, 1]}]})"), ::testing::IsEmpty());
    for (const char* load :
         {R"("force_N": [0, 0, -1])", R"("pressure_MPa": 1)", R"("torque_Nmm": [0, 0, 3])"})
        EXPECT_THAT(notes(held + R"({"side": "-z", )" + load + "}]}"),
                    ::testing::ElementsAre(testing::Says(messages::kLoadOnHeld, "*")));
    // Held along one axis, it does nothing along that.
    EXPECT_THAT(notes(R"({"held": [{"side": "-z"}, {"side": "+z", "along": "z"}],
                          "loads": [{"side": "+z", "force_N": [0, 0, 1]}]})"),
                ::testing::ElementsAre(testing::Says(messages::kLoadOnHeld, "*")));
    EXPECT_THAT(notes(R"({"held": [{"side": "-z"}, {"side": "+z", "along": "z"}],
                          "loads": [{"side": "+z", "force_N": [1, 0, 0]}]})"),
                ::testing::IsEmpty());
    // Pascals, and gravity in mm/s2.
    EXPECT_THAT(notes(held + R"({"side": "+z", "pressure_MPa": 101325}]})"),
                ::testing::ElementsAre(testing::Says(messages::kLoadAboveStiffness)));
    EXPECT_THAT(notes(R"({"held": [{"side": "-z"}], "gravity_m_s2": [0, 0, -9810]})"),
                ::testing::ElementsAre(testing::Says(messages::kGravityIsMm)));
}

TEST(MechanicsCase, MistakesAreLocated) {
    const std::pair<const char*, ::testing::Matcher<std::string>> all[] = {
        {R"({"held": [], "loads": []})", testing::Says(messages::kNothingHeld)},
        {R"({"held": [{"side": "-x"}]})", testing::Says(messages::kNothingLoads)},
        {R"({"held": [{"side": "x"}], "loads": []})",
         testing::Says(messages::kMustOneOf, "side", "-x*")},
        {R"({"held": [{"along": "x"}], "loads": []})", testing::Says(messages::kNoFacesChosen)},
        {R"({"held": [{"side": "-x", "along": "w"}], "loads": []})",
         testing::Says(messages::kAlongAxes)},
        {R"({"held": [{"side": "-x", "force_N": [0, 0, 1]}], "loads": []})",
         testing::Says(messages::kUnknownHere, "force_N")},
        {R"({"held": [{"side": "-x"}], "loads": [{"side": "+x"}]})",
         testing::Says(messages::kLoadWithoutForce)},
        {R"({"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": 3}]})",
         testing::Says(messages::kMustThreeNumbers, "force_N")},
        {R"({"held": [{"normal": [0, 0, 1]}], "loads": []})",
         testing::Says(messages::kPlaneIncomplete)},
        {R"({"held": [{"box_mm": [[1, 0, 0], [0, 1, 1]]}], "loads": []})",
         testing::Says(messages::kLowerCornerFirst)},
        {R"({"held": [{"side": "-x", "along": "z", "move_mm": [1, 0, -1]}], "loads": []})",
         testing::Says(messages::kMovedNotHeld, "x")},
        {R"({"held": [{"side": "-x"}], "wind": 3})", testing::Says(messages::kCaseLacks, "wind")},
        {R"([1])", testing::Says(messages::kCaseNoObject)},
    };
    for (const auto& [text, part] : all) {
        const std::string said = case_refused(text);
        EXPECT_THAT(said, part) << text;
        EXPECT_EQ(said.rfind("test:1:", 0), 0U) << said;
    }
    const Result<LoadCase> two = parse_load_case(R"({"cases": {"a": {}, "b": {}}})", "test", "");
    ASSERT_FALSE(two);
    EXPECT_THAT(two.error().text(), testing::Says(messages::kChooseCase, "a, b"));
}

TEST(MechanicsEigen, PrincipalStressesAreEigenvalues) {
    for (int seed = 1; seed < 50; ++seed) {
        std::array<double, 6> s;
        for (size_t i = 0; i < 6; ++i)
            s[i] = std::sin(seed * 12.9898 + static_cast<double>(i) * 78.233) * 5;
        const Eigen e = eigen_of({s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2]}, 3);
        const std::array<double, 3> p = principal_of(s);
        for (size_t i = 0; i < 3; ++i)
            EXPECT_NEAR(p[i], e.values[i], 1e-7);
    }
}

}  // namespace
}  // namespace openfab::mechanics
