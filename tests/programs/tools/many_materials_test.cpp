// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A world of more materials than 4 bits can name goes through every tool: print, verify, info,
// export, previews and statistics; with every dither.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <filesystem>

#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "world/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* kFablet = R"(fablet Mix {
    @uniform { Material a, b; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(a, 3);
        mc.Set(b, 1);
        return mc;
    }
}
)";

/// Cubes of 3 parts of one material and 1 of the next, side by side.
std::string world(int32_t materials) {
    std::string text = R"({"openfab": 1, "printer": "generic",
        "fablets": {"mix": {"source": "mix.fl", "fablet": "Mix"}},
        "meshes": {"cube": {"box": [1, 1, 1]}}, "materials": {)";
    std::string objects, build;
    for (int32_t m = 0; m < materials; ++m) {
        const std::string n = std::to_string(m);
        char key[8];
        std::snprintf(key, sizeof key, "#%06x", 0x010203 * (m + 1));
        text += (m > 0 ? ", " : "") + ("\"m" + n + "\": {\"key\": \"") + key +
                "\", \"preview\": \"" + key + "ff\"}";
        if (m % 2 != 0) continue;
        objects += (m > 0 ? ", " : "") + ("\"o" + n) +
                   R"(": {"mesh": "cube", "fablet": "mix", "uniforms": {"a": "m)" + n +
                   R"(", "b": "m)" + std::to_string(m + 1) + "\"}}";
        build += (m > 0 ? ", " : "") + (R"({"object": "o)" + n) + R"(", "translate_mm": [)" +
                 std::to_string(m) + ", 0, 0]}";
    }
    return text + "}, \"objects\": {" + objects + "}, \"build\": [" + build + "]}";
}

class ManyMaterials : public ::testing::Test {
  protected:
    ManyMaterials() {
        scratch_.write("mix.fl", kFablet);
        scratch_.write("world.fab.json", world(20));
        scratch_.write("few.fab.json", world(4));
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome openfab(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), program("openfab"));
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }

    ScratchFolder scratch_;
};

TEST_F(ManyMaterials, GoThroughEveryTool) {
    for (const std::string dither : {"floyd_steinberg", "decorrelated", "blue_noise", "majority"}) {
        const std::string file = path(dither + ".ofr");
        const Outcome printed =
            openfab({"print", path("world.fab.json"), "-o", file, "--dither", dither, "--stats",
                     path("stats.json"), "--preview", path("view.png")});
        ASSERT_EQ(printed.exit_code, 0) << printed.err;
        EXPECT_TRUE(fs::exists(path("view.png")));
        const std::string stats = read_file(path("stats.json"));
        // Cubes of 1000 voxels at 0.1 mm. Errors that are dropped at a cube's sides are part of
        // every rule.
        EXPECT_THAT(stats, HasSubstr("\"voxels_solid\": 10000"));
        if (dither == "majority") {
            EXPECT_THAT(stats, HasSubstr("\"m18\": 1000"));
            EXPECT_THAT(stats, HasSubstr("\"m19\": 0"));
        }

        const Outcome verified = openfab({"verify", file});
        EXPECT_EQ(verified.exit_code, 0) << verified.err;
        const Outcome told = openfab({"info", file});
        EXPECT_THAT(told.out, HasSubstr("8 bits"));
        EXPECT_THAT(told.out, HasSubstr("m19"));
    }
    const Outcome exported = openfab({"export", path("decorrelated.ofr"), "-o", path("exported")});
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    const Outcome slices = openfab({"print", path("world.fab.json"), "-o", path("printed"),
                                    "--format", "png", "--dither", "decorrelated"});
    ASSERT_EQ(slices.exit_code, 0) << slices.err;
    for (const char* name : {"slice_0001.png", "slice_0010.png"}) {
        const std::string picture = read_file(fs::path(path("printed")) / name);
        EXPECT_GT(picture.size(), 100u);
        EXPECT_TRUE(picture == read_file(fs::path(path("exported")) / name)) << name;
    }
    const Outcome indexed = openfab({"print", path("world.fab.json"), "-o", path("indexed"),
                                     "--format", "png", "--png", "indexed"});
    EXPECT_EQ(indexed.exit_code, 0) << indexed.err;
}

TEST_F(ManyMaterials, AllCodesOfASliceAreMaterials) {
    scratch_.write("all.fab.json", world(254));
    for (const std::string dither : {"floyd_steinberg", "decorrelated", "blue_noise", "majority"}) {
        const std::string file = path("all_" + dither + ".ofr");
        const Outcome printed = openfab({"print", path("all.fab.json"), "-o", file, "--dither",
                                         dither, "--stats", path("stats.json")});
        ASSERT_EQ(printed.exit_code, 0) << printed.err;
        rapidjson::Document stats;
        stats.Parse(read_file(path("stats.json")).c_str());
        EXPECT_EQ(stats["voxels_solid"].GetInt(), 127000);
        const rapidjson::Value& voxels = stats["voxels_by_material"];
        for (int i = 0; i < 254; i += 2) {
            const int first = voxels[fmt::format("m{}", i).c_str()].GetInt();
            EXPECT_EQ(first + voxels[fmt::format("m{}", i + 1).c_str()].GetInt(), 1000) << i;
            // Three quarters of it, or all of it by the majority.
            EXPECT_NEAR(first, dither == "majority" ? 1000 : 750, dither == "majority" ? 0 : 40);
        }
        const Outcome verified = openfab({"verify", file});
        EXPECT_EQ(verified.exit_code, 0) << verified.err;
        EXPECT_THAT(openfab({"info", file}).out, HasSubstr("m253"));
    }
    const Outcome indexed = openfab({"print", path("all.fab.json"), "-o", path("all_indexed"),
                                     "--format", "png", "--png", "indexed"});
    EXPECT_EQ(indexed.exit_code, 0) << indexed.err;
    scratch_.write("more.fab.json", world(256));
    const Outcome more = openfab({"print", path("more.fab.json"), "-o", path("more.ofr")});
    EXPECT_EQ(more.exit_code, 1);
    EXPECT_THAT(more.err, Says(world::messages::kTooManyMaterials, 254));
}

TEST_F(ManyMaterials, FourBitsDoForFew) {
    ASSERT_EQ(openfab({"print", path("few.fab.json"), "-o", path("few.ofr")}).exit_code, 0);
    EXPECT_THAT(openfab({"info", path("few.ofr")}).out, HasSubstr("4 bits"));
}

TEST_F(ManyMaterials, AreRefusedByAPrinterOfFewer) {
    const Outcome outcome =
        openfab({"print", path("world.fab.json"), "--printer", "connex500", "-o", path("no.ofr")});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("20 materials"));
    EXPECT_FALSE(fs::exists(path("no.ofr")));
}

TEST_F(ManyMaterials, AnUnknownDitherIsAUsageError) {
    const Outcome outcome =
        openfab({"print", path("few.fab.json"), "--dither", "ordered", "-o", path("no.ofr")});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("floyd_steinberg, decorrelated, blue_noise, majority"));
}

}  // namespace
}  // namespace openfab::testing
