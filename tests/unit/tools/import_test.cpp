// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The worlds that an import makes of bodies and their looks.

#include "tools/openfab/import.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "mesh/model/messages.h"
#include "tests/support/memory/meter.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/stock.h"
#include "world/world.h"

namespace openfab::tools {
namespace {

using mesh::BodyRole;
using mesh::LoadedBodies;
using mesh::LoadedMesh;
using mesh::Look;
using ::testing::HasSubstr;
using ::testing::Not;

SharedBytes bytes_of(const std::string& text) {
    return std::make_shared<const std::string>(text);
}

Look plain(const std::string& name, const std::array<double, 3>& color) {
    Look look;
    look.name = name;
    look.color = color;
    return look;
}

Look textured(const std::string& name, const std::string& file) {
    Look look;
    look.name = name;
    look.picture.emplace();
    look.picture->source = look.picture->name = file;
    look.picture->alpha = mesh::PictureUse::Alpha::kBlend;
    return look;
}

/// A cube with these looks by number: its front, the rest.
LoadedMesh cube(const std::string& name, std::vector<int32_t> looks) {
    LoadedMesh out;
    out.body = name;
    out.mesh = testing::cube(10);
    for (mesh::MeshAttribute& a : out.mesh.attributes) {
        if (a.name != "face") continue;
        for (int32_t& f : a.faces)
            f = f == 0 || looks.size() == 1 ? 0 : 1;
    }
    for (size_t i = 0; i < looks.size(); ++i)
        out.groups.emplace_back(fmt::format("g{}", i), static_cast<int32_t>(i));
    out.look_of = std::move(looks);
    return out;
}

LoadedBodies label_and_rest() {
    LoadedBodies out;
    out.looks = {textured("front \"x\"", "a b/ü.png"), plain("rest", {1, 0, 0})};
    out.looks[0].picture->wrap = {mesh::PictureWrap::kClamp, mesh::PictureWrap::kNone};
    out.bodies.push_back(cube("body", {0, 1}));
    return out;
}

Pictures one_picture() {
    Pictures pictures;
    pictures.emplace("a b/ü.png", bytes_of("picture"));
    return pictures;
}

std::string world_of(const LoadedBodies& loaded, const Pictures& pictures = {},
                     const ImportOptions& options = {}) {
    const Result<Import> import = make_import(loaded, pictures, "cube.obj", options);
    EXPECT_TRUE(import) << import.error().text();
    return import ? import->world : "";
}

TEST(Import, LooksDecideByGroup) {
    const Result<Import> import = make_import(label_and_rest(), one_picture(), "cube.obj", {});
    ASSERT_TRUE(import) << import.error().text();
    EXPECT_EQ(import->fablets, (std::vector<std::string>{"textured"}));
    ASSERT_EQ(import->files.size(), 2u);
    EXPECT_EQ(import->files[0].name, "a_b___.png");
    EXPECT_THAT(*import->files[1].bytes, HasSubstr("const int GROUPS = 2;"));
    EXPECT_THAT(*import->files[1].bytes, HasSubstr("float cutoff[GROUPS] = {-1, -1} [["));
    for (const char* text : {"\"materials\": [\"white\", \"rest\"]", "\"map_of\": [0, -1]",
                             "\"maps\": \"a_b___\"", "\"tints\": [[1, 1, 1, 0], [1, 1, 1, 0]]",
                             "\"wrap\": [\"clamp\", \"black\"]", "\"rest\": {\"key\": \"#ff0000\"",
                             // It shows on the white ground of pictures.
                             "\"white\": {\"key\": \"#ffffff\", \"preview\": \"#f4f2ecff\"}"})
        EXPECT_THAT(import->world, HasSubstr(text));
    EXPECT_THAT(import->world, Not(HasSubstr("cutoff")));
}

TEST(Import, OpaquePicturesEndWhereTheyDoNotRepeat) {
    LoadedBodies loaded = label_and_rest();
    loaded.looks[0].picture->alpha = mesh::PictureUse::Alpha::kOpaque;
    EXPECT_THAT(world_of(loaded, one_picture()), Not(HasSubstr("cutoff")));
    loaded.looks[0].picture->wrap = {};
    EXPECT_THAT(world_of(loaded, one_picture()), HasSubstr("\"cutoff\": [0, -1]"));
}

TEST(Import, ABodyIsAnObjectOfItsOwnMaterial) {
    LoadedBodies loaded;
    loaded.unit_note = mesh::messages::kUnitOfFile;
    loaded.looks = {plain("PLA", {1, 0, 0}), plain("PLA", {0, 0, 1})};
    loaded.bodies = {cube("left", {0}), cube("right", {1}), cube("bare", {})};
    loaded.bodies[1].depth = 1;
    const std::string world = world_of(loaded);
    for (const char* text :
         {"\"left\": {\"file\": \"cube.obj\", \"body\": \"left\"}", "\"materials\": \"PLA\"",
          "\"PLA_2\": {\"key\": \"#0000ff\"", "\"priority\": 1",
          "\"uniforms\": {\"materials\": \"bare\"}", "{\"object\": \"right\"}",
          "{\"group\": \"cube\", \"translate_mm\": [0, 0]}"})
        EXPECT_THAT(world, HasSubstr(text));
    ImportOptions one;
    one.one_material = true;
    EXPECT_THAT(world_of(loaded, {}, one), Not(HasSubstr("PLA")));
    one.largest_mm = 25;
    EXPECT_THAT(world_of(loaded, {}, one), HasSubstr("\"scale\": 2.5"));
}

TEST(Import, BodiesOfOtherCountsOfGroupsShareAFablet) {
    LoadedBodies loaded;
    loaded.looks = {plain("red", {1, 0, 0}), plain("blue", {0, 0, 1})};
    loaded.bodies = {cube("one", {0}), cube("two", {1, 0})};
    const std::string world = world_of(loaded);
    EXPECT_THAT(world, HasSubstr("\"materials\": [\"red\", \"red\"]"));
    EXPECT_THAT(world, HasSubstr("\"materials\": [\"blue\", \"red\"]"));
}

TEST(Import, WhatObjectsShareIsSaidOnce) {
    LoadedBodies loaded;
    loaded.unit_note = mesh::messages::kUnitOfFile;
    loaded.looks = {plain("", {1, 0, 0}), plain("", {0, 0, 1})};
    for (Look& look : loaded.looks)
        look.is_material = false;
    loaded.bodies = {cube("one", {0}), cube("two", {1})};
    const std::string world = world_of(loaded);
    for (const char* text :
         {"\"painted\": {\n            \"source\": \"stock_painted.fl\",\n            \"fablet\": "
          "\"Painted\",\n            \"uniforms\": {\n                \"materials\": \"white\",\n  "
          "      "
          "        \"cyan\": \"cyan\",\n",
          "        \"one\": {\"mesh\": \"one\", \"fablet\": \"painted\", \"uniforms\": {\"tints\": "
          "[1, 0, 0, 1]}},\n"})
        EXPECT_THAT(world, HasSubstr(text));
    // A hundred bodies of one material take three lines each.
    loaded.looks = {plain("PLA", {1, 0, 0})};
    loaded.bodies.clear();
    for (int i = 0; i < 100; ++i)
        loaded.bodies.push_back(cube(fmt::format("body {}", i), {0}));
    const std::string hundred = world_of(loaded);
    EXPECT_LT(std::count(hundred.begin(), hundred.end(), '\n'), 3 * 100 + 30) << hundred;
}

TEST(Import, PicturesWithHardTexelsStaySo) {
    LoadedBodies loaded = label_and_rest();
    loaded.looks[0].picture->nearest = true;
    loaded.looks[1] = textured("soft", "a b/ü.png");
    const std::string world = world_of(loaded, one_picture());
    EXPECT_THAT(world, HasSubstr("\"wrap\": [\"clamp\", \"black\"], \"filter\": \"nearest\"}"));
    EXPECT_THAT(world, HasSubstr("\"a_b____2\": {\"file\": \"a_b___.png\"}"));
}

TEST(Import, EqualColoursHaveTwoKeys) {
    LoadedBodies loaded;
    loaded.looks = {plain("front \"x\"", {1, 0, 0}), plain("rest", {1, 0, 0})};
    loaded.bodies.push_back(cube("body", {0, 1}));
    const std::string world = world_of(loaded);
    EXPECT_THAT(world, HasSubstr("\"front \\\"x\\\"\": {\"key\": \"#ff0000\""));
    EXPECT_THAT(world, HasSubstr("\"rest\": {\"key\": \"#ff0001\", \"preview\": \"#ff0000ff\""));
}

TEST(Import, ColoursWithoutAMaterialAreASkin) {
    LoadedBodies loaded;
    loaded.looks = {plain("", {1, 0, 0}), plain("PLA", {0, 0, 1})};
    loaded.looks[0].is_material = false;
    loaded.bodies.push_back(cube("body", {0, 1}));
    const std::string world = world_of(loaded);
    for (const char* text : {"\"fablet\": \"painted\"", "\"materials\": [\"white\", \"PLA\"]",
                             "\"tints\": [[1, 0, 0, 1], [1, 1, 1, 0]]"})
        EXPECT_THAT(world, HasSubstr(text));
}

TEST(Import, CompositesAreMixtures) {
    LoadedBodies loaded;
    loaded.looks = {plain("soft", {1, 1, 1}), plain("hard", {0, 0, 0}), plain("blend", {})};
    loaded.looks[2].mixture = {{0, 0.25}, {1, 0.75}};
    loaded.bodies.push_back(cube("body", {2, 1}));
    const std::string world = world_of(loaded);
    for (const char* text :
         {"\"fablet\": \"mixed\"", "\"materials\": [\"soft\", \"hard\", \"hard\", \"hard\"]",
          "\"shares\": [0.25, 0.75, 1, 0]"})
        EXPECT_THAT(world, HasSubstr(text));
    EXPECT_THAT(world, Not(HasSubstr("blend")));
}

TEST(Import, NegativeBodiesCut) {
    LoadedBodies loaded;
    loaded.bodies = {cube("part", {}), cube("hole", {}), cube("other", {})};
    loaded.bodies[0].depth = 2;
    loaded.bodies[1].role = BodyRole::kNegative;
    loaded.bodies[2].assembly = 1;
    const Result<Import> import = make_import(loaded, {}, "cube.obj", {});
    ASSERT_TRUE(import) << import.error().text();
    EXPECT_THAT(import->world,
                HasSubstr("\"priority\": 3,\n            \"support\": false,\n       "
                          "     \"uniforms\": {\"materials\": \"VOID\"}"));
    EXPECT_THAT(fmt::format("{}", fmt::join(import->notes, "\n")),
                testing::Says(messages::kMayCutAssembly, "`other`"));
}

TEST(Import, OffersAWayOutOfTooManyMaterials) {
    LoadedBodies loaded;
    for (int i = 0; i < 255; ++i) {
        loaded.looks.push_back(plain("m", {i / 255.0, 0, 0}));
        loaded.bodies.push_back(cube(std::to_string(i), {i}));
    }
    const Result<Import> refused = make_import(loaded, {}, "cube.obj", {});
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().text(), HasSubstr("`--one-material`"));
    ImportOptions options;
    options.fablet = "painted";
    EXPECT_TRUE(make_import(loaded, {}, "cube.obj", options));
    // Without any materials they share one.
    loaded.looks.clear();
    for (LoadedMesh& body : loaded.bodies)
        body.look_of.clear();
    const Result<Import> bare = make_import(loaded, {}, "cube.obj", {});
    ASSERT_TRUE(bare) << bare.error().text();
    EXPECT_THAT(fmt::format("{}", fmt::join(bare->notes, "\n")),
                testing::Says(messages::kBodiesShareMaterial));
}

TEST(Import, NamesManyPicturesOfOneName) {
    constexpr int kPictures = 20'000;
    LoadedBodies loaded;
    Pictures pictures;
    loaded.bodies.push_back(cube("body", {}));
    for (int i = 0; i < kPictures; ++i) {
        loaded.looks.push_back(textured("m", fmt::format("{:05}", i)));
        loaded.looks.back().picture->name = "a.png";
        loaded.bodies[0].look_of.push_back(i);
        pictures.emplace(fmt::format("{:05}", i), bytes_of(std::to_string(i)));
    }
    const testing::Meter meter;
    const Result<Import> import = make_import(loaded, pictures, "a.obj", {});
    ASSERT_TRUE(import) << import.error().text();
    EXPECT_EQ(import->files[0].name, "a.png");
    EXPECT_EQ(import->files[kPictures - 1].name, fmt::format("a_{}.png", kPictures));
    EXPECT_LT(meter.seconds(), testing::kHangSeconds);
}

TEST(Import, RefusesWhatTheMeshLacks) {
    LoadedBodies loaded;
    loaded.bodies.push_back(cube("body", {}));
    ImportOptions options;
    for (const char* fablet : {"relief", "painted", "textured"}) {
        options.fablet = fablet;
        EXPECT_FALSE(make_import(loaded, {}, "cube.obj", options)) << fablet;
    }
    loaded = label_and_rest();
    loaded.bodies[0].mesh = testing::without(loaded.bodies[0].mesh, "uv");
    options.fablet = "textured";
    EXPECT_THAT(make_import(loaded, one_picture(), "cube.obj", options).error().text(),
                testing::Says(messages::kNoCoordinates, "cube.obj", "textured"));
    options.fablet.clear();
    EXPECT_EQ(make_import(loaded, one_picture(), "cube.obj", options)->fablets[0], "solid");
}

TEST(Import, WritesWorldsOfEveryStockFabletThatLoad) {
    for (const StockFablet& stock : kStockFablets) {
        const std::string fablet(stock.name);
        const testing::TempFolder folder;
        LoadedBodies loaded = label_and_rest();
        mesh::MeshAttribute color;
        color.name = "color";
        color.components = 3;
        color.values = {1, 0, 0};
        color.corners.resize(loaded.bodies[0].mesh.triangles.size());
        loaded.bodies[0].mesh.attributes.push_back(color);
        ImportOptions options;
        options.fablet = fablet;
        const Result<Import> import = make_import(loaded, one_picture(), "cube.obj", options);
        ASSERT_TRUE(import) << import.error().text();
        for (const ImportedFile& file : import->files)
            folder.write(file.name, *file.bytes);
        folder.write("cube.obj",
                     "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
        const Result<world::World> world =
            world::load_world(folder.write("cube.fab.json", import->world));
        EXPECT_TRUE(world) << fablet << ": " << world.error().text();
    }
}

}  // namespace
}  // namespace openfab::tools
