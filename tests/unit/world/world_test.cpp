// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/world.h"
#include "mesh/model/messages.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/input_file.h"
#include "base/messages.h"
#include "mesh/load/load_mesh.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "world/messages.h"
#include "world/primitive_reader.h"

namespace openfab::world {
namespace {

constexpr const char* kWorld = R"({
  "openfab": 1,
  "printer": "j750",
  "fablets": {"f": {"source": "f.fl", "fablet": "F"}},
  "materials": {
    "white": {"key": "#ffffff", "preview": "#f0f0f080", "density_g_cm3": 1.2, "channel": "A"},
    "black": {"key": "#000000"}
  },
  "textures": {"photo": {"file": "photo.png", "wrap": "clamp", "filter": "trilinear", "space": "data", "channels": "luminance"}},
  "meshes": {
    "zed": {"box": [10, 20, 30]},
    "ball": {"sphere": 8},
    "pin": {"cylinder": [2, 9]},
    "sheet": {"plane": [4, 5]}
  },
  "objects": {
    "b": {"mesh": "zed", "fablet": "f", "priority": -3, "max_displacement_mm": 1.5,
          "uniforms": {"n": 2, "v": [1, 2.5], "m": [[1, 2], [3, 4]], "on": true, "t": "photo", "p": ["white", "black"]}},
    "a": {"mesh": "ball", "fablet": "f", "support": false}
  },
  "build": [
    {"object": "a", "scale": 2, "rotate_deg": [0, 0, 90], "translate_mm": [1, 2, 3]},
    {"object": "b", "matrix": [[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9]], "uniforms": {"n": 5}},
    {"object": "b", "matrix": [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]}
  ]
})";

class WorldTest : public ::testing::Test {
  protected:
    WorldTest() { folder_.write("photo.png", "not read here"); }

    /// Loads it with and without the files of meshes: a mistake of the world's is told by both.
    Result<World> load(const std::string& text) {
        const std::filesystem::path file = folder_.write("w.fab.json", text);
        Result<World> world = load_world(file);
        const Result<World> early = load_world(file, {}, MeshFiles::kSkip);
        if (world) {
            EXPECT_TRUE(early) << early.error().text();
        } else if (!early) {
            EXPECT_EQ(early.error().text(), world.error().text());
        } else {
            // What is wrong is in a file of a mesh.
            EXPECT_NE(world.error().text().rfind(file.string(), 0), 0u) << world.error().text();
        }
        return world;
    }
    /// Returns the message after the file's name.
    std::string error_of(const std::string& text) {
        const Result<World> world = load(text);
        if (world) return "no error";
        const std::string file = (folder_.path() / "w.fab.json").string();
        return world.error().text().starts_with(file) ? world.error().text().substr(file.size() + 1)
                                                      : world.error().text();
    }
    /// Loads kWorld with one piece of text replaced.
    std::string error_with(const std::string& from, const std::string& to) {
        std::string text = kWorld;
        const size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return error_of(text.replace(at, from.size(), to));
    }

    testing::TempFolder folder_;
};

TEST_F(WorldTest, SaysWhetherAndOfWhatSupportIs) {
    const auto with = [&](const std::string& support) {
        std::string text = kWorld;
        const size_t at = text.find("\"printer\"");
        text.insert(at, support);
        const Result<World> world = load(text);
        EXPECT_TRUE(world) << world.error().text();
        return world->support;
    };
    EXPECT_FALSE(with("").on.has_value());
    EXPECT_EQ(with("\"support\": true, ").on, true);
    EXPECT_EQ(with("\"support\": true, ").material, "");
    EXPECT_EQ(with("\"support\": false, ").on, false);
    EXPECT_EQ(with("\"support\": \"black\", ").on, true);
    EXPECT_EQ(with("\"support\": \"black\", ").material, "black");
    const Result<World> world = load(kWorld);
    ASSERT_TRUE(world);
    EXPECT_TRUE(world->objects[0].support);
    EXPECT_FALSE(world->objects[1].support);
}

TEST_F(WorldTest, APictureWrapsAlongEachAxis) {
    std::string text = kWorld;
    const std::string two = R"(["mirror", "black"])";
    const Result<World> world = load(text.replace(text.find(R"("clamp")"), 7, two));
    ASSERT_TRUE(world) << world.error().text();
    EXPECT_EQ(world->textures.at(0).wrap, Wrap::kMirror);
    EXPECT_EQ(world->textures.at(0).wrap_v, Wrap::kBlack);
}

TEST_F(WorldTest, IsReadWhole) {
    const Result<World> world = load(kWorld);
    ASSERT_TRUE(world) << world.error().text();
    EXPECT_EQ(world->printer, "j750");
    EXPECT_EQ(world->fablets.at("f").fablet, "F");
    EXPECT_EQ(world->fablets.at("f").source, folder_.path() / "f.fl");
    ASSERT_EQ(world->materials.size(), 2u);
    EXPECT_EQ(world->materials[0].name, "white");
    EXPECT_EQ(world->materials[0].preview, (Rgba8{0xf0, 0xf0, 0xf0, 0x80}));
    EXPECT_EQ(world->materials[1].preview, (Rgba8{0, 0, 0, 255}));
    EXPECT_EQ(world->materials[1].location.line, 7);
    const Texture& texture = world->textures.at(0);
    EXPECT_EQ(texture.wrap, Wrap::kClamp);
    EXPECT_EQ(texture.wrap_v, Wrap::kClamp);
    EXPECT_EQ(texture.filter, Filter::kTrilinear);
    EXPECT_EQ(texture.space, Space::kData);
    EXPECT_TRUE(texture.luminance);
    // The order of the file, not of the alphabet.
    ASSERT_EQ(world->meshes.size(), 4u);
    EXPECT_EQ(world->meshes[0].name, "zed");
    EXPECT_EQ(world->meshes[0].positions.size(), 8u);
    ASSERT_EQ(world->objects.size(), 2u);
    const Object& b = world->objects[0];
    EXPECT_EQ(b.name, "b");
    EXPECT_EQ(b.mesh, 0);
    EXPECT_EQ(b.priority, -3);
    EXPECT_EQ(b.max_displacement_mm, 1.5);
    EXPECT_EQ(std::get<0>(b.uniforms.at("m").value), (std::vector<double>{1, 2, 3, 4}));
    EXPECT_TRUE(b.uniforms.at("on").boolean);
    EXPECT_EQ(std::get<1>(b.uniforms.at("t").value), (std::vector<std::string>{"photo"}));
    EXPECT_EQ(b.uniforms.at("v").location.line, 18);
    EXPECT_EQ(b.uniforms.at("v").location.column, 37);
    EXPECT_EQ(world->objects[1].max_displacement_mm, std::numeric_limits<double>::infinity());
    ASSERT_EQ(world->build.size(), 3u);
    EXPECT_EQ(world->build[0].object, 1);
    EXPECT_EQ(world->build[0].transform.apply({1, 0, 0}), (Vec3d{1, 4, 3}));
    EXPECT_EQ(world->build[1].transform.apply({1, 1, 1}), (Vec3d{8, 9, 10}));
    EXPECT_EQ(std::get<0>(world->build[1].overrides.at("n").value), (std::vector<double>{5}));
    EXPECT_EQ(world->build[2].transform.apply({1, 0, 0}), (Vec3d{0, 1, 0}));
}

TEST_F(WorldTest, AVolumeSaysHowItsFileIsRead) {
    std::string text = kWorld;
    const std::string photo = R"("file": "photo.png", )";
    text.insert(
        text.find(photo) + photo.size(),
        R"("origin_mm": [1, 2, 3], "spacing_mm": 0.5, "field": "stress", "unit": "m", "pitch_mm": 0.2, "outside": -1000, )");
    const Result<World> world = load(text);
    ASSERT_TRUE(world) << world.error().text();
    const Texture& texture = world->textures.at(0);
    EXPECT_EQ(texture.origin_mm, (std::array<double, 3>{1, 2, 3}));
    EXPECT_EQ(texture.spacing_mm, (std::array<double, 3>{0.5, 0.5, 0.5}));
    EXPECT_EQ(texture.field, "stress");
    EXPECT_EQ(texture.unit, "m");
    EXPECT_EQ(texture.pitch_mm, 0.2);
    EXPECT_EQ(texture.outside, -1000);
    text.replace(text.find(R"("unit": "m")"), 11, R"("unit": "n")");
    EXPECT_NE(error_of(text).find("`unit` of texture `photo` is `n`"), std::string::npos);
}

TEST_F(WorldTest, NamesThePlaceOfWhatIsWrong) {
    const std::string folder = folder_.path().string();
    const struct {
        const char* from;
        const char* to;
        std::string message;
    } cases[] = {
        {"\"openfab\": 1", "\"openfab\": 2",
         "2:14: " + fmt::format(messages::kWorldVersion, 2.0) + "; " + messages::kWorldVersionHelp},
        {"\"openfab\": 1,", "",
         "1:1: " + fmt::format(messages::kKeyMissing, "the world", "openfab") + "; " +
             messages::kIsRequired},
        {"\"printer\": \"j750\"", "\"printre\": \"j750\"",
         "3:3: " + fmt::format(messages::kUnknownKey, "printre", "the world") + "; " +
             fmt::format(openfab::messages::kDidYouMean, "printer")},
        {"\"printer\": \"j750\"", "\"tray\": \"centre\"",
         "3:11: `tray` is `centre`; " + fmt::format(openfab::messages::kDidYouMean, "center")},
        {"\"printer\": \"j750\"", "\"printer\": 7",
         fmt::format("3:14: `printer` is {}; {}", openfab::messages::kKindNumber,
                     messages::kMustString)},
        {"\"key\": \"#000000\"", "\"key\": \"#FFFFFF\"",
         "7:22: " + fmt::format(messages::kSameKeyColour, "material `black`", "white") + "; " +
             messages::kSameKeyColourHelp},
        {"\"#000000\"", "\"#00000080\"",
         "7:22: `key` of material `black` is `#00000080`; " +
             fmt::format(messages::kWriteItAs, messages::kOpaqueColourForm)},
        {"\"#000000\"", "\"#0000zz\"",
         "7:22: `key` of material `black` is `#0000zz`; " +
             fmt::format(messages::kWriteItAs, messages::kOpaqueColourForm)},
        {"1.2,", "0,",
         "6:74: `density_g_cm3` of material `white` is 0; " +
             fmt::format(messages::kMustBetween, 0.001, 30.0)},
        {"\"photo.png\"", "\"foto.png\"",
         "9:34: the file of texture `photo` `" + folder + std::string("/foto.png` ") +
             messages::kDoesNotExist + "; " + messages::kPathsCountFromWorld},
        {"\"clamp\"", "\"clmap\"",
         "9:55: `wrap` of texture `photo` is `clmap`; " +
             fmt::format(openfab::messages::kDidYouMean, "clamp")},
        {"\"clamp\"", "[\"clamp\", \"repaet\"]",
         "9:65: `wrap` of texture `photo` is `repaet`; " +
             fmt::format(openfab::messages::kDidYouMean, "repeat")},
        {"\"clamp\"", "[\"clamp\"]",
         std::string("9:55: `wrap` of texture `photo`") + messages::kOneMode + "; " +
             messages::kWrongModesHelp},
        {"\"sphere\": 8", "\"sphere\": 8, \"box\": [1, 1, 1]",
         "12:14: " + fmt::format(messages::kBothKeys, "mesh `ball`", "box", "sphere") + "; " +
             messages::kBothKeysHelp},
        {"{\"sphere\": 8}", "{}",
         "12:13: " + fmt::format(messages::kNoFile, "mesh `ball`") + "; " +
             fmt::format(messages::kNoFileHelp, fmt::join(primitive_keys(), "`, `"))},
        {"\"sphere\": 8", "\"sphere\": 8, \"box_mm\": 3",
         "12:27: " + fmt::format(messages::kBoxWithoutShape, "box_mm", "mesh `ball`") + "; " +
             messages::kBoxWithoutShapeHelp},
        {"\"sphere\": 8", "\"cone\": [0, 0, 3]",
         std::string("12:22: `cone` of mesh `ball`") + messages::kNoDiameter},
        {"\"sphere\": 8", "\"torus\": [4, 4]",
         std::string("12:23: `torus` of mesh `ball`") + messages::kSectionTooWide},
        {"\"sphere\": 8", "\"capsule\": [4, 3]",
         std::string("12:25: `capsule` of mesh `ball`") + messages::kShorterThanDiameter + "; " +
             messages::kShorterThanDiameterHelp},
        {"\"sphere\": 8", "\"revolution\": [[-1, 0], [1, 0], [1, 1]]",
         std::string("12:29: `revolution` of mesh `ball`") + messages::kCornerBeyondAxis + "; " +
             messages::kCornerBeyondAxisHelp},
        {"\"sphere\": 8", "\"revolution\": [[0, 0], [1, 1], [1, 0], [0, 1]]",
         "12:28: `revolution` of mesh `ball`: the polygon meets itself: the side from (0, 0) to "
         "(1, "
         "1) and that from (1, 0) to (0, 1)"},
        {"\"sphere\": 8", "\"revolution\": 3",
         std::string("12:28: `revolution` of mesh `ball`") + messages::kNotAPolygon + "; " +
             messages::kNotAPolygonHelp},
        {"\"sphere\": 8", "\"extrusion\": {\"polygons\": [], \"height\": 3}",
         std::string("12:40: `polygons` of `extrusion` of mesh `ball`") + messages::kNotPolygons +
             "; " + messages::kNotPolygonsHelp},
        {"\"sphere\": 8", "\"extrusion\": {\"polygons\": [[[0, 0], [1, 0]]], \"height\": 3}",
         "12:40: `extrusion` of mesh `ball`: the polygon has fewer than 3 corners"},
        {"\"sphere\": 8", "\"sphere\": -1",
         "12:24: `sphere` of mesh `ball` is -1; " +
             fmt::format(messages::kMustBetween, 1e-06, 100000.0)},
        {"[10, 20, 30]", "[10, 0, 30]",
         std::string("11:25: `box` of mesh `zed`") + messages::kSizeNotAboveZero},
        {"[10, 20, 30]", "[10, 30]",
         "11:20: `box` of mesh `zed` is an array of 2; " +
             fmt::format(messages::kMustArrayNumbers, 3)},
        {"\"sphere\": 8", "\"sphere\": 8, \"unit\": \"cm\"",
         "12:27: " + fmt::format(messages::kGoesWithFile, "unit", "mesh `ball`") + "; " +
             fmt::format(messages::kGoesWithFileHelp, "sphere")},
        {"\"sphere\": 8", "\"file\": \"photo.png\"",
         "12:22: " + fmt::format(messages::kNoMeshExtension, "mesh `ball`", "photo.png") +
             "; supported: " + mesh::mesh_formats()},
        {"\"mesh\": \"ball\"", "\"mesh\": \"bal\"",
         "19:19: " + fmt::format(messages::kNoneOfName, "mesh", "bal") + "; " +
             fmt::format(openfab::messages::kDidYouMean, "ball")},
        {"\"fablet\": \"f\", \"priority\"", "\"fablet\": \"ggg\", \"priority\"",
         "17:36: " + fmt::format(messages::kNoneOfName, "fablet", "ggg") + "; " +
             fmt::format(openfab::messages::kKnownNames, "`f`")},
        {"\"priority\": -3", "\"priority\": 1.5",
         std::string("17:53: `priority` of object `b` is 1.5; ") + messages::kMustWholeNumber},
        {"\"support\": false", "\"support\": 1",
         fmt::format("19:53: `support` of object `a` is {}; {}", openfab::messages::kKindNumber,
                     messages::kMustTrueFalse)},
        {"\"printer\": \"j750\"", "\"support\": \"grey\"",
         "3:14: " + fmt::format(messages::kNoSuchMaterial, "grey") + "; " +
             fmt::format(openfab::messages::kKnownNames, "`white`, `black`")},
        {"\"printer\": \"j750\"", "\"support\": []",
         std::string("3:14: ") + messages::kSupportNeither},
        {"\"support\": false", "\"repair\": \"glue\"",
         "19:52: `repair` of object `a` is `glue`; " +
             fmt::format(openfab::messages::kKnownNames, "`winding`")},
        {"\"n\": 2", "\"n\": null",
         std::string("18:29: uniform `n` of object `b` holds null; ") + messages::kMixedValuesHelp},
        {"[1, 2.5]", "[1, \"x\"]",
         std::string("18:41: uniform `v` of object `b` ") + messages::kMixedValues + "; " +
             messages::kMixedValuesHelp},
        {"[1, 2.5]", "{\"keys\": [[0, 1], 2]}",
         std::string("18:55: uniform `v` of object `b`") + messages::kKeyNoNumbers + "; " +
             messages::kKeyNoNumbersHelp},
        {"[1, 2.5]", "{\"keys\": [[0, 1]], \"interpolation\": \"smooth\"}",
         "18:73: " + fmt::format(messages::kInterpolationNone, "uniform `v` of object `b`") + "; " +
             messages::kInterpolationNoneHelp},
        {"[1, 2.5]", "{\"keys\": [[0, 1]], \"interpolate\": 1}",
         "18:71: uniform `v` of object `b` has no `interpolate`; " +
             fmt::format(openfab::messages::kDidYouMean, "interpolation")},
        {"[1, 2.5]", "{\"interpolation\": \"step\"}",
         "18:37: uniform `v` of object `b` is an object without `keys`; a curve is given as "
         "`{\"keys\": [[0, 1], [5, 2]]}`"},
        {"[1, 2.5]", "[]",
         std::string("18:37: uniform `v` of object `b`") + messages::kEmptyArray + "; " +
             messages::kEmptyArrayHelp},
        {"{\"object\": \"a\"", "{\"object\": \"c\"",
         "22:16: " + fmt::format(messages::kNoSuchObject, "c") + "; " +
             fmt::format(openfab::messages::kKnownNames, "`b`, `a`")},
        {"\"scale\": 2", "\"scael\": 2",
         "22:21: " + fmt::format(messages::kUnknownKey, "scael", "build[0]") + "; " +
             fmt::format(openfab::messages::kDidYouMean, "scale")},
        {"\"scale\": 2", "\"scale\": 0",
         "22:30: " + fmt::format(openfab::messages::kTransformFlattens, 0.0) + "; " +
             openfab::messages::kTransformFlattensHelp},
        {"\"scale\": 2", "\"matrix\": [1]",
         "22:36: " + fmt::format(messages::kMatrixAndOther, "build[0]", "rotate_deg") + "; " +
             messages::kOneOrTheOther},
        {"[0, 0, 90]", "[0, 90]",
         "22:47: `rotate_deg` of build[0] is an array of 2; " +
             fmt::format(messages::kMustArrayNumbers, 3)},
        {"\"build\": [", "\"build\": [], \"x\": [",
         "21:16: " + fmt::format(messages::kUnknownKey, "x", "the world") + "; " +
             fmt::format(openfab::messages::kKnownNames,
                         "`$schema`, `openfab`, `printer`, `tray`, `support`, `fablets`, `dither`, "
                         "`materials`, `textures`, `meshes`, `objects`, `groups`" +
                             fmt::format(openfab::messages::kAndMore, 3))},
    };
    for (const auto& c : cases)
        EXPECT_EQ(error_with(c.from, c.to), c.message) << c.to;
    EXPECT_EQ(error_of("[]"), fmt::format("1:1: the world is {}; {}", openfab::messages::kKindArray,
                                          messages::kMustObject));
    EXPECT_EQ(error_of(R"({"openfab":1,"fablets":{},"meshes":{},"objects":{},"build":[]})"),
              std::string("1:60: `build` is empty; ") + messages::kMustBePlacements);
    EXPECT_NE(load_world(folder_.path() / "none.fab.json").error().text().find("No such file"),
              std::string::npos);
    EXPECT_EQ(load_world(folder_.path() / "none.fab.json").error().code, ErrorCode::kUserInput);
    EXPECT_FALSE(load_world(folder_.path()));
}

TEST_F(WorldTest, PassesTheErrorsOfMeshFilesOn) {
    folder_.write("open.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n");
    const std::string message = error_with("\"sphere\": 8", "\"file\": \"open.obj\"");
    EXPECT_TRUE(message.starts_with((folder_.path() / "open.obj").string() +
                                    ":4:1: mesh `ball` is not a closed surface: "
                                    "3 open edges"))
        << message;
    folder_.write("thing.step", "solid");
    const std::string unknown = error_with("\"sphere\": 8", "\"file\": \"thing.step\"");
    EXPECT_THAT(unknown, ::testing::AllOf(testing::Says(messages::kNoMeshExtension,
                                                        "*12:22: mesh `ball`", "thing.step"),
                                          ::testing::HasSubstr("; supported: .obj, .stl")))
        << unknown;
}

TEST_F(WorldTest, SaysWhichAxisOfAFileIsUp) {
    folder_.write("part.glb", "not read");
    EXPECT_THAT(error_with("\"sphere\": 8", "\"file\": \"part.glb\", \"up\": \"y\""),
                ::testing::AllOf(testing::Says(messages::kGltfIsYUp, "mesh `ball`"),
                                 testing::Says(messages::kLeaveItOut)));
    folder_.write("part.obj", "not read");
    const std::string other = error_with("\"sphere\": 8", "\"file\": \"part.obj\", \"up\": \"x\"");
    EXPECT_NE(other.find("`up` of mesh `ball` is `x`"), std::string::npos) << other;
    EXPECT_THAT(error_with("\"sphere\": 8", "\"sphere\": 8, \"up\": \"y\""),
                testing::Says(messages::kGoesWithFile, "up", "mesh `ball`"));
}

TEST_F(WorldTest, SurvivesEveryTruncation) {
    const std::string text = kWorld;
    for (size_t n = 0; n < text.size(); n += 3)
        EXPECT_NE(error_of(text.substr(0, n)), "no error") << n;
}

TEST_F(WorldTest, LimitsMaterials) {
    std::string list;
    for (int i = 0; i < 255; ++i)
        list += fmt::format("\"m{0}\": {{\"key\": \"#00{0:04}\"}},", i);
    EXPECT_THAT(error_with("\"white\"", list + "\"white\""),
                testing::Says(messages::kTooManyMaterials, 254));
}

TEST_F(WorldTest, DataOfADetachedVolumeAreFilesOfTheWorld) {
    const std::string header =
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\ndata file: ";
    folder_.write("scan.nhdr", header + "/etc/passwd\n\n");
    EXPECT_NE(error_with("photo.png", "scan.nhdr").find("its file `passwd` is `/etc/passwd`"),
              std::string::npos);
    folder_.write("scan.nhdr", header + "scan.raw\n\n");
    std::string text = kWorld;
    const Result<World> world =
        load(text.replace(text.find("photo.png"), std::string("photo.png").size(), "scan.nhdr"));
    ASSERT_TRUE(world) << world.error().text();
    // So that --watch watches them, too.
    EXPECT_EQ(std::count(world->files.begin(), world->files.end(), folder_.path() / "scan.raw"), 1);
    EXPECT_EQ(world->roots, std::vector{without_links(folder_.path())});
}

TEST_F(WorldTest, ChunksOfTheArrayThatIsReadAreFilesOfTheWorld) {
    const std::string array =
        R"({"zarr_format": 2, "shape": [1, 1, 2], "chunks": [1, 1, 1], "dtype": "|u1", "order": "C", "fill_value": 0, "compressor": null, "filters": null})";
    for (const char* name : {"a", "b"})
        std::filesystem::create_directories(folder_.path() / "s.zarr" / name);
    folder_.write("s.zarr/.zgroup", R"({"zarr_format": 2})");
    for (const char* name : {"a", "b"}) {
        folder_.write(fmt::format("s.zarr/{}/.zarray", name), array);
        folder_.write(fmt::format("s.zarr/{}/0.0.0", name), "x");
    }
    std::string text = kWorld;
    const size_t at = text.find("photo.png");
    const Result<World> world = load(text.replace(at, 9, R"(s.zarr", "field": "b)"));
    ASSERT_TRUE(world) << world.error().text();
    std::vector<std::string> names;
    for (const std::filesystem::path& file : world->files) {
        if (is_below(file, folder_.path() / "s.zarr"))
            names.push_back(std::filesystem::relative(file, folder_.path()).string());
    }
    EXPECT_EQ(names,
              (std::vector<std::string>{"s.zarr/.zgroup", "s.zarr/b/.zarray", "s.zarr/b/0.0.0"}));
}

TEST_F(WorldTest, DataOfXdmfAreFilesOfTheWorld) {
    const auto with = [](const std::string& name) {
        return "<Xdmf><Domain><Grid><Attribute><DataItem Dimensions=\"1\" Format=\"Binary\">" +
               name + "</DataItem></Attribute></Grid></Domain></Xdmf>";
    };
    folder_.write("scan.xdmf", with("../elsewhere.bin"));
    EXPECT_NE(error_with("photo.png", "scan.xdmf").find("its file `elsewhere.bin` is `"),
              std::string::npos);
    folder_.write("scan.xdmf", with("scan.bin"));
    std::string text = kWorld;
    const Result<World> world =
        load(text.replace(text.find("photo.png"), std::string("photo.png").size(), "scan.xdmf"));
    ASSERT_TRUE(world) << world.error().text();
    EXPECT_EQ(std::count(world->files.begin(), world->files.end(), folder_.path() / "scan.bin"), 1);
}

TEST_F(WorldTest, ObjectsHaveTheUniformsOfTheirFabletUnlessTheySayOtherwise) {
    const auto world = load(R"({"openfab": 1,
        "fablets": {"f": {"source": "f.fl", "fablet": "F", "uniforms": {"n": 1, "m": "white"}}},
        "materials": {"white": {"key": "#ffffff"}}, "meshes": {"ball": {"sphere": 4}},
        "objects": {"a": {"mesh": "ball", "fablet": "f"},
                    "b": {"mesh": "ball", "fablet": "f", "uniforms": {"n": 2, "k": 3}}},
        "build": [{"object": "a"}, {"object": "b"}]})");
    ASSERT_TRUE(world) << world.error().text();
    const auto number = [&](size_t object, const char* name) {
        return std::get<0>(world->objects[object].uniforms.at(name).value);
    };
    EXPECT_EQ(number(0, "n"), std::vector<double>{1});
    EXPECT_EQ(number(1, "n"), std::vector<double>{2});
    EXPECT_EQ(number(1, "k"), std::vector<double>{3});
    EXPECT_EQ(std::get<1>(world->objects[1].uniforms.at("m").value),
              std::vector<std::string>{"white"});
    EXPECT_EQ(world->objects[1].uniforms.at("m").location.line, 2);
    EXPECT_EQ(world->objects[0].uniforms.size(), 2u);
}

TEST_F(WorldTest, NamesADitherRule) {
    const auto with = [](const std::string& dither) {
        std::string text = kWorld;
        return text.replace(text.find("  \"materials\""), 0, "  \"dither\": " + dither + ",\n");
    };
    folder_.write("rules.fl", "not read here");
    const std::string text = with(R"({"source": "rules.fl", "rule": "dots"})");
    const Result<World> world = load(text);
    ASSERT_TRUE(world) << world.error().text();
    ASSERT_TRUE(world->dither);
    EXPECT_EQ(world->dither->source, folder_.path() / "rules.fl");
    EXPECT_EQ(world->dither->rule, "dots");
    EXPECT_EQ(world->dither->location.line, 5);
    EXPECT_TRUE(std::find(world->files.begin(), world->files.end(), world->dither->source) !=
                world->files.end());
    EXPECT_FALSE(load(kWorld)->dither);

    EXPECT_EQ(
        error_of(with(R"({"source": "no.fl", "rule": "dots"})")),
        fmt::format("5:24: the source of `dither` `{}` {}; {}", (folder_.path() / "no.fl").string(),
                    messages::kDoesNotExist, messages::kPathsCountFromWorld));
    EXPECT_EQ(error_of(with(R"({"source": "rules.fl"})")).substr(0, 5), "5:13:");
    EXPECT_EQ(error_of(with(R"({"source": "rules.fl", "rule": 3})")).substr(0, 5), "5:44:");
    EXPECT_EQ(error_of(with(R"("dots")")).substr(0, 5), "5:13:");
}

TEST_F(WorldTest, ABodyOfAFileIsAMeshOfItsOwn) {
    folder_.write("part.obj",
                  "v 1000 0 0\nv 1009 0 0\nv 1000 9 0\nv 1000 0 9\n"
                  "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    const auto world_of = [&](const std::string& mesh) {
        std::string text = kWorld;
        text.replace(text.find("{\"box\": [10, 20, 30]}"), 21, mesh);
        return load_world(folder_.write("w.fab.json", text));
    };
    const Result<World> world =
        world_of(R"({"file": "part.obj", "body": "body", "origin_mm": [1000, -1, 2]})");
    ASSERT_TRUE(world) << world.error().text();
    EXPECT_EQ(world->meshes.at(0).positions[0], (Vec3d{0, 1, -2}));
    const std::string unknown = world_of(R"({"file": "part.obj", "body": "bodi"})").error().text();
    EXPECT_THAT(unknown, testing::Says(mesh::messages::kNoBodyOfMesh, "*", "bodi")) << unknown;
    EXPECT_THAT(unknown, ::testing::HasSubstr("`body`")) << unknown;
    EXPECT_FALSE(world_of(R"({"file": "part.obj", "body": ""})"));
    EXPECT_FALSE(world_of(R"({"box": [1, 2, 3], "body": "body"})"));
}

TEST_F(WorldTest, FilesOfMeshesCanBeLeftUnread) {
    folder_.write("part.obj", "not a mesh");
    std::string text = kWorld;
    text.replace(text.find("{\"box\": [10, 20, 30]}"), 21, R"({"file": "part.obj"})");
    text.replace(text.find("\"materials\""), 0, R"("dither": {"source": "f.fl", "rule": "r"}, )");
    folder_.write("f.fl", "not read here");
    const std::filesystem::path file = folder_.write("w.fab.json", text);
    EXPECT_FALSE(load_world(file));
    const Result<World> early = load_world(file, {}, MeshFiles::kSkip);
    ASSERT_TRUE(early) << early.error().text();
    EXPECT_TRUE(early->meshes.at(0).positions.empty());
    EXPECT_FALSE(early->meshes.at(1).positions.empty());
    EXPECT_EQ(early->fablets.at("f").source, folder_.path() / "f.fl");
    EXPECT_EQ(early->dither->rule, "r");
    EXPECT_EQ(early->build.size(), 3u);
}

}  // namespace
}  // namespace openfab::world
