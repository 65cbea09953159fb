// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Looks, places and pictures of glTF files, and files that are refused.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstring>

#include "base/messages.h"
#include "mesh/read/gltf.h"
#include "mesh/read/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/gltf_box.h"

namespace openfab::mesh {
namespace {

TEST(Gltf, CountWhatIsLeftOutAndSayWhere) {
    const auto source =
        parse_gltf(with(&File::scenes, R"({"nodes": [0]}, {"name": "b"}, {})").glb(), "a.glb");
    ASSERT_TRUE(source) << source.error().text();
    ASSERT_EQ(source->left_out.size(), 1u);
    EXPECT_EQ(source->left_out[0].count, 2);
    EXPECT_EQ(source->left_out[0].place, "scene `b`");
    const auto nameless =
        parse_gltf(with(&File::nodes, R"({"mesh": 0, "extras": 0})").glb(), "a.glb");
    ASSERT_TRUE(nameless) << nameless.error().text();
    EXPECT_TRUE(nameless->left_out.at(0).place.starts_with("a.glb:1:"))
        << nameless->left_out.at(0).place;
}

TEST(Gltf, LooksAreMaterialsAsPrimitivesUseThem) {
    File file;
    file.materials = R"({"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}},
        {"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 1, 1]}})";
    file.primitives = R"({"attributes": {"POSITION": 0}, "indices": 5, "material": 0},
        {"attributes": {"POSITION": 0}, "indices": 5, "material": 1},
        {"attributes": {"POSITION": 0, "COLOR_0": 4}, "indices": 5, "material": 1},
        {"attributes": {"POSITION": 0}, "indices": 5},
        {"attributes": {"POSITION": 0}, "indices": 5, "material": 0})";
    const auto source = parse_gltf(file.glb(), "a.glb");
    ASSERT_TRUE(source) << source.error().text();
    ASSERT_EQ(source->looks.size(), 3u);
    EXPECT_EQ(source->looks[0].name, "m");
    EXPECT_EQ(source->looks[1].name, "m");
    EXPECT_EQ(source->looks[1].color, (std::array<double, 3>{0, 0, 1}));
    EXPECT_TRUE(source->looks[2].vertex_colors);
    std::vector<int32_t> looks;
    for (const int32_t group : source->face_groups)
        looks.push_back(source->groups[static_cast<size_t>(group)].look);
    EXPECT_EQ(looks[0], 0);
    EXPECT_EQ(looks[12], 1);
    EXPECT_EQ(looks[24], 2);
    EXPECT_EQ(looks[36], -1);
    EXPECT_EQ(looks[48], 0);
    // One node is one body, whatever it is made of.
    EXPECT_EQ(source->bodies.size(), 1u);
}

TEST(Gltf, PrimitivesThatShareCoordinatesHaveTheirOwnTransforms) {
    File file;
    file.materials = R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions":
            {"KHR_texture_transform": {"offset": [0.5, 0]}}}}},
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})";
    file.primitives =
        R"({"attributes": {"POSITION": 0, "TEXCOORD_0": 3}, "indices": 5, "material": 0},
        {"attributes": {"POSITION": 0, "TEXCOORD_0": 3}, "indices": 5, "material": 1})";
    const auto source = parse_gltf(file.glb(), "a.glb");
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_EQ(first_value(*source, "uv", 0), (std::vector<float>{0.75f, 0.5f}));
    EXPECT_EQ(first_value(*source, "uv", 12), (std::vector<float>{0.25f, 0.5f}));
}

TEST(Gltf, CompressedMeshesAndOldFilesAreRefused) {
    const auto refused = [](const File& file) {
        const auto source = parse_gltf(file.glb(), "a.glb");
        return source ? "read" : source.error().text();
    };
    EXPECT_THAT(
        refused(with(&File::more, R"(, "extensionsRequired": ["EXT_meshopt_compression"])")),
        testing::Says(messages::kExportWithoutCompression));
    File draco = with(&File::attributes, R"("POSITION": 11)");
    draco.primitive = R"(, "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0}})";
    EXPECT_THAT(refused(draco), testing::Says(messages::kCompressedWithDraco));
    EXPECT_THAT(refused(with(&File::nodes, "{}")), testing::Says(messages::kNoNodeShowsAMesh));
    std::string old = File().glb();
    old[4] = 1;
    EXPECT_THAT(parse_gltf(old, "a.glb").error().text(), testing::Says(messages::kOldGltf, "*", 1));
    EXPECT_THAT(parse_gltf(R"({"asset": {"version": "2.1", "minVersion": "2.1"}})", "a.gltf")
                    .error()
                    .text(),
                testing::Says(messages::kNewerGltf, "*", "2.1*"));
}

// Taken as absent, a property of a wrong type would lose a colour or a body without a word.
TEST(Gltf, PropertiesOfWrongTypesAreRefused) {
    const auto error_of = [](const File& file) {
        const auto source = parse_gltf(file.glb(), "a.glb");
        return source ? "no error" : source.error().text();
    };
    EXPECT_THAT(error_of(with_material(R"("pbrMetallicRoughness": ["none"])")),
                testing::Says(messages::kWrongType, "pbrMetallicRoughness",
                              openfab::messages::kKindArray, openfab::messages::kKindObject));
    EXPECT_THAT(error_of(with_picture(R"(, "extensions": {"KHR_texture_transform": "none"})")),
                testing::Says(messages::kWrongType, "KHR_texture_transform",
                              openfab::messages::kKindString, openfab::messages::kKindObject));
    EXPECT_THAT(error_of(with_material(R"("extensions": {"KHR_materials_pbrSpecularGlossiness":
                           {"diffuseTexture": 0}})")),
                testing::Says(messages::kWrongType, "diffuseTexture",
                              openfab::messages::kKindNumber, openfab::messages::kKindObject));
    EXPECT_THAT(error_of(with_material(R"("alphaMode": 1)")),
                testing::Says(messages::kWrongType, "alphaMode", openfab::messages::kKindNumber,
                              openfab::messages::kKindString));
    EXPECT_THAT(error_of(with(&File::materials, R"("none")")),
                testing::Says(messages::kWrongType, "materials", openfab::messages::kKindString,
                              openfab::messages::kKindObject));
    EXPECT_THAT(error_of(with(&File::more, R"(, "skins": {"joints": []})")),
                testing::Says(messages::kWrongType, "skins", openfab::messages::kKindObject,
                              openfab::messages::kKindArray));
    // These names mean something else there.
    EXPECT_EQ(error_of(with(&File::more,
                            R"(, "extras": {"nodes": 1}, "extensions": {"ACME": {"name": 1}})")),
              "no error");
}

TEST(Gltf, ContainersMayHaveMoreThanTheirChunks) {
    // A byte order mark, a chunk of another kind, and something behind the end.
    const std::string plain = File().glb();
    std::string bytes = plain;
    const size_t binary = bytes.find(std::string("BIN\0", 4)) - 4;
    bytes.insert(binary, std::string("\4\0\0\0ACMEwhat", 12));
    const auto length = static_cast<uint32_t>(bytes.size());
    std::memcpy(bytes.data() + 8, &length, sizeof length);
    const auto source = parse_gltf(bytes + "more", "a.glb");
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_EQ(source->mesh.triangles.size(), 12u);
    const auto marked = parse_gltf("\xEF\xBB\xBF{\"asset\": {\"version\": \"2.0\"}}", "a.gltf");
    ASSERT_TRUE(marked) << marked.error().text();
}

TEST(Gltf, PicturesAreFetchedByTheirSources) {
    testing::TempFolder folder;
    folder.write("a b.png", "one");
    folder.write("100%.png", "two");
    std::filesystem::create_directory(folder.path() / "maps");
    folder.write("maps/c.png", "three");
    File file = with_picture();
    file.images = R"({"uri": "a%20b.png"}, {"uri": "100%.png"}, {"uri": "maps\\c.png"},
        {"uri": "data:image/png;base64,Zm91cg=="}, {"uri": "data:text/plain,fi%76e"},
        {"bufferView": 0}, {"uri": "missing.png"}, {"uri": "../up.png"}, {"name": "none"})";
    const auto glb = folder.write("a.glb", file.glb());
    const std::vector<std::string> sources = {"6", "0", "1", "2", "3", "4", "5", "7", "8", "0"};
    std::vector<std::string> found(sources.size());
    const auto read = read_gltf_pictures(
        glb, sources, 1'000'000, [&](size_t i, const Result<std::string>& bytes) {
            found.at(i) = bytes ? *bytes : "error: " + bytes.error().text();
        });
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_THAT(found[0], ::testing::HasSubstr("missing.png"));
    EXPECT_EQ(found[1], "one");
    EXPECT_EQ(found[2], "two");
    EXPECT_EQ(found[3], "three");
    EXPECT_EQ(found[4], "four");
    EXPECT_EQ(found[5], "five");
    EXPECT_EQ(found[6].size(), 96u);
    EXPECT_THAT(found[7], testing::Says(messages::kFileOutsideFolder));
    EXPECT_THAT(found[8], testing::Says(messages::kImageWithoutSource));
    EXPECT_EQ(found[9], "one");
}

}  // namespace
}  // namespace openfab::mesh
