// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `--only-object` for every kind of geometry: the voxels that a world has that builds nothing else, in the grid
// of the whole build.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "backends/ofr/ofr_reader.h"
#include "program/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

constexpr const char* kFablets = R"(fablet Plain {
    @uniform { Material m; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
fablet Bumpy {
    @uniform { Material m; float by = 0.2; }
    @Surface(@varying { SurfaceAttributes attr }) { return by * attr.n; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
fablet Ball {
    @uniform { Material m; float r = 3; }
    @Shape(@varying { ShapeAttributes attr }) { return length(attr.p) - r; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
fablet Skin {
    @uniform { Material m; Object core; }
    @Shape(@varying { ShapeAttributes attr }) { return distance_to(core, attr.p) - 1; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
struct Bar { float3 end[2]; float radius; int children; float reach; };
fablet Tree {
    @uniform { Material m; int levels = 3; }
    @Grow(@varying { GrowAttributes attr, Bar parent })
    {
        Bar b;
        b.end[0] = float3(0, 0, 1);
        if (attr.level > 0) b.end[0] = parent.end[1];
        b.end[1] = b.end[0] + float3(attr.child == 0 ? 1 : -1, 0, 2);
        b.radius = 0.8;
        b.children = attr.level + 1 < levels ? 2 : 0;
        b.reach = 12;
        return b;
    }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
fablet Hollow {
    @uniform { Material m; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        if (attr.voxelCenter.x > 0) mc.Set(m, 1);
        return mc;
    }
}
)";

/// What the build has of an object, and with which options.
struct Kind {
    const char* object;
    const char* items;
};
constexpr Kind kKinds[] = {
    {"mesh", R"({"object": "mesh", "translate_mm": [1, 1, 2], "rotate_deg": [0, 0, 30]})"},
    {"box", R"({"object": "box", "translate_mm": [2, 1, 3]})"},
    {"body", R"({"object": "body", "translate_mm": [0, 0, 4]})"},
    {"bumpy", R"({"object": "bumpy", "translate_mm": [1, 0, 4]})"},
    {"ball", R"({"object": "ball", "translate_mm": [0, 2, 4]})"},
    {"skin", R"({"object": "skin", "translate_mm": [0, 2, 4]})"},
    {"truss", R"({"object": "truss", "translate_mm": [0, 0, 3]})"},
    {"tree", R"({"object": "tree", "translate_mm": [0, 0, 1]})"},
    {"post", R"({"object": "post", "translate_mm": [0, 0, 2]})"},
    {"cut", R"({"object": "cut", "piece": "left", "translate_mm": [1, 0, 2]})"},
    {"filed", R"({"object": "filed", "translate_mm": [1, 0, 2]})"},
    {"hollow", R"({"object": "hollow", "translate_mm": [1, 0, 2]})"},
    // Placed twice, and in a group beside another one.
    {"box",
     R"({"object": "box", "grid": {"count": [2, 1, 1], "spacing_mm": [1, 0, 0]}, "translate_mm": [-3, 0, 2]})"},
    {"thing", R"({"group": "pair", "translate_mm": [0, 1, 2]})"},
};

using Voxels = std::map<std::array<int64_t, 3>, int>;  ///< codes, by voxel of the lattice

class OnlyObject : public ::testing::Test {
  protected:
    OnlyObject() {
        scratch_.write("f.fl", kFablets);
        scratch_.write("two.obj", [] {
            std::string text;
            for (const char* name : {"left", "right"}) {
                const int from = text.empty() ? -4 : 1;
                text += std::string("g ") + name + "\n";
                for (int v = 0; v < 8; ++v)
                    text += fmt::format("v {} {} {}\n", from + 3 * (v & 1), 4 * (v >> 1 & 1) - 2,
                                        3 * (v >> 2));
                for (const char* face : {"-8 -6 -5 -7", "-4 -3 -1 -2", "-8 -7 -3 -4", "-6 -2 -1 -5",
                                         "-8 -4 -2 -6", "-7 -5 -1 -3"})
                    text += std::string("f ") + face + "\n";
            }
            return text;
        }());
        scratch_.write("truss.txt", "node -4 0 0 1\nnode 4 1 2 1.5\nstrut 0 1\n");
        scratch_.write("cuts.json",
                       R"({"normal": [1, 0, 0], "at_mm": 0.5, "back": "left", "front": "right"})");
        scratch_.write("post.py",
                       "import sys\nfor line in sys.stdin:\n"
                       "    print('beam 0 0 1 6 0 1 1 1')\n    print('done', flush=True)\n");
        scratch_.write("own.printer.json", R"({"name": "own", "pitch_mm": [0.5, 0.5, 0.5],
            "build_volume_mm": [300, 300, 300], "max_materials": 8, "native_format": "ofr", "makes_support": true})");
    }

    std::string world(const std::string& build) const {
        const std::string cut =
            R"({"normal": [1, 0, 0], "at_mm": 0.5, "back": "left", "front": "right"})";
        std::string objects;
        for (const auto& [name, mesh, fablet, more] : std::vector<std::array<std::string, 4>>{
                 {"mesh", "file", "plain", ""},
                 {"box", "box", "plain", ""},
                 {"body", "body", "plain", ""},
                 {"bumpy", "sphere", "bumpy", ""},
                 {"ball", "ball", "ball", ""},
                 {"skin", "skin", "skin", ""},
                 {"truss", "truss", "plain", ""},
                 {"tree", "tree", "tree", ""},
                 {"post", "post", "plain", ""},
                 {"cut", "box", "plain", R"(, "pieces": )" + cut},
                 {"filed", "box", "plain", R"(, "pieces": "cuts.json")"},
                 {"hollow", "box", "hollow", ""},
                 {"thing", "sphere", "plain", ""},
                 {"core", "box", "plain", ""},
                 {"block", "block", "plain", R"(, "priority": 5)"}}) {
            std::string uniforms = name == "block" ? R"("m": "a")" : R"("m": "b")";
            if (name == "ball") uniforms += R"(, "r": 2.5)";
            if (name == "skin") uniforms += R"(, "core": "core")";
            objects +=
                fmt::format(R"({}"{}": {{"mesh": "{}", "fablet": "{}", "uniforms": {{{}}}{}}})",
                            objects.empty() ? "" : ", ", name, mesh, fablet, uniforms, more);
        }
        const std::string name = fmt::format("w{}.fab.json", ++worlds_);
        scratch_.write(
            name,
            R"({"openfab": 1, "printer": "own.printer.json", "fablets": {)" +
                [] {
                    std::string out;
                    for (const auto& [key, fablet] :
                         std::map<std::string, std::string>{{"plain", "Plain"},
                                                            {"bumpy", "Bumpy"},
                                                            {"ball", "Ball"},
                                                            {"skin", "Skin"},
                                                            {"tree", "Tree"},
                                                            {"hollow", "Hollow"}})
                        out += fmt::format(R"({}"{}": {{"source": "f.fl", "fablet": "{}"}})",
                                           out.empty() ? "" : ", ", key, fablet);
                    return out;
                }() +
                R"(}, "materials": {"a": {"key": "#ffffff"}, "b": {"key": "#000000"}}, "meshes": {
    "block": {"box": [14, 10, 6]}, "file": {"file": "two.obj", "unit": "mm"},
    "body": {"file": "two.obj", "unit": "mm", "body": "right"},
    "box": {"box": [6, 4, 4]}, "sphere": {"sphere": 5}, "truss": {"beams": "truss.txt"},
    "ball": {"shape": "ball", "box_mm": [[-4, -4, -4], [4, 4, 4]]},
    "skin": {"shape": "skin", "box_mm": [[-5, -4, -2], [5, 4, 6]]},
    "tree": {"grow": "tree", "box_mm": [[-9, -9, -1], [9, 9, 16]]},
    "post": {"program": ["python3", "post.py"], "box_mm": [[-2, -2, -1], [8, 2, 3]]}},
"objects": {)" + objects +
                R"(}, "groups": {"pair": [{"object": "thing"}, {"object": "box", "translate_mm": [3, 0, 0]}]},
"build": [)" + build +
                "]}");
        return (scratch_ / name).string();
    }

    Outcome print(const std::string& file, std::vector<std::string> more) const {
        more.insert(more.begin(), {program("openfab").string(), "print", file, "--allow-programs",
                                   "--threads", "2"});
        return run(more, {{{"OPENFAB_CACHE", (scratch_ / "cache").string()}}, {}, {}});
    }

    /// Prints; the grid's lowest voxel and size go to `box`.
    Voxels voxels(const std::string& file, std::vector<std::string> more,
                  std::array<int64_t, 6>* box = nullptr) const {
        const std::string out = (scratch_ / "out.ofr").string();
        more.insert(more.end(), {"-o", out});
        const Outcome outcome = print(file, more);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        Voxels codes;
        auto reader = ofr::OfrReader::open(out);
        if (!reader) return codes;
        const pipeline::PrintInfo& info = (*reader)->info();
        std::array<int64_t, 3> low{};
        for (int a = 0; a < 3; ++a)
            low[static_cast<size_t>(a)] = std::llround(info.origin_mm[a] / info.pitch_mm[a]);
        if (box != nullptr) *box = {low[0], low[1], low[2], info.size.x, info.size.y, info.size.z};
        for (int64_t z = 0;; ++z) {
            const Result<bool> one = (*reader)->next();
            if (!one || !*one) return codes;
            for (int32_t y = 0; y < info.size.y; ++y)
                for (int32_t x = 0; x < info.size.x; ++x)
                    if (const int code = (*reader)->slice().code(x, y, info.bits); code != 0)
                        codes[{low[0] + x, low[1] + y, low[2] + z}] = code;
        }
    }

    ScratchFolder scratch_;
    mutable int worlds_ = 0;
};

constexpr const char* kBlock = R"({"object": "block"})";

TEST_F(OnlyObject, IsWhatAWorldBuildsOfItAlone) {
    for (const Kind& kind : kKinds) {
        const std::string both = world(std::string(kBlock) + ", " + kind.items);
        std::array<int64_t, 6> whole{}, only{};
        voxels(both, {}, &whole);
        const Voxels got = voxels(both, {"--only-object", kind.object}, &only);
        EXPECT_EQ(whole, only) << kind.object;
        Voxels alone = voxels(world(kind.items), {});
        if (std::string(kind.object) == "thing") {
            // The group's other one is placed, too: what is left of it is the box.
            const Voxels box = voxels(both, {"--only-object", "box"});
            EXPECT_FALSE(box.empty());
            Voxels united = got;
            united.insert(box.begin(), box.end());
            EXPECT_EQ(united, alone);
            continue;
        }
        EXPECT_FALSE(got.empty()) << kind.object;
        EXPECT_TRUE(got == alone) << kind.object << ": " << got.size() << " and " << alone.size();
    }
}

TEST_F(OnlyObject, WhatIsNotBuiltLiesWhereItsMeshDoesAndIsCutByTheGrid) {
    const std::string block = world(kBlock);
    std::array<int64_t, 6> grid{};
    voxels(block, {}, &grid);
    for (const Kind& kind : kKinds) {
        if (std::string(kind.items).find("group") != std::string::npos) continue;
        std::array<int64_t, 6> only{};
        const Voxels got = voxels(block, {"--only-object", kind.object}, &only);
        EXPECT_EQ(grid, only) << kind.object;
        // Uncut: nothing says how far apart its pieces would be.
        std::string object = kind.object;
        if (object == "cut" || object == "filed") object = "core";
        Voxels alone = voxels(world(fmt::format(R"({{"object": "{}"}})", object)), {});
        std::erase_if(alone, [&](const auto& one) {
            for (size_t a = 0; a < 3; ++a)
                if (one.first[a] < grid[a] || one.first[a] >= grid[a] + grid[a + 3]) return true;
            return false;
        });
        EXPECT_FALSE(got.empty()) << kind.object;
        EXPECT_TRUE(got == alone) << kind.object << ": " << got.size() << " and " << alone.size();
    }
}

TEST_F(OnlyObject, ASolidIsFullWhateverItsFabletMakesOfIt) {
    const std::string both =
        world(std::string(kBlock) + ", " + R"({"object": "hollow", "translate_mm": [1, 0, 2]})");
    const std::string box = world(R"({"object": "core", "translate_mm": [1, 0, 2]})");
    const Voxels half = voxels(both, {"--only-object", "hollow"});
    std::array<int64_t, 6> whole{}, around{};
    voxels(both, {}, &whole);
    const Voxels full =
        voxels(both, {"--only-object", "hollow", "--solid", "--around", "2"}, &around);
    EXPECT_LT(half.size(), full.size());
    Voxels expected = voxels(box, {});
    for (auto& [at, code] : expected)
        code = 1;
    EXPECT_EQ(full, expected);
    for (size_t a = 0; a < 3; ++a) {
        EXPECT_EQ(around[a], whole[a] - 2);
        EXPECT_EQ(around[a + 3], whole[a + 3] + 4);
    }
}

TEST_F(OnlyObject, TakesSettingsAndTheirDraftsAndSlices) {
    const std::string both = world(std::string(kBlock) + ", " + kKinds[4].items);
    const std::string alone = world(kKinds[4].items);
    for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{
             {"--set", "ball.r=1.7"}, {"--draft", "2"}, {"--voxel", "0.3mm"}}) {
        std::vector<std::string> only = more;
        only.insert(only.end(), {"--only-object", "ball"});
        EXPECT_EQ(voxels(both, only), voxels(alone, more)) << more[0];
    }
    const Outcome wrong =
        print(both, {"--only-object", "bal", "-o", (scratch_ / "x.ofr").string()});
    EXPECT_EQ(wrong.exit_code, 1);
    EXPECT_THAT(wrong.err, ::testing::AllOf(Says(program::messages::kNoSuchOnlyObject, "bal"),
                                            ::testing::HasSubstr("did you mean `ball`")));
    // It is another print: what is there is not continued.
    const std::string out = (scratch_ / "r.ofr").string();
    EXPECT_EQ(print(both, {"-o", out}).exit_code, 0);
    EXPECT_NE(print(both, {"--only-object", "ball", "-o", out, "--resume"}).exit_code, 0);
}

TEST_F(OnlyObject, AsBuiltIsThePartThatComesOut) {
    const std::string plain = world(kKinds[1].items);
    const Voxels meant = voxels(plain, {});
    scratch_.write("process.json", R"({"scale": [1, 1.1, 1.25]})");
    const std::vector<std::string> process{"--process", (scratch_ / "process.json").string()};
    EXPECT_NE(voxels(plain, process), meant);
    std::vector<std::string> built = process;
    built.push_back("--as-built");
    EXPECT_EQ(voxels(plain, built), meant);
    // Without a bleed it has none to show; with one, that of `--bleed both`.
    scratch_.write("process.json",
                   R"({"bleed": {"pairs": [{"materials": ["void", "*"], "sigma_um": 400}]}})");
    std::vector<std::string> shown = process;
    shown.insert(shown.end(), {"--bleed", "both"});
    EXPECT_EQ(voxels(plain, built), voxels(plain, shown));
    EXPECT_NE(voxels(plain, built), meant);
}

}  // namespace
}  // namespace openfab::testing
