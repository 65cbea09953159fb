// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What OBJ files and their material libraries can hold, by the specifications of both and by what
// programs write: each is carried over, or told.

#include <fmt/format.h>

#include "mesh/read/messages.h"
#include "mesh/read/obj.h"

#include "base/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/features.h"

namespace openfab::mesh {
namespace {

const std::string kPoints = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\n";
const std::string kPointsAndUv = kPoints + "vt 0 0\nvt 1 0\nvt 0 1\n";
const std::string kFaces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
const std::string kFacesWithUv = "f 1/1 3/3 2/2\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\nf 1/1 4/2 3/3\n";

constexpr double kHalf = 0.2140411;  // sRGB 0.5 as light

std::string with_material(const std::string& library = "a.mtl", const std::string& name = "red") {
    return "mtllib " + library + "\n" + kPointsAndUv + "usemtl " + name + "\n" + kFacesWithUv;
}

bool is_red(const MeshSource& m) {
    return look_of(m, 0).color == std::array{1.0, 0.0, 0.0} && look_of(m, 0).is_material;
}

Feature of_library(const char* name, const std::string& statements, const std::string& told,
                   std::function<bool(const MeshSource&)> carried) {
    return {name, with_material(),   {{"a.mtl", "newmtl red\n" + statements}}, told,
            1,    std::move(carried)};
}

TEST(ObjFeatures, OfMaterialLibraries) {
    const std::string red = "newmtl red\nKd 1 0 0\n";
    const auto picture = [](const MeshSource& m) {
        return look_of(m, 0).picture.value_or(PictureUse{});
    };
    check_features(
        parse_obj, "m.obj",
        {of_library("Kd", "Kd 1 0.5 0\n", "",
                    [](const MeshSource& m) {
                        const Look look = look_of(m, 0);
                        return look.name == "red" && near((*look.color)[1], kHalf) &&
                               !look.vertex_colors && look.alpha == 1;
                    }),
         {"Kd of Blender is linear light",
          with_material(),
          {{"a.mtl",
            "# Blender 5.2.3 MTL File: 'a.blend'\n# www.blender.org\nnewmtl red\nKd 1 0.5 0\n"}},
          "",
          1,
          [](const MeshSource& m) { return (*look_of(m, 0).color)[1] == 0.5; }},
         of_library("one number is grey", "Kd 0.5\n", "",
                    [](const MeshSource& m) { return near((*look_of(m, 0).color)[2], kHalf); }),
         of_library("Kd of bytes", "Kd 255 0 0\n", "0 … 255", is_red),
         of_library("Kd spectral", "Kd spectral a.rfl 1\n", "`Kd spectral`",
                    [](const MeshSource& m) { return !look_of(m, 0).color; }),
         of_library("Kd xyz", "Kd xyz 1 1 1\n", "`Kd xyz`", {}),
         of_library("Ke where nothing else is", "Kd 0 0 0\nKe 1 0 0\n", "", is_red),
         of_library("map_Ke where nothing else is", "map_Ke a.png\n", "",
                    [=](const MeshSource& m) { return picture(m).name == "a.png"; }),
         of_library("d", "Kd 1 0 0\nd 0.25\n", "",
                    [](const MeshSource& m) { return is_red(m) && look_of(m, 0).alpha == 0.25; }),
         of_library("Tr", "Kd 1 0 0\nTr 0.25\n", "",
                    [](const MeshSource& m) { return look_of(m, 0).alpha == 0.75; }),
         of_library("d before Tr", "Tr 1\nd 1\n", "",
                    [](const MeshSource& m) { return look_of(m, 0).alpha == 1; }),
         of_library("Tr of 1", "Tr 1\n", messages::kTransparencyTrOne,
                    [](const MeshSource& m) { return look_of(m, 0).alpha == 1; }),
         of_library("halo", "d -halo 0.5\n", "`d -halo`", {}),
         of_library("gloss is silent", "Ka 1 1 1\nKs 1 1 1\nNs 10\nNi 1\nillum 2\nTf 1 1 1\n", "",
                    {}),
         of_library("filter", "Tf 1 0 0\n", "`Tf`", {}),
         of_library("bump", "map_Bump -bm 2 b.png\n", "`map_bump`", {}),
         of_library("normals", "norm b.png\n", "`norm`", {}),
         of_library("displacement", "disp b.png\n", "`disp`", {}),
         of_library("decal", "decal b.png\n", "`decal`", {}),
         of_library("gloss by picture", "map_Ks b.png\n", "`map_ks`", {}),
         of_library("reflection", "refl -type sphere b.png\n", "`refl`", {}),
         of_library("ambient picture", "map_Ka b.png\n", "`map_Ka`", {}),
         of_library("ambient picture beside another", "map_Kd b.png\nmap_Ka b.png\n", "", {}),
         of_library("opacity by picture", "map_Kd a.png\nmap_d b.png\n", "`map_d`", {}),
         of_library(
             "opacity by the same picture", "map_Kd a.png\nmap_d a.png\n", "",
             [=](const MeshSource& m) { return picture(m).alpha == PictureUse::Alpha::kBlend; }),
         of_library("unknown", "Kx 1\n", "`kx`", {}),
         of_library("map_Kd", "Kd 1 0 0\nmap_Kd maps\\a b.png\n", "",
                    [=](const MeshSource& m) {
                        return picture(m).source == "maps/a b.png" &&
                               picture(m).name == "a b.png" && !look_of(m, 0).tinted && is_red(m) &&
                               picture(m).wrap[0] == PictureWrap::kRepeat;
                    }),
         of_library("clamp", "map_Kd -clamp on -blendu off -texres 256 a.png\n", "",
                    [=](const MeshSource& m) {
                        return picture(m).wrap[0] == PictureWrap::kClamp &&
                               picture(m).wrap[1] == PictureWrap::kClamp;
                    }),
         of_library(
             "space", "map_Kd -colorspace sRGB -clamp on a.tif\n", "",
             [=](const MeshSource& m) { return picture(m).space == PictureUse::Space::kSrgb; }),
         of_library(
             "linear light", "map_Kd -colorspace linear a.png\n", "",
             [=](const MeshSource& m) { return picture(m).space == PictureUse::Space::kLinear; }),
         of_library("offset and scale", "map_Kd -o 0.25 0.5 0 -s 2 4 1 a.png\n", "",
                    [=](const MeshSource& m) {
                        return near(value_at(m, "uv", 0, 2, 0), 2.25) &&
                               near(value_at(m, "uv", 0, 1, 1), 4.5) && picture(m).name == "a.png";
                    }),
         of_library("turbulence", "map_Kd -t 1 1 1 a.png\n", "`-t`", {}),
         of_library("range", "map_Kd -mm 0 2 a.png\n", "`-mm`", {}),
         of_library("range as it is", "map_Kd -mm 0 1 a.png\n", "", {}),
         of_library("channel", "map_Kd -imfchan r a.png\n", "`-imfchan`", {}),
         of_library("signs in names", "map_Kd tile#1 #2.png\n", "",
                    [=](const MeshSource& m) { return picture(m).source == "tile#1 #2.png"; }),
         of_library("comments", "# Kd 0 1 0\nKd 1 0 0 # red\nmap_Kd a.png # a picture\n", "",
                    [=](const MeshSource& m) { return is_red(m) && picture(m).name == "a.png"; }),
         of_library("tabs, blanks, carriage returns", "\t Kd\t1 0  0 \r\n\r\n", "", is_red),
         {"byte order mark", with_material(), {{"a.mtl", "\xEF\xBB\xBF" + red}}, "", 0, is_red},
         {"carriage returns alone",
          with_material(),
          {{"a.mtl", "newmtl red\rKd 1 0 0\r"}},
          "",
          0,
          is_red},
         {"UTF-16",
          with_material(),
          {{"a.mtl", std::string("\xFF\xFEn\0e\0w\0m\0", 10)}},
          "UTF-16",
          1,
          {}},
         {"upper case of the file", with_material("A.MTL"), {{"a.mtl", red}}, "", 0, is_red},
         {"path of another machine",
          with_material("C:\\models\\a.mtl"),
          {{"a.mtl", red}},
          "",
          0,
          is_red},
         {"blanks in its name",
          with_material("my lib é.mtl"),
          {{"my lib é.mtl", red}},
          "",
          0,
          is_red},
         {"quotes", with_material("\"my lib.mtl\""), {{"my lib.mtl", red}}, "", 0, is_red},
         {"sign in its name", with_material("lib #1.mtl"), {{"lib #1.mtl", red}}, "", 0, is_red},
         {"comment behind it", with_material("a.mtl # mine"), {{"a.mtl", red}}, "", 0, is_red},
         {"several on a line",
          with_material("b.mtl a.mtl"),
          {{"a.mtl", red}, {"b.mtl", "newmtl x\n"}},
          "",
          0,
          is_red},
         {"several with blanks",
          with_material("b c.mtl a.mtl"),
          {{"a.mtl", red}, {"b c.mtl", "newmtl x\n"}},
          "",
          0,
          is_red},
         {"one of several missing",
          with_material("b.mtl a.mtl"),
          {{"a.mtl", red}},
          messages::kMaterialLibrary,
          1,
          is_red},
         {"missing",
          with_material("b.mtl"),
          {},
          messages::kMaterialLibrary,
          1,
          [](const MeshSource& m) { return look_of(m, 0).name == "red" && !look_of(m, 0).color; }},
         {"outside",
          with_material("../../b.mtl"),
          {},
          fmt::format(messages::kMaterialLibrary, "../../b.mtl", messages::kNotBelowFolder),
          1,
          {}},
         {"none",
          kPoints + "usemtl red\n" + kFaces,
          {},
          "",
          0,
          [](const MeshSource& m) { return look_of(m, 0).name == "red"; }},
         {"material that no library has",
          with_material("a.mtl", "blue"),
          {{"a.mtl", red}},
          "`blue`",
          4,
          {}},
         {"sign in a name",
          with_material("a.mtl", "Material #1"),
          {{"a.mtl", "newmtl Material #2\nKd 0 1 0\nnewmtl Material #1\nKd 1 0 0\n"}},
          "",
          0,
          is_red},
         {"comments behind names",
          with_material("a.mtl", "red # the red one"),
          {{"a.mtl", "newmtl red # one\nKd 1 0 0\n"}},
          "",
          0,
          is_red},
         {"comments like names",
          with_material("a.mtl", "red #the"),
          {{"a.mtl", red}},
          "",
          0,
          is_red},
         {"Latin-1",
          with_material("a.mtl", "caf\xE9"),
          {{"a.mtl", "newmtl caf\xE9\nKd 1 0 0\nmap_Kd caf\xE9.png\n"}},
          "",
          0,
          [=](const MeshSource& m) {
              return is_red(m) && look_of(m, 0).name == "café" &&
                     picture(m).source == "caf\xE9.png" && picture(m).name == "café.png";
          }},
         {"a second one of its name",
          with_material(),
          {{"a.mtl", red + "newmtl red\nKd 0 1 0\n"}},
          messages::kSecondMaterialOfName,
          1,
          is_red},
         {"unused materials are not told",
          with_material(),
          {{"a.mtl", red + "newmtl b\nmap_Bump b.png\n"}},
          "",
          0,
          is_red}});
}

TEST(ObjFeatures, ThousandsOfThemTakeFewLines) {
    const testing::TempFolder folder;
    std::string library = "newmtl red\nKd 1 0 0\n", mesh = "mtllib a.mtl\n" + kPoints;
    for (int i = 0; i < 20'000; ++i) {
        library += fmt::format("x{} 1\n", i);
        mesh += fmt::format("usemtl {}\nf 1 2 3\n", i);
    }
    folder.write("a.mtl", library);
    const Result<MeshSource> read =
        parse_obj(mesh + "usemtl red\nf 1 2 4\n", (folder.path() / "m.obj").string());
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_LT(read->left_out.size(), 200u);
    EXPECT_EQ(read->left_out.back().count, 20'000 - 100);
    EXPECT_TRUE(look_of(*read, 20'000).color.has_value());
}

TEST(ObjFeatures, OfStatements) {
    const auto colored = [](const std::string& first, const std::string& others) {
        return fmt::format("v 0 0 0 {0}\nv 9 0 0 {1}\nv 0 9 0 {1}\nv 0 0 9 {1}\n", first, others);
    };
    const auto is = [](double value) {
        return [=](const MeshSource& m) {
            return near(value_at(m, "color", 0, 0, 0), value) && look_of(m, 0).vertex_colors &&
                   look_of(m, 0).color == std::array{1.0, 1.0, 1.0} && !look_of(m, 0).is_material;
        };
    };
    const auto has_faces = [](const MeshSource& m) { return m.mesh.triangles.size() == 4; };
    check_features(
        parse_obj, "M.OBJ",
        {{"nothing",
          kPoints + kFaces,
          {},
          "",
          0,
          [](const MeshSource& m) {
              return m.looks.empty() && m.bodies.empty() && m.groups[0].look == -1;
          }},
         {"colours of vertices", colored("0.5 0 0", "1 0 0") + kFaces, {}, "", 0, is(kHalf)},
         {"colours as bytes", colored("255 0 0", "128 0 0") + kFaces, {}, "", 0, is(1)},
         {"colours beyond 1",
          colored("0.5 0 0", "1.5 0 0") + kFaces,
          {},
          messages::kColoursBeyondOne,
          0,
          is(kHalf)},
         {"colours behind a weight",
          colored("1 0.5 0 0", "1 1 0 0") + kFaces,
          {},
          "",
          0,
          is(kHalf)},
         {"a vertex without colour",
          colored("", "0.5 0 0") + kFaces,
          {},
          messages::kVerticesWithoutColour,
          1,
          [=](const MeshSource& m) {
              return is(1)(m) && near(value_at(m, "color", 0, 1, 0), kHalf);
          }},
         {"colours of one of two bodies",
          colored("0.5 0 0", "1 0 0") + "o a\n" + kFaces + kPoints + "o b\nusemtl m\nf 5 7 6\n",
          {},
          "",
          0,
          [=](const MeshSource& m) {
              return is(kHalf)(m) && value_at(m, "color", 4, 0, 0) == -1 &&
                     !look_of(m, 4).vertex_colors;
          }},
         {"colours and groups",
          colored("0.5 0 0", "1 0 0") + "g low\nf 1 3 2\nf 1 2 4\ng high\nf 2 3 4\nf 1 4 3\n",
          {},
          "",
          0,
          [=](const MeshSource& m) { return is(kHalf)(m) && bodies_of(m) == "low, high"; }},
         {"colours and a material's",
          "mtllib a.mtl\n" + colored("0 0.5 0", "0 1 0") + "usemtl red\n" + kFaces,
          {{"a.mtl", "newmtl red\nKd 1 0 0\n"}},
          fmt::format(messages::kColourOfColouredVertices, "red"),
          1,
          [](const MeshSource& m) {
              return look_of(m, 0).vertex_colors && near(value_at(m, "color", 0, 0, 1), kHalf);
          }},
         {"white beside a material",
          "mtllib a.mtl\n" + colored("1 1 1", "1 1 1") + "usemtl red\n" + kFaces,
          {{"a.mtl", "newmtl red\nKd 1 0 0\n"}},
          "",
          0,
          is_red},
         {"polypaint", kPoints + "#MRGB ff808080ff808080\n" + kFaces, {}, "`#MRGB`", 1, has_faces},
         {"weights",
          "v 0 0 0 0.5\n" + kPoints.substr(8) + kFaces,
          {},
          messages::kWeightsOfVertices,
          1,
          has_faces},
         {"points of parameters", kPoints + "vp 1 2\nvp 1\n" + kFaces, {}, "`vp`", 2, has_faces},
         {"lines and points",
          kPoints + "l 1 2\n" + kFaces + "p 1\n",
          {},
          "lines (`l`)",
          1,
          has_faces},
         {"points", kPoints + kFaces + "p 1\np 1 2\n", {}, "points (`p`)", 2, has_faces},
         {"curves",
          kPoints + "cstype bezier\ndeg 2\ncurv 0 1 1 2 3\nparm u 0 1\nend\n" + kFaces,
          {},
          messages::kFreeForm,
          1,
          has_faces},
         {"surfaces",
          kPoints + "cstype rat bspline\nsurf 0 1 0 1 1 2 3 4\nend\n" + kFaces,
          {},
          messages::kFreeForm,
          1,
          has_faces},
         {"calls", kPoints + kFaces + "call b.obj\n", {}, "`call`", 1, has_faces},
         {"texture maps", kPoints + "maplib a\nusemap b\n" + kFaces, {}, "`usemap`", 2, has_faces},
         {"hints of display",
          kPoints + "s 1\ns off\nlod 1\nbevel on\nc_interp off\nmg 1 1\nshadow_obj a\n" + kFaces,
          {},
          "",
          0,
          has_faces},
         {"normal that is not there",
          kPoints + "f 1//1 3//1 2//1\n",
          {},
          messages::kNormalsMissing,
          3,
          [](const MeshSource& m) { return value_at(m, "n", 0, 0, 0) == -1; }},
         {"texture coordinate that is not there",
          kPointsAndUv + "f 1/1 3/3 2/9\nf 1/1 2/2 4/3\n",
          {},
          messages::kCoordinatesMissing,
          1,
          [](const MeshSource& m) {
              return value_at(m, "uv", 0, 2, 0) == -1 && value_at(m, "uv", 1, 1, 0) == 1;
          }},
         {"objects",
          kPoints + "o left\n" + kFaces + "o right\n" + kFaces,
          {},
          "",
          0,
          [](const MeshSource& m) {
              return bodies_of(m) == "left, right" && m.groups[m.face_groups[4]].body == 1;
          }},
         {"objects of one name",
          kPoints + "o a\n" + kFaces + "o a\n" + kFaces,
          {},
          "",
          0,
          [](const MeshSource& m) { return bodies_of(m) == "a, a"; }},
         {"groups",
          kPoints + "g left\n" + kFaces + "g right\n" + kFaces + "g left\n" + kFaces,
          {},
          "",
          0,
          [](const MeshSource& m) { return bodies_of(m) == "left, right"; }},
         {"groups of objects",
          kPoints + "o a\ng x\n" + kFaces + "o b\ng y\n" + kFaces + "g z z\n" + kFaces,
          {},
          "",
          0,
          [](const MeshSource& m) { return bodies_of(m) == "a, b y, b z z"; }},
         {"signs in groups",
          kPoints + "g Box #1\n" + kFaces + "g Box #2 # second\n" + kFaces,
          {},
          "",
          0,
          [](const MeshSource& m) {
              return bodies_of(m) == "Box #1, Box #2" && m.groups[0].names.size() == 2;
          }},
         {"Latin-1",
          kPoints + "g caf\xE9\n" + kFaces,
          {},
          "",
          0,
          [](const MeshSource& m) {
              return bodies_of(m) == "café" && m.groups[0].names[0] == "café";
          }},
         {"one body of two materials",
          kPoints + "o a\nusemtl x\nf 1 3 2\nusemtl y\nf 1 2 4\nusemtl x\nf 2 3 4\n",
          {},
          "",
          0,
          [](const MeshSource& m) {
              return bodies_of(m) == "a" && m.looks.size() == 2 && look_of(m, 1).name == "y" &&
                     look_of(m, 2).name == "x";
          }},
         {"byte order mark", "\xEF\xBB\xBF" + kPoints + kFaces, {}, "", 0, has_faces},
         {"carriage returns alone",
          "v 0 0 0\rv 9 0 0\rv 0 9 0\r# one\rf 1 2 3\r",
          {},
          "",
          0,
          [](const MeshSource& m) {
              return m.mesh.triangles.size() == 1 && m.origin.lines[0] == 5;
          }},
         {"comments",
          kPoints + "# f 1 2 3\n" + "f 1 3 2 # one\n#\n",
          {},
          "",
          0,
          [](const MeshSource& m) { return m.mesh.triangles.size() == 1; }}});
}

TEST(ObjFeatures, RefuseWhatIsNotText) {
    const auto error = [](const std::string& text) {
        const Result<MeshSource> read = parse_obj(text, "m.obj");
        return read ? "no error" : read.error().text();
    };
    EXPECT_EQ(error(std::string("\xFF\xFEv\0 \0", 6)),
              "m.obj:1:1: " + fmt::format(openfab::messages::kWideText, "UTF-16") + "; " +
                  openfab::messages::kWideTextHelp);
    EXPECT_EQ(error(std::string("v\0 \0"
                                "1\0 \0"
                                "2\0",
                                10)),
              "m.obj:1:1: " + fmt::format(openfab::messages::kWideText, "UTF-16") + "; " +
                  openfab::messages::kWideTextHelp);
    EXPECT_EQ(
        error(kPoints + "surf 0 1 0 1 1 2 3 4\n"),
        std::string("m.obj:5:1: ") + messages::kOnlyFreeForm + "; " + messages::kOnlyFreeFormHelp);
}

TEST(ObjFeatures, PicturesStandInTheMeshsFolder) {
    const testing::TempFolder folder, other;
    std::filesystem::create_directory(folder.path() / "maps");
    folder.write("maps/A.PNG", "one");
    folder.write("tile#1.png", "two");
    folder.write("m.obj", "");
    const std::string secret = other.write("secret.png", "secret").string();
    folder.write("100% té.png", "three");
    const std::vector<std::string> sources = {
        "maps/a.png",  "C:\\x\\tile#1.png",    secret,       "gone.png", "../m.obj", "tile%231.png",
        "100% té.png", "100%25%20t%C3%A9.png", "gone%00.png"};
    std::vector<std::string> got;
    ASSERT_TRUE(read_obj_pictures(folder.path() / "m.obj", sources, 1000,
                                  [&](size_t i, Result<std::string> bytes) {
                                      EXPECT_EQ(i, got.size());
                                      got.push_back(bytes ? *bytes : bytes.error().text());
                                  }));
    EXPECT_EQ(got,
              (std::vector<std::string>{
                  "one", "two",
                  std::string(messages::kNotBelowFolder) + "; " + messages::kNotBelowFolderHelp,
                  std::string(messages::kNoSuchFile) + "; " + messages::kNoSuchFileHelp, "", "two",
                  "three", "three",
                  std::string(messages::kNoSuchFile) + "; " + messages::kNoSuchFileHelp}));
    got.clear();
    ASSERT_TRUE(read_obj_pictures(folder.path() / "m.obj", sources, 2,
                                  [&](size_t, Result<std::string> bytes) {
                                      got.push_back(bytes ? *bytes : bytes.error().text());
                                  }));
    EXPECT_THAT(got[0], testing::Says(openfab::messages::kLargerThan));
}

}  // namespace
}  // namespace openfab::mesh
