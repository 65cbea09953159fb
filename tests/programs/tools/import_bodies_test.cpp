// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab import` of files with several bodies and looks, up to the voxels.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <map>
#include <string>

#include "mesh/model/messages.h"
#include "mesh/read/messages.h"
#include "tests/support/meshes/zip_archive.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr int kFaces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                               {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

struct Box {
    double x, y, z, side;
    double corner(int i, int axis) const {
        const double low = axis == 0 ? x : axis == 1 ? y : z;
        return low + ((i >> axis & 1) != 0 ? side : 0);
    }
};

/// A mesh of 3MF; the triangles of a hollow are turned.
std::string mesh_of(const Box& box, const Box* hollow = nullptr, const std::string& more = "") {
    std::string vertices, triangles;
    int base = 0;
    for (const Box* b : {&box, hollow}) {
        if (b == nullptr) continue;
        for (int i = 0; i < 8; ++i)
            vertices += fmt::format("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", b->corner(i, 0),
                                    b->corner(i, 1), b->corner(i, 2));
        for (const auto& [p, q, r] : kFaces)
            triangles +=
                fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"{}/>", base + p,
                            base + (b == hollow ? r : q), base + (b == hollow ? q : r), more);
        base += 8;
    }
    return "<mesh><vertices>" + vertices + "</vertices><triangles>" + triangles +
           "</triangles></mesh>";
}

std::string package(const std::string& resources, const std::string& build,
                    const std::vector<std::pair<std::string, std::string>>& more = {}) {
    std::vector<std::pair<std::string, std::string>> parts = {
        {"_rels/.rels",
         R"(<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/m.model" Id="r0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)"},
        {"3D/m.model",
         R"(<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>)" +
             resources + "</resources><build>" + build + "</build></model>"}};
    parts.insert(parts.end(), more.begin(), more.end());
    return zip_archive(parts);
}

constexpr const char* kMaterials =
    R"(<basematerials id="1"><base name="PLA" displaycolor="#FF0000"/><base name="PLA" displaycolor="#0000FF"/></basematerials>)";

std::string object(int id, const std::string& name, int material, const std::string& mesh) {
    return fmt::format(
        "<object id=\"{}\" name=\"{}\" type=\"model\" pid=\"1\" pindex=\"{}\">{}"
        "</object>",
        id, name, material, mesh);
}

/// A box of OBJ, after `before` vertices.
std::string obj_box(const Box& box, int before, const std::string& corner = "") {
    std::string text;
    for (int i = 0; i < 8; ++i)
        text += fmt::format("v {} {} {}\n", box.corner(i, 0), box.corner(i, 1), box.corner(i, 2));
    for (const auto& [p, q, r] : kFaces)
        text += fmt::format("f {}{c} {}{c} {}{c}\n", before + p + 1, before + q + 1, before + r + 1,
                            fmt::arg("c", corner));
    return text;
}

class ImportBodies : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome openfab(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), program("openfab"));
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    /// Imports a file into the folder NAME; returns what was told.
    std::string import(const std::string& file, const std::string& name,
                       std::vector<std::string> more = {}) const {
        std::vector<std::string> arguments = {"import", path(file), "-o", path(name)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = openfab(arguments);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err;
    }
    std::string world(const std::string& name, const std::string& stem) const {
        return read_file(path(name + "/" + stem + ".fab.json"));
    }
    /// Prints the world of an import with voxels of half a millimetre; returns its codes, z y x.
    std::string voxels(const std::string& name, const std::string& stem) const {
        const Outcome outcome =
            openfab({"print", path(name + "/" + stem + ".fab.json"), "-o", path(name + ".npy"),
                     "--voxel", "0.5mm", "--support", "off"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::string npy = read_file(path(name + ".npy"));
        if (npy.size() < 10) return {};
        const auto byte = [&](size_t i) { return static_cast<unsigned char>(npy[i]); };
        return npy.substr(10 + byte(8) + 256 * byte(9));
    }
    static std::map<int, int> counts(const std::string& codes) {
        std::map<int, int> out;
        for (const char code : codes)
            ++out[static_cast<unsigned char>(code)];
        return out;
    }

    ScratchFolder scratch_;
};
using Counts = std::map<int, int>;

TEST_F(ImportBodies, TouchingOnesKeepEachToItsOwnMaterial) {
    const Box left{0, 0, 0, 10}, right{10, 0, 0, 10};
    scratch_.write("two.3mf", package(kMaterials + object(2, "left", 0, mesh_of(left)) +
                                          object(3, "right", 1, mesh_of(right)),
                                      "<item objectid=\"2\"/><item objectid=\"3\"/>"));
    EXPECT_THAT(import("two.3mf", "threemf"),
                testing::Says(tools::messages::kSummaryFablets,
                              fmt::format(tools::messages::kOfBodies, 2), "", "`solid`"));
    EXPECT_THAT(world("threemf", "two"),
                HasSubstr("\"left\": {\"file\": \"two.3mf\", \"body\": \"left\"}"));
    EXPECT_THAT(world("threemf", "two"), HasSubstr("\"PLA_2\": {\"key\": \"#0000ff\""));
    scratch_.write("two.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
    scratch_.write("two.obj", "# Units: mm\nmtllib two.mtl\nusemtl red\n" + obj_box(left, 0) +
                                  "usemtl blue\n" + obj_box(right, 8));
    import("two.obj", "obj");
    for (const std::string name : {"threemf", "obj"}) {
        const std::string codes = voxels(name, "two");
        EXPECT_EQ(counts(codes), (Counts{{1, 8000}, {2, 8000}})) << name;
        int wrong = 0;
        for (size_t i = 0; i < codes.size(); ++i)
            wrong += codes[i] != (i % 40 < 20 ? 1 : 2);
        EXPECT_EQ(wrong, 0) << name;
    }
}

TEST_F(ImportBodies, OnesInsideOthersWinWhateverTheOrder) {
    const Box block{0, 0, 0, 20}, core{7, 7, 7, 6};
    const std::string outer = object(2, "block", 0, mesh_of(block)),
                      inner = object(3, "core", 1, mesh_of(core)),
                      hollow = object(2, "block", 0, mesh_of(block, &core));
    const std::string both = "<item objectid=\"2\"/><item objectid=\"3\"/>",
                      turned = "<item objectid=\"3\"/><item objectid=\"2\"/>";
    scratch_.write("a.3mf", package(kMaterials + outer + inner, both));
    scratch_.write("b.3mf", package(kMaterials + outer + inner, turned));
    scratch_.write("c.3mf", package(kMaterials + hollow + inner, both));
    for (const std::string name : {"a", "b", "c"}) {
        import(name + ".3mf", name);
        const std::string text = world(name, name);
        EXPECT_EQ(text.find("\"priority\": 1") != std::string::npos, name != "c") << text;
        const Counts found = counts(voxels(name, name));
        const int core_code = name == "b" ? 1 : 2;
        EXPECT_EQ(found.at(core_code), 1728) << name;
        EXPECT_EQ(found.at(3 - core_code), 64000 - 1728) << name;
    }
    // Neither lies in the other: told, and the later one wins.
    scratch_.write(
        "d.3mf",
        package(kMaterials + outer + object(3, "across", 1, mesh_of({15, 1, 1, 10})), both));
    EXPECT_THAT(import("d.3mf", "d"),
                testing::Says(tools::messages::kShareVolume, "*`block` and `across`"));
    EXPECT_EQ(counts(voxels("d", "d")).at(2), 8000);
}

TEST_F(ImportBodies, NegativeVolumesCut) {
    const Box part{0, 0, 0, 10};
    std::string mesh = mesh_of(part);
    // A column of 4 x 4 mm that sticks out, in the same object.
    std::string column;
    for (int i = 0; i < 8; ++i)
        column += fmt::format("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", (i & 1) != 0 ? 7 : 3,
                              (i & 2) != 0 ? 7 : 3, (i & 4) != 0 ? 12 : -2);
    mesh.insert(mesh.find("</vertices>"), column);
    std::string faces;
    for (const auto& [p, q, r] : kFaces)
        faces += fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>", 8 + p, 8 + q, 8 + r);
    mesh.insert(mesh.find("</triangles>"), faces);
    const auto config = [](const char* type) {
        return std::pair<std::string, std::string>(
            "Metadata/Slic3r_PE_model.config",
            fmt::format(
                R"(<config><object id="2"><volume firstid="0" lastid="11"><metadata type="volume" key="name" value="box"/><metadata type="volume" key="volume_type" value="ModelPart"/></volume><volume firstid="12" lastid="23"><metadata type="volume" key="name" value="hole"/><metadata type="volume" key="volume_type" value="{}"/></volume></object></config>)",
                type));
    };
    const std::string resources = "<object id=\"2\" type=\"model\">" + mesh + "</object>";
    scratch_.write("n.3mf",
                   package(resources, "<item objectid=\"2\"/>", {config("NegativeVolume")}));
    EXPECT_THAT(import("n.3mf", "n"), testing::Says(tools::messages::kCutOthers, "`hole`"));
    EXPECT_EQ(counts(voxels("n", "n")), (Counts{{0, 1280}, {1, 6720}})) << "840 mm3";
    scratch_.write("m.3mf",
                   package(resources, "<item objectid=\"2\"/>", {config("ParameterModifier")}));
    EXPECT_THAT(import("m.3mf", "m"), HasSubstr("left out"));
    EXPECT_EQ(counts(voxels("m", "m")), (Counts{{1, 8000}}));
}

TEST_F(ImportBodies, PicturesStayOnTheirFacesBesidePlainOnes) {
    scratch_.write("cyan.ppm", "P3 1 1 255 0 255 255\n");
    scratch_.write("a.mtl", "newmtl label\nmap_Kd cyan.ppm\nnewmtl plain\nKd 1 0 0\n");
    scratch_.write("a.obj", "# Units: mm\nmtllib a.mtl\nvt 0.5 0.5\no label\nusemtl label\n" +
                                obj_box({0, 0, 0, 10}, 0, "/1") + "o plain\nusemtl plain\n" +
                                obj_box({15, 0, 0, 10}, 8));
    const std::string told = import("a.obj", "a");
    EXPECT_THAT(told, Not(HasSubstr("dropped")));
    const std::string text = world("a", "a");
    EXPECT_THAT(text, HasSubstr("\"fablet\": \"textured\""));
    EXPECT_THAT(text, HasSubstr("\"uniforms\": {\"materials\": \"plain\"}"));
    // A skin of cyan over white, the first and last of the inks; the plain box, right through.
    Counts found = counts(voxels("a", "a"));
    EXPECT_EQ(found[1], 20 * 20 * 20 - 18 * 18 * 18);
    EXPECT_EQ(found[5], 18 * 18 * 18);
    EXPECT_EQ(found[6], 8000);
}

TEST_F(ImportBodies, OurOwnExportComesBackVoxelForVoxel) {
    scratch_.write("v.fl", R"(fablet V {
    @uniform { Material a, b, c; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float x = attr.voxelCenter.x + attr.voxelCenter.z * 0.5;
        mc.Set(x < 0 ? a : (x < 1 ? b : c), 1);
        return mc;
    }
})");
    fs::create_directory(scratch_ / "own");
    scratch_.write("own/own.fab.json", R"({"openfab": 1, "printer": "generic",
        "fablets": {"v": {"source": "v.fl", "fablet": "V"}},
        "materials": {"a": {"key": "#00ffff"}, "b": {"key": "#ff00ff"}, "c": {"key": "#ffff00"}},
        "meshes": {"m": {"sphere": 6}}, "build": [{"object": "o"}],
        "objects": {"o": {"mesh": "m", "fablet": "v", "uniforms": {"a": "a", "b": "b", "c": "c"}}}})");
    scratch_.write("own/v.fl", read_file(path("v.fl")));
    const std::string before = voxels("own", "own");
    const Outcome exported = openfab({"print", path("own/own.fab.json"), "-o", path("x.3mf"),
                                      "--mesh-pitch", "0.5mm", "--support", "off"});
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    import("x.3mf", "back");
    EXPECT_EQ(counts(before).size(), 4u);
    EXPECT_TRUE(voxels("back", "x") == before);
}

TEST_F(ImportBodies, ThreeHundredAreAsManyObjectsOfOneFile) {
    std::string text = "# Units: mm\n";
    for (int i = 0; i < 300; ++i)
        text += fmt::format("o body {}\n", i) +
                obj_box({12.0 * (i % 10), 12.0 * (i / 10), 0, 10}, 8 * i);
    scratch_.write("many.obj", text);
    EXPECT_THAT(import("many.obj", "many"), testing::Says(tools::messages::kBodiesShareMaterial));
    const Outcome info = openfab({"info", path("many/many.fab.json")});
    EXPECT_EQ(info.exit_code, 0) << info.err;
    EXPECT_THAT(info.out, HasSubstr("build      300 placed, 118 x 358 x 10 mm"));
    const Outcome list = openfab({"import", path("many.obj"), "--list"});
    EXPECT_THAT(list.out, HasSubstr("bodies     300\n"));
    const Outcome json = openfab({"info", path("many.obj"), "--json"});
    EXPECT_EQ(json.exit_code, 0) << json.err;
    EXPECT_THAT(json.out, HasSubstr("\"unit_from\":\"as the file says\""));
}

TEST_F(ImportBodies, WhatLiesFarOutIsToldAndRecentred) {
    scratch_.write("far.obj", "# Units: mm\n" + obj_box({50'000.25, -70'000, 12, 10}, 0));
    EXPECT_THAT(import("far.obj", "far"), testing::Says(tools::messages::kFarFromOrigin));
    import("far.obj", "near", {"--recentre"});
    EXPECT_THAT(world("near", "far"), HasSubstr("\"origin_mm\": [50005, -69995, 12]"));
    EXPECT_THAT(openfab({"info", path("near/far.fab.json")}).out, HasSubstr("from -4.75 -5 0"));
}

TEST_F(ImportBodies, ASizeSettlesTheUnit) {
    const auto is_told = [](const std::string& text) {
        return testing::says(text, mesh::messages::kMeshSizeUnlikely) ||
               testing::says(text, mesh::messages::kUnitGuessed) ||
               testing::says(text, tools::messages::kFarFromOrigin);
    };
    // Twenty metres, and five hundredths of an unknown unit.
    scratch_.write("house.obj", "# Units: m\n" + obj_box({0, 0, 0, 20}, 0));
    scratch_.write("coin.obj", obj_box({0, 0, 0, 0.05}, 0));
    for (const std::string name : {"house", "coin"}) {
        EXPECT_TRUE(is_told(import(name + ".obj", name))) << name;
        EXPECT_FALSE(is_told(import(name + ".obj", name + "_60", {"--size", "60mm"}))) << name;
        const auto dry = [&](const std::string& folder) {
            return openfab({"print", path(folder + "/" + name + ".fab.json"), "--dry-run"}).err;
        };
        // The unit that was guessed is in the world.
        EXPECT_EQ(is_told(dry(name)), name == "house") << name;
        EXPECT_FALSE(is_told(dry(name + "_60"))) << name;
    }
    // A scale to what nobody prints settles nothing.
    import("house.obj", "large", {"--size", "1500mm"});
    EXPECT_TRUE(is_told(openfab({"print", path("large/house.fab.json"), "--dry-run"}).err));
}

/// What an import takes, a list shows.
TEST_F(ImportBodies, ListsShowLatticesAndWhatPicturesLack) {
    const std::string net =
        R"(<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="10" y="0" z="0"/></vertices><triangles/>)"
        R"(<b:beamlattice xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02" )"
        R"(radius="1" minlength="0.01"><b:beams><b:beam v1="0" v2="1"/></b:beams></b:beamlattice></mesh>)";
    scratch_.write("net.3mf", package(R"(<object id="2" name="net">)" + net + "</object>",
                                      R"(<item objectid="2"/>)"));
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"import", path("net.3mf"), "--list"},
          {"info", path("net.3mf")}}) {
        const Outcome list = openfab(words);
        EXPECT_EQ(list.exit_code, 0) << list.err;
        EXPECT_THAT(list.out, HasSubstr("lattice    net: 1 beams and balls\n"));
        EXPECT_THAT(list.out, HasSubstr("size       12 x 2 x 2 mm, from -1 -1 -1\n"));
    }
    const Outcome json = openfab({"info", path("net.3mf"), "--json"});
    EXPECT_THAT(json.out, HasSubstr(R"("lattices":[{"name":"net","beams":1,"size_mm":[12,2,2])"));

    for (const auto& [picture, why] :
         {std::pair("none.png", mesh::messages::kNoSuchFile),
          std::pair("tex.<UDIM>.png", mesh::messages::kPictureTiles)}) {
        scratch_.write("m.mtl", fmt::format("newmtl skin\nmap_Kd {}\n", picture));
        scratch_.write("m.obj", "# Units: mm\nmtllib m.mtl\nvt 0 0\nusemtl skin\n" +
                                    obj_box({0, 0, 0, 10}, 0, "/1"));
        EXPECT_THAT(openfab({"import", path("m.obj"), "--list"}).out,
                    HasSubstr(fmt::format("picture {} (left out: {}", picture, why)));
    }
}

}  // namespace
}  // namespace openfab::testing
