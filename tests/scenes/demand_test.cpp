// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Voxels that do not depend on their nearest surface point do not query it, and the print stays the
// same.

#include <cstdlib>

#include "tests/scenes/scene_fixture.h"

namespace openfab::testing {
namespace {

constexpr const char* kWorld = R"({
    "openfab": 1,
    "printer": "j750",
    "fablets": {"foam": {"source": "foam_skin.fl", "fablet": "FABLET"}},
    "materials": {"white": {"key": "#ffffff"}, "black": {"key": "#000000"}},
    "meshes": {"sphere": {"sphere": 6}},
    "objects": {"ball": {"mesh": "sphere", "fablet": "foam", "uniforms": {"light": "white", "dark": "black"}}},
    "build": [{"object": "ball"}]
})";

/// Voids first, then materials that need the distance and an attribute.
constexpr const char* kPlain = R"(
import foam;

fablet Plain {
    @uniform { Material light, dark; }
    @Surface(@varying { SurfaceAttributes attr, out float shade })
    {
        shade = attr.p.x;
        return 0;
    }
    @Volume(@varying { VolumeAttributes attr, @nearest float shade })
    {
        MaterialComposition mc;
        if (foam_voids_bcc(attr.voxelCenter, 3, 1) < 0) return mc;
        if (-distance(attr.voxelCenter) < 0.8) {
            mc.Set(light, saturate(shade * 0.2 + 0.5));
            mc.Set(dark, 1 - saturate(shade * 0.2 + 0.5));
        } else {
            mc.Set(light, 1);
        }
        return mc;
    }
}
)";

/// A loop whose trip count depends on the voxel.
constexpr const char* kLooping = R"(
import foam;

fablet Looping {
    @uniform { Material light, dark; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        if (foam_voids_bcc(attr.voxelCenter, 3, 1) < 0) return mc;
        float depth = -distance(attr.voxelCenter);
        int rings = 0;
        @bound(40)
        while (depth > 0) {
            depth -= 0.3;
            rings++;
        }
        if (rings % 2 == 0) mc.Set(light, 1); else mc.Set(dark, 1);
        return mc;
    }
}
)";

class Demand : public ::testing::Test {
  protected:
    struct Printed {
        std::string bytes;
        double asked = 0;
    };

    Printed print(const std::string& fablet, const std::string& source,
                  const std::vector<std::string>& arguments) {
        std::string world = kWorld;
        world.replace(world.find("FABLET"), 6, fablet);
        scratch_.write("ball.fab.json", world);
        scratch_.write("foam_skin.fl", source);
        const std::filesystem::path out = scratch_ / "out.ofr", stats = scratch_ / "stats.json";
        std::vector<std::string> argv{program("openflc").string(),
                                      "run",
                                      (scratch_ / "foam_skin.fl").string(),
                                      (scratch_ / "ball.fab.json").string(),
                                      "--draft",
                                      "4",
                                      "--no-cull",
                                      "-o",
                                      out.string(),
                                      "--stats",
                                      stats.string()};
        argv.insert(argv.end(), arguments.begin(), arguments.end());
        const Outcome printed =
            run(argv, {{{"OPENFAB_CACHE", (scratch_ / "cache").string()}}, {}, {}});
        EXPECT_EQ(printed.exit_code, 0) << printed.err;
        if (printed.exit_code != 0) return {};
        const std::string text = read_file(stats), key = "\"asked\":";
        const size_t at = text.find(key);
        EXPECT_NE(at, std::string::npos) << text;
        if (at == std::string::npos) return {};
        return {read_file(out), std::strtod(text.c_str() + at + key.size(), nullptr)};
    }

    void check(const std::string& fablet, const std::string& source) {
        const Printed all = print(fablet, source, {"--no-pass", "form_demand"});
        const Printed some = print(fablet, source, {});
        EXPECT_GT(all.bytes.size(), 5'000u);
        EXPECT_TRUE(all.bytes == some.bytes);
        // Balls of radius 1 on a body-centred grid of 3 mm are 0.31 of space.
        EXPECT_LT(some.asked, 0.75 * all.asked);
        EXPECT_GT(some.asked, 0.6 * all.asked);
    }

    ScratchFolder scratch_;
};

TEST_F(Demand, VoxelsInVoidsDoNotAsk) {
    check("Plain", kPlain);
}

TEST_F(Demand, VoxelsInVoidsDoNotAskInStagesOfSegments) {
    check("Looping", kLooping);
}

}  // namespace
}  // namespace openfab::testing
