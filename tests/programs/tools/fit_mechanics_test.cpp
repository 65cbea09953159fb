// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab fit` with goals that `openfab mechanics` solves for: a graded beam against the theory of beams and Hashin and
// Shtrikman's bounds, a conductor against Ohm's law, a cell of layers against its mean; what is wrong is named.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "base/json.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/fit/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

constexpr double kSoft = 1000, kStiff = 2500, kNu = 0;  // MPa

constexpr const char* kFablet = R"(fablet Beam {
    @uniform {
        float t = 0.5;
        Material soft, stiff;
    }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float s = saturate(t * (12 - attr.voxelCenter.x) / 24);
        mc.Set(stiff, s);
        mc.Set(soft, 1 - s);
        return mc;
    }
}
fablet Even {
    @uniform {
        float t = 0.5;
        Material soft, stiff;
    }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(stiff, t);
        mc.Set(soft, 1 - t);
        return mc;
    }
}
)";

constexpr const char* kWorld = R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"beam": {"source": "beam.fl", "fablet": "Beam"}, "even": {"source": "beam.fl", "fablet": "Even"}},
  "materials": {"soft": {"key": "#ffffff"}, "stiff": {"key": "#000000"}},
  "meshes": {"bar": {"box": [24, 3, 3]}},
  "objects": {"bar": {"mesh": "bar", "fablet": "FABLET", "uniforms": {"soft": "soft", "stiff": "stiff"}}},
  "build": [{"object": "bar"}],
  "cases": {
    "bend": {"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": [0, 0, -1]}]},
    "both": {"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": [0, 0, -1]}, {"side": "+z", "pressure_MPa": 1}]},
    "flow": {"held": [{"side": "-x", "volt": 0}, {"side": "+x", "volt": 1}]}
  }
}
)";

constexpr const char* kMaterials = R"({"law": "LAW", "materials": {
  "soft": {"E_MPa": 1000, "nu": 0, "conductivity_S_m": 100},
  "stiff": {"E_MPa": 2500, "nu": 0, "conductivity_S_m": 300}}})";

/// Bulk and shear modulus of a mixture of two by the mean of Hashin and Shtrikman's bounds ("A variational approach to the
/// theory of the elastic behaviour of multiphase materials", 1963).
struct Moduli {
    double bulk, shear;
};
Moduli hashin_shtrikman(double stiff) {
    const auto of = [](double young) {
        return Moduli{young / (3 * (1 - 2 * kNu)), young / (2 * (1 + kNu))};
    };
    const auto bound = [](const Moduli& matrix, const Moduli& drops, double share) {
        const double k =
            matrix.bulk + share / (1 / (drops.bulk - matrix.bulk) +
                                   3 * (1 - share) / (3 * matrix.bulk + 4 * matrix.shear));
        const double g =
            matrix.shear + share / (1 / (drops.shear - matrix.shear) +
                                    6 * (1 - share) * (matrix.bulk + 2 * matrix.shear) /
                                        (5 * matrix.shear * (3 * matrix.bulk + 4 * matrix.shear)));
        return Moduli{k, g};
    };
    const Moduli low = bound(of(kSoft), of(kStiff), stiff);
    const Moduli high = bound(of(kStiff), of(kSoft), 1 - stiff);
    return {(low.bulk + high.bulk) / 2, (low.shear + high.shear) / 2};
}

/// How far the end of the cantilever of 24 x 3 x 3 mm is bent by 1 N: Timoshenko's beam, of which the stiff share falls
/// from t where it is held to nothing.
double deflection(double t) {
    constexpr double kLength = 24, kSide = 3;
    const double second_moment = std::pow(kSide, 4) / 12, area = kSide * kSide;
    constexpr int kParts = 2000;
    double sum = 0;
    for (int k = 0; k < kParts; ++k) {
        const double x = kLength * (k + 0.5) / kParts;
        const Moduli moduli = hashin_shtrikman(t * (1 - x / kLength));
        const double young = 9 * moduli.bulk * moduli.shear / (3 * moduli.bulk + moduli.shear);
        const double nu = young / (2 * moduli.shear) - 1;
        const double kappa = 10 * (1 + nu) / (12 + 11 * nu);
        sum += (kLength - x) * (kLength - x) / (young * second_moment) +
               1 / (kappa * moduli.shear * area);
    }
    return sum * kLength / kParts;
}

class FitMechanicsTest : public ::testing::Test {
  protected:
    void write(const std::string& fablet, const std::string& law) {
        folder_.write("beam.fl", kFablet);
        const auto with = [](std::string text, const std::string& word, const std::string& value) {
            return text.replace(text.find(word), word.size(), value);
        };
        folder_.write("w.fab.json", with(kWorld, "FABLET", fablet));
        folder_.write("mechanics.json", with(kMaterials, "LAW", law));
    }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    Outcome fit(const std::string& goals, const std::vector<std::string>& more = {}) const {
        folder_.write("goals.json",
                      fmt::format("{{\"openfab_fit\": 1, \"unknowns\": {{\"bar.t\": {{\"min\": 0, "
                                  "\"max\": 1}}}}, \"goals\": [{}]}}",
                                  goals));
        std::vector<std::string> words{program("openfab"), "fit",    path("w.fab.json"),
                                       path("goals.json"), "--json", path("fit.json"),
                                       "--voxel",          "0.25mm"};
        words.insert(words.end(), more.begin(), more.end());
        RunOptions options;
        options.environment.emplace_back("XDG_CACHE_HOME", path("cache"));
        return run(words, options);
    }
    double found() const { return json().find("unknowns")->value.find("bar.t")->value.number; }
    double number(const std::string& key) const {
        return json().find("goals")->value.items.at(0).find(key)->value.number;
    }
    JsonValue json() const {
        const Result<JsonValue> value = parse_json(read_file(folder_ / "fit.json"), "fit.json");
        EXPECT_TRUE(value);
        return value ? *value : JsonValue();
    }

    ScratchFolder folder_;
};

TEST_F(FitMechanicsTest, AGradedBeamIsBentAsFarAsIsWanted) {
    write("beam", "hs-mean");
    const double wanted = (deflection(0) + 2 * deflection(1)) / 3;
    const auto goal = [&](double within) {
        return fmt::format(
            R"({{"deflection_mm": "bend", "equal": {}, "within": {}, "element_mm": 0.5}})", wanted,
            within * wanted);
    };
    // Of mixtures, which the first round is for: its dithered voxels are 2 % stiffer.
    Outcome outcome = fit(goal(0.04));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
    EXPECT_EQ(json().find("rounds")->value.number, 1);
    EXPECT_NEAR(number("searched"), wanted, 0.004 * wanted) << outcome.out;
    EXPECT_NEAR(deflection(found()), number("searched"), 0.005 * wanted) << outcome.out;
    EXPECT_NEAR(number("mixtures"), wanted, 0.008 * wanted) << outcome.out;
    // Of dithered voxels.
    outcome = fit(goal(0.01));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
    EXPECT_EQ(json().find("rounds")->value.number, 2);
    EXPECT_NEAR(number("printed"), wanted, 0.01 * wanted) << outcome.out;
}

TEST_F(FitMechanicsTest, WhatTheLawDoesNotSeeIsAimedOff) {
    // Voigt's mean is too stiff for dithered voxels, by more than 3 %.
    write("beam", "voigt");
    const double wanted = (deflection(0) + 2 * deflection(1)) / 3;
    const Outcome outcome = fit(
        fmt::format(R"({{"deflection_mm": "bend", "equal": {}, "within": {}, "element_mm": 0.5}})",
                    wanted, 0.002 * wanted));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
    EXPECT_GE(json().find("rounds")->value.number, 2);
    EXPECT_NEAR(number("printed"), wanted, 0.002 * wanted);
    EXPECT_LT(number("mixtures"), 0.97 * wanted);
}

TEST_F(FitMechanicsTest, AResistance) {
    // In parallel: 24 mm / (9 mm2 times the mean of 100 and 300 S/m).
    write("even", "voigt");
    const Outcome outcome =
        fit(R"({"resistance_ohm": "flow", "equal": 16, "within": 2, "element_mm": 1})");
    const double ohm = 24e-3 / (9e-6 * (100 + 200 * found()));
    ASSERT_NE(outcome.exit_code, 2) << outcome.err;
    EXPECT_NEAR(ohm, number("searched"), 1e-3 * 16) << outcome.out;
}

TEST_F(FitMechanicsTest, ACell) {
    write("even", "voigt");
    const Outcome outcome = fit(
        R"({"young_MPa": "x", "cell_mm": [2, 2, 2], "equal": 1600, "within": 200, "element_mm": 0.5})");
    ASSERT_NE(outcome.exit_code, 2) << outcome.err;
    EXPECT_NEAR(kSoft + (kStiff - kSoft) * found(), number("searched"), 1) << outcome.out;
    EXPECT_NEAR(number("searched"), 1600, 100);
}

TEST_F(FitMechanicsTest, Refusals) {
    write("even", "voigt");
    const std::pair<const char*, const char*> cases[] = {
        {R"({"deflection_mm": "bent", "equal": 1})", "did you mean `bend`?"},
        {R"({"deflection_mm": "both", "equal": 1})", fit::messages::kOneForceHelp},
        {R"({"young_MPa": "x", "equal": 1})", fit::messages::kNoCellHelp},
        {R"({"stiffness_MPa": "17", "cell_mm": [2, 2, 2], "equal": 1})",
         fit::messages::kTensorEntryHelp},
        {R"({"moved_mm": "bend", "box_mm": [[0, 0, 0], [1, 1, 1]], "equal": 1})",
         "`box_mm` has no meaning for `moved_mm`"},
        {R"({"share": "soft", "element_mm": 1, "equal": 1})",
         "`element_mm` has no meaning for `share`"},
    };
    for (const auto& [goal, said] : cases) {
        SCOPED_TRACE(goal);
        const Outcome outcome = fit(goal);
        EXPECT_EQ(outcome.exit_code, 1);
        EXPECT_THAT(outcome.err, HasSubstr(said));
    }
}

}  // namespace
}  // namespace openfab::testing
