// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Appearance in glTF: base colours and their pictures.

#include <fmt/format.h>

#include <algorithm>

#include "mesh/read/gltf_file.h"
#include "tools/openfab/appearance.h"

namespace openfab::tools {

namespace {

using mesh::GltfFile;

const JsonValue* child(const JsonValue* object, const char* key) {
    const JsonMember* found =
        object != nullptr && object->is(JsonValue::Kind::kObject) ? object->find(key) : nullptr;
    return found != nullptr ? &found->value : nullptr;
}

std::string extension_of(std::string_view bytes) {
    return bytes.starts_with("\x89PNG") ? ".png" : bytes.starts_with("\xff\xd8") ? ".jpg" : ".img";
}

/// Reads the picture of a texture.
std::optional<Picture> picture_of(GltfFile* gltf, const JsonValue& info, const std::string& name,
                                  LooksMaker* out) {
    const JsonValue* texture =
        gltf->item("textures", gltf->integer(info, "index", 0), "a material");
    if (texture == nullptr) return {};
    if (gltf->integer(info, "texCoord", 0) != 0) {
        out->note(
            fmt::format("the picture of material `{}` uses other coordinates than the "
                        "first; it is read at the first",
                        name));
    }
    const int64_t source = gltf->integer(*texture, "source", 0);
    const JsonValue* image = gltf->item("images", source, "a texture");
    if (image == nullptr) return {};
    const Result<SharedBytes> bytes =
        out->picture(std::to_string(source), [&](int64_t) { return gltf->image(*image); });
    if (!bytes) return {};  // the file keeps the error
    Picture picture;
    picture.bytes = *bytes;
    const std::filesystem::path uri = GltfFile::text(*image, "uri");
    const bool is_file = !uri.empty() && !uri.string().starts_with("data:");
    std::string stem = GltfFile::text(*image, "name");
    if (stem.empty()) stem = fmt::format("picture_{}", source);
    picture.name = is_file ? uri.filename().string() : stem + extension_of(*picture.bytes);
    if (texture->find("sampler") != nullptr) {
        const JsonValue* sampler =
            gltf->item("samplers", gltf->integer(*texture, "sampler", 0), "a texture");
        constexpr int64_t kClampToEdge = 33071, kRepeat = 10497;
        picture.clamp =
            sampler != nullptr && gltf->integer(*sampler, "wrapS", kRepeat) == kClampToEdge;
    }
    return picture;
}

}  // namespace

Result<Appearances> gltf_appearances(std::string_view bytes, const std::string& file,
                                     int64_t memory_bytes) {
    Result<GltfFile> opened = GltfFile::open(bytes, file, memory_bytes);
    if (!opened) return opened.error();
    GltfFile& gltf = *opened;
    LooksMaker out(&gltf.memory_left());
    const JsonValue* materials = child(&gltf.root(), "materials");
    const size_t count = materials != nullptr ? materials->items.size() : 0;
    for (size_t i = 0; i < count && gltf.ok(); ++i) {
        const JsonValue& material = materials->items[i];
        std::string name = GltfFile::text(material, "name");
        if (name.empty()) name = fmt::format("material {}", i);
        MaterialAppearance* appearance = out.add(name);
        if (appearance == nullptr) continue;
        appearance->tinted = true;
        const JsonValue* pbr = child(&material, "pbrMetallicRoughness");
        if (pbr != nullptr) {
            if (const auto factor = gltf.numbers(*pbr, "baseColorFactor", 4)) {
                std::array<double, 3> color{};
                for (size_t c = 0; c < 3; ++c)
                    color[c] = std::clamp((*factor)[c], 0.0, 1.0);
                appearance->color = color;
            }
            if (const JsonValue* info = child(pbr, "baseColorTexture"))
                appearance->picture = picture_of(&gltf, *info, name, &out);
        }
    }
    if (!gltf.ok()) return gltf.error();
    return out.finish(file);
}

}  // namespace openfab::tools
