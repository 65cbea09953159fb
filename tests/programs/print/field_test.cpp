// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Displacement fields that `openfab compensate` makes, in prints; and `openfab check` of prints.

#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "program/messages.h"
#include "runtime/part/messages.h"
#include "tests/programs/print/process_fixture.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"
#include "world/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

class MachineTools : public ProcessOption {
  protected:
    MachineTools() { ::setenv("OPENFAB_HELPER", program("openfab").c_str(), 1); }
    Outcome tool(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), program("openfab").string());
        return run(arguments);
    }
    std::string text(const std::string& name) const {
        std::ifstream in(scratch_ / name);
        std::stringstream out;
        out << in.rdbuf();
        return out.str();
    }
    /// A solid world of the beams of `t.txt`.
    void write_beams(const std::string& name) {
        write_world(name, "");
        std::string world = text(name);
        const size_t at = world.find("{\"sphere\": 6}");
        ASSERT_NE(at, std::string::npos);
        world.replace(at, 13, "{\"beams\": \"t.txt\"}");
        world.replace(world.find("\"fablet\": \"Skin\""), 16, "\"fablet\": \"Solid\"");
        scratch_.write(name, world);
    }
    /// Points of a box around the ball that a machine has shrunk.
    void write_points(const std::string& name, double by) {
        std::string lines = "x,y,z,mx,my,mz\n# measured on a Monday\n";
        for (int x = -5; x <= 5; x += 2) {
            for (int y = -5; y <= 5; y += 2) {
                for (int z = -5; z <= 5; z += 2) {
                    lines += fmt::format("{},{},{},{},{},{}\n", x, y, z, x * by, y * by, z * by);
                }
            }
        }
        scratch_.write(name, lines);
    }
};

TEST_F(MachineTools, AFieldThatShrinksIsUndoneAsAScaleIs) {
    write_points("points.csv", 0.96);
    const Outcome made =
        tool({"compensate", path("points.csv"), "-o", path("shrink.json"), "--cell", "2mm"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_THAT(made.out, testing::Says(tools::messages::kFieldMade, 216));
    scratch_.write("field.process.json", R"({"field": "shrink.json"})");
    scratch_.write("scale.process.json", fmt::format(R"({{"scale": {}}})", 1 / 0.96));
    const Voxels plain = print_voxels({});
    const Voxels field = print_voxels({"--process", path("field.process.json")});
    const Voxels scale = print_voxels({"--process", path("scale.process.json")});
    EXPECT_GT(field.info.size.x, plain.info.size.x);
    ASSERT_EQ(field.info.size, scale.info.size);
    int64_t differ = 0;
    for (size_t i = 0; i < field.codes.size(); ++i)
        differ += (field.codes[i] == 0) != (scale.codes[i] == 0) ? 1 : 0;
    // Vertices are moved in floats of a field.
    EXPECT_LT(differ, 30);
    const Voxels again = print_voxels({"--process", path("field.process.json"), "--threads", "1"});
    EXPECT_TRUE(again.codes == field.codes);
}

TEST_F(MachineTools, AFieldThatShrinksBeamsIsUndoneAsAScaleIs) {
    write_points("points.csv", 0.96);
    ASSERT_EQ(tool({"compensate", path("points.csv"), "-o", path("shrink.json"), "--cell", "2mm"})
                  .exit_code,
              0);
    scratch_.write("field.process.json", R"({"field": "shrink.json"})");
    scratch_.write("scale.process.json", fmt::format(R"({{"scale": {}}})", 1 / 0.96));
    for (const char* ends : {"ball", "flat", "dome"}) {
        scratch_.write("t.txt", fmt::format("node -4 0 2 1\nnode 4 1 2 0.6\nnode 0 -3 3 0.8\nends "
                                            "{}\nstrut 0 1\nstrut 1 2\nball 2\n",
                                            ends));
        write_beams("beams.fab.json");
        const Voxels plain = print_voxels({}, "beams.fab.json");
        const Voxels field =
            print_voxels({"--process", path("field.process.json")}, "beams.fab.json");
        const Voxels scale =
            print_voxels({"--process", path("scale.process.json")}, "beams.fab.json");
        EXPECT_GT(field.info.size.x, plain.info.size.x + 2);
        ASSERT_EQ(field.info.size, scale.info.size) << ends;
        int64_t differ = 0;
        for (size_t i = 0; i < field.codes.size(); ++i)
            differ += (field.codes[i] == 0) != (scale.codes[i] == 0) ? 1 : 0;
        EXPECT_LT(differ, 30) << ends;
    }
}

TEST_F(MachineTools, AFieldBendsBeams) {
    // The machine lifts the middle by x^2 / 100; what is sent hangs as much.
    std::string lines = "x,y,z,mx,my,mz\n";
    for (int x = -6; x <= 6; ++x) {
        for (int y = -2; y <= 2; y += 4) {
            for (int z = -2; z <= 4; z += 6)
                lines += fmt::format("{},{},{},{},{},{}\n", x, y, z, x, y, z + x * x / 100.0);
        }
    }
    scratch_.write("points.csv", lines);
    ASSERT_EQ(tool({"compensate", path("points.csv"), "-o", path("bend.json"), "--cell", "1mm",
                    "--smooth", "0.000001"})
                  .exit_code,
              0);
    scratch_.write("bend.process.json", R"({"field": "bend.json"})");
    for (const char* ends : {"ball", "flat"}) {
        scratch_.write("t.txt",
                       fmt::format("node -6 0 2 0.5\nnode 6 0 2 0.5\nends {}\nstrut 0 1\n", ends));
        write_beams("beams.fab.json");
        const Voxels bent =
            print_voxels({"--process", path("bend.process.json")}, "beams.fab.json");
        const Vec3i& size = bent.info.size;
        for (int32_t x = 0; x < size.x; ++x) {
            const double at = bent.info.origin_mm.x + (x + 0.5) * 0.1;
            if (std::fabs(at) > 5.8) continue;
            double sum = 0;
            int64_t voxels = 0;
            for (int32_t z = 0; z < size.z; ++z) {
                for (int32_t y = 0; y < size.y; ++y) {
                    if (bent.at(x, y, z) == 0) continue;
                    ++voxels;
                    sum += bent.info.origin_mm.z + (z + 0.5) * 0.1;
                }
            }
            // The section of the strut, and half a voxel.
            EXPECT_NEAR(static_cast<double>(voxels), 78.5, 12) << ends << " " << at;
            EXPECT_NEAR(sum / static_cast<double>(voxels), 2 - at * at / 100, 0.05)
                << ends << " " << at;
        }
    }
}

TEST_F(MachineTools, AStretchedBallOfBeamsIsAnEllipsoid) {
    scratch_.write("t.txt", "node 0 0 0 3\nball 0\n");
    write_beams("beams.fab.json");
    const Vec3d scale{1.02, 1, 1.07};
    scratch_.write("scale.process.json", R"({"scale": [1.02, 1, 1.07]})");
    const Voxels found = print_voxels({"--process", path("scale.process.json")}, "beams.fab.json");
    int64_t wrong = 0;
    for (int32_t z = 0; z < found.info.size.z; ++z) {
        for (int32_t y = 0; y < found.info.size.y; ++y) {
            for (int32_t x = 0; x < found.info.size.x; ++x) {
                double sum = 0;
                for (int a = 0; a < 3; ++a) {
                    const int32_t voxel = a == 0 ? x : a == 1 ? y : z;
                    const double p = found.info.origin_mm[a] + (voxel + 0.5) * 0.1;
                    sum += p * p / (9 * scale[a] * scale[a]);
                }
                const bool in = found.at(x, y, z) != 0;
                if (std::fabs(sum - 1) > 1e-5) wrong += in != (sum < 1) ? 1 : 0;
            }
        }
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_NEAR(found.info.size.z, 64.2, 2);
    scratch_.write("scale.process.json", R"({"scale": [1, 1, 1.2]})");
    const Outcome refused =
        print({"--process", path("scale.process.json"), "-o", path("x.ofr")}, "beams.fab.json");
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, Says(part::messages::kUnevenStretch, "1", "1.2"));
}

TEST_F(MachineTools, AFieldAsItIsAndItsInverseReturn) {
    write_points("points.csv", 1.03);
    ASSERT_EQ(tool({"compensate", path("points.csv"), "-o", path("grow.json")}).exit_code, 0);
    std::string as_is = text("grow.json");
    as_is.replace(as_is.find("inverse"), 7, "as_is");
    scratch_.write("as_is.json", as_is);
    scratch_.write("a.process.json", R"({"field": "as_is.json"})");
    const Voxels grown = print_voxels({"--process", path("a.process.json")});
    EXPECT_EQ(grown.info.size.x, 62);
}

TEST_F(MachineTools, WrongFieldsAreTold) {
    const auto fails = [&](const std::string& process, const std::string& with) {
        scratch_.write("x.process.json", process);
        const Outcome outcome = print({"--process", path("x.process.json"), "-o", path("x.ofr")});
        EXPECT_EQ(outcome.exit_code, 1) << process;
        EXPECT_THAT(outcome.err, Says(with)) << process;
    };
    fails(R"({"field": ""})", world::messages::kFieldEmpty);
    fails(R"({"field": 3})", "`field`");
    fails(R"({"field": "none.json"})", "none.json");
    scratch_.write("bad.json", R"({"origin_mm": [0, 0, 0]})");
    fails(R"({"field": "bad.json"})", "`file`");
    write_points("points.csv", 2);
    ASSERT_EQ(tool({"compensate", path("points.csv"), "-o", path("steep.json")}).exit_code, 0);
    fails(R"({"field": "steep.json"})", program::messages::kFieldTooSteep);
    scratch_.write("few.csv", "1,2,3,4,5\n");
    const Outcome few = tool({"compensate", path("few.csv"), "-o", path("few.json")});
    EXPECT_EQ(few.exit_code, 1);
    EXPECT_THAT(few.err, HasSubstr("few.csv:1"));
}

TEST_F(MachineTools, CheckFindsAThinSkinInAPrint) {
    // A plate of 0.3 mm beside the ball, and a speck; solid, since stray voxels of a dither are islands, too.
    scratch_.write("w2.fab.json", fmt::format(R"({{
  "openfab": 1, "printer": "p.printer.json",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "Solid"}}}},
  "materials": {{"white": {{"key": "#ffffff"}}, "black": {{"key": "#000000"}}, "grey": {{"key": "#808080"}}}},
  "meshes": {{"ball": {{"sphere": 6}}, "plate": {{"box": [0.3, 5, 5]}}, "speck": {{"box": [0.4, 0.4, 0.4]}}}},
  "objects": {{
    "a": {{"mesh": "ball", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}},
    "p": {{"mesh": "plate", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}},
    "s": {{"mesh": "speck", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}}}},
  "build": [{{"object": "a"}}, {{"object": "p", "translate_mm": [8, 0, 0]}}, {{"object": "s", "translate_mm": [-5, 0, 0]}}]
}})"));
    ASSERT_EQ(print({"-o", path("w2.ofr")}, "w2.fab.json").exit_code, 0);
    const Outcome found =
        tool({"check", path("w2.ofr"), "--wall", "0.5mm", "--island", "1mm3", "--trapped", "0mm3",
              "--report", path("r.json"), "-o", path("r.png")});
    EXPECT_EQ(found.exit_code, 1) << found.out;
    EXPECT_THAT(found.out, HasSubstr("wall"));
    EXPECT_THAT(found.out, HasSubstr("island"));
    rapidjson::Document report;
    report.Parse(text("r.json").c_str());
    ASSERT_TRUE(report.IsObject());
    int walls = 0, islands = 0;
    for (const auto& finding : report["findings"].GetArray()) {
        const std::string fault = finding["fault"].GetString();
        const double x = finding["at_mm"][0].GetDouble();
        if (fault == "wall" && x > 7) {
            ++walls;
            EXPECT_NEAR(finding["measure"].GetDouble(), 0.3, 0.003);
            EXPECT_NEAR(x, 8, 0.3);
        }
        if (fault == "island") {
            ++islands;
            EXPECT_NEAR(finding["measure"].GetDouble(), 0.064, 1e-6);
            EXPECT_NEAR(x, -5, 0.4);
        }
    }
    EXPECT_EQ(walls, 1);
    EXPECT_EQ(islands, 1);
    EXPECT_GT(std::filesystem::file_size(scratch_ / "r.png"), 500u);
    const Outcome fine = tool({"check", path("w2.ofr"), "--wall", "0.2mm"});
    EXPECT_EQ(fine.exit_code, 0) << fine.out << fine.err;
    EXPECT_THAT(fine.out, testing::Says(tools::messages::kNothingFound));

    ASSERT_EQ(print({"-o", path("w.ofr")}).exit_code, 0);
    const Outcome apart =
        tool({"check", path("w.ofr"), "--apart", "white,black", "--apart", "white,gold"});
    EXPECT_EQ(apart.exit_code, 1);
    EXPECT_THAT(apart.out, HasSubstr("touch"));
    EXPECT_THAT(apart.err, testing::Says(tools::messages::kNoSuchMaterialToCheck, "gold"));
    EXPECT_EQ(tool({"check", path("w2.ofr"), "--wall", "wide"}).exit_code, 2);
    EXPECT_EQ(tool({"check", path("p.printer")}).exit_code, 2);
    const Outcome itself = tool({"check", path("w.ofr"), "--apart", "white,white"});
    EXPECT_EQ(itself.exit_code, 2);
    EXPECT_THAT(itself.err, Says(tools::messages::kApartFromItself, "white,white"));
}

}  // namespace
}  // namespace openfab::testing
