// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Colours and pictures of mesh files, and the worlds that an import makes of them.

#include "tools/openfab/appearance.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>

#include "tests/support/memory/meter.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/meshes/zip_archive.h"
#include "tools/openfab/import.h"
#include "tools/openfab/stock.h"
#include "world/world.h"

namespace openfab::tools {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

TEST(Appearances, OfAMaterialLibrary) {
    const testing::TempFolder folder;
    const testing::TempFolder other;
    other.write("secret.png", "not for the world");
    fs::create_directory(folder.path() / "maps");
    folder.write("maps/skin.png", "skin");
    folder.write("eye.png", "eye");
    folder.write("robot.mtl",
                 "# robot\nnewmtl body one\r\nKd 1 0 0.5\nNs 10\nmap_Kd maps\\skin.png\r\n"
                 "newmtl eye\n  Kd 0 0 0\n\tmap_Kd -clamp on -o 0.5 0 -bm 2 eye.png\n"
                 "newmtl plain\nKd 0 1 0\nnewmtl lost\nmap_Kd gone.png\n"
                 "newmtl far\nmap_Kd " +
                     (other.path() / "secret.png").string() + "\nnewmtl eye\nKd 1 1 1\nKd x y z\n");
    const fs::path mesh =
        folder.write("robot.obj", "mtllib robot.mtl\nmtllib ../up.mtl\nv 0 0 0\n");
    const Result<Appearances> appearances = read_appearances(mesh);
    ASSERT_TRUE(appearances) << appearances.error().text();
    ASSERT_EQ(appearances->appearances.size(), 5u);
    const MaterialAppearance& body = appearances->appearances[0];
    EXPECT_EQ(body.name, "body one");
    EXPECT_EQ((*body.color)[0], 1);
    EXPECT_NEAR((*body.color)[2], 0.21404, 1e-5);  // sRGB 0.5 as light
    EXPECT_EQ(body.picture->name, "skin.png");
    EXPECT_EQ(*body.picture->bytes, "skin");
    EXPECT_FALSE(body.picture->clamp);
    EXPECT_FALSE(body.tinted);
    const auto named = [&](const char* name) {
        return appearances->appearances[indices_of(*appearances).at(name)];
    };
    EXPECT_EQ(*named("eye").picture->bytes, "eye");
    EXPECT_TRUE(named("eye").picture->clamp);
    EXPECT_EQ((*named("eye").color)[0], 0);
    EXPECT_FALSE(named("plain").picture);
    EXPECT_FALSE(named("lost").picture);
    EXPECT_FALSE(named("far").picture) << "a file outside the mesh's folder was read";
    EXPECT_EQ(appearances->notes.size(), 4u);  // the shift, gone.png, secret.png, up.mtl
}

TEST(Appearances, OfGltf) {
    // "aGVsbG8=" is hello.
    const std::string text = R"({"asset": {"version": "2.0"}, "materials": [
        {"name": "skin", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 0.25, 1], "baseColorTexture": {"index": 0}}},
        {"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}, {"name": "none"}],
        "textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 33071}],
        "images": [{"uri": "data:image/png;base64,aGVsbG8=", "name": "face"}]})";
    const Result<Appearances> appearances = gltf_appearances(text, "a.gltf");
    ASSERT_TRUE(appearances) << appearances.error().text();
    ASSERT_EQ(appearances->appearances.size(), 3u);
    EXPECT_EQ(*appearances->appearances[0].picture->bytes, "hello");
    EXPECT_TRUE(appearances->appearances[0].picture->clamp);
    EXPECT_TRUE(appearances->appearances[0].tinted);
    EXPECT_EQ((*appearances->appearances[0].color)[2], 0.25);
    EXPECT_EQ(appearances->appearances[1].name, "material 1");
    EXPECT_FALSE(gltf_appearances(
        R"({"asset": {"version": "2.0"}, "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 3}}}]})",
        "a.gltf"));
}

constexpr int64_t kMegabyte = 1'000'000;

/// Memory and time of `read` are bounded.
Result<Appearances> within(int64_t memory_bytes, const std::function<Result<Appearances>()>& read) {
    const testing::Meter meter;
    Result<Appearances> appearances = read();
    EXPECT_LE(meter.peak_bytes(), memory_bytes + 2 * kMegabyte);
    EXPECT_LT(meter.seconds(), testing::kHangSeconds);
    return appearances;
}

TEST(Appearances, HaveAPictureOnceThatManyMaterialsHave) {
    constexpr int kMaterials = 5000;
    constexpr int64_t kMost = 40 * kMegabyte;
    const testing::TempFolder folder;
    folder.write("large.png", std::string(5'000'000, 'x'));
    std::string library;
    for (int i = 0; i < kMaterials; ++i)
        library += fmt::format("newmtl m{}\nmap_Kd {}large.png\n", i, i % 2 == 0 ? "" : "./");
    folder.write("a.mtl", library);
    const fs::path obj = folder.write("a.obj", "mtllib a.mtl\n");
    Result<Appearances> appearances = within(kMost, [&] { return read_appearances(obj, kMost); });
    ASSERT_TRUE(appearances) << appearances.error().text();
    ASSERT_EQ(appearances->appearances.size(), size_t{kMaterials});
    EXPECT_EQ(appearances->appearances[0].picture->bytes,
              appearances->appearances[4999].picture->bytes);

    std::string gltf = R"({"asset": {"version": "2.0"}, "materials": [)";
    for (int i = 0; i < kMaterials; ++i)
        gltf += fmt::format(
            R"({}{{"name": "m{}", "pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}}}})",
            i > 0 ? "," : "", i);
    gltf += R"(], "textures": [{"source": 0}], "images": [{"bufferView": 0}],
        "bufferViews": [{"buffer": 0, "byteLength": 5000000}],
        "buffers": [{"uri": "large.png", "byteLength": 5000000}]})";
    const fs::path file = folder.write("a.gltf", gltf);
    appearances = within(kMost, [&] { return read_appearances(file, kMost); });
    ASSERT_TRUE(appearances) << appearances.error().text();
    EXPECT_EQ(appearances->appearances[0].picture->bytes,
              appearances->appearances[4999].picture->bytes);
    EXPECT_FALSE(within(8 * kMegabyte, [&] { return read_appearances(file, 8 * kMegabyte); }));

    std::string groups;
    for (int i = 0; i < kMaterials; ++i)
        groups += fmt::format(R"(<texture2dgroup id="{}" texid="1"/>)", i + 2);
    const fs::path threemf = folder.write(
        "a.3mf",
        testing::zip_archive(
            {{"_rels/.rels",
              R"(<Relationships><Relationship Target="/m.model" Id="r0" Type="x/3dmodel"/></Relationships>)"},
             {"m.model", R"(<model xmlns="c"><resources><texture2d id="1" path="/l.png"/>)" +
                             groups + "</resources><build/></model>"},
             {"l.png", std::string(5'000'000, 'x')}}));
    appearances = within(kMost, [&] { return read_appearances(threemf, kMost); });
    ASSERT_TRUE(appearances) << appearances.error().text();
    EXPECT_EQ(appearances->appearances[0].picture->bytes,
              appearances->appearances[4999].picture->bytes);
}

TEST(Appearances, OfManyMaterialsAreFoundAtOnceAndCounted) {
    const testing::TempFolder folder;
    std::string library;
    for (int i = 0; i < 150'000; ++i)
        library += fmt::format("newmtl a_material_{}\nKd 1 0 0\n", i);
    folder.write("a.mtl", library);
    const fs::path obj = folder.write("a.obj", "mtllib a.mtl\n");
    const Result<Appearances> appearances =
        within(200 * kMegabyte, [&] { return read_appearances(obj, 200 * kMegabyte); });
    ASSERT_TRUE(appearances) << appearances.error().text();
    EXPECT_EQ(appearances->appearances.size(), 150'000u);
    const Result<Appearances> refused =
        within(30 * kMegabyte, [&] { return read_appearances(obj, 30 * kMegabyte); });
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().text(), HasSubstr("allow more with `--memory`"));
}

TEST(Import, NamesManyPicturesOfOneName) {
    constexpr int kPictures = 20'000;
    mesh::LoadedMesh mesh;
    mesh.mesh = testing::cube(10);
    Appearances appearances;
    for (int i = 0; i < kPictures; ++i) {
        mesh.groups.emplace_back(std::to_string(i), i);
        appearances.appearances.push_back(
            {std::to_string(i),
             {},
             Picture{"a.png", std::make_shared<const std::string>(std::to_string(i)), false},
             false});
    }
    const testing::Meter meter;
    const Result<Import> import = make_import(mesh, appearances, "a.obj", {});
    ASSERT_TRUE(import) << import.error().text();
    EXPECT_EQ(import->files[0].name, "a.png");
    EXPECT_EQ(import->files[kPictures - 1].name, fmt::format("a_{}.png", kPictures));
    EXPECT_LT(meter.seconds(), testing::kHangSeconds);
}

/// A cube of two groups, its front and the rest.
mesh::LoadedMesh two_groups() {
    mesh::LoadedMesh out;
    out.mesh = testing::cube(10);
    for (mesh::MeshAttribute& a : out.mesh.attributes) {
        if (a.name != "face") continue;
        for (int32_t& f : a.faces)
            f = f == 0 ? 0 : 1;
    }
    out.groups = {{"front \"x\"", 0}, {"rest", 1}};
    return out;
}

Appearances two_appearances() {
    Appearances appearances;
    appearances.appearances.push_back(
        {"front \"x\"", std::array<double, 3>{0.5, 0.5, 0.5},
         Picture{"a b/ü.png", std::make_shared<const std::string>("picture"), true}, false});
    appearances.appearances.push_back({"rest", std::array<double, 3>{1, 0, 0}, {}, false});
    return appearances;
}

TEST(Import, BindsPicturesByGroup) {
    const Result<Import> import = make_import(two_groups(), two_appearances(), "cube.obj", {});
    ASSERT_TRUE(import) << import.error().text();
    EXPECT_EQ(import->fablet, "textured");
    ASSERT_EQ(import->files.size(), 2u);
    EXPECT_EQ(import->files[0].name, "a_b___.png");
    EXPECT_THAT(*import->files[1].bytes, HasSubstr("const int GROUPS = 2;"));
    EXPECT_THAT(import->world, HasSubstr("\"map_of\": [0, -1]"));
    EXPECT_THAT(import->world, HasSubstr("\"tints\": [[1, 1, 1], [1, 0, 0]]"));
    EXPECT_THAT(import->world, HasSubstr("\"wrap\": \"clamp\""));
    // It shows on the white ground of pictures.
    EXPECT_THAT(import->world,
                HasSubstr("\"white\": {\"key\": \"#ffffff\", \"preview\": \"#f4f2ecff\"}"));
}

TEST(Import, GivesEveryGroupAMaterialOfItsOwn) {
    ImportOptions options;
    options.fablet = "solid";
    options.largest_mm = 25;
    Appearances appearances = two_appearances();
    appearances.appearances[0].color =
        appearances.appearances[1].color;  // the same colour, but two keys
    const Result<Import> import = make_import(two_groups(), appearances, "cube.obj", options);
    ASSERT_TRUE(import) << import.error().text();
    EXPECT_THAT(import->world, HasSubstr("\"front \\\"x\\\"\": {\"key\": \"#ff0000\""));
    EXPECT_THAT(import->world,
                HasSubstr("\"rest\": {\"key\": \"#ff0001\", \"preview\": \"#ff0000ff\""));
    EXPECT_THAT(import->world, HasSubstr("\"scale\": 2.5"));
}

TEST(Import, RefusesWhatTheMeshLacks) {
    mesh::LoadedMesh mesh = two_groups();
    ImportOptions options;
    for (const char* fablet : {"relief", "painted", "textured"}) {
        options.fablet = fablet;
        EXPECT_FALSE(make_import(mesh, {}, "cube.obj", options)) << fablet;
    }
    mesh.mesh = testing::without(mesh.mesh, "uv");
    options.fablet = "textured";
    EXPECT_THAT(make_import(mesh, two_appearances(), "cube.obj", options).error().text(),
                HasSubstr("no texture coordinates"));
    options.fablet.clear();
    EXPECT_EQ(make_import(mesh, two_appearances(), "cube.obj", options)->fablet, "solid");
}

TEST(Import, WritesWorldsOfEveryStockFabletThatLoad) {
    for (const std::string fablet : kStockFablets) {
        const testing::TempFolder folder;
        mesh::LoadedMesh mesh = two_groups();
        mesh::MeshAttribute color;
        color.name = "color";
        color.components = 3;
        color.values = {1, 0, 0};
        color.corners.resize(mesh.mesh.triangles.size());
        mesh.mesh.attributes.push_back(color);
        ImportOptions options;
        options.fablet = fablet;
        const Result<Import> import = make_import(mesh, two_appearances(), "cube.obj", options);
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
