// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab import`, `new` and quick mode, to the print: no OpenFL is written.

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/process/process.h"

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
        arguments.insert(arguments.begin(), OPENFAB_PROGRAM);
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    /// Millilitres of a material in a print, as `openfab info` tells them; 0 where it has none.
    double ml(const std::string& file, const std::string& material) const {
        const std::string text = openfab({"info", path(file)}).out;
        const size_t at = text.find(" " + material + ", ");
        if (at == std::string::npos) ADD_FAILURE() << "no " << material << " in " << text;
        return at == std::string::npos ? 0 : std::atof(text.c_str() + at + material.size() + 3);
    }

    ScratchFolder scratch_;
};

TEST_F(OpenfabImport, ATexturedModelPrintsByItsMaterials) {
    const Outcome imported = openfab({"import", path("block.obj"), "-o", path("made")});
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_THAT(imported.err, HasSubstr("the fablet `textured`"));
    EXPECT_THAT(imported.err, HasSubstr("says no unit: taken as millimetres, 4 x 4 x 2 mm"));
    const Outcome printed = openfab(
        {"print", path("made/block.fab.json"), "-o", path("a.ofr"), "--set", "block.density=1"});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    // Half a millimetre of each side is coloured; density 1 makes 1 / 16 of light a full ink. The
    // photo's left half is cyan and its right half black; red is magenta and yellow, five sides.
    EXPECT_GT(ml("a.ofr", "cyan"), 0.0015);
    EXPECT_LT(ml("a.ofr", "cyan"), 0.006);
    EXPECT_GT(ml("a.ofr", "magenta"), 0.004);
    EXPECT_GT(ml("a.ofr", "yellow"), 0.004);
    EXPECT_NEAR(ml("a.ofr", "magenta"), ml("a.ofr", "yellow"), 0.002);
    EXPECT_GT(ml("a.ofr", "black"), 0.0008);
    // The core of 3 x 3 x 1 mm at least.
    EXPECT_GE(ml("a.ofr", "white"), 0.009);
    // Not over what is there.
    EXPECT_EQ(openfab({"import", path("block.obj"), "-o", path("made")}).exit_code, 1);
}

// The way out that the refusal of an open mesh names.
TEST_F(OpenfabImport, AnOpenMeshIsRepairedWhereThatIsAskedFor) {
    const std::string block = kBlock;
    scratch_.write("open.obj", block.substr(0, block.find("usemtl photo")));
    const Outcome refused = openfab({"import", path("open.obj"), "-o", path("made")});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, HasSubstr("4 open edges"));
    EXPECT_THAT(refused.err, HasSubstr("`openfab import --repair winding`"));
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
    EXPECT_THAT(outcome.err, HasSubstr("`generic` prints voxels of 0.1"));
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
    EXPECT_THAT(gone.err, HasSubstr("there is no file `gone.png`"));
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

}  // namespace
}  // namespace openfab::testing
