// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sys/stat.h>

#include "base/messages.h"
#include "mesh/model/messages.h"
#include "mesh/read/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {
namespace {

/// A buffer and the views and accessors into it.
struct Buffer {
    std::string bytes;
    std::string views;
    std::string accessors;
    int count = 0;

    template <typename T>
    int add(const std::vector<T>& values, const char* type, int component_type, size_t components,
            const char* more = "") {
        bytes.resize((bytes.size() + 3) / 4 * 4);
        views += fmt::format(R"({}{{"buffer": 0, "byteOffset": {}, "byteLength": {}}})",
                             count > 0 ? ", " : "", bytes.size(), values.size() * sizeof(T));
        accessors += fmt::format(
            R"({}{{"bufferView": {}, "componentType": {}, "count": {}, "type": "{}"{}}})",
            count > 0 ? ",\n    " : "", count, component_type, values.size() / components, type,
            more);
        for (const T& value : values)
            append(&bytes, value);
        return count++;
    }
};

/// A box of 1 x 2 x 3 in glTF's axes, with everything a primitive can have.
Buffer box_buffer() {
    Buffer b;
    std::vector<float> positions, normals, uvs, heat;
    std::vector<uint8_t> colors;
    for (int v = 0; v < 8; ++v) {
        const float x = v == 1 || v == 2 || v == 5 || v == 6 ? 1 : 0;
        const float y = v == 2 || v == 3 || v == 6 || v == 7 ? 2 : 0;
        const float z = v >= 4 ? 3 : 0;
        positions.insert(positions.end(), {x, y, z});
        normals.insert(normals.end(), {0, 1, 0});
        uvs.insert(uvs.end(), {x, y / 8});
        heat.push_back(static_cast<float>(v) * 10);
        colors.insert(colors.end(), {255, static_cast<uint8_t>(v), 0, 128});
    }
    std::vector<uint16_t> indices;
    const uint16_t faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                  {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    for (const auto& f : faces)
        indices.insert(indices.end(), {f[0], f[1], f[2], f[0], f[2], f[3]});
    b.add(positions, "VEC3", 5126, 3);
    b.add(normals, "VEC3", 5126, 3);
    b.add(uvs, "VEC2", 5126, 2);
    b.add(colors, "VEC4", 5121, 4, R"(, "normalized": true)");
    b.add(heat, "SCALAR", 5126, 1);
    b.add(indices, "SCALAR", 5123, 1);
    return b;
}

constexpr const char* kNodes = R"("scenes": [{"nodes": [0]}],
  "nodes": [{"children": [1, 2], "scale": [0.01, 0.01, 0.01]},
            {"mesh": 0, "name": "left"},
            {"mesh": 0, "name": "right", "matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 5,0,0,1]}])";

std::string gltf_json(const Buffer& b, const std::string& buffer,
                      const std::string& nodes = kNodes) {
    return fmt::format(R"({{"asset": {{"version": "2.0"}}, {},
  "materials": [{{"name": "skin"}}],
  "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3,
    "_HEAT": 4}}, "indices": 5, "material": 0}}]}}],
  "accessors": [{}],
  "bufferViews": [{}],
  "buffers": [{}]}})",
                       nodes, b.accessors, b.views, buffer);
}

std::string box_glb(const std::string& nodes = kNodes) {
    const Buffer b = box_buffer();
    return glb(gltf_json(b, fmt::format(R"({{"byteLength": {}}})", b.bytes.size()), nodes),
               b.bytes);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// Text of the same length, so that chunks keep their offsets.
std::string swapped(const std::string& glb, const std::string& from, std::string to) {
    to.resize(from.size(), ' ');
    return replaced(glb, from, to);
}

TEST(Gltf, PlacesNodesInMillimetresWithZUp) {
    const Result<LoadedMesh> loaded = parse_bytes(box_glb(), "a.glb");
    ASSERT_TRUE(loaded) << loaded.error().text();
    const Mesh& mesh = loaded->mesh;
    EXPECT_EQ(loaded->unit_mm, 1000);
    EXPECT_EQ(loaded->unit_note, messages::kUnitOfFile);
    EXPECT_TRUE(loaded->warnings.empty());
    EXPECT_EQ(mesh.triangles.size(), 24u);
    EXPECT_EQ(mesh.positions.size(), 16u);
    // The second is mirrored, so that its triangles must have been flipped.
    EXPECT_NEAR(testing::signed_volume(mesh), 2 * 10 * 20 * 30, 1e-6);
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    const Vec3d far = box.hi - Vec3d{50, 0, 20};
    EXPECT_NEAR(length(far), 0, 1e-12) << box.hi.x << " " << box.hi.y << " " << box.hi.z;
    EXPECT_NEAR(length(box.lo - Vec3d{0, -30, 0}), 0, 1e-12);
    const auto value = [&](const char* name, size_t triangle, size_t corner, size_t component) {
        const MeshAttribute& a = *mesh.find(name);
        return a
            .values[static_cast<size_t>(a.corners[triangle][corner] * a.components) + component];
    };
    // Triangle 0 is 0 3 2; 12 is the same in the mirrored one, flipped to 0 2 3.
    EXPECT_EQ(value("heat", 0, 1, 0), 30);
    EXPECT_EQ(value("heat", 12, 1, 0), 20);
    EXPECT_EQ(value("uv", 0, 1, 1), 0.75f);
    EXPECT_EQ(value("color", 0, 1, 0), 1);
    EXPECT_EQ(value("color", 0, 1, 1), 3.0f / 255);
    for (size_t t : {0, 12}) {
        EXPECT_EQ(value("n", t, 0, 1), 0);
        EXPECT_EQ(value("n", t, 0, 2), 1);
    }
    EXPECT_EQ(loaded->groups, (std::vector<std::pair<std::string, int32_t>>{{"skin", 0}}));
    MeshOptions options;
    options.groups = {{"left", 4}, {"right", 5}};
    const Result<LoadedMesh> mapped = parse_bytes(box_glb(), "a.glb", options);
    ASSERT_TRUE(mapped) << mapped.error().text();
    EXPECT_EQ(mapped->mesh.find("face")->faces[11], 4);
    EXPECT_EQ(mapped->mesh.find("face")->faces[12], 5);
}

TEST(Gltf, AppliesRotationsBeforeTranslations) {
    // Quarter turn about glTF's y: x -> -z; then in z up: -z -> y.
    const Result<LoadedMesh> loaded = parse_bytes(
        box_glb(R"("nodes": [{"mesh": 0, "rotation": [0, 0.7071067811865476, 0, 0.7071067811865476],
            "scale": [0.01, 0.02, 0.03], "translation": [0, 1, 0]}])"),
        "a.glb");
    ASSERT_TRUE(loaded) << loaded.error().text();
    Box3d box;
    for (const Vec3d& p : loaded->mesh.positions)
        box.add(p);
    EXPECT_NEAR(length(box.lo - Vec3d{0, 0, 1000}), 0, 1e-9);
    EXPECT_NEAR(length(box.hi - Vec3d{90, 10, 1040}), 0, 1e-9);
}

TEST(Gltf, ReadsTextWithBuffersBesideItOrInIt) {
    testing::TempFolder folder;
    const Buffer b = box_buffer();
    folder.write("my box.bin", b.bytes);
    const auto file = folder.write(
        "a.gltf", gltf_json(b, fmt::format(R"({{"uri": "my%20box.bin", "byteLength": {}}})",
                                           b.bytes.size())));
    const Result<LoadedMesh> loaded = load_mesh(file, {});
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_NEAR(testing::signed_volume(loaded->mesh), 12000, 1e-6);
    EXPECT_EQ(loaded->files, (std::vector<std::filesystem::path>{folder.path() / "my box.bin"}));
    for (const char* uri : {"../b.bin", "/etc/passwd", "http://x/b.bin", "none.bin"}) {
        const auto bad =
            folder.write("b.gltf", gltf_json(b, fmt::format(R"({{"uri": "{}"}})", uri)));
        EXPECT_FALSE(load_mesh(bad, {})) << uri;
    }
    // Nor does a link lead out of the folder, nor does a pipe block.
    testing::TempFolder elsewhere;
    std::filesystem::create_symlink(elsewhere.write("b.bin", b.bytes), folder.path() / "link.bin");
    ASSERT_EQ(::mkfifo((folder.path() / "pipe.bin").c_str(), 0600), 0);
    for (const auto& [uri, why] :
         {std::pair{"link.bin", std::string(openfab::messages::kNotBelow)},
          std::pair{"pipe.bin",
                    fmt::format(openfab::messages::kKindNotAFile, openfab::messages::kKindPipe)}}) {
        const std::string buffer =
            fmt::format(R"({{"uri": "{}", "byteLength": {}}})", uri, b.bytes.size());
        const auto led = load_mesh(folder.write("b.gltf", gltf_json(b, buffer)), {});
        ASSERT_FALSE(led);
        EXPECT_THAT(led.error().text(), testing::Says(why));
    }
    // A triangle as base64: three positions of 12 bytes.
    const std::string flat = R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
    EXPECT_NE(parse_error(flat, "a.gltf").find("3 open edges"), std::string::npos)
        << parse_error(flat, "a.gltf");
}

TEST(Gltf, ReadsStripsFansAndSparseAccessors) {
    // A tetrahedron: a strip of all four faces over 0 1 2 3 0 1.
    Buffer b;
    b.add(std::vector<float>{0, 0, 0, 0, 1, 0, 1, 0, 0, 9, 9, 9}, "VEC3", 5126, 3,
          R"(, "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121},
             "values": {"bufferView": 2}})");
    b.add(std::vector<uint8_t>{3}, "SCALAR", 5121, 1);
    b.add(std::vector<float>{0, 0, 1}, "VEC3", 5126, 3);
    b.add(std::vector<uint8_t>{0, 1, 2, 3, 0, 1}, "SCALAR", 5121, 1);
    b.add(std::vector<uint32_t>{0, 1, 2, 3, 1}, "SCALAR", 5125, 1);
    b.add(std::vector<uint32_t>{1, 3, 2}, "SCALAR", 5125, 1);
    const auto json = [&](const char* primitives) {
        return fmt::format(R"({{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}],
  "meshes": [{{"primitives": [{}]}}], "accessors": [{}], "bufferViews": [{}], "buffers": [{{"byteLength": {}}}]}})",
                           primitives, b.accessors, b.views, b.bytes.size());
    };
    for (const char* primitives : {R"({"attributes": {"POSITION": 0}, "indices": 3, "mode": 5})",
                                   R"({"attributes": {"POSITION": 0}, "indices": 4, "mode": 6},
             {"attributes": {"POSITION": 0}, "indices": 5},
             {"attributes": {"POSITION": 0}, "mode": 0})"}) {
        const Result<LoadedMesh> loaded = parse_bytes(glb(json(primitives), b.bytes), "a.glb");
        ASSERT_TRUE(loaded) << loaded.error().text();
        EXPECT_EQ(loaded->mesh.triangles.size(), 4u);
        EXPECT_NEAR(testing::signed_volume(loaded->mesh), 1e9 / 6, 1);
    }
}

TEST(Gltf, NamesWhatIsWrong) {
    const std::string good = box_glb();
    EXPECT_EQ(parse_error(good.substr(0, good.size() - 8), "a.glb"),
              fmt::format(messages::kCutShortInChunk, "a.glb"));
    EXPECT_NE(parse_error(swapped(good, "\"2.0\"", "\"1.0\""), "a.glb").find("version 1.0"),
              std::string::npos);
    EXPECT_THAT(parse_error(swapped(good, "\"indices\": 5", "\"indices\": 9"), "a.glb"),
                testing::Says(messages::kRefersToNone, "*a mesh", "accessors", 9, "6*"));
    EXPECT_THAT(parse_error(swapped(good, "\"indices\": 5", "\"indices\": 4"), "a.glb"),
                testing::Says(messages::kIndicesScalar));
    EXPECT_THAT(parse_error(swapped(good, "\"count\": 36", "\"count\": 37"), "a.glb"),
                testing::Says(messages::kAccessorTooShort, 37, 2, "36*"));
    EXPECT_THAT(parse_error(swapped(good, "\"children\": [1, 2]", "\"children\": [1, 1]"), "a.glb"),
                testing::Says(messages::kNodeTwoParents, 1));
    EXPECT_THAT(parse_error(swapped(good, "\"children\": [1, 2]", "\"children\": [1, 0]"), "a.glb"),
                testing::Says(messages::kNodeTwoParents, 0));
    const std::string draco =
        box_glb(std::string(kNodes) + R"(, "extensionsRequired": ["KHR_draco_mesh_compression"])");
    EXPECT_THAT(parse_error(draco, "a.glb"),
                testing::Says(messages::kRequiresExtension, "KHR_draco_mesh_compression"));
}

TEST(Gltf, SurvivesDamage) {
    survive_damage(box_glb(), "a.glb", 600);
    const std::string good = box_glb();
    // Damage to the JSON alone, which is most of what can go wrong.
    const size_t json = good.find("BIN") - 24;
    std::mt19937 random(3);
    for (int i = 0; i < 400; ++i) {
        std::string damaged = good;
        for (int k = 0; k < 3; ++k)
            damaged[20 + random() % json] = "0123456789-,:[]{}\" .e"[random() % 21];
        (void)parse_error(damaged, "a.glb");
    }
}

}  // namespace
}  // namespace openfab::mesh
