// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab import`, `new` and quick mode, up to the print, without writing OpenFL.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "mesh/model/messages.h"
#include "mesh/read/messages.h"
#include "program/messages.h"
#include "runtime/part/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"
#include "tools/color/ink_table.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A block of 4 x 4 x 2 mm: its top has the material `photo`, all else `red`.
constexpr const char* kBlock = R"(mtllib block.mtl
v 0 0 0
v 4 0 0
v 4 4 0
v 0 4 0
v 0 0 2
v 4 0 2
v 4 4 2
v 0 4 2
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl red
f 4/1 3/2 2/3 1/4
f 1/1 2/2 6/3 5/4
f 2/1 3/2 7/3 6/4
f 3/1 4/2 8/3 7/4
f 4/1 1/2 5/3 8/4
usemtl photo
f 5/1 6/2 7/3 8/4
)";

class OpenfabImport : public ::testing::Test {
  protected:
    OpenfabImport() {
        scratch_.write("block.obj", kBlock);
        scratch_.write("block.mtl",
                       "newmtl red\nKd 1 0 0\nnewmtl photo\nKd 1 1 1\nmap_Kd photo.ppm\n");
        // Cyan on the left, black on the right.
        scratch_.write("photo.ppm", "P3 2 1 255 0 255 255 0 0 0\n");
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome openfab(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), program("openfab"));
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    /// Returns the millilitres of a material in a print, from `openfab info`; 0 if it has none.
    double ml(const std::string& file, const std::string& material) const {
        const std::string text = openfab({"info", path(file)}).out;
        const size_t at = text.find(" " + material + ", ");
        if (at == std::string::npos) ADD_FAILURE() << "no " << material << " in " << text;
        return at == std::string::npos ? 0 : std::atof(text.c_str() + at + material.size() + 3);
    }

    ScratchFolder scratch_;
};

TEST_F(OpenfabImport, ColoursAreMixedByAProfile) {
    const std::string table = source_dir() / "gallery/ink_profile/inks.nrrd";
    std::string grey = kBlock;
    for (size_t at = 0; (at = grey.find("\nv ", at)) != std::string::npos; ++at)
        grey.insert(grey.find('\n', at + 1), " 0.5 0.5 0.5");
    grey.erase(0, grey.find('\n') + 1);  // no materials, and one group
    for (size_t at = 0; (at = grey.find("usemtl")) != std::string::npos;)
        grey.erase(at, grey.find('\n', at) + 1 - at);
    scratch_.write("grey.obj", grey);
    const Outcome imported = openfab(
        {"import", path("grey.obj"), "-o", path("grey"), "--size", "20mm", "--profile", table});
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_THAT(imported.err, Says(tools::messages::kSummaryFablets, "", "", "`painted`"));
    // Inks right through, so that the whole block is what the table says of that grey.
    const Outcome printed = openfab({"print", path("grey/grey.fab.json"), "-o", path("grey.ofr"),
                                     "--voxel", "0.2mm", "--set", "grey.depth=50"});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const Result<color::InkTable> inks = color::InkTable::read(table);
    ASSERT_TRUE(inks) << inks.error().text();
    const color::Inks wanted = inks->at({0.5, 0.5, 0.5});
    size_t i = 0;
    for (const char* name : {"cyan", "magenta", "yellow", "black"})
        EXPECT_NEAR(ml("grey.ofr", name) / 4, wanted[i++], 0.005) << name;

    // A picture by texture coordinates and one that is laid on take it, too.
    for (const std::string mapping : {"uv", "box"}) {
        const std::string folder = "profile_" + mapping;
        const Outcome one = openfab({"import", path("block.obj"), "-o", path(folder), "--unit",
                                     "mm", "--mapping", mapping, "--profile", table});
        ASSERT_EQ(one.exit_code, 0) << one.err;
        const std::string source =
            path(folder + (mapping == "uv" ? "/stock_textured.fl" : "/stock_mapped.fl"));
        const Outcome checked = run({program("openflc"), "check", source}, {});
        EXPECT_EQ(checked.exit_code, 0) << checked.err;
    }
    const auto refused = [&](const std::vector<std::string>& more, int code,
                             const std::string& message) {
        std::vector<std::string> arguments{"import", path("block.obj"), "-o", path("no")};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = openfab(arguments);
        EXPECT_EQ(outcome.exit_code, code) << outcome.err;
        EXPECT_THAT(outcome.err, Says(message));
    };
    refused({"--profile", table, "--fablet", "shell"}, 2,
            fmt::format(tools::messages::kIsForFablets, "--profile",
                        tools::messages::kFabletsWithInks, "shell"));
    refused({"--profile", path("photo.ppm")}, 1, tools::messages::kNoTableOfInks);
    refused({"--profile", path("none.nrrd")}, 1, "none.nrrd");
}

TEST_F(OpenfabImport, ATexturedModelPrintsByItsMaterials) {
    const Outcome imported = openfab({"import", path("block.obj"), "-o", path("made")});
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_THAT(imported.err, Says(tools::messages::kSummaryFablets, "", "", "`textured`"));
    EXPECT_THAT(imported.err, Says(tools::messages::kNoUnit, "*", "4", "4", "2"));
    const Outcome printed = openfab(
        {"print", path("made/block.fab.json"), "-o", path("a.ofr"), "--set", "block.density=1"});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    // Half a millimetre below the photo is coloured; density 1 makes 1 / 16 of light a full ink.
    // Its left half is cyan and its right half black; what is nearer to another side is red.
    EXPECT_GT(ml("a.ofr", "cyan"), 0.0015);
    EXPECT_LT(ml("a.ofr", "cyan"), 0.006);
    EXPECT_EQ(ml("a.ofr", "magenta"), 0);
    EXPECT_EQ(ml("a.ofr", "yellow"), 0);
    EXPECT_GT(ml("a.ofr", "black"), 0.0008);
    EXPECT_GT(ml("a.ofr", "white"), 0.002);
    EXPECT_NEAR(ml("a.ofr", "red"), 0.0227, 0.001);  // all but the frustum under the photo
    // Does not overwrite files.
    EXPECT_EQ(openfab({"import", path("block.obj"), "-o", path("made")}).exit_code, 1);
}

// The remedy in the error for an open mesh.
TEST_F(OpenfabImport, AnOpenMeshIsRepairedWhereThatIsAskedFor) {
    const std::string block = kBlock;
    scratch_.write("open.obj", block.substr(0, block.find("usemtl photo")));
    const Outcome refused = openfab({"import", path("open.obj"), "-o", path("made")});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, HasSubstr("4 open edges"));
    EXPECT_THAT(refused.err, Says(mesh::messages::kNotClosedHelp));
    EXPECT_FALSE(fs::exists(path("made")));
    const Outcome imported = openfab({"import", path("open.obj"), "-o", path("made"), "--fablet",
                                      "solid", "--repair", "winding"});
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_THAT(read_file(path("made/open.fab.json")), HasSubstr("\"repair\": \"winding\","));
    const Outcome printed = openfab({"print", path("made/open.fab.json"), "-o", path("a.ofr")});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    // The hole is capped: all of 4 x 4 x 2 mm.
    EXPECT_NEAR(ml("a.ofr", "red"), 0.032, 0.0005);
}

TEST_F(OpenfabImport, EachGroupOfASolidHasItsMaterial) {
#ifdef OPENFAB_SANITIZED
    GTEST_SKIP() << "the first test compiles and prints; more of the same would take minutes";
#endif
    ASSERT_EQ(openfab({"import", path("block.obj"), "-o", path("made"), "--fablet", "solid",
                       "--size", "2mm"})
                  .exit_code,
              0);
    ASSERT_EQ(
        openfab({"print", path("made/block.fab.json"), "-o", path("a.ofr"), "--voxel", "0.05mm"})
            .exit_code,
        0);
    // 2 x 2 x 1 mm; nearest to the top is a frustum, at least the pyramid under it.
    EXPECT_NEAR(ml("a.ofr", "red") + ml("a.ofr", "photo"), 0.004, 0.0011);
    EXPECT_GT(ml("a.ofr", "photo"), 0.0005);
    EXPECT_GT(ml("a.ofr", "red"), ml("a.ofr", "photo"));
}

TEST_F(OpenfabImport, QuickModeTakesAStockFablet) {
#ifdef OPENFAB_SANITIZED
    GTEST_SKIP() << "the first test compiles and prints; more of the same would take minutes";
#endif
    const Outcome outcome = openfab({"print", path("block.obj"), "--fablet", "shell", "--set",
                                     "block.thickness=0.5", "-o", path("a.ofr")});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, Says(program::messages::kNoPrinterNamed, "generic", "0.1*"));
    EXPECT_NEAR(ml("a.ofr", "skin") + ml("a.ofr", "core"), 0.032, 0.0001);
    EXPECT_NEAR(ml("a.ofr", "core"), 0.009, 0.0011);
    const Outcome without = openfab({"print", path("block.obj"), "-o", path("b.ofr")});
    EXPECT_EQ(without.exit_code, 2);
    EXPECT_THAT(without.err, HasSubstr("`textured`"));
}

TEST_F(OpenfabImport, QuickModeTakesAPicture) {
#ifdef OPENFAB_SANITIZED
    GTEST_SKIP() << "the first test compiles and prints; more of the same would take minutes";
#endif
    scratch_.write("photo.ppm", "P3 2 1 255 255 255 255 0 0 0\n");
    const Outcome outcome =
        openfab({"print", path("block.obj"), "--fablet", "relief", "-o", path("a.ofr"), "--set",
                 "block.map=" + path("photo.ppm"), "--set", "block.height=-0.5"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_LT(ml("a.ofr", "material"), 0.031);  // engraved
    const Outcome gone = openfab({"print", path("block.obj"), "--fablet", "relief", "-o",
                                  path("a.ofr"), "--set", "block.map=gone.png"});
    EXPECT_EQ(gone.exit_code, 1);
    EXPECT_THAT(gone.err, Says(part::messages::kNoSuchFile, "gone.png"));
}

/// The block without texture coordinates.
std::string plain_block() {
    std::string block = kBlock, out;
    block = block.substr(0, block.find("vt ")) + block.substr(block.find("usemtl red"));
    for (size_t i = 0; i < block.size(); ++i) {
        if (block[i] == '/') {
            ++i;
        } else {
            out += block[i];
        }
    }
    return out;
}

TEST_F(OpenfabImport, APictureIsMappedOntoAMeshWithoutCoordinates) {
    scratch_.write("plain.obj", plain_block());
    scratch_.write("two.ppm", "P3 2 1 255 0 255 255 0 0 0\n");
    const Outcome imported =
        openfab({"import", path("plain.obj"), "-o", path("made"), "--picture", path("two.ppm")});
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_THAT(imported.err, Says(tools::messages::kSummaryFablets, "", "", "`mapped`"));
    EXPECT_THAT(imported.err, Says(tools::messages::kOnSixSides));
    const std::string world = read_file(path("made/plain.fab.json"));
    EXPECT_THAT(world, HasSubstr("\"mapping\": 1"));
    EXPECT_THAT(world, HasSubstr("\"center\": [2, 2, 1]"));
    EXPECT_THAT(world, HasSubstr("\"size\": [4, 4, 2]"));
    EXPECT_THAT(world, HasSubstr("\"wrap\": \"clamp\""));
    // Planar from the front the left half is cyan, from the right the front half, right through.
    const auto world_of = [&](const std::string& folder, std::vector<std::string> more) {
        more.insert(more.begin(), {"import", path("plain.obj"), "-o", path(folder), "--picture",
                                   path("two.ppm")});
        const Outcome outcome = openfab(more);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return read_file(path(folder + "/plain.fab.json"));
    };
    EXPECT_THAT(world_of("top", {"--mapping", "planar"}), HasSubstr("\"side\": 4"));
    EXPECT_THAT(world_of("tiled", {"--mapping", "triplanar", "--picture-size", "1mm"}),
                HasSubstr("\"size\": [1, 1, 1]"));
    EXPECT_THAT(world_of("scaled", {"--mapping", "box", "--size", "8mm"}),
                HasSubstr("\"size\": [8, 8, 4]"));
}

TEST_F(OpenfabImport, AMappedPictureIsPrintedWhereItIs) {
#ifdef OPENFAB_SANITIZED
    GTEST_SKIP() << "the first test compiles and prints; more of the same would take minutes";
#endif
    scratch_.write("plain.obj", plain_block());
    // The lower left quarter is black, and blends into the others.
    scratch_.write("two.ppm", "P3 2 2 255 255 255 255 255 255 255 0 0 0 255 255 255\n");
    const auto black = [&](const std::string& name, std::vector<std::string> more) {
        more.insert(more.begin(),
                    {"import", path("plain.obj"), "-o", path(name), "--picture", path("two.ppm")});
        EXPECT_EQ(openfab(more).exit_code, 0);
        const Outcome printed = openfab({"print", path(name + "/plain.fab.json"), "-o",
                                         path(name + ".ofr"), "--set", "plain.depth=5"});
        EXPECT_EQ(printed.exit_code, 0) << printed.err;
        const std::string slice = path(name + ".png");
        EXPECT_EQ(openfab({"export", path(name + ".ofr"), "--slice", "2", "-o", slice}).exit_code,
                  0);
        return read_png(slice);
    };
    // Black where y is low and x is low; the first row of a slice is at the highest y.
    const auto dark = [](const ReadPng& png, int32_t x, int32_t y) {
        const auto& p = png.at(x * png.width / 40, y * png.height / 40);
        return p[3] != 0 && p[0] + p[1] + p[2] < 100;
    };
    const auto share = [&](const ReadPng& png, int32_t x0, int32_t y0) {
        int count = 0;
        for (int32_t y = y0 + 3; y < y0 + 17; ++y) {
            for (int32_t x = x0 + 3; x < x0 + 17; ++x)
                count += dark(png, x, y) ? 1 : 0;
        }
        return count / 196.0;
    };
    const ReadPng top = black("top", {"--mapping", "planar"});
    EXPECT_GT(share(top, 0, 20), 0.35);
    for (const auto& [x, y] : {std::pair{0, 0}, {20, 0}, {20, 20}})
        EXPECT_LT(share(top, x, y), 0.1) << x << ' ' << y;
    // From the back the left is at the highest x; slice 2 is in the lower half.
    const ReadPng back = black("back", {"--mapping", "planar", "--side", "back"});
    EXPECT_GT(share(back, 20, 0), 0.35);
    EXPECT_GT(share(back, 20, 20), 0.35);
    EXPECT_LT(share(back, 0, 0) + share(back, 0, 20), 0.1);
}

TEST_F(OpenfabImport, OptionsThatDoNotGoTogetherAreTold) {
    scratch_.write("plain.obj", plain_block());
    const auto told = [&](std::vector<std::string> more, int code, const std::string& words) {
        more.insert(more.begin(), {"import", path("plain.obj"), "-o", path("made")});
        const Outcome outcome = openfab(more);
        EXPECT_EQ(outcome.exit_code, code) << outcome.err;
        EXPECT_THAT(outcome.err, Says(words));
        EXPECT_FALSE(fs::exists(path("made")));
    };
    const std::string photo = path("photo.ppm");
    told({"--picture", photo, "--fablet", "solid"}, 2,
         fmt::format(tools::messages::kIsForFablets, "--picture",
                     tools::messages::kFabletsWithPicture, "solid"));
    told({"--picture", photo, "--mapping", "uv"}, 1, tools::messages::kNoCoordinatesMappingHelp);
    told({"--picture", photo, "--side", "top"}, 2, tools::messages::kSideIsForPlanar);
    told({"--mapping", "box", "--fablet", "shell"}, 2,
         fmt::format(tools::messages::kIsForFablets, "--mapping", tools::messages::kTheFabletMapped,
                     "shell"));
    told({"--fablet", "solid", "--picture-size", "3mm"}, 2,
         fmt::format(tools::messages::kIsForFablets, "--picture-size", "{}", "{}"));
    told({"--picture", photo, "--mapping", "box", "--picture-size", "0mm"}, 2,
         tools::messages::kMustBeAboveZero);
    told({"--mapping", "round"}, 2, "planar");
    const Outcome gltf = openfab({"import", path("a.glb"), "-o", path("made"), "--up", "y"});
    EXPECT_EQ(gltf.exit_code, 2);
    EXPECT_THAT(gltf.err, Says(tools::messages::kGltfIsYUp));
}

TEST_F(OpenfabImport, WhatIsReadIsListedForWhatIsNot) {
    scratch_.write("a.txt", "x");
    const Outcome outcome = openfab({"import", path("a.txt"), "-o", path("made")});
    EXPECT_EQ(outcome.exit_code, 2);
    for (const char* kind : {".obj", ".3mf", ".amf", ".off", ".step", ".wrl", ".usd", ".usdz"})
        EXPECT_THAT(outcome.err, HasSubstr(kind));
}

/// A pyramid whose base is at the lowest y, or z.
std::string pyramid(bool y_up) {
    std::string text;
    for (const auto& [x, across, up] :
         {std::array{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}, {0, 0, 10}}) {
        const int y = y_up ? up : across, z = y_up ? -across : up;
        text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
    }
    return text + "f 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
}

// Modules of the folder are a stranger's: they are neither USD's library nor run.
TEST_F(OpenfabImport, UsdNeedsItsLibrary) {
    scratch_.write("a.usda", "#usda 1.0\n");
    scratch_.write("pxr.py", "open('stranger', 'w')\nraise ImportError\n");
    scratch_.write("without/pxr.py", "raise ImportError\n");
    RunOptions options;
    options.folder = scratch_.path();
    options.environment = {{"PYTHONPATH", (scratch_ / "without").string()}};
    const auto import = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {program("openfab").string(), "import"});
        return run(words, options);
    };
    const Outcome outcome = import({"a.usda", "-o", "world"});
    EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("pip install usd-core"));
    EXPECT_FALSE(fs::exists(scratch_ / "stranger"));
    EXPECT_FALSE(fs::exists(scratch_ / "world"));
    const Outcome unit = import({"a.usda", "-o", "world", "--unit", "mm"});
    EXPECT_EQ(unit.exit_code, 2);
    EXPECT_THAT(unit.err, Says(tools::messages::kUsdSaysUnit));
    const Outcome missing = import({"b.usdz", "-o", "world"});
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_THAT(missing.err, HasSubstr("b.usdz"));
}

TEST_F(OpenfabImport, AMeshStaysWhereItLies) {
    fs::create_directories(path("my part"));
    scratch_.write("my part/p (1).obj", read_file(path("block.obj")));
    scratch_.write("my part/block.mtl", "newmtl photo\nmap_Kd ../block.obj\n");
    const Outcome outcome =
        openfab({"import", path("my part/p (1).obj"), "-o", path("my part"), "--unit", "mm"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("my part/p (1).fab.json' -o 'p (1).ofr'"));
    EXPECT_THAT(outcome.err, ::testing::AllOf(Says(mesh::messages::kNotBelowFolder),
                                              Says(mesh::messages::kNotBelowFolderHelp)));
    EXPECT_EQ(openfab({"info", path("my part/p (1).fab.json")}).exit_code, 0);
}

TEST_F(OpenfabImport, AFigureThatLiesOnItsBackIsTold) {
    scratch_.write("figure.obj", pyramid(true));
    const Outcome lying = openfab({"import", path("figure.obj"), "-o", path("lying")});
    EXPECT_EQ(lying.exit_code, 0) << lying.err;
    EXPECT_THAT(lying.err, Says(tools::messages::kMayLieOnItsBack));
    EXPECT_THAT(lying.err, HasSubstr("2.5 times as tall in y as in z"));
    EXPECT_THAT(lying.err, HasSubstr("--up y"));
    const Outcome up = openfab(
        {"import", path("figure.obj"), "-o", path("up"), "--up", "y", "--fablet", "graded"});
    EXPECT_EQ(up.exit_code, 0) << up.err;
    EXPECT_THAT(up.err, ::testing::Not(HasSubstr("back")));
    const std::string world = read_file(path("up/figure.fab.json"));
    EXPECT_THAT(world, HasSubstr("\"up\": \"y\""));
    EXPECT_THAT(world, HasSubstr("\"high\": 10")) << "heights are along z";
    EXPECT_THAT(openfab({"info", path("up/figure.fab.json")}).out, HasSubstr("4 x 4 x 10 mm"));
    // Meshes that are z-up, flat or ambiguous are left alone.
    scratch_.write("stands.obj", pyramid(false));
    scratch_.write("plate.obj",
                   "v 0 0 0\nv 5 0 0\nv 5 20 0\nv 0 20 0\nv 0 0 1\nv 5 0 1\nv 5 20 1\nv 0 20 1\n"
                   "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    for (const char* name : {"stands", "plate", "block"}) {
        const Outcome outcome =
            openfab({"import", path(std::string(name) + ".obj"), "-o", path(name)});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_THAT(outcome.err, ::testing::Not(HasSubstr("back"))) << name;
    }
}

TEST_F(OpenfabImport, InfoTellsOfAMeshAndItsWorld) {
    const Outcome mesh = openfab({"info", path("block.obj")});
    EXPECT_EQ(mesh.exit_code, 0) << mesh.err;
    for (const char* line :
         {"unit       1 mm, assumed", "size       4 x 4 x 2 mm", "attribute  uv: 2 float",
          "group      red: face 0", "group      photo: face 1", "printable  yes"})
        EXPECT_THAT(mesh.out, HasSubstr(line));
    ASSERT_EQ(openfab({"import", path("block.obj"), "-o", path("made")}).exit_code, 0);
    const Outcome world = openfab({"info", path("made/block.fab.json")});
    EXPECT_THAT(world.out,
                HasSubstr("object     block: mesh block, fablet textured, placed 1 times"));
    EXPECT_THAT(world.out, HasSubstr("build      1 placed, 4 x 4 x 2 mm, from 0 0 0"));
}

TEST_F(OpenfabImport, ANewFolderPrints) {
#ifdef OPENFAB_SANITIZED
    GTEST_SKIP() << "the first test compiles and prints; more of the same would take minutes";
#endif
    ASSERT_EQ(openfab({"new", path("soft-toy")}).exit_code, 0);
    const Outcome outcome =
        openfab({"print", path("soft-toy/soft-toy.fab.json"), "-o", path("a.ofr"), "--draft", "4"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(read_file(path("soft-toy/soft-toy.fl")), HasSubstr("fablet SoftToy {"));
    EXPECT_EQ(openfab({"new", path("soft-toy")}).exit_code, 1);
    EXPECT_EQ(openfab({"new", path("7 toys")}).exit_code, 2);
}

/// A tetrahedron `copies` times, side by side.
std::string many_tetrahedra(int copies) {
    std::string text;
    for (int i = 0; i < copies; ++i) {
        const std::string x = std::to_string(2 * (i % 200)),
                          next = std::to_string(2 * (i % 200) + 1);
        const std::string y = std::to_string(2 * (i / 200)),
                          behind = std::to_string(2 * (i / 200) + 1);
        text += "v " + x + " " + y + " 0\nv " + next + " " + y + " 0\nv " + x + " " + behind +
                " 0\nv " + x + " " + y + " 1\n";
        text += "f -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n";
    }
    return text;
}

TEST_F(OpenfabImport, KeepsToItsMemory) {
    scratch_.write("many.obj", many_tetrahedra(60'000));
    scratch_.write("w.fab.json",
                   R"({"openfab": 1, "fablets": {}, "meshes": {"m": {"file": "many.obj"}},
        "objects": {}, "build": []})");
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"info", path("many.obj")},
          {"info", path("w.fab.json")},
          {"import", path("many.obj"), "-o", path("out")}}) {
        std::vector<std::string> arguments = command;
        arguments.insert(arguments.end(), {"--memory", "40MB"});
        const Outcome refused = openfab(arguments);
        EXPECT_EQ(refused.exit_code, 1) << refused.err;
        EXPECT_THAT(refused.err, Says(mesh::messages::kTooLargeToRead));
#ifndef OPENFAB_SANITIZED
        EXPECT_LT(refused.peak_rss_bytes, 80 << 20);
#endif
        arguments.back() = "some";
        EXPECT_EQ(openfab(arguments).exit_code, 2);
    }
    EXPECT_EQ(openfab({"info", path("many.obj"), "--memory", "400MB"}).exit_code, 0);
    const Outcome made =
        openfab({"import", path("many.obj"), "-o", path("out"), "--memory", "400MB"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    // Pictures count towards the memory, like the mesh.
    scratch_.write("photo.ppm", std::string(30'000'000, ' '));
    const Outcome picture = openfab({"import", path("block.obj"), "-o", path("block"), "--fablet",
                                     "textured", "--memory", "20MB"});
    EXPECT_EQ(picture.exit_code, 1) << picture.err;
    EXPECT_THAT(picture.err, Says(tools::messages::kPictureOfLeftOut, "photo.ppm",
                                  fmt::format(tools::messages::kOfMaterial, "photo")));
}

}  // namespace
}  // namespace openfab::testing
