// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab fit` of curves' keys, against closed forms, and with slopes that are derivatives.

#include <gmock/gmock.h>

#include "tests/programs/tools/fit_folder.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

class FitCurvesTest : public FitFolder {
  protected:
    void SetUp() override {
        folder_.write("mix.fl", R"(fablet Mix {
    @uniform { Spline by_x; ColorRamp by_y; float t = -20; Material heavy, light; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        float s = by_x.At(p.x) + exp(by_y.At(p.y).y + t) / 100;
        mc.Set(heavy, s);
        mc.Set(light, 1 - s);
        return mc;
    }
}
)");
        folder_.write("w.fab.json", R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"mix": {"source": "mix.fl", "fablet": "Mix"}},
  "materials": {"light": {"key": "#ffffff", "density_g_cm3": 1.0}, "heavy": {"key": "#000000", "density_g_cm3": 2.0}},
  "meshes": {"block": {"box": [10, 5, 4]}},
  "objects": {"thing": {"mesh": "block", "fablet": "mix", "uniforms": {"heavy": "heavy", "light": "light",
    "by_x": {"keys": [[-5, 0.25], [0, 0.25], [5, 0.25]], "interpolation": "linear"},
    "by_y": {"keys": [[-2.5, 0, 0, 0], [2.5, 0, 0, 0]]}}}},
  "build": [{"object": "thing"}]
}
)");
    }
};

TEST_F(FitCurvesTest, ValuesOfKeysAreUnknowns) {
    // Halves of a block, whose shares are means of two neighbouring keys.
    const JsonValue found =
        fit(R"("thing.by_x[0]": {"min": 0, "max": 1}, "thing.by_x[2]": {"min": 0, "max": 1})",
            R"({"share": "heavy", "equal": 0.3, "box_mm": [[-5, -5, -5], [0, 5, 5]]},
               {"share": "heavy", "equal": 0.5, "box_mm": [[0, -5, -5], [5, 5, 5]]})",
            {"--set",
             R"(thing.by_x={"keys": [[-5, 0.2], [0, 0.2], [5, 0.2]], "interpolation": "linear"})"});
    EXPECT_NEAR(unknown(found, "thing.by_x[0]"), 0.4, 1e-3);
    EXPECT_NEAR(unknown(found, "thing.by_x[2]"), 0.8, 2e-3);
    EXPECT_THAT(last_.out, HasSubstr("[0, 0.2], [5, "));
    EXPECT_THAT(last_.out, HasSubstr("\"interpolation\": \"linear\"}"));
}

TEST_F(FitCurvesTest, SlopesOfManyUnknownsAreDerivatives) {
    // Keys 0.3, 0.1 and 0.4 along x, and exponents from 0 to 2 along y, have these sums.
    const auto with = [&](const std::string& threads) {
        const JsonValue found = fit(
            R"("thing.by_x[0]": {"min": 0, "max": 0.9}, "thing.by_x[1]": {"min": 0, "max": 0.9},
               "thing.by_x[2]": {"min": 0, "max": 0.9},
               "thing.by_y[4]": {"min": -2, "max": 2})",
            R"({"share": "heavy", "equal": 0.2519, "box_mm": [[-5, -5, -5], [-1, 5, 5]]},
               {"share": "heavy", "equal": 0.1569, "box_mm": [[-1, -5, -5], [1, 5, 5]]},
               {"share": "heavy", "equal": 0.3119, "box_mm": [[1, -5, -5], [5, 5, 5]]},
               {"weight_g": "all", "equal": 0.076834, "box_mm": [[-5, 1, -5], [5, 5, 5]], "object": "thing"})",
            {"--set", "thing.t=1", "--set",
             R"(thing.by_y={"keys": [[-2.5, 0, -1, 0], [2.5, 0, 0, 0]]})", "--threads", threads});
        EXPECT_TRUE(found.find("reached")->value.boolean) << last_.out;
        // Differences take four for each slope, and three for each unknown to see that it counts.
        EXPECT_LT(found.find("evaluations")->value.number, 15) << last_.out;
        const double keys[] = {0.3, 0.1, 0.4};
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(unknown(found, fmt::format("thing.by_x[{}]", k)), keys[k], 3e-3);
        EXPECT_NEAR(unknown(found, "thing.by_y[4]"), 1, 0.03);
        return last_.out.substr(0, last_.out.find(" evaluations"));
    };
    EXPECT_EQ(with("1"), with("3"));
}

TEST_F(FitCurvesTest, WhereVoxelsComeAndGoSlopesAreDifferences) {
    // One material, so that its share is 1 wherever its amount is above 0: half of the block, moved to three quarters.
    folder_.write("mix.fl", R"(fablet Mix {
    @uniform { float a = 0; float b = 0; float c = 0; float d = 0; Material heavy; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        mc.Set(heavy, a + b * p.y + c * p.z + d * p.y * p.z - p.x);
        return mc;
    }
}
)");
    std::string world = read_file(folder_ / "w.fab.json");
    const size_t from = world.find(", \"light\": \"light\"");
    world.erase(from, world.find("}}},\n  \"build\"") - from);
    folder_.write("w.fab.json", world);
    const JsonValue found =
        fit(R"("thing.a": {"min": -4, "max": 4}, "thing.b": {"min": -0.5, "max": 0.5},
               "thing.c": {"min": -0.5, "max": 0.5}, "thing.d": {"min": -0.1, "max": 0.1})",
            R"({"volume_ml": "heavy", "equal": 0.15, "within": 5e-4})", {"--voxel", "0.05mm"});
    EXPECT_TRUE(found.find("reached")->value.boolean) << last_.out;
    EXPECT_LT(found.find("evaluations")->value.number, 150) << last_.out;
}

TEST_F(FitCurvesTest, Refusals) {
    const struct {
        std::string unknown, says;
    } cases[] = {
        {"thing.by_x", "name a value, as `thing.by_x[0]`; its numbers are 0 to 2"},
        {"thing.by_y[6]", "is none of the 6 values of the curve's keys"},
    };
    for (const auto& one : cases) {
        write_goals("\"" + one.unknown + R"(": {"min": 0, "max": 1})",
                    R"({"share": "heavy", "equal": 0.3})");
        const Outcome outcome = openfab({"fit", path("w.fab.json"), path("goals.json")});
        EXPECT_EQ(outcome.exit_code, 1) << outcome.out;
        EXPECT_THAT(outcome.err, HasSubstr(one.says));
    }
}

}  // namespace
}  // namespace openfab::testing
