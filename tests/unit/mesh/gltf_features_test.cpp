// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Every feature of glTF 2.0 and of its extensions: it is carried over, or it is told.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>

#include "mesh/read/gltf.h"
#include "mesh/read/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {
namespace {

using ::testing::Message;

/// Arrays of the files below, by their accessors.
enum : int {
    kPositions,
    kNormals,
    kCoordinates,
    kOtherCoordinates,
    kColours,
    kIndices,
    kMoves,
    kTurns,
    kSizes,
    kShift,
    kClearColours,
    kNoBytes,
    kShortCoordinates,
    kPale,
    kLoose,
    kJoints,
    kShares,
    kInverses,
};

/// The sections of a file with a box of 1 x 1 x 1.
struct File {
    std::string attributes = R"("POSITION": 0, "TEXCOORD_0": 2)";
    std::string primitive;   ///< more of it
    std::string primitives;  ///< all of them, if more than one
    std::string mesh;        ///< more of it
    std::string materials = R"({"name": "skin"})";
    std::string nodes = R"({"mesh": 0, "name": "box"})";
    std::string scenes = R"({"nodes": [0]})";
    std::string textures = R"({"source": 0})";
    std::string samplers = "{}";
    std::string images = R"({"uri": "a%20b.png"})";
    std::string more;  ///< of the file

    std::string glb() const;
};

std::string File::glb() const {
    std::string bytes, views, accessors;
    const auto add = [&]<typename T>(const std::vector<T>& values, const char* shape, int type,
                                     size_t components, const char* rest = "") {
        bytes.resize((bytes.size() + 3) / 4 * 4);
        const size_t view = static_cast<size_t>(std::count(views.begin(), views.end(), '{'));
        views += fmt::format(R"({}{{"buffer": 0, "byteOffset": {}, "byteLength": {}}})",
                             view > 0 ? ", " : "", bytes.size(), values.size() * sizeof(T));
        accessors += fmt::format(
            R"({}{{"bufferView": {}, "componentType": {}, "count": {}, "type": "{}"{}}})",
            view > 0 ? ", " : "", view, type, values.size() / components, shape, rest);
        for (const T& value : values)
            append(&bytes, value);
    };
    std::vector<float> positions, normals, coordinates, others, shift;
    std::vector<uint8_t> colours, clear;
    std::vector<uint16_t> shorts;
    for (int v = 0; v < 8; ++v) {
        const float x = v == 1 || v == 2 || v == 5 || v == 6 ? 1 : 0;
        const float y = v == 2 || v == 3 || v == 6 || v == 7 ? 1 : 0;
        const float z = v >= 4 ? 1 : 0;
        positions.insert(positions.end(), {x, y, z});
        normals.insert(normals.end(), {0, 1, 0});
        coordinates.insert(coordinates.end(), {x, y});
        others.insert(others.end(), {0.25f, 0.5f});
        shift.insert(shift.end(), {0, 2, 0});
        colours.insert(colours.end(), {255, 51, 0, 255});
        clear.insert(clear.end(), {255, 51, 0, 128});
        shorts.insert(shorts.end(), {static_cast<uint16_t>(x * 65535), 0});
    }
    const std::vector<uint16_t> indices = {0, 3, 2, 0, 2, 1, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                           1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
    add(positions, "VEC3", 5126, 3);
    add(normals, "VEC3", 5126, 3);
    add(coordinates, "VEC2", 5126, 2);
    add(others, "VEC2", 5126, 2);
    add(colours, "VEC4", 5121, 4, R"(, "normalized": true)");
    add(indices, "SCALAR", 5123, 1);
    add(std::vector<float>{0, 0, 0, 3, 0, 0, 6, 0, 0}, "VEC3", 5126, 3);
    add(std::vector<int16_t>{0, 0, 0, 32767, 0, 0, 32767, 0, 32767, 0, 0, 0}, "VEC4", 5122, 4,
        R"(, "normalized": true)");
    add(std::vector<float>{1, 1, 1, 2, 2, 2, 1, 1, -1}, "VEC3", 5126, 3);
    add(shift, "VEC3", 5126, 3);
    add(clear, "VEC4", 5121, 4, R"(, "normalized": true)");
    accessors += R"(, {"componentType": 5126, "count": 8, "type": "VEC3"})";
    add(shorts, "VEC2", 5123, 2, R"(, "normalized": true)");
    add(std::vector<float>(24, 0.5f), "VEC3", 5126, 3);
    add(std::vector<uint8_t>(32, 51), "VEC4", 5121, 4);
    std::vector<uint8_t> joints;
    std::vector<float> shares, inverses;
    for (int v = 0; v < 8; ++v) {
        joints.insert(joints.end(), {0, 1, 0, 0});
        shares.insert(shares.end(), {0.5f, 0.5f, 0, 0});
    }
    for (const float down : {0.0f, -1.0f})
        inverses.insert(inverses.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, down, 0, 1});
    add(joints, "VEC4", 5121, 4);
    add(shares, "VEC4", 5126, 4);
    add(inverses, "MAT4", 5126, 16);
    const std::string all =
        primitives.empty()
            ? fmt::format(R"({{"attributes": {{{}}}, "indices": 5, "material": 0{}}})", attributes,
                          primitive)
            : primitives;
    std::string json = fmt::format(
        R"({{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{}], "nodes": [{}],
 "meshes": [{{"name": "mesh", "primitives": [{}]{}}}], "materials": [{}], "textures": [{}],
 "samplers": [{}], "images": [{}], "accessors": [{}], "bufferViews": [{}],
 "buffers": [{{"byteLength": {}}}]{}}})",
        scenes, nodes, all, mesh, materials, textures, samplers, images, accessors, views,
        bytes.size(), more);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string out = "glTF";
    append(&out, uint32_t{2});
    append(&out, static_cast<uint32_t>(28 + json.size() + bytes.size()));
    append(&out, static_cast<uint32_t>(json.size()));
    out += "JSON" + json;
    append(&out, static_cast<uint32_t>(bytes.size()));
    return out + std::string("BIN\0", 4) + bytes;
}

File with(std::string File::*section, const std::string& text) {
    File file;
    file.*section = text;
    return file;
}
File with_material(const std::string& text) {
    return with(&File::materials, R"({"name": "skin", )" + text + "}");
}
/// A material of a picture at the texture 0, with more of the texture's use.
File with_picture(const std::string& use = "", const std::string& material = "") {
    return with_material(fmt::format(
        R"("pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0{}}}}}{})", use, material));
}
File with_colours(int accessor, const std::string& material) {
    File file = with_material(material);
    file.attributes = fmt::format(R"("POSITION": 0, "TEXCOORD_0": 2, "COLOR_0": {})", accessor);
    return file;
}
File and_more(File file, std::string File::*section, const std::string& text) {
    file.*section = text;
    return file;
}

using Told = std::vector<std::string>;
using Check = std::function<void(const MeshSource&)>;

/// Returns the value of an attribute at the first corner of the first triangle.
std::vector<float> first_value(const MeshSource& source, const char* name, size_t triangle = 0) {
    const MeshAttribute* a = source.mesh.find(name);
    if (a == nullptr || a->corners[triangle][0] < 0) return {};
    const auto n = static_cast<size_t>(a->components);
    const float* at = &a->values[static_cast<size_t>(a->corners[triangle][0]) * n];
    return {at, at + n};
}

const Look& look_of(const MeshSource& source, size_t triangle = 0) {
    const auto& group = source.groups[static_cast<size_t>(source.face_groups[triangle])];
    return source.looks.at(static_cast<size_t>(group.look));
}

using Rgb = std::array<double, 3>;

/// The look is of this colour, without a picture.
Check is_plain(Rgb colour, double alpha = 1) {
    return [=](const MeshSource& source) {
        const Look& look = look_of(source);
        EXPECT_EQ(look.color, std::optional(colour));
        EXPECT_EQ(look.alpha, alpha);
        EXPECT_FALSE(look.picture);
        EXPECT_FALSE(look.vertex_colors);
        EXPECT_TRUE(look.is_material);
        EXPECT_EQ(look.name, "skin");
    };
}
/// The look has this picture, tinted.
Check shows(const std::string& name, Rgb tint = {1, 1, 1}) {
    return [=](const MeshSource& source) {
        const Look& look = look_of(source);
        ASSERT_TRUE(look.picture);
        EXPECT_EQ(look.picture->name, name);
        EXPECT_EQ(look.color, std::optional(tint));
        EXPECT_TRUE(look.tinted);
    };
}
Check wraps(PictureWrap u, PictureWrap v) {
    return [=](const MeshSource& source) {
        ASSERT_TRUE(look_of(source).picture);
        EXPECT_EQ(look_of(source).picture->wrap, (std::array{u, v}));
    };
}
Check is_covered(PictureUse::Alpha alpha, double of_colour, double from = 0.5) {
    return [=](const MeshSource& source) {
        ASSERT_TRUE(look_of(source).picture);
        EXPECT_EQ(look_of(source).picture->alpha, alpha);
        EXPECT_EQ(look_of(source).alpha, of_colour);
        EXPECT_EQ(look_of(source).picture->mask_from, from);
    };
}
Check has_value(const char* attribute, std::vector<float> value) {
    return [=](const MeshSource& source) {
        const std::vector<float> found = first_value(source, attribute);
        ASSERT_EQ(found.size(), value.size()) << attribute;
        for (size_t c = 0; c < value.size(); ++c)
            EXPECT_NEAR(found[c], value[c], 1e-6) << attribute << c;
    };
}
Check are_bodies(std::vector<std::string> names) {
    return [=](const MeshSource& source) {
        std::vector<std::string> found;
        for (const Body& body : source.bodies)
            found.push_back(body.name);
        EXPECT_EQ(found, names);
        EXPECT_EQ(source.mesh.triangles.size(), names.size() * 12);
    };
}
Check all_of(std::vector<Check> checks) {
    return [=](const MeshSource& source) {
        for (const Check& check : checks)
            check(source);
    };
}

struct Feature {
    const char* name;
    File file;
    Told told;    ///< every one, in order
    Check check;  ///< of what is carried over
};

/// The same feature is told wherever a material has it.
Feature effect(const char* name, const std::string& extension, const char* told) {
    return {name, with_material(fmt::format(R"("extensions": {{"{}": {}}})", name, extension)),
            told != nullptr ? Told{told} : Told{}, is_plain({1, 1, 1})};
}

const std::string kTextured = R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 0}})";

/// A box that follows two nodes; its own, which then does not count, is far away.
File skinned(const std::string& scene) {
    File file =
        with(&File::attributes, R"("POSITION": 0, "NORMAL": 1, "JOINTS_0": 15, "WEIGHTS_0": 16)");
    file.nodes = R"({"mesh": 0, "name": "box", "skin": 0, "translation": [100, 0, 0]},
        {"children": [2]}, {"translation": [0, 3, 0]})";
    file.scenes = scene;
    file.more = R"(, "skins": [{"joints": [1, 2], "inverseBindMatrices": 17}])";
    return file;
}

std::vector<Feature> features() {
    using Alpha = PictureUse::Alpha;
    const auto factor = [](const char* rgba) {
        return fmt::format(R"("pbrMetallicRoughness": {{"baseColorFactor": {}}})", rgba);
    };
    std::vector<Feature> all = {
        // Materials.
        {"no material",
         with(&File::primitives, R"({"attributes": {"POSITION": 0}, "indices": 5})"),
         {},
         [](const MeshSource& s) { EXPECT_EQ(s.groups.at(0).look, -1); }},
        {"default material", {}, {}, is_plain({1, 1, 1})},
        {"baseColorFactor", with_material(factor("[1, 0.5, 0, 1]")), {}, is_plain({1, 0.5, 0})},
        {"doubleSided", with_material(R"("doubleSided": true)"), {}, is_plain({1, 1, 1})},
        {"two of one name",
         with(&File::materials, fmt::format(R"({{"name": "skin", {}}}, {{"name": "skin", {}}})",
                                            factor("[1, 0, 0, 1]"), factor("[0, 0, 1, 1]"))),
         {},
         is_plain({1, 0, 0})},
        {"alpha of OPAQUE", with_material(factor("[1, 1, 1, 0.5]")), {}, is_plain({1, 1, 1})},
        {"alpha of BLEND",
         with_material(R"("alphaMode": "BLEND", )" + factor("[1, 1, 1, 0.5]")),
         {},
         is_plain({1, 1, 1}, 0.5)},
        {"alpha of MASK",
         with_material(R"("alphaMode": "MASK", )" + factor("[1, 1, 1, 0.4]")),
         {},
         is_plain({1, 1, 1}, 0)},
        {"alphaCutoff",
         with_material(R"("alphaMode": "MASK", "alphaCutoff": 0.3, )" + factor("[1, 1, 1, 0.4]")),
         {},
         is_plain({1, 1, 1}, 1)},
        {"emissive beside a colour",
         with_material(R"("emissiveFactor": [1, 1, 0], )" + factor("[0.5, 0, 0, 1]")),
         {messages::kLightEmitted},
         is_plain({0.5, 0, 0})},
        {"emissive alone",
         with_material(R"("emissiveFactor": [0.5, 0.5, 0], "extensions":
             {"KHR_materials_emissive_strength": {"emissiveStrength": 1.5}})"),
         {},
         is_plain({0.75, 0.75, 0})},
        {"emissive picture on black",
         with_material(R"("emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}, )" +
                       factor("[0, 0, 0, 1]")),
         {},
         shows("a b.png")},
        {"metal and roughness",
         with_material(R"("pbrMetallicRoughness": {"metallicFactor": 0.5, "roughnessFactor": 0.5,
             "metallicRoughnessTexture": {"index": 0}})"),
         {messages::kMapMetalRoughness},
         is_plain({1, 1, 1})},
        {"normalTexture",
         with_material(R"("normalTexture": {"index": 0})"),
         {messages::kNormalMapMaterial},
         is_plain({1, 1, 1})},
        {"occlusionTexture",
         with_material(R"("occlusionTexture": {"index": 0})"),
         {messages::kOcclusionMapMaterial},
         is_plain({1, 1, 1})},
        effect("KHR_materials_unlit", "{}", nullptr),
        effect("KHR_materials_transmission", R"({"transmissionFactor": 1})",
               messages::kTransmissionMaterial),
        effect("KHR_materials_diffuse_transmission", R"({"diffuseTransmissionFactor": 1})",
               messages::kDiffuseTransmissionMaterial),
        effect("KHR_materials_volume", R"({"thicknessFactor": 1})", messages::kAbsorptionMaterial),
        effect("KHR_materials_volume_scatter", R"({"multiscatterColor": [1, 1, 1]})",
               messages::kScatteringMaterial),
        effect("KHR_materials_ior", R"({"ior": 1.8})", messages::kRefractionMaterial),
        effect("KHR_materials_ior", R"({"ior": 1.5})", nullptr),
        effect("KHR_materials_dispersion", R"({"dispersion": 1})", messages::kDispersionMaterial),
        effect("KHR_materials_clearcoat", R"({"clearcoatTexture": {"index": 0}})",
               messages::kClearCoatMaterial),
        effect("KHR_materials_clearcoat", R"({"clearcoatFactor": 0})", nullptr),
        effect("KHR_materials_sheen", R"({"sheenColorFactor": [0, 1, 0]})",
               messages::kSheenMaterial),
        effect("KHR_materials_specular", R"({"specularColorFactor": [1, 0, 1]})",
               messages::kSpecularColourMaterial),
        effect("KHR_materials_iridescence", R"({"iridescenceFactor": 1})",
               messages::kIridescenceMaterial),
        effect("KHR_materials_anisotropy", R"({"anisotropyStrength": 1})",
               messages::kAnisotropyMaterial),
        {"KHR_materials_pbrSpecularGlossiness",
         with_material(R"("extensions": {"KHR_materials_pbrSpecularGlossiness":
             {"diffuseFactor": [1, 0.2, 0, 1]}})"),
         {},
         is_plain({1, 0.2, 0})},
        {"its picture",
         with_material(R"("extensions": {"KHR_materials_pbrSpecularGlossiness":
             {"diffuseTexture": {"index": 0}, "specularGlossinessTexture": {"index": 0}}})"),
         {messages::kMapSpecularGlossiness},
         shows("a b.png")},
        {"its metal",
         with_material(R"("extensions": {"KHR_materials_pbrSpecularGlossiness":
             {"diffuseFactor": [0, 0, 0, 1], "specularFactor": [1, 0.5, 0]}})"),
         {},
         is_plain({1, 0.5, 0})},
        {"KHR_materials_variants",
         with(&File::more, R"(, "extensionsUsed": ["KHR_materials_variants"],
             "extensions": {"KHR_materials_variants": {"variants": [{"name": "a"}, {"name": "b"}]}})"),
         {messages::kVariantOfMaterials},
         is_plain({1, 1, 1})},

        // Pictures.
        {"baseColorTexture", with_picture(), {}, shows("a b.png")},
        {"tint",
         with_material(R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 0},
             "baseColorFactor": [1, 0.5, 0, 1]})"),
         {},
         shows("a b.png", {1, 0.5, 0})},
        {"OPAQUE picture", with_picture(), {}, is_covered(Alpha::kOpaque, 1)},
        {"BLEND picture",
         with_picture("", R"(, "alphaMode": "BLEND")"),
         {},
         is_covered(Alpha::kBlend, 1)},
        {"MASK picture",
         with_material(R"("alphaMode": "MASK", "alphaCutoff": 0.4, "pbrMetallicRoughness":
             {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, 0.5]})"),
         {},
         is_covered(Alpha::kMask, 1, 0.8)},
        {"wrap by default", with_picture(), {}, wraps(PictureWrap::kRepeat, PictureWrap::kRepeat)},
        {"wrap by axis",
         and_more(and_more(with_picture(), &File::samplers, R"({"wrapS": 33648, "wrapT": 33071})"),
                  &File::textures, R"({"source": 0, "sampler": 0})"),
         {},
         wraps(PictureWrap::kMirror, PictureWrap::kClamp)},
        {"nearest",
         and_more(and_more(with_picture(), &File::samplers, R"({"magFilter": 9728})"),
                  &File::textures, R"({"source": 0, "sampler": 0})"),
         {},
         [](const MeshSource& s) {
             shows("a b.png")(s);
             EXPECT_TRUE(look_of(s).picture->nearest);
         }},
        {"picture of a data URI",
         and_more(with_picture(), &File::images,
                  R"({"name": "x/wood", "uri": "data:image/jpeg;base64,iVBORw0KGgo="})"),
         {},
         shows("wood.png")},
        {"picture of a buffer view",
         and_more(with_picture(), &File::images, R"({"bufferView": 0, "mimeType": "image/jpeg"})"),
         {},
         shows("picture_0.jpg")},
        {"EXT_texture_webp",
         and_more(with_picture(), &File::textures,
                  R"({"extensions": {"EXT_texture_webp": {"source": 0}}})"),
         {},
         shows("a b.png")},
        {"KHR_texture_basisu",
         and_more(with_picture(), &File::textures,
                  R"({"extensions": {"KHR_texture_basisu": {"source": 0}}})"),
         {messages::kPictureInKtx2},
         is_plain({1, 1, 1})},
        {"KHR_texture_basisu beside PNG",
         and_more(with_picture(), &File::textures,
                  R"({"source": 0, "extensions": {"KHR_texture_basisu": {"source": 9}}})"),
         {},
         shows("a b.png")},
        {"texture without a source",
         and_more(with_picture(), &File::textures, "{}"),
         {messages::kTextureWithoutPicture},
         is_plain({1, 1, 1})},
        {"no coordinates",
         and_more(with_picture(), &File::attributes, R"("POSITION": 0)"),
         {messages::kPictureWithoutCoordinates},
         is_plain({1, 1, 1})},

        // Attributes. The first corner is at (0, 0, 0), with the coordinates 0, 0.
        {"TEXCOORD_0", with_picture(), {}, has_value("uv", {0, 1})},
        {"NORMAL",
         with(&File::attributes, R"("POSITION": 0, "NORMAL": 1)"),
         {},
         has_value("n", {0, 0, 1})},
        {"texCoord",
         and_more(with_picture(R"(, "texCoord": 1)"), &File::attributes,
                  R"("POSITION": 0, "TEXCOORD_0": 2, "TEXCOORD_1": 3)"),
         {},
         all_of({has_value("uv", {0.25, 0.5}), has_value("uv1", {0.25, 0.5}),
                 has_value("uv0", {0, 1})})},
        {"texCoord that is not there",
         with_picture(R"(, "texCoord": 1)"),
         {messages::kPictureWithoutCoordinates},
         has_value("uv", {0, 1})},
        {"KHR_texture_transform",
         and_more(with_picture(R"(, "texCoord": 3, "extensions": {"KHR_texture_transform":
             {"offset": [0.5, 0.25], "scale": [2, 0.5], "texCoord": 1}})"),
                  &File::attributes, R"("POSITION": 0, "TEXCOORD_1": 3)"),
         {},
         all_of({has_value("uv", {1, 0.5}), has_value("uv1", {0.25, 0.5})})},
        // A quarter turn of the axes: u' = v, v' = -u.
        {"its rotation",
         and_more(with_picture(R"(, "extensions": {"KHR_texture_transform": {"offset": [0, 1],
             "rotation": 1.5707963267948966, "scale": [0.5, 0.25]}})"),
                  &File::attributes, R"("POSITION": 0, "TEXCOORD_0": 3)"),
         {},
         has_value("uv", {0.125, 0.125})},
        {"normalised coordinates",
         and_more(with_picture(), &File::attributes, R"("POSITION": 0, "TEXCOORD_0": 12)"),
         {},
         has_value("uv", {0, 1})},
        {"COLOR_0 alone",
         with(&File::primitives, R"({"attributes": {"POSITION": 0, "COLOR_0": 4}, "indices": 5})"),
         {},
         [](const MeshSource& s) {
             has_value("color", {1, 0.2f, 0})(s);
             EXPECT_TRUE(look_of(s).vertex_colors);
             EXPECT_EQ(look_of(s).color, std::optional(Rgb{1, 1, 1}));
         }},
        {"COLOR_0 x factor x picture",
         with_colours(kColours, R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 0},
             "baseColorFactor": [1, 0.5, 0, 1]})"),
         {},
         [](const MeshSource& s) {
             EXPECT_TRUE(look_of(s).vertex_colors);
             shows("a b.png", {1, 0.5, 0})(s);
         }},
        {"COLOR_0 of three",
         with_colours(kPale, R"("alphaMode": "BLEND")"),
         {},
         has_value("color", {0.5, 0.5, 0.5})},
        {"COLOR_0 that is not said to be normalised",
         with_colours(kLoose, kTextured),
         {},
         has_value("color", {0.2f, 0.2f, 0.2f})},
        {"alpha of COLOR_0, opaque",
         with_colours(kClearColours, kTextured),
         {},
         has_value("color", {1, 0.2f, 0})},
        {"alpha of COLOR_0",
         with_colours(kClearColours, R"("alphaMode": "BLEND")"),
         {messages::kVertexTransparency},
         has_value("color", {1, 0.2f, 0})},
        {"COLOR_1",
         with(&File::attributes, R"("POSITION": 0, "COLOR_1": 4, "TANGENT": 4, "WEIGHTS_0": 4)"),
         {fmt::format(messages::kOwnAttribute, "COLOR_1")},
         is_plain({1, 1, 1})},
        {"one's own",
         with(&File::attributes, R"("POSITION": 0, "_Heat": 2)"),
         {},
         has_value("heat", {0, 0})},
        {"two that differ by case",
         with(&File::attributes, R"("POSITION": 0, "_Heat": 2, "_HEAT": 3)"),
         {fmt::format(messages::kOwnAttribute, "_HEAT")},
         has_value("heat", {0, 0})},
        {"one's own of the name of ours",
         with(&File::attributes, R"("POSITION": 0, "TEXCOORD_0": 2, "_UV": 3, "_N": 1)"),
         {fmt::format(messages::kOwnAttribute, "_UV")},
         has_value("uv", {0, 1})},

        // Primitives.
        {"points and lines",
         with(
             &File::primitives,
             R"({"attributes": {"POSITION": 0}, "mode": 0}, {"attributes": {"POSITION": 0}, "mode": 3},
                 {"attributes": {"POSITION": 0}, "indices": 5})"),
         {messages::kPointsOfMesh, messages::kLinesOfMesh},
         are_bodies({"box"})},
        {"morph targets at rest",
         with(&File::primitive, R"(, "targets": [{"POSITION": 9}])"),
         {messages::kMorphTargets},
         are_bodies({"box"})},
        {"weights of the mesh",
         and_more(with(&File::primitive, R"(, "targets": [{"POSITION": 9}])"), &File::mesh,
                  R"(, "weights": [0.5])"),
         {messages::kMorphTargets},
         [](const MeshSource& s) {
             EXPECT_EQ(s.mesh.positions.at(0), (Vec3d{0, 0, 1}));
         }},
        {"weights of the node",
         and_more(with(&File::primitive, R"(, "targets": [{"POSITION": 9}])"), &File::nodes,
                  R"({"mesh": 0, "weights": [1]})"),
         {messages::kMorphTargets},
         [](const MeshSource& s) {
             EXPECT_EQ(s.mesh.positions.at(0), (Vec3d{0, 0, 2}));
         }},
        {"KHR_draco_mesh_compression beside the mesh",
         and_more(with(&File::primitive,
                       R"(, "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0}})"),
                  &File::more, R"(, "extensionsUsed": ["KHR_draco_mesh_compression"])"),
         {},
         are_bodies({"box"})},

        // Nodes.
        {"bodies",
         and_more(with(&File::nodes, R"({"mesh": 0}, {"mesh": 0, "name": "b", "children": [2],
             "translation": [3, 0, 0]}, {"mesh": 0, "name": "b", "translation": [3, 0, 0]})"),
                  &File::scenes, R"({"nodes": [0, 1]})"),
         {},
         [](const MeshSource& s) {
             are_bodies({"mesh", "b", "b"})(s);
             EXPECT_EQ(s.bodies.at(0).assembly, 0);
             EXPECT_EQ(s.bodies.at(1).assembly, 1);
             EXPECT_EQ(s.bodies.at(2).assembly, 1);
             EXPECT_EQ(s.groups.at(2).body, 2);
         }},
        {"EXT_mesh_gpu_instancing",
         with(&File::nodes, R"({"mesh": 0, "name": "box", "extensions": {"EXT_mesh_gpu_instancing":
             {"attributes": {"TRANSLATION": 6, "ROTATION": 7, "SCALE": 8, "_ID": 0}}}})"),
         {fmt::format(messages::kAttributeOfInstances, "_ID")},
         [](const MeshSource& s) {
             are_bodies({"box", "box", "box"})(s);
             Box3d boxes[3];
             for (size_t v = 0; v < s.mesh.positions.size(); ++v)
                 boxes[v / 8].add(s.mesh.positions[v]);
             // Half a turn about glTF's z, which is -y here, at twice the size.
             EXPECT_NEAR(length(boxes[1].lo - Vec3d{1, -2, -2}), 0, 1e-9);
             EXPECT_NEAR(length(boxes[1].hi - Vec3d{3, 0, 0}), 0, 1e-9);
             EXPECT_NEAR(testing::signed_volume(s.mesh), 1 + 8 + 1, 1e-9);
         }},
        {"a mirrored node",
         with(&File::nodes, R"({"mesh": 0, "name": "box", "scale": [-1, 1, 1]})"),
         {},
         [](const MeshSource& s) { EXPECT_NEAR(testing::signed_volume(s.mesh), 1, 1e-9); }},
        {"a node of no size",
         and_more(
             with(&File::nodes, R"({"mesh": 0, "name": "box"}, {"mesh": 0, "scale": [0, 1, 1]})"),
             &File::scenes, R"({"nodes": [0, 1]})"),
         {messages::kMeshScaledToNothing},
         are_bodies({"box"})},
        {"KHR_node_visibility",
         and_more(with(&File::nodes, R"({"mesh": 0, "name": "box"}, {"children": [2], "extensions":
             {"KHR_node_visibility": {"visible": false}}}, {"mesh": 0})"),
                  &File::scenes, R"({"nodes": [0, 1]})"),
         {messages::kHiddenNode},
         are_bodies({"box"})},
        // One joint stays, the other goes up by two: half of each.
        {"skin",
         skinned(R"({"nodes": [0, 1]})"),
         {},
         [](const MeshSource& s) {
             are_bodies({"box"})(s);
             EXPECT_EQ(s.mesh.positions.at(0), (Vec3d{0, 0, 1}));
             has_value("n", {0, 0, 1})(s);
         }},
        {"a skin without its skeleton",
         skinned(R"({"nodes": [0]})"),
         {messages::kSkeletonNotInScene},
         [](const MeshSource& s) {
             EXPECT_EQ(s.mesh.positions.at(0), (Vec3d{100, 0, 0}));
         }},
        {"joints without a skin",
         with(&File::attributes, R"("POSITION": 0, "JOINTS_0": 15, "WEIGHTS_0": 16)"),
         {},
         are_bodies({"box"})},
        {"MSFT_lod",
         with(&File::nodes, R"({"mesh": 0, "name": "box", "extensions": {"MSFT_lod": {"ids": [1]}}},
             {"mesh": 0})"),
         {messages::kCoarserForms},
         are_bodies({"box"})},

        // The file.
        {"other scenes",
         with(&File::scenes, R"({"nodes": [0]}, {"name": "b"}, {})"),
         {messages::kOtherScene},
         are_bodies({"box"})},
        {"a mesh that is nowhere",
         with(&File::mesh, R"(}, {"name": "spare", "primitives": [])"),
         {messages::kMeshNotPlaced},
         are_bodies({"box"})},
        {"cameras, lights, animations",
         with(&File::more, R"(, "cameras": [{}], "animations": [{"name": "walk"}],
             "extensionsUsed": ["KHR_lights_punctual", "KHR_xmp_json_ld"],
             "extensions": {"KHR_lights_punctual": {"lights": [{}]}, "KHR_xmp_json_ld": {}})"),
         {"a camera", "a light", messages::kAnimation},
         are_bodies({"box"})},
        {"extras",
         with(&File::mesh, R"(, "extras": {"a": 1})"),
         {messages::kExtras},
         are_bodies({"box"})},
        {"an unknown extension",
         with(&File::more, R"(, "extensionsUsed": ["ACME_holes"])"),
         {fmt::format(messages::kExtensionOfGltf, "ACME_holes")},
         are_bodies({"box"})},
        {"required ones that are read",
         with(&File::more, R"(, "extensionsRequired": ["KHR_mesh_quantization",
             "KHR_texture_transform", "EXT_mesh_gpu_instancing", "EXT_texture_webp",
             "KHR_materials_unlit"])"),
         {},
         are_bodies({"box"})},
    };
    return all;
}

TEST(GltfFeatures, AreCarriedOverOrTold) {
    for (const Feature& feature : features()) {
        SCOPED_TRACE(Message() << feature.name);
        const Result<MeshSource> source = parse_gltf(feature.file.glb(), "a.glb");
        ASSERT_TRUE(source) << source.error().text();
        Told told;
        for (const LeftOut& left_out : source->left_out) {
            told.push_back(left_out.what);
            EXPECT_FALSE(left_out.place.empty());
            EXPECT_FALSE(left_out.remedy.empty());
            EXPECT_GT(left_out.count, 0);
        }
        EXPECT_EQ(told, feature.told);
        EXPECT_TRUE(source->warnings.empty());
        for (const FaceGroup& group : source->groups)
            EXPECT_LT(static_cast<size_t>(group.body), source->bodies.size());
        feature.check(*source);
    }
}

TEST(GltfFeatures, CountWhatIsLeftOutAndSayWhere) {
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

TEST(GltfFeatures, LooksAreMaterialsAsPrimitivesUseThem) {
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

TEST(GltfFeatures, PrimitivesThatShareCoordinatesHaveTheirOwnTransforms) {
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

TEST(GltfFeatures, CompressedMeshesAndOldFilesAreRefused) {
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
TEST(GltfFeatures, PropertiesOfWrongTypesAreRefused) {
    const auto error_of = [](const File& file) {
        const auto source = parse_gltf(file.glb(), "a.glb");
        return source ? "no error" : source.error().text();
    };
    EXPECT_THAT(
        error_of(with_material(R"("pbrMetallicRoughness": ["none"])")),
        testing::Says(messages::kWrongType, "pbrMetallicRoughness", "an array", "an object*"));
    EXPECT_THAT(
        error_of(with_picture(R"(, "extensions": {"KHR_texture_transform": "none"})")),
        testing::Says(messages::kWrongType, "KHR_texture_transform", "a string", "an object*"));
    EXPECT_THAT(error_of(with_material(R"("extensions": {"KHR_materials_pbrSpecularGlossiness":
                           {"diffuseTexture": 0}})")),
                testing::Says(messages::kWrongType, "diffuseTexture", "a number", "an object*"));
    EXPECT_THAT(error_of(with_material(R"("alphaMode": 1)")),
                testing::Says(messages::kWrongType, "alphaMode", "a number", "a string*"));
    EXPECT_THAT(error_of(with(&File::materials, R"("none")")),
                testing::Says(messages::kWrongType, "materials", "a string", "an object*"));
    EXPECT_THAT(error_of(with(&File::more, R"(, "skins": {"joints": []})")),
                testing::Says(messages::kWrongType, "skins", "an object", "an array*"));
    // These names mean something else there.
    EXPECT_EQ(error_of(with(&File::more,
                            R"(, "extras": {"nodes": 1}, "extensions": {"ACME": {"name": 1}})")),
              "no error");
}

TEST(GltfFeatures, ContainersMayHaveMoreThanTheirChunks) {
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

TEST(GltfFeatures, PicturesAreFetchedByTheirSources) {
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
