// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What `openfab mechanics` makes of a world: objects that cases name, of every kind; the part that comes out of
// the machine; elements that are the printer's voxels; materials that nothing is made of.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "mechanics/messages.h"
#include "tests/programs/mechanics/model_world.h"
#include "tests/support/says/says.h"
#include "world/messages.h"

namespace openfab::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

TEST_F(MechanicsModel, AnObjectOfACaseIsFoundWhateverItIs) {
    const std::string cases =
        kBySide +
        std::string(
            R"(, "by_object": {"held": [{"object": "it", "side": "-x"}], "loads": [{"side": "+x", "force_N": [0, 0, -1]}]})");
    scratch_.write("own.printer.json", R"({"name": "own", "pitch_mm": [0.1, 0.1, 0.1],
"build_volume_mm": [300, 300, 300], "max_materials": 8, "native_format": "ofr", "makes_support": true})");
    scratch_.write("cuts.json",
                   R"({"normal": [1, 0, 0], "at_mm": 0, "back": "left", "front": "right"})");
    scratch_.write("post.py",
                   "import sys\nfor line in sys.stdin:\n    print('beam 0 0 1 10 0 1 1 1')\n"
                   "    print('done', flush=True)\n");
    const auto it = [](const std::string& mesh, const std::string& fablet = "one",
                       const std::string& uniforms = "", const std::string& more = "") {
        return fmt::format(
            R"({}, "it": {{"mesh": "{}", "fablet": "{}", "uniforms": {{"m": "stiff"{}}}{}}})", kBar,
            mesh, fablet, uniforms, more);
    };
    const std::string stands = R"({"object": "it", "translate_mm": [0, 0, 0]})";
    const std::vector<std::array<std::string, 4>> kinds{
        {"", it("bar"), stands, "own.printer.json"},
        {"", it("bar", "one", "", R"(, "pieces": "cuts.json")"),
         R"({"object": "it", "piece": "left"})", "generic"},
        {"",
         it("bar", "one", "",
            R"(, "pieces": {"normal": [1, 0, 0], "at_mm": 0, "back": "left", "front": "right"})"),
         R"({"object": "it", "piece": "left"})", "generic"},
        {R"("post": {"program": ["python3", "post.py"], "box_mm": [[-2, -2, -1], [12, 2, 3]]})",
         it("post"), stands, "generic"},
        {R"("skin": {"shape": "skin", "box_mm": [[-8, -5, -5], [8, 5, 6]]})",
         it("skin", "skin", R"(, "core": "bar")"), R"({"object": "it", "translate_mm": [0, 0, 2]})",
         "generic"},
        {R"("ball": {"shape": "ball", "box_mm": [[-9, -9, -9], [9, 9, 9]]})",
         it("ball", "ball", R"(, "r": 4)"), R"({"object": "it", "translate_mm": [0, 0, 4]})",
         "generic"},
    };
    for (const auto& [meshes, objects, build, printer] : kinds) {
        const std::string file = world("w.fab.json", meshes, objects, build, cases, printer);
        EXPECT_EQ(part(file, "by_object"), part(file, "by_side")) << build << " " << meshes;
    }
    // Also where the build puts it itself.
    const std::string arranged =
        world("a.fab.json", "", it("bar"), R"({"object": "it"})", cases, "generic",
              R"(, "arrange": {"columns": 1, "spacing_mm": 2})");
    EXPECT_EQ(part(arranged, "by_object"), part(arranged, "by_side"));
}

TEST_F(MechanicsModel, AMarkerIsWhereItsValuesPutIt) {
    const std::string meshes = R"("mark": {"shape": "mark", "box_mm": [[-14, -6, -6], [16, 6, 8]]},
        "ball": {"shape": "ball", "box_mm": [[-14, -6, -6], [16, 6, 8]]},
        "fixed": {"beams": "ball.txt"}, "plate": {"box": [40, 40, 1]})";
    scratch_.write("ball.txt", "node 4 0 2 3\nball 0\n");
    const std::string objects =
        kBar + std::string(R"(, "mark": {"mesh": "mark", "fablet": "mark", "uniforms": {"x": 4}},
        "moved": {"mesh": "mark", "fablet": "mark"},
        "bound": {"mesh": "mark", "fablet": "mark", "uniforms": {"x": 4}},
        "fixed": {"mesh": "fixed", "fablet": "one"},
        "below": {"mesh": "plate", "fablet": "one", "uniforms": {"m": "label"}})");
    std::string cases;
    for (const char* mark : {"mark", "moved", "fixed"})
        cases += fmt::format(
            R"("{0}": {{"held": [{{"side": "-x"}}], "loads": [{{"object": "{0}", "force_N": [0, 0, -1]}}]}}, )",
            mark);
    cases +=
        R"("below": {"held": [{"object": "below"}], "loads": [{"side": "+x", "force_N": [0, 0, -1]}]},
        "ground": {"held": [{"side": "-z"}], "loads": [{"side": "+x", "force_N": [0, 0, -1]}]})";
    std::string text = read_file(world("w.fab.json", meshes, objects, kBuild, cases));
    const std::string file = path("w.fab.json");
    const std::string right = part(file, "fixed");
    EXPECT_EQ(part(file, "mark"), right);
    EXPECT_NE(part(file, "moved"), right);
    EXPECT_EQ(part(file, "moved", {"--voxel", "0.5mm", "--set", "moved.x=4"}), right);
    // A plate under the part, which only touches it: its faces look at it.
    const std::string at = R"("mesh": "plate")";
    text.replace(
        text.find(R"("plate": {"box": [40, 40, 1]})"),
        std::string(R"("plate": {"box": [40, 40, 1]})").size(),
        R"("plate": {"extrusion": {"polygons": [[[-9, -9], [9, -9], [9, 9], [-9, 9]]], "height": 1}})");
    scratch_.write("w.fab.json", text);
    const std::string ground = part(file, "ground");
    EXPECT_NE(part(file, "below"), ground);  // it is in the part
}

TEST_F(MechanicsModel, AMarkerBesideThePartIsFoundFromItsFaces) {
    // It touches the part from below, outside the grid of the build.
    const std::string meshes = R"("under": {"file": "under.obj", "unit": "mm"})";
    std::string obj;
    for (int v = 0; v < 8; ++v)
        obj += fmt::format("v {} {} {}\n", (v & 1) == 0 ? -9 : 9, (v >> 1 & 1) == 0 ? -9 : 9,
                           (v >> 2) == 0 ? -3 : 0);
    for (const char* face : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"})
        obj += std::string("f ") + face + "\n";
    scratch_.write("under.obj", obj);
    const std::string objects =
        kBar + std::string(R"(, "under": {"mesh": "under", "fablet": "one"})");
    const std::string file = world(
        "w.fab.json", meshes, objects, kBuild,
        R"("at": {"held": [{"object": "under", "facing": "-z"}], "loads": [{"side": "+x", "force_N": [0, 0, -1]}]},
        "on": {"held": [{"side": "-z"}], "loads": [{"side": "+x", "force_N": [0, 0, -1]}]})");
    EXPECT_EQ(part(file, "at"), part(file, "on"));
}

TEST_F(MechanicsModel, ValuesOfTheObjectAndOfTheFabletAreOne) {
    const std::string meshes =
        R"("ball": {"shape": "ball", "box_mm": [[-9, -9, -9], [9, 9, 9]]}, "base": {"box": [20, 20, 4]})";
    const std::string base =
        R"(, "base": {"mesh": "base", "fablet": "one", "uniforms": {"m": "stiff"}})";
    const std::string build =
        R"({"object": "ball", "translate_mm": [0, 0, 9]}, {"object": "base", "translate_mm": [0, 0, 0]})";
    const std::string press =
        R"("press": {"held": [{"side": "-z"}], "loads": [{"object": "ball", "facing": "+z", "pressure_MPa": 0.01}]})";
    const std::string object = world(
        "object.fab.json", meshes,
        R"("ball": {"mesh": "ball", "fablet": "ball", "uniforms": {"r": 6, "m": "stiff"}})" + base,
        build, press);
    std::string text = read_file(object);
    const std::string ref = R"({"source": "f.fl", "fablet": "Ball"})";
    text.replace(text.find(ref), ref.size(),
                 R"({"source": "f.fl", "fablet": "Ball", "uniforms": {"r": 6, "m": "stiff"}})");
    const std::string own = R"("uniforms": {"r": 6, "m": "stiff"}})" + base;
    text.replace(text.find(own), own.size(), R"("uniforms": {}})" + base);
    scratch_.write("fablet.fab.json", text);
    const std::string got = part(object, "press");
    EXPECT_EQ(got, part(path("fablet.fab.json"), "press"));
    // The upward faces of a ball of 6 mm, in its grid: at most its disk of voxels.
    const size_t at = got.find("held by (");
    ASSERT_NE(at, std::string::npos);
    const std::string third = got.substr(got.rfind(", ", got.find(')', at)) + 2);
    EXPECT_GT(std::stod(third), 0.5);
    EXPECT_LT(std::stod(third), 0.01 * M_PI * 36 * 1.02);
}

TEST_F(MechanicsModel, AMistakeInAnObjectThatIsNotBuiltIsShownInTheWorld) {
    const std::string file = world(
        "w.fab.json", R"("wrong": {"cylinder": {"diameter": 20}})",
        kBar + std::string(
                   R"(, "plug": {"mesh": "wrong", "fablet": "one", "uniforms": {"m": "stiff"}})"),
        kBuild,
        R"("press": {"held": [{"side": "-x"}], "loads": [{"object": "plug", "pressure_MPa": 5}]})");
    const Outcome out = mechanics({"part", file, "--voxel", "1mm"});
    EXPECT_EQ(out.exit_code, 1);
    EXPECT_THAT(out.err, AllOf(HasSubstr("w.fab.json:6:"), HasSubstr("^"),
                               ::testing::Not(HasSubstr("object.fab.json"))));
    // One that is found only when it is placed.
    std::string open = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
    scratch_.write("open.obj", open);
    const std::string holed = world(
        "h.fab.json", R"("wrong": {"file": "open.obj", "unit": "mm"})",
        kBar + std::string(
                   R"(, "plug": {"mesh": "wrong", "fablet": "one", "uniforms": {"m": "stiff"}})"),
        kBuild,
        R"("press": {"held": [{"side": "-x"}], "loads": [{"object": "plug", "pressure_MPa": 5}]})");
    const Outcome hole = mechanics({"part", holed, "--voxel", "1mm"});
    EXPECT_EQ(hole.exit_code, 1);
    EXPECT_THAT(hole.err,
                AllOf(HasSubstr("open.obj"), ::testing::Not(HasSubstr("object.fab.json"))));
}

TEST_F(MechanicsModel, MaterialsThatNothingIsMadeOfAreNotAskedFor) {
    scratch_.write("mechanics.json", R"({"materials": {"stiff": {"E_MPa": 2000, "nu": 0.35}}})");
    const std::string file = world("w.fab.json", "", kBar, kBuild, kBySide);
    for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
             {"part", file, "--voxel", "1mm"},
             {"part", file, "--voxel", "1mm", "--codes"},
             {"stand", file, "--voxel", "1mm", "--modes", "0"},
             {"cell", file, "--cell", "4mm", "--voxel", "1mm"},
             {"export", file, "--voxel", "1mm", "-o", path("x.inp")}}) {
        const Outcome out = mechanics(command);
        EXPECT_EQ(out.exit_code, 0) << command[0] << ": " << out.err;
    }
    // One that a voxel in a thousand has is.
    const std::string mixed = world(
        "m.fab.json", "",
        R"("bar": {"mesh": "bar", "fablet": "mix", "uniforms": {"soft": "soft", "stiff": "stiff", "share": 0.999}})",
        kBuild, kBySide);
    const Outcome asked = mechanics({"part", mixed, "--voxel", "1mm"});
    EXPECT_EQ(asked.exit_code, 1);
    EXPECT_THAT(asked.err, Says(mechanics::messages::kMaterialUnknown, "*", "soft"));
}

TEST_F(MechanicsModel, ThePartIsThatWhichComesOutOfTheMachine) {
    const auto profile = [&](const std::string& name, const std::string& process) {
        scratch_.write(name + ".printer.json", R"({"name": ")" + name +
                                                   R"(", "pitch_mm": [0.1, 0.1, 0.1],
"build_volume_mm": [300, 300, 300], "max_materials": 8, "native_format": "ofr", "makes_support": true, "process": {)" +
                                                   process + "}}");
        return name + ".printer.json";
    };
    // A field that moves all by up to half a millimetre.
    std::string nrrd =
        "NRRD0004\ntype: float\ndimension: 4\nsizes: 3 2 2 2\nkinds: vector space space space\n"
        "space dimension: 3\nspace directions: none (40,0,0) (0,40,0) (0,0,40)\n"
        "space origin: (-20,-20,-20)\nencoding: text\n\n";
    for (int node = 0; node < 8; ++node)
        nrrd += (node & 1) == 0 ? "0.5 0 0\n" : "-0.5 0 0.3\n";
    scratch_.write("field.nrrd", nrrd);
    const std::string none = world("none.fab.json", "", kBar, kBuild, kBySide, profile("none", ""));
    const std::string right = part(none, "by_side");
    const Outcome standing = mechanics({"stand", none, "--voxel", "0.5mm", "--modes", "0"});
    for (const char* process :
         {R"("scale": [1, 1, 1.05])", R"("scale": 0.97)", R"("field": "field.nrrd")"}) {
        const std::string file =
            world("p.fab.json", "", kBar, kBuild, kBySide, profile("p", process));
        EXPECT_EQ(part(file, "by_side"), right) << process;
        const Outcome out = mechanics({"stand", file, "--voxel", "0.5mm", "--modes", "0"});
        EXPECT_EQ(out.out, standing.out) << process;
    }
    // Two halves that run into each other: shares are those of `--bleed both`, not what is sent.
    const std::string halves =
        R"("bar": {"mesh": "bar", "fablet": "halves", "uniforms": {"soft": "soft", "stiff": "stiff"}})";
    const std::string bleeds =
        world("b.fab.json", "", halves, kBuild, kBySide,
              profile("b", R"("bleed": {"sigma_um": [0, 0, 300], "steps": 1})"));
    const auto sharp_share = [&](const std::string& file) {
        const Outcome out = mechanics({"export", file, "--voxel", "0.5mm", "-o", path("b.msh")});
        EXPECT_EQ(out.exit_code, 0) << out.err;
        return out.out;
    };
    const Outcome printed = run({program("openfab").string(), "print", bleeds, "--bleed", "both",
                                 "--voxel", "0.5mm", "--fractions", path("both.npy")},
                                {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    // As many kinds of elements as mixtures along z.
    EXPECT_NE(sharp_share(bleeds),
              sharp_share(world("n.fab.json", "", halves, kBuild, kBySide, "none.printer.json")));
    const std::string array = read_file(path("both.npy"));
    std::vector<float> shares((array.size() - 128) / 4);
    std::memcpy(shares.data(), array.data() + 128, shares.size() * 4);
    const Outcome vtu = mechanics({"export", bleeds, "--voxel", "0.5mm", "-o", path("b.xdmf")});
    ASSERT_EQ(vtu.exit_code, 0) << vtu.err;
    // The numbers of the file's fields are those of the print, element by element.
    const std::string h5 = read_file(path("b.h5"));
    std::string soft;
    for (size_t i = 0; i < shares.size(); i += 3)
        soft.append(reinterpret_cast<const char*>(&shares[i]), 4);
    EXPECT_NE(h5.find(soft), std::string::npos);
}

TEST_F(MechanicsModel, APrintIsNoWorld) {
    scratch_.write("print.ofr", std::string("OFR\0\1\2", 6));
    scratch_.write("mesh.obj", "v 0 0 0\n");
    for (const char* command : {"part", "stand", "conduct"})
        for (const auto& [file, message] :
             {std::pair("print.ofr", mechanics::messages::kInputIsPrint),
              {"mesh.obj", mechanics::messages::kInputIsNoWorld}}) {
            const Outcome out = mechanics({command, path(file)});
            EXPECT_EQ(out.exit_code, 1) << command;
            EXPECT_THAT(out.err, AllOf(Says(message), Says(mechanics::messages::kGiveWorld)));
        }
    const Outcome cell = mechanics({"cell", path("print.ofr"), "--cell", "1mm"});
    EXPECT_THAT(cell.err, Says(mechanics::messages::kGiveWorldOrFablet));
}

TEST_F(MechanicsModel, AWorldIsStrengthenedWithAllThatItNames) {
    scratch_.write("weak.fl", R"(fablet Weak {
    @uniform { ImageTexture3D need; Material m; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float f = need.Sample1(attr.voxelCenter, 0);
        if (attr.voxelCenter.z > 2 + 2 * f) return mc;
        mc.Set(m, 1);
        return mc;
    }
})");
    scratch_.write("own.printer.json", R"({"name": "own", "pitch_mm": [0.25, 0.25, 0.25],
"build_volume_mm": [300, 300, 300], "max_materials": 8, "native_format": "ofr", "makes_support": true})");
    scratch_.write("cuts.json",
                   R"({"normal": [1, 0, 0], "at_mm": 0, "back": "left", "front": "right"})");
    scratch_.write("nothing.nrrd",
                   "NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 1\nspacings: 100 100 "
                   "100\nencoding: text\n\n0\n");
    scratch_.write("w.fab.json", R"({"openfab": 1, "printer": "own.printer.json",
"fablets": {"file": {"source": "weak.fl", "fablet": "Weak"}},
"materials": {"stiff": {"key": "#23415e"}}, "textures": {"file": {"file": "nothing.nrrd"}},
"meshes": {"bar": {"box": [20, 4, 4]}},
"objects": {"bar": {"mesh": "bar", "fablet": "file", "uniforms": {"need": "file", "m": "stiff"}},
            "cut": {"mesh": "bar", "fablet": "file", "pieces": "cuts.json", "uniforms": {"need": "file", "m": "stiff"}}},
"build": [{"object": "bar"}],
"cases": {"c": {"held": [{"object": "bar", "side": "-x"}], "loads": [{"side": "+x", "force_N": [0, 0, -6]}]}}})");
    fs::create_directory(path("out"));
    const Outcome out =
        mechanics({"strengthen", path("w.fab.json"), "--field", "file", "--safety", "1.6",
                   "--voxel", "0.5mm", "--thin", "-o", path("out/strong.fab.json")});
    ASSERT_EQ(out.exit_code, 0) << out.out << out.err;
    const std::string folder = fs::path(path("w.fab.json")).parent_path().string();
    EXPECT_THAT(out.err, Says(mechanics::messages::kNamesOthers, path("out/strong.fab.json"),
                              folder, folder));
    const Outcome held =
        mechanics({"part", path("out/strong.fab.json"), "--voxel", "0.5mm", "--thin", "--materials",
                   path("mechanics.json"), "--allow", path("")});
    EXPECT_EQ(held.exit_code, 0) << held.err;
    EXPECT_THAT(held.out, HasSubstr("it holds"));
    // A program runs in the world's folder.
    std::string text = read_file(path("w.fab.json"));
    const std::string box = R"({"box": [20, 4, 4]})";
    text.replace(text.find(box), box.size(),
                 R"({"program": ["python3", "post.py"], "box_mm": [[-2, -2, -1], [12, 2, 3]]})");
    scratch_.write("w.fab.json", text);
    const Outcome elsewhere = mechanics({"strengthen", path("w.fab.json"), "--field", "file",
                                         "--allow-programs", "-o", path("out/s.fab.json")});
    EXPECT_EQ(elsewhere.exit_code, 1);
    EXPECT_THAT(elsewhere.err, Says(world::messages::kProgramStays));
}

}  // namespace
}  // namespace openfab::testing
