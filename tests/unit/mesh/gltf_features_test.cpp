// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Every feature of glTF 2.0 and of its extensions: it is carried over, or it is told.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "mesh/read/gltf.h"
#include "mesh/read/messages.h"
#include "tests/unit/mesh/gltf_box.h"

namespace openfab::mesh {
namespace {

using ::testing::Message;

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
         {fmt::format(messages::kMoreColours, "COLOR_1")},
         is_plain({1, 1, 1})},
        {"COLOR_1 beside colours",
         with(&File::attributes, R"("POSITION": 0, "COLOR_0": 13, "COLOR_1": 4)"),
         {fmt::format(messages::kMoreColours, "COLOR_1")},
         has_value("color", {0.5, 0.5, 0.5})},
        {"COLOR_1 beside white, as Blender writes paint that a material does not use",
         with(&File::attributes, R"("POSITION": 0, "COLOR_1": 4, "COLOR_0": 18, "COLOR_2": 13)"),
         {messages::kWhiteColours, fmt::format(messages::kMoreColours, "COLOR_2")},
         has_value("color", {1, 0.2f, 0})},
        {"COLOR_1 and COLOR_0 white",
         with(&File::attributes, R"("POSITION": 0, "COLOR_0": 18, "COLOR_1": 18)"),
         {fmt::format(messages::kMoreColours, "COLOR_1")},
         has_value("color", {1, 1, 1})},
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

}  // namespace
}  // namespace openfab::mesh
