// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Culling never changes the output: the same bytes with and without, for fablets that depend on the
// surface only near some depths, plain and displaced, rotated and stretched, in voxels that are not
// cubes.

#include <fmt/format.h>

#include "tests/scenes/scene_fixture.h"

namespace openfab::testing {
namespace {

constexpr const char* kFablets = R"(
import shell;

// Exact distances matter in a band, thinner than a block, that crosses blocks at any angle.
fablet ShellCore {
    @uniform { Material light, dark; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float share = shell_soft(distance(attr.voxelCenter), 1.1, 0.25);
        mc.Set(light, share);
        mc.Set(dark, 1 - share);
        return mc;
    }
}

// Layers thinner than a block: no block is uniform, some pieces are.
fablet Onion {
    @uniform { Material light, dark; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float inside = shell_onion(distance(attr.voxelCenter), 0.7);
        mc.Set(light, inside);
        mc.Set(dark, 1 - inside);
        return mc;
    }
}

// An attribute where the skin is, on a surface that is displaced by more than a block.
fablet Rough {
    @uniform { Material light, dark; }
    @Surface(@varying { SurfaceAttributes attr, out float shade, out int side })
    {
        shade = attr.p.x;
        side = attr.n.z > 0 ? 1 : 0;
        return attr.n * (0.3 + 0.3 * sin(attr.p.x * 4) * sin(attr.p.y * 4));
    }
    @Volume(@varying { VolumeAttributes attr, @nearest float shade, @nearest int side })
    {
        MaterialComposition mc;
        if (-distance(attr.voxelCenter) < 0.7 && side == 1) {
            float share = saturate(shade * 0.2 + 0.5);
            mc.Set(light, share);
            mc.Set(dark, 1 - share);
        } else {
            mc.Set(dark, 1);
        }
        return mc;
    }
}

// A picture on a front whose back is displaced: in a draft a block is as high as the card is thick.
fablet Card {
    @uniform { Material light, dark; }
    @Surface(@varying { SurfaceAttributes attr, out float shade, out int side })
    {
        shade = attr.p.x;
        side = attr.n.z > 0.5 ? 1 : 0;
        return attr.n.z < -0.5 ? attr.n * (0.4 + 0.4 * sin(attr.p.x * 4) * sin(attr.p.y * 4)) : float3(0, 0, 0);
    }
    @Volume(@varying { VolumeAttributes attr, @nearest float shade, @nearest int side })
    {
        MaterialComposition mc;
        if (side == 1 && abs(distance(attr.voxelCenter)) <= 0.4) {
            float share = saturate(shade * 0.05 + 0.5);
            mc.Set(light, share);
            mc.Set(dark, 1 - share);
        } else {
            mc.Set(dark, 1);
        }
        return mc;
    }
}

// Near the surface a loop of queries elsewhere, whose trips vary: a stage of segments.
fablet Marched {
    @uniform { Material light, dark; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float depth = -distance(attr.voxelCenter);
        float most = 0;
        if (depth < 0.7) {
            int steps = min(int(depth * 6), 5) + 1;
            for (int i = 0; i < steps; i++)
                most = max(most, -distance(attr.voxelCenter + float3(0.2 * (i + 1), 0, 0)));
        }
        mc.Set(light, saturate(most));
        mc.Set(dark, 1 - saturate(most));
        return mc;
    }
}
)";

constexpr const char* kWorld = R"({
    "openfab": 1,
    "printer": "j750",
    "fablets": {"it": {"source": "fablets.fl", "fablet": "FABLET"}},
    "materials": {"white": {"key": "#ffffff"}, "black": {"key": "#000000"}},
    "meshes": {"sphere": {"sphere": 6}},
    "objects": {"ball": {"mesh": "sphere", "fablet": "it", "uniforms": {"light": "white", "dark": "black"}}},
    "build": [
        {"object": "ball", "scale": [1, 0.7, 1.2], "rotate_deg": [25, 40, 10]},
        {"object": "ball", "translate_mm": [5, 2, 3]}
    ]
})";

constexpr const char* kCardWorld = R"({
    "openfab": 1,
    "printer": "j750",
    "fablets": {"it": {"source": "fablets.fl", "fablet": "FABLET"}},
    "materials": {"white": {"key": "#ffffff"}, "black": {"key": "#000000"}},
    "meshes": {"card": {"box": [20, 14, 1.3]}},
    "objects": {"card": {"mesh": "card", "fablet": "it", "max_displacement_mm": 0.8,
        "uniforms": {"light": "white", "dark": "black"}}},
    "build": [{"object": "card"}]
})";

class Culling : public ::testing::Test {
  protected:
    struct Printed {
        std::string bytes;
        double filled = 0, asked = 0;
    };

    Outcome try_print(const std::string& fablet, const std::vector<std::string>& arguments) {
        std::string world = world_;
        world.replace(world.find("FABLET"), 6, fablet);
        scratch_.write("ball.fab.json", world);
        scratch_.write("fablets.fl", kFablets);
        std::vector<std::string> argv{program("openfab").string(),
                                      "print",
                                      (scratch_ / "ball.fab.json").string(),
                                      "--draft",
                                      draft_,
                                      "-o",
                                      (scratch_ / "out.ofr").string(),
                                      "--stats",
                                      (scratch_ / "stats.json").string()};
        argv.insert(argv.end(), arguments.begin(), arguments.end());
        return run(argv, {{{"OPENFAB_CACHE", (scratch_ / "cache").string()}}, {}, {}});
    }

    Printed print(const std::string& fablet, const std::vector<std::string>& arguments) {
        const Outcome printed = try_print(fablet, arguments);
        EXPECT_EQ(printed.exit_code, 0) << printed.err;
        if (printed.exit_code != 0) return {};
        const std::filesystem::path statistics = scratch_ / "stats.json";
        return {read_file(scratch_ / "out.ofr"), statistic(statistics, "blocks/filled"),
                statistic(statistics, "queries/asked")};
    }

    /// Filled blocks, and the fraction of remaining queries, including those of culling itself.
    void check(const std::string& fablet, double least_filled, double most_asked) {
        const Printed all = print(fablet, {"--no-cull", "--threads", "1"});
        EXPECT_GT(all.bytes.size(), 1'000u);
        EXPECT_EQ(all.filled, 0);
        for (const char* threads : {"1", "2"}) {
            const Printed some = print(fablet, {"--threads", threads});
            EXPECT_TRUE(all.bytes == some.bytes) << fablet << ", " << threads << " threads";
            EXPECT_GE(some.filled, least_filled);
            EXPECT_LT(some.asked, most_asked * all.asked);
        }
        int64_t least = least_memory_mb(try_print(fablet, {"--memory", "16MB"}));
#ifdef OPENFAB_SANITIZED
        // A sanitizer's memory counts as resident and varies from run to run.
        least += least / 4;
#endif
        const Printed small = print(fablet, {"--memory", fmt::format("{}MB", least)});
        EXPECT_TRUE(all.bytes == small.bytes) << fablet << ", little memory";
    }

    std::string world_ = kWorld, draft_ = "2";
    ScratchFolder scratch_;
};

TEST_F(Culling, ShellAndCore) {
    check("ShellCore", 200, 0.5);
}

TEST_F(Culling, LayersThinnerThanABlock) {
    check("Onion", 0, 0.9);
}

TEST_F(Culling, AttributesOfADisplacedSkin) {
    // Boxes of displaced patches come before points: a few more voxels ask, and bounds cost less.
    check("Rough", 200, 0.75);
}

TEST_F(Culling, AFrontBeforeADisplacedBack) {
    // Queries end at the depth that is looked at.
    world_ = kCardWorld;
    for (const char* draft : {"3", "5", "7"}) {
        draft_ = draft;
        check("Card", 0, 1.01);
    }
}

TEST_F(Culling, LoopsOfQueriesNearTheSurface) {
    check("Marched", 40, 0.95);
}

}  // namespace
}  // namespace openfab::testing
