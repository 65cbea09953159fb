// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What a glTF file holds beside the meshes of its scene, which import tells of.

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "mesh/read/gltf_scene.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

/// Extensions that are read, that are told where they are used, or that say nothing of a print.
constexpr std::string_view kKnown[] = {
    "KHR_mesh_quantization", "KHR_texture_transform", "EXT_mesh_gpu_instancing",
    "KHR_node_visibility", "KHR_draco_mesh_compression", "EXT_meshopt_compression",
    "KHR_meshopt_compression", "KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif",
    "MSFT_texture_dds", "KHR_lights_punctual", "KHR_xmp", "KHR_xmp_json_ld",
    "KHR_animation_pointer", "MSFT_lod", "KHR_materials_unlit",
    "KHR_materials_pbrSpecularGlossiness", "KHR_materials_emissive_strength",
    "KHR_materials_variants", "KHR_materials_transmission", "KHR_materials_diffuse_transmission",
    "KHR_materials_volume", "KHR_materials_volume_scatter", "KHR_materials_ior",
    "KHR_materials_dispersion", "KHR_materials_clearcoat", "KHR_materials_sheen",
    "KHR_materials_specular", "KHR_materials_iridescence", "KHR_materials_anisotropy",
    // Hints for who draws it on a screen.
    "EXT_lights_image_based", "EXT_lights_ies", "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic", "CESIUM_RTC", "FB_ngon_encoding"};

const std::vector<JsonValue>& items_of(const JsonValue* list) {
    static const std::vector<JsonValue> none;
    return list != nullptr ? list->items : none;
}

class Teller {
  public:
    Teller(const GltfFile& gltf, MeshAssembly* mesh) : gltf_(gltf), mesh_(*mesh) {}

    void tell() {
        tell_of_scenes();
        tell_all(root("cameras"), "camera", "a camera", messages::kSeenFromAllSides);
        const JsonValue* lights = gltf_extension(&gltf_.root(), "KHR_lights_punctual");
        tell_all(gltf_member(lights, "lights"), "light", "a light", messages::kLitByTheRoom);
        tell_all(root("animations"), "animation", messages::kAnimation, messages::kAnimationHelp);
        const JsonValue* variants = gltf_extension(&gltf_.root(), "KHR_materials_variants");
        tell_all(gltf_member(variants, "variants"), "variant", messages::kVariantOfMaterials,
                 messages::kChooseAndExportAgain);
        for (const JsonValue& node : items_of(root("nodes"))) {
            if (gltf_extension(&node, "MSFT_lod") != nullptr)
                mesh_.leave_out(messages::kCoarserForms, gltf_.place_of("node", node),
                                messages::kCoarserFormsHelp);
        }
        for (const auto& [list, kind] :
             {std::pair{"scenes", "scene"}, std::pair{"nodes", "node"}, std::pair{"meshes", "mesh"},
              std::pair{"materials", "material"}}) {
            for (const JsonValue& item : items_of(root(list))) {
                if (item.find("extras") != nullptr)
                    mesh_.leave_out(messages::kExtras, gltf_.place_of(kind, item),
                                    messages::kExtrasHelp);
            }
        }
        for (const JsonValue& name : items_of(root("extensionsUsed"))) {
            if (std::find(std::begin(kKnown), std::end(kKnown), name.text) != std::end(kKnown))
                continue;
            mesh_.leave_out(fmt::format(messages::kExtensionOfGltf, name.text.substr(0, 60)),
                            gltf_.place_of("extension", name), messages::kExportWithoutExtension);
        }
    }

  private:
    const JsonValue* root(const char* key) const { return gltf_member(&gltf_.root(), key); }

    void tell_all(const JsonValue* list, const char* kind, const char* what, const char* remedy) {
        for (const JsonValue& item : items_of(list))
            mesh_.leave_out(what, gltf_.place_of(kind, item), remedy);
    }

    void tell_of_scenes() {
        const std::vector<JsonValue>& scenes = items_of(root("scenes"));
        const JsonValue* chosen = root("scene");
        const double shown = chosen != nullptr ? chosen->number : 0;
        for (size_t s = 0; s < scenes.size(); ++s) {
            if (static_cast<double>(s) != shown)
                mesh_.leave_out(messages::kOtherScene, gltf_.place_of("scene", scenes[s]),
                                messages::kChooseAndExportAgain);
        }
        // Meshes of other scenes are told with these.
        if (scenes.size() > 1) return;
        const std::vector<JsonValue>& meshes = items_of(root("meshes"));
        std::vector<bool> used(meshes.size());
        for (const JsonValue& node : items_of(root("nodes"))) {
            const JsonValue* mesh = gltf_member(&node, "mesh");
            if (mesh != nullptr && mesh->number >= 0 &&
                mesh->number < static_cast<double>(used.size()))
                used[static_cast<size_t>(mesh->number)] = true;
        }
        for (size_t m = 0; m < meshes.size(); ++m) {
            if (!used[m])
                mesh_.leave_out(messages::kMeshNotPlaced, gltf_.place_of("mesh", meshes[m]),
                                messages::kMeshNotPlacedHelp);
        }
    }

    const GltfFile& gltf_;
    MeshAssembly& mesh_;
};

}  // namespace

void tell_what_is_beside_the_scene(const GltfFile& gltf, MeshAssembly* mesh) {
    Teller(gltf, mesh).tell();
}

}  // namespace openfab::mesh
