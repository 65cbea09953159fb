// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Where beams, what grows and what programs make stand, and what tools say of their size: as the same solid does that is
// placed by numbers from a closed form.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iterator>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "backends/ofr/ofr_reader.h"
#include "base/json.h"
#include "program/messages.h"
#include "runtime/pipeline/messages.h"
#include "runtime/solid/messages.h"
#include "tests/programs/tools/openfab_print.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"
#include "world/messages.h"

namespace openfab::testing {
namespace {

constexpr const char* kGrown =
    R"(struct N { float3 end[2]; float radius; int children; float reach; };

fablet F {
    @uniform { Material m; float r = 1; }
    @Grow(@varying { GrowAttributes attr, N parent })
    {
        N s;
        s.end[0] = attr.level == 0 ? float3(-3, 0, 0) : float3(0, -2, 1);
        s.end[1] = attr.level == 0 ? float3(3, 1, 2) : float3(0, 3, 1);
        s.radius = r;
        s.children = attr.level == 0 ? 1 : 0;
        s.reach = 9;
        return s;
    }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(m, 1);
        return mc;
    }
}

fablet Round {
    @uniform { Material m; float r = 1; }
    @Shape(@varying { ShapeAttributes attr }) [[ distance ]]
    {
        return length(attr.p) - 3 * r;
    }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(m, 1);
        return mc;
    }
}

fablet Plain {
    @uniform { Material m; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(m, 1);
        return mc;
    }
}
)";

/// Ends of the two beams, of radius 1.
constexpr double kEnds[4][3] = {{-3, 0, 0}, {3, 1, 2}, {0, -2, 1}, {0, 3, 1}};

class Extents : public OpenfabPrint {
  protected:
    Extents() {
        scratch_.write("f.fl", kGrown);
        scratch_.write("t.txt",
                       "node -3 0 0 1\nnode 3 1 2 1\nnode 0 -2 1 1\nnode 0 3 1 1\n"
                       "strut 0 1\nstrut 2 3\n");
        scratch_.write(
            "p.sh",
            "while read line; do echo 'beam -3 0 0 3 1 2 1 1'; echo 'beam 0 -2 1 0 3 1 1 1'; "
            "echo done; done\n");
    }
    /// Writes `beams`, `grown` and `program`, of a build.
    void write_worlds(const std::string& build) {
        const std::string box = R"("box_mm": [[-9, -8, -9], [9, 9, 7]])";
        for (const auto& [name, mesh, fablet] :
             {std::tuple<const char*, std::string, const char*>{"beams", R"({"beams": "t.txt"})",
                                                                "plain"},
              {"grown", R"({"grow": "f", )" + box + "}", "f"},
              {"shape", R"({"shape": "round", "box_mm": [[-4, -4, -4], [4, 4, 4]]})", "round"},
              {"program", R"({"program": ["sh", "p.sh"], )" + box + "}", "plain"}})
            scratch_.write(std::string(name) + ".fab.json", fmt::format(R"({{
  "openfab": 1, "printer": "generic",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "F"}}, "plain": {{"source": "f.fl", "fablet": "Plain"}}, "round": {{"source": "f.fl", "fablet": "Round"}}}},
  "materials": {{"a": {{"key": "#ffffff"}}}},
  "meshes": {{"m": {}}},
  "objects": {{"o": {{"mesh": "m", "fablet": "{}", "uniforms": {{"m": "a"}}}}}},
  "build": {}
}})",
                                                                        mesh, fablet, build));
    }
    /// The places of voxels with material, in multiples of the pitch.
    std::set<std::array<int64_t, 3>> printed(const std::string& world) {
        const Outcome outcome = print({path(world + ".fab.json"), "-o", path("a.ofr"), "--voxel",
                                       "0.25mm", "--support", "off", "--allow-programs"});
        EXPECT_EQ(outcome.exit_code, 0) << world << ": " << outcome.err;
        std::set<std::array<int64_t, 3>> out;
        auto reader = ofr::OfrReader::open(path("a.ofr"));
        if (!reader) return out;
        const pipeline::PrintInfo info = (*reader)->info();
        const auto place = [&](int axis, int32_t i) {
            return std::llround(info.origin_mm[axis] / info.pitch_mm[axis]) + i;
        };
        int32_t z = 0;
        for (Result<bool> more = (*reader)->next(); more && *more; more = (*reader)->next(), ++z) {
            for (int32_t y = 0; y < info.size.y; ++y) {
                for (int32_t x = 0; x < info.size.x; ++x) {
                    if ((*reader)->slice().code(x, y, info.bits) != 0)
                        out.insert({place(0, x), place(1, y), place(2, z)});
                }
            }
        }
        EXPECT_GT(out.size(), 1000u);
        return out;
    }
    Outcome tool(std::vector<std::string> words) {
        words.insert(words.begin(), program("openfab").string());
        return run(words, {{{"OPENFAB_CACHE", path("cache")},
                            {"OPENFAB_HELPER", program("openfab").string()}},
                           {},
                           {}});
    }
};

/// Single voxels whose middles lie on a surface, but for the last bits, may differ.
size_t differences(const std::set<std::array<int64_t, 3>>& a,
                   const std::set<std::array<int64_t, 3>>& b) {
    std::vector<std::array<int64_t, 3>> out;
    std::ranges::set_symmetric_difference(a, b, std::back_inserter(out));
    return out.size();
}

TEST_F(Extents, WhatIsTurnedStandsOnTheBedAndInRows) {
    // Turned by 50 degrees about x.
    const double c = std::cos(50 * M_PI / 180), s = std::sin(50 * M_PI / 180);
    double low[3] = {1e9, 1e9, 1e9}, high[3] = {-1e9, -1e9, -1e9};
    for (const auto& [x, y, z] : kEnds) {
        const double at[3] = {x, y * c - z * s, y * s + z * c};
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], at[a] - 1);
            high[a] = std::max(high[a], at[a] + 1);
        }
    }
    const std::string placed = fmt::format(
        R"([{{"object": "o", "rotate_deg": [50, 0, 0], "translate_mm": [0, 0, {}], "grid": {{"count": [1, 3], "step_mm": [0, {}, 0]}}}}])",
        -low[2], high[1] - low[1] + 2);
    write_worlds(placed);
    const auto right = printed("beams");
    EXPECT_EQ((*std::ranges::min_element(right, {}, [](const auto& p) { return p[2]; }))[2], 0);
    write_worlds(
        R"([{"object": "o", "rotate_deg": [50, 0, 0], "translate_mm": [0, 0], "grid": {"count": [1, 3], "spacing_mm": 2}}])");
    EXPECT_LE(differences(printed("beams"), right), 3u);
    for (const char* kind : {"grown", "program"}) {
        const Outcome refused = print({path(std::string(kind) + ".fab.json"), "-o", path("a.ofr"),
                                       "--voxel", "0.25mm", "--allow-programs"});
        EXPECT_EQ(refused.exit_code, 1) << kind;
        EXPECT_THAT(refused.err, Says(solid::messages::kReachNotKnown, "o"));
    }
}

/// Placed by three numbers it is not known whether it or only its box is beside the tray: the message says so.
TEST_F(Extents, OfWhatGrowsTheBoxHasToBeOnTheTray) {
    write_worlds(R"([{"object": "o", "translate_mm": [3, 4, 20]}], "tray": "corner")");
    for (const char* kind : {"grown", "program"}) {
        const Outcome refused = print({path(std::string(kind) + ".fab.json"), "-o", path("a.ofr"),
                                       "--voxel", "0.25mm", "--allow-programs"});
        EXPECT_EQ(refused.exit_code, 1) << kind;
        EXPECT_THAT(refused.err, Says(program::messages::kBoxOutsideTray, "o"));
    }
}

TEST_F(Extents, ToolsTakeThemAsTheyAre) {
    write_worlds(R"([{"object": "o"}])");
    // A program is not run unasked, and the message says how to ask. What grows is refused by name.
    for (const char* one : {"arrange", "split"}) {
        std::vector<std::string> words{one,  path("program.fab.json"), "--fit", "20x20x20mm",
                                       "-o", path("n.fab.json")};
        const Outcome unasked = tool(words);
        EXPECT_EQ(unasked.exit_code, 1);
        EXPECT_THAT(unasked.err, ::testing::HasSubstr("--allow-programs"));
        words.emplace_back("--allow-programs");
        const Outcome refused = tool(words);
        EXPECT_EQ(refused.exit_code, 1);
        EXPECT_THAT(refused.err, Says(solid::messages::kReachNotKnown, "o"));
    }
    const std::string world = path("beams.fab.json");
    // 8 x 7 x 4 mm: from -3 - 1 to 3 + 1, from -2 - 1 to 3 + 1, from 0 - 1 to 2 + 1.
    const Outcome arranged =
        tool({"arrange", world, "--fit", "9x8x5mm", "-o", path("t.fab.json"), "--turn", "none"});
    EXPECT_EQ(arranged.exit_code, 0) << arranged.err;
    EXPECT_THAT(arranged.out, ::testing::HasSubstr("8 x 7 x 4 mm"));
    EXPECT_EQ(
        tool({"arrange", world, "--fit", "7.9x7.9x5mm", "-o", path("t.fab.json"), "--turn", "none"})
            .exit_code,
        1);
    const Outcome split = tool({"split", world, "--fit", "9x8x5mm", "-o", path("s.fab.json")});
    EXPECT_EQ(split.exit_code, 0) << split.err;
    EXPECT_THAT(split.out, Says(tools::messages::kFitsAsItIs, "object `o`, 8 x 7 x 4 mm"));
}

// Cuts and dowels are looked for in the solid: the box of a ring has its hole, and a corner of an L has nothing.
TEST_F(Extents, SplitCutsTheSolidItself) {
    scratch_.write("cut.fl", R"(fablet One {
    @uniform { Material m; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
float bar(float3 p, float3 half) { float3 q = abs(p) - half; return max(q.x, max(q.y, q.z)); }
fablet L {
    @uniform { Material m; }
    @Shape(@varying { ShapeAttributes attr })
    {
        return min(bar(attr.p - float3(10, 0, 0), float3(11, 1, 1)), bar(attr.p - float3(0, 10, 0), float3(1, 11, 1)));
    }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
fablet Ring {
    @uniform { Material m; }
    @Shape(@varying { ShapeAttributes attr }) { return length(float2(length(attr.p.xy) - 12, attr.p.z)) - 4; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
})");
    scratch_.write("l.txt", "node 0 0 0 1\nnode 20 0 0 1\nnode 0 20 0 1\nstrut 0 1\nstrut 0 2\n");
    const auto world = [&](const std::string& mesh, const char* fablet, const std::string& build) {
        scratch_.write(
            "cut.fab.json",
            R"({"openfab": 1, "printer": "generic", "fablets": {"f": {"source": "cut.fl", "fablet": ")" +
                std::string(fablet) +
                R"("}}, "materials": {"m": {"key": "#203040"}}, "meshes": {"s": )" + mesh +
                R"(}, "objects": {"o": {"mesh": "s", "fablet": "f", "uniforms": {"m": "m"}}}, "build": )" +
                build + "}");
    };
    const std::string placed =
        R"([{"object": "o", "rotate_deg": [0, 0, 90], "translate_mm": [5, -3, 7]},
        {"object": "o", "translate_mm": [60, 0, 0]}])";
    for (const auto& [mesh, fablet] :
         {std::pair(R"({"shape": "f", "box_mm": [[-25, -25, -25], [25, 25, 25]]})", "L"),
          {R"({"beams": "l.txt"})", "One"}}) {
        world(mesh, fablet, placed);
        const Outcome split = tool({"split", path("cut.fab.json"), "--fit", "12x12x12mm", "--peg",
                                    "0mm", "--number", "0mm", "-o", path("l.fab.json")});
        ASSERT_EQ(split.exit_code, 0) << split.err;
        EXPECT_THAT(split.out, ::testing::HasSubstr(": 3 pieces")) << fablet;
        // Two of each, of the two placements.
        int trays = 0;
        for (const char* tray : {"l", "l-2", "l-3", "l-4", "l-5", "l-6"}) {
            const std::string file = path(std::string(tray) + ".fab.json");
            if (!std::filesystem::exists(file)) continue;
            ++trays;
            const Outcome print = tool({"print", file, "-o", path("x.ofr"), "--voxel", "0.4mm"});
            EXPECT_EQ(print.exit_code, 0) << tray << ": " << print.err;
        }
        EXPECT_GE(trays, 2);
    }
    // Mirrored, too.
    for (const auto& [mesh, fablet] :
         {std::pair(R"({"shape": "f", "box_mm": [[-25, -25, -25], [25, 25, 25]]})", "L"),
          {R"({"beams": "l.txt"})", "One"}}) {
        world(mesh, fablet, R"([{"object": "o", "scale": [-1, 1, 1]}])");
        const Outcome mirrored =
            tool({"split", path("cut.fab.json"), "--fit", "12x12x12mm", "--peg", "0mm", "--number",
                  "0mm", "-o", path("m.fab.json")});
        EXPECT_EQ(mirrored.exit_code, 0) << mirrored.err;
        EXPECT_THAT(mirrored.out, ::testing::HasSubstr(": 3 pieces")) << fablet;
    }
    // Two that touch are one solid to the print.
    world(R"({"shape": "f", "box_mm": [[-25, -25, -25], [25, 25, 25]]})", "L",
          R"([{"object": "o"}, {"object": "o", "translate_mm": [22, 0, 0]}])");
    const Outcome touching =
        tool({"split", path("cut.fab.json"), "--fit", "12x12x12mm", "-o", path("l.fab.json")});
    EXPECT_EQ(touching.exit_code, 1);
    EXPECT_THAT(touching.err, Says(tools::messages::kPlacementsTouch, "o"));
    world(R"({"shape": "f", "box_mm": [[-20, -20, -20], [20, 20, 20]]})", "Ring", placed);
    const Outcome split = tool({"split", path("cut.fab.json"), "--fit", "20x20x20mm", "--peg",
                                "3mm", "--number", "0mm", "-o", path("ring.fab.json")});
    ASSERT_EQ(split.exit_code, 0) << split.err;
    const Result<JsonValue> cuts =
        parse_json(read_file(path("ring.cuts.json")), path("ring.cuts.json"));
    ASSERT_TRUE(cuts);
    int dowels = 0;
    const std::function<void(const JsonValue&)> look = [&](const JsonValue& cut) {
        if (const JsonMember* all = cut.find("connectors")) {
            for (const JsonValue& one : all->value.items) {
                const std::vector<JsonValue>& at = one.members.front().value.items;
                const double around = std::hypot(at[0].number, at[1].number) - 12;
                // All of a dowel of 3 mm, with its skin of 1.5 mm.
                EXPECT_LT(std::hypot(around, at[2].number), 4 - 1.5 - 1.5 + 0.3);
                ++dowels;
            }
        }
        for (const char* side : {"front", "back"})
            if (const JsonMember* next = cut.find(side)) look(next->value);
    };
    look(*cuts);
    EXPECT_GE(dowels, 2);
    // Whether they are inside, only the print could tell.
    const Outcome print =
        tool({"print", path("ring.fab.json"), "-o", path("x.ofr"), "--voxel", "0.5mm"});
    EXPECT_EQ(print.exit_code, 0) << print.err;
    EXPECT_THAT(print.err, Says(world::messages::kConnectorsNotCompared, "o"));
}

// The box reaches there, the shape does not.
TEST_F(Extents, AnEmptyPieceOfAShapeIsNothingToPrint) {
    write_worlds(R"([{"object": "o", "piece": "far"}])");
    std::string world = read_file(path("shape.fab.json"));
    const std::string fablet = R"("fablet": "round", "uniforms")";
    ASSERT_NE(world.find(fablet), std::string::npos);
    world.replace(
        world.find(fablet), fablet.size(),
        R"("fablet": "round", "pieces": {"normal": [1, 0, 0], "at_mm": 3.5, "back": "near", "front": "far"}, "uniforms")");
    scratch_.write("piece.fab.json", world);
    const Outcome out = tool({"print", path("piece.fab.json"), "-o", path("x.ofr")});
    EXPECT_EQ(out.exit_code, 1);
    EXPECT_THAT(out.err, Says(pipeline::messages::kNothingToPrint));
}

// As the print that follows has it.
TEST_F(Extents, ToolsTakeSettings) {
    write_worlds(R"([{"object": "o"}])");
    const std::string world = path("shape.fab.json");
    const Outcome arranged = tool({"arrange", world, "--fit", "9x9x9mm", "-o", path("t.fab.json"),
                                   "--turn", "none", "--set", "o.r=0.5"});
    EXPECT_THAT(arranged.out, ::testing::HasSubstr("3 x 3 x 3 mm")) << arranged.err;
    const Outcome split =
        tool({"split", world, "--fit", "9x9x9mm", "-o", path("s.fab.json"), "--set", "o.r=0.5"});
    EXPECT_THAT(split.out, Says(tools::messages::kFitsAsItIs, "object `o`, 3 x 3 x 3 mm"))
        << split.err;
    for (const char* one : {"arrange", "split"}) {
        const Outcome wrong = tool({one, path("beams.fab.json"), "--fit", "9x8x5mm", "-o",
                                    path("t.fab.json"), "--set", "o.r=0.5"});
        EXPECT_EQ(wrong.exit_code, 1) << one;
        EXPECT_THAT(wrong.err, ::testing::HasSubstr("o.r"));
    }
    const auto check = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{"check", world, "--draft", "2", "--wall", "1.5mm"};
        words.insert(words.end(), more.begin(), more.end());
        return tool(words);
    };
    EXPECT_EQ(check({}).exit_code, 0);
    const Outcome found = check({"--set", "o.r=0.2"});
    EXPECT_EQ(found.exit_code, 1) << found.err;
    EXPECT_THAT(found.out, ::testing::HasSubstr("wall"));
}

}  // namespace
}  // namespace openfab::testing
