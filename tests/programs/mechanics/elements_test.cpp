// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The elements that `openfab mechanics` makes of a world: the printer's voxels, means over them, and where they begin.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <tuple>
#include <vector>

#include "mechanics/messages.h"
#include "tests/programs/mechanics/model_world.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class MechanicsElements : public MechanicsModel {};

// A strip, a rod and a plate of odd numbers of elements, wherever the build puts them, are these elements: stresses are those
// of the middle of a bar that is bent by a couple, 6 M / (b h^2), and of one that is pulled.
TEST_F(MechanicsElements, BeginWhereThePartDoes) {
    for (const auto& [box, place] : {std::pair("[24, 3, 3]", "[0, 0, 0]"),
                                     {"[24, 3, 3]", "[0.3, -0.7, 0.4]"},
                                     {"[25, 5, 3]", "[10.5, 0.1, 0]"}}) {
        scratch_.write("own.printer.json", R"({"name": "own", "pitch_mm": [0.1, 0.1, 0.1],
"build_volume_mm": [300, 300, 300], "max_materials": 8, "native_format": "ofr", "makes_support": true})");
        const double wide = box[5] - '0';
        const std::string file = world(
            "w.fab.json", fmt::format(R"("rod": {{"box": {}}})", box),
            R"("rod": {"mesh": "rod", "fablet": "one", "uniforms": {"m": "stiff"}})",
            fmt::format(R"({{"object": "rod", "translate_mm": {}}})", place),
            fmt::format(
                R"("bent": {{"held": [{{"side": "-x"}}], "loads": [{{"side": "+x", "torque_Nmm": [0, {0}, 0]}}]}},
                  "pulled": {{"held": [{{"side": "-x", "along": "x"}}, {{"side": "-y", "along": "y"}}, {{"side": "-z", "along": "z"}}],
                              "loads": [{{"side": "+x", "force_N": [{1}, 0, 0]}}]}},
                  "marked": {{"held": [{{"object": "rod", "side": "-x"}}], "loads": [{{"object": "rod", "side": "+x", "torque_Nmm": [0, {0}, 0]}}]}})",
                10 * wide * 9 / 6, 10 * wide * 3),
            "own.printer.json");
        for (const char* one : {"bent", "marked", "pulled"}) {
            const JsonValue json = numbers({"part", file, "--case", one, "--voxel", "1mm"});
            const double away = number(json, "safety_away_from_holds_and_loads");
            // 50 MPa over 10; a strip of five bends a little less than a beam.
            EXPECT_NEAR(away, 5, 0.02 * 5 + (one[0] == 'p' ? 0 : 0.06 * 5)) << box << place << one;
            const JsonMember* elements = json.find("elements");
            ASSERT_NE(elements, nullptr);
            EXPECT_EQ(elements->value.items[1].number, wide) << box << place;
            EXPECT_EQ(elements->value.items[2].number, 3) << box << place;
        }
    }
}

// What is thinner than a whole number of elements is pulled in its middle, and what moves far is told.
TEST_F(MechanicsElements, WallsEndWithinElements) {
    const std::string file = world(
        "w.fab.json", R"("strip": {"box": [27.3, 8, 4.3]})",
        R"("strip": {"mesh": "strip", "fablet": "one", "uniforms": {"m": "stiff"}})",
        R"({"object": "strip", "translate_mm": [0, 0, 0]})",
        R"("pulled": {"held": [{"side": "-x", "along": "x"}, {"side": "-y", "along": "y"}, {"side": "-z", "along": "z"}],
                      "loads": [{"side": "+x", "force_N": [344, 0, 0]}]},
           "far": {"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": [0, 0, -78]}]},
           "near": {"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": [0, 0, -6.5]}]})");
    const JsonValue json = numbers({"part", file, "--case", "pulled", "--voxel", "1mm"});
    // Three elements from where it is held, it is a little more strained than in its middle.
    EXPECT_NEAR(number(json, "safety_away_from_holds_and_loads"), 5, 0.05 * 5);
    // P L^3 / (3 E I) = 5 and 0.42 mm.
    const Outcome far = mechanics({"part", file, "--case", "far", "--voxel", "0.5mm"});
    EXPECT_THAT(far.out, Says(mechanics::messages::kMovedFar)) << far.err;
    const Outcome near = mechanics({"part", file, "--case", "near", "--voxel", "0.5mm"});
    EXPECT_THAT(near.out, ::testing::Not(Says(mechanics::messages::kMovedFar))) << near.err;
}

// Stiff voxels of 42 x 85 x 27 um touch along y first, cubes of the same codes along z.
TEST_F(MechanicsElements, OblongVoxelsTurnTheOrderOfDirections) {
    const std::string mixed =
        R"("bar": {"mesh": "bar", "fablet": "mix", "uniforms": {"soft": "soft", "stiff": "stiff"}})";
    const std::string file = world("w.fab.json", "", mixed, kBuild, kBySide, "j750");
    const auto young = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{"cell", file, "--codes"};
        words.insert(words.end(), more.begin(), more.end());
        const JsonValue json = numbers(words);
        std::array<double, 3> out{};
        const JsonMember* found = json.find("young_MPa");
        for (size_t a = 0; found != nullptr && a < 3; ++a)
            out[a] = found->value.items[a].number;
        return out;
    };
    // Sixteen voxels along each side.
    const auto own = young({"--cell", "0.677333x1.354667x0.432mm"});
    EXPECT_GT(own[1], 2 * own[0]);
    EXPECT_GT(own[0], 1.3 * own[2]);
    const auto cubes = young({"--cell", "0.8mm", "--voxel", "0.05mm"});
    EXPECT_GT(cubes[2], 1.2 * std::max(cubes[0], cubes[1]));
}

TEST_F(MechanicsElements, ModuliAreThoseOfTheConditions) {
    scratch_.write("one.fl", R"(fablet One {
    @uniform { Material stuff; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(stuff, 1);
        return mc;
    }
})");
    scratch_.write("mechanics.json", R"({"materials": {"stuff": {"nu": 0.4, "E_MPa": [
        {"T_C": 10, "rate_1_s": 0.01, "value": 3}, {"T_C": 37, "rate_1_s": 0.01, "value": 0.75}]}}})");
    const std::vector<std::string> words{"cell", path("one.fl"), "--cell", "4mm", "--voxel", "1mm"};
    const Outcome open = mechanics(words);
    EXPECT_EQ(open.exit_code, 1);
    EXPECT_THAT(open.err, ::testing::HasSubstr("--temperature 23C"));
    for (const auto& [temperature, modulus] :
         {std::pair("10C", 3.0), {"37C", 0.75}, {"23.5C", 1.5}}) {
        std::vector<std::string> at = words;
        at.insert(at.end(), {"--temperature", temperature, "--rate", "100s"});
        const JsonValue json = numbers(at);
        const JsonMember* young = json.find("young_MPa");
        ASSERT_NE(young, nullptr) << temperature;
        EXPECT_NEAR(young->value.items[0].number, modulus, 1e-4 * modulus);
    }
}

TEST_F(MechanicsElements, CellsOfOddNumbersOfVoxels) {
    // Layers along y of 2 of 5: by Voigt along x and z, by Reuss across.
    scratch_.write("layers.fl", R"(fablet Layers {
    @uniform { Material soft, stiff; float size = 5; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(attr.voxelCenter.y < -0.1 * size ? stiff : soft, 1);
        return mc;
    }
})");
    scratch_.write("mechanics.json", R"({"materials": {"soft": {"E_MPa": 100, "nu": 0},
        "stiff": {"E_MPa": 1000, "nu": 0}}})");
    for (const auto& [cell, voxel, size] : {std::tuple("5mm", "1mm", "5"),
                                            {"2.5mm", "0.5mm", "2.5"},
                                            {"17.3mmx17.3mmx8mm", "3.46mmx3.46mmx1mm", "17.3"},
                                            {"5x10x7mm", "1x2x1mm", "10"}}) {
        const JsonValue json = numbers({"cell", path("layers.fl"), "--cell", cell, "--voxel", voxel,
                                        "--set", std::string("size=") + size});
        const JsonMember* young = json.find("young_MPa");
        ASSERT_NE(young, nullptr) << cell;
        EXPECT_NEAR(young->value.items[0].number, 0.4 * 1000 + 0.6 * 100, 0.01) << cell;
        EXPECT_NEAR(young->value.items[1].number, 1 / (0.4 / 1000 + 0.6 / 100), 0.01) << cell;
        EXPECT_NEAR(young->value.items[2].number, 0.4 * 1000 + 0.6 * 100, 0.01) << cell;
    }
    // Where a layer ends within elements, that is told, and of what has not settled no limit.
    const std::vector<std::string> unaligned{"cell",  path("layers.fl"), "--cell",
                                             "5mm",   "--voxel",         "1mm",
                                             "--set", "size=10",         "--converge"};
    const Outcome odd = mechanics(unaligned);
    EXPECT_EQ(odd.exit_code, 0) << odd.err;
    EXPECT_THAT(odd.err, Says(mechanics::messages::kOddCell, "x and y"));
    EXPECT_THAT(odd.out,
                Says(mechanics::messages::kCellNotSettled, "Young's x, Young's z, shear xz"));
    const Outcome even = mechanics({"cell", path("layers.fl"), "--cell", "10mm", "--voxel", "1mm",
                                    "--set", "size=10", "--converge"});
    EXPECT_EQ(even.exit_code, 0) << even.err;
    EXPECT_THAT(even.err, Not(HasSubstr("an odd number")));
    EXPECT_THAT(even.out, Not(HasSubstr("not settled")));
    // As many of each as in a print of the piece that has an even number.
    const Outcome advice =
        mechanics({"cell", path("layers.fl"), "--cell", "5mm", "--voxel", "0.9x1x0.8mm"});
    EXPECT_EQ(advice.exit_code, 1);
    EXPECT_THAT(advice.err, AllOf(Says(mechanics::messages::kCellNotWhole),
                                  HasSubstr("`--voxel 0.833333x1x0.833333mm`")));
}

TEST_F(MechanicsElements, CodesAreThePrintersVoxels) {
    const std::string mixed =
        R"("bar": {"mesh": "bar", "fablet": "mix", "uniforms": {"soft": "soft", "stiff": "stiff"}})";
    scratch_.write("oblong.printer.json", R"({"name": "oblong", "pitch_mm": [0.5, 1, 0.25],
"build_volume_mm": [300, 300, 300], "max_materials": 8, "native_format": "ofr", "makes_support": true})");
    const std::string file = world("w.fab.json", "", mixed, kBuild, kBySide, "oblong.printer.json");
    const Outcome own = mechanics({"part", file, "--codes", "--thin", "--loose"});
    EXPECT_EQ(own.exit_code, 0) << own.err;
    EXPECT_THAT(own.out, HasSubstr("pitch 0.5 x 1 x 0.25 mm, 1280 solid elements of 20 x 4 x 16"));
    const Outcome said =
        mechanics({"part", file, "--codes", "--thin", "--loose", "--voxel", "0.5x1x0.25mm"});
    EXPECT_EQ(said.out, own.out);
    EXPECT_THAT(said.err, ::testing::Not(Says(mechanics::messages::kNotPrintersVoxels)));
    const Outcome cubes = mechanics({"part", file, "--codes", "--voxel", "0.5mm"});
    EXPECT_EQ(cubes.exit_code, 0) << cubes.err;
    EXPECT_THAT(cubes.err, Says(mechanics::messages::kNotPrintersVoxels, "0.5mm", "0.5x1x0.25mm"));
    // A cell is cut to whole voxels, and says so.
    const Outcome cell = mechanics({"cell", file, "--cell", "4.2mm", "--codes"});
    EXPECT_EQ(cell.exit_code, 0) << cell.err;
    EXPECT_THAT(cell.out, HasSubstr("pitch 0.5 x 1 x 0.25 mm, 8 x 4 x 17 elements"));
    EXPECT_THAT(cell.err, Says(mechanics::messages::kCellOfWholeVoxels));
    // Elements of mixtures may be oblong as well, and are means over the printer's voxels.
    for (const char* command : {"part", "stand", "export"}) {
        std::vector<std::string> words{command, file, "--voxel", "1x2x0.5mm", "--thin"};
        if (std::string(command) == "export") words.insert(words.end(), {"-o", path("x.inp")});
        const Outcome out = mechanics(words);
        EXPECT_EQ(out.exit_code, 0) << command << ": " << out.err;
    }
    EXPECT_EQ(mechanics({"part", file, "--voxel", "1x2mm"}).exit_code, 2);
    EXPECT_EQ(mechanics({"part", file, "--voxel", "1x0x2mm"}).exit_code, 2);
}

TEST_F(MechanicsElements, SharesAreMeansOverThePrintersVoxels) {
    // A ball in elements of 5 voxels: how many of the voxels' middles are in it.
    const std::string meshes = R"("ball": {"shape": "ball", "box_mm": [[-5, -5, -5], [5, 5, 5]]})";
    scratch_.write("own.printer.json", R"({"name": "own", "pitch_mm": [0.2, 0.25, 0.1],
"build_volume_mm": [300, 300, 300], "max_materials": 8, "native_format": "ofr", "makes_support": true})");
    const std::string file = world(
        "w.fab.json", meshes,
        R"("ball": {"mesh": "ball", "fablet": "ball", "uniforms": {"m": "stiff", "r": 3.95}})",
        R"({"object": "ball", "translate_mm": [0, 0, 4]})",
        R"("c": {"held": [{"side": "-z"}], "gravity_m_s2": [0, 0, -9.81]})", "own.printer.json");
    const Outcome out =
        mechanics({"part", file, "--voxel", "1mm", "--thin", "--loose", "-o", path("w.npy")});
    ASSERT_EQ(out.exit_code, 0) << out.err;
    const std::string array = read_file(path("w.npy"));
    constexpr int kSide = 8;
    ASSERT_EQ(array.size(), 128U + sizeof(float) * 8 * kSide * kSide * kSide);
    double worst = 0;
    for (int e = 0; e < kSide * kSide * kSide; ++e) {
        const int ex = e % kSide, ey = e / kSide % kSide, ez = e / kSide / kSide;
        int inside = 0;
        for (int z = 0; z < 10; ++z)
            for (int y = 0; y < 4; ++y)
                for (int x = 0; x < 5; ++x) {
                    const double px = -4 + ex + 0.2 * (x + 0.5), py = -4 + ey + 0.25 * (y + 0.5),
                                 pz = -4 + ez + 0.1 * (z + 0.5);
                    inside += std::sqrt(px * px + py * py + pz * pz) < 3.95 ? 1 : 0;
                }
        float solid = 0;
        std::memcpy(&solid, array.data() + 128 + sizeof(float) * (8 * static_cast<size_t>(e) + 7),
                    4);
        worst = std::max(worst, std::abs(static_cast<double>(solid) - inside / 200.0));
    }
    // One voxel of 200 may lie on the surface itself.
    EXPECT_LE(worst, 1.01 / 200);
}

}  // namespace
}  // namespace openfab::testing
