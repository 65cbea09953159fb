// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/gltf_looks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

namespace fs = std::filesystem;

using Rgba = std::array<double, 4>;

constexpr char kSpecular[] = "KHR_materials_pbrSpecularGlossiness";

/// Extensions of a material that change how it looks: where a factor of theirs is not `neutral`, or
/// where they have a picture.
struct Effect {
    const char* extension;
    const char* what;
    std::array<std::string_view, 2> factors;
    double neutral;
    const char* remedy;
};
constexpr Effect kEffects[] = {
    {"KHR_materials_transmission",
     messages::kTransmissionMaterial,
     {"transmissionFactor"},
     0,
     messages::kClearMaterial},
    {"KHR_materials_diffuse_transmission",
     messages::kDiffuseTransmissionMaterial,
     {"diffuseTransmissionFactor"},
     0,
     messages::kTranslucentMaterial},
    {"KHR_materials_volume",
     messages::kAbsorptionMaterial,
     {"thicknessFactor"},
     0,
     messages::kClearMaterialOfColour},
    {"KHR_materials_volume_scatter",
     messages::kScatteringMaterial,
     {"multiscatterColor", "multiscatterColorFactor"},
     0,
     messages::kTranslucentMaterial},
    {"KHR_materials_ior",
     messages::kRefractionMaterial,
     {"ior"},
     1.5,
     messages::kMaterialOfThatKind},
    {"KHR_materials_dispersion",
     messages::kDispersionMaterial,
     {"dispersion"},
     0,
     messages::kMaterialOfThatKind},
    {"KHR_materials_clearcoat",
     messages::kClearCoatMaterial,
     {"clearcoatFactor"},
     0,
     messages::kShinesAsItsMaterial},
    {"KHR_materials_sheen",
     messages::kSheenMaterial,
     {"sheenColorFactor"},
     0,
     messages::kShinesAsItsMaterial},
    {"KHR_materials_specular",
     messages::kSpecularColourMaterial,
     {"specularFactor", "specularColorFactor"},
     1,
     messages::kShinesAsItsMaterial},
    {"KHR_materials_iridescence",
     messages::kIridescenceMaterial,
     {"iridescenceFactor"},
     0,
     messages::kShinesAsItsMaterial},
    {"KHR_materials_anisotropy",
     messages::kAnisotropyMaterial,
     {"anisotropyStrength"},
     0,
     messages::kShinesAsItsMaterial},
};

bool is_black(const Rgba& colour) {
    return colour[0] == 0 && colour[1] == 0 && colour[2] == 0;
}

bool does_something(const JsonValue& extension, const Effect& effect) {
    const auto differs = [&](const JsonValue& v) {
        return v.is(JsonValue::Kind::kNumber) && v.number != effect.neutral;
    };
    for (const JsonMember& m : extension.members) {
        if (m.value.is(JsonValue::Kind::kObject) && m.key.ends_with("Texture")) return true;
        if (m.key != effect.factors[0] && m.key != effect.factors[1]) continue;
        if (differs(m.value)) return true;
        if (std::any_of(m.value.items.begin(), m.value.items.end(), differs)) return true;
    }
    return false;
}

/// Returns the extension of files that begin like this, or of this media type.
std::string extension_of(std::string_view head, std::string_view media_type) {
    if (head.starts_with("\x89PNG")) return ".png";
    if (head.starts_with("\xff\xd8")) return ".jpg";
    if (head.starts_with("RIFF")) return ".webp";
    if (head.starts_with("BM")) return ".bmp";
    if (head.starts_with("GIF8")) return ".gif";
    if (head.starts_with("DDS ")) return ".dds";
    if (head.starts_with("II*") || head.starts_with("MM")) return ".tif";
    constexpr std::string_view kImage = "image/";
    if (!media_type.starts_with(kImage)) return ".img";
    std::string_view kind = media_type.substr(kImage.size());
    kind = kind.substr(0, kind.find_first_of(";,"));
    if (kind == "jpeg") return ".jpg";
    const bool is_word =
        !kind.empty() && kind.size() <= 8 && std::all_of(kind.begin(), kind.end(), [](char c) {
            return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
        });
    return is_word ? "." + std::string(kind) : ".img";
}

std::string without_folders(std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    return fs::path(name).filename().string();
}

}  // namespace

GltfSkin GltfLooks::of(const JsonValue& primitive) {
    GltfSkin out;
    const JsonValue* attributes = gltf_member(&primitive, "attributes");
    const bool colours = gltf_member(attributes, "COLOR_0") != nullptr;
    const JsonValue* used = gltf_member(&primitive, "material");
    Key key{-1, colours, false};
    Look look;
    if (used != nullptr) {
        key.material = gltf_.integer(primitive, "material", 0);
        const GltfMaterial* found = gltf_.ok() ? material(key.material) : nullptr;
        if (found == nullptr) return out;
        out.material = found->name;
        out.place = found->place;
        out.is_transparent = found->is_transparent;
        look = found->look;
        const std::string coordinates = fmt::format("TEXCOORD_{}", found->coordinates);
        key.picture = look.picture && gltf_member(attributes, coordinates) != nullptr;
        if (key.picture) {
            out.coordinates = found->coordinates;
            out.transform = found->transform;
        }
    } else if (colours) {
        look.color = {1, 1, 1};
        look.is_material = false;
    } else {
        return out;
    }
    const auto [at, is_new] = looks_.emplace(key, static_cast<int32_t>(mesh_.looks().size()));
    out.look = at->second;
    if (!is_new) return out;
    look.vertex_colors = colours;
    if (look.picture && !key.picture) {
        mesh_.leave_out(messages::kPictureWithoutCoordinates, out.place,
                        messages::kPictureWithoutCoordinatesHelp);
        look.picture.reset();
    }
    constexpr size_t kNode = 100;  // of the map
    size_t bytes = 3 * sizeof look + kNode + look.name.size();
    if (look.picture) bytes += look.picture->name.size() + look.picture->source.size();
    if (gltf_.take_memory(bytes, primitive)) mesh_.looks().push_back(std::move(look));
    return out;
}

const GltfMaterial* GltfLooks::material(int64_t index) {
    if (const auto known = materials_.find(index); known != materials_.end()) return &known->second;
    const JsonValue* value = gltf_.item("materials", index, "a mesh");
    if (value == nullptr) return nullptr;
    GltfMaterial read;
    read_material(*value, index, &read);
    constexpr size_t kNode = 100;
    const size_t bytes = sizeof read + kNode + 2 * read.name.size() + read.place.size();
    if (!gltf_.ok() || !gltf_.take_memory(bytes, *value)) return nullptr;
    return &materials_.emplace(index, std::move(read)).first->second;
}

void GltfLooks::read_material(const JsonValue& value, int64_t index, GltfMaterial* out) {
    constexpr size_t kLongest = 1000;
    out->name = GltfFile::text(value, "name");
    if (out->name.size() > kLongest)
        return gltf_.fail(value, fmt::format(messages::kNameTooLong, out->name.size(), kLongest));
    if (out->name.empty()) out->name = fmt::format("material {}", index);
    out->look.name = out->name;
    out->place = gltf_.place_of("material", value);
    out->look.tinted = true;
    read_colour(value, out);
    if (gltf_.ok()) read_alpha(value, out);
    if (gltf_.ok()) tell_what_is_not_printed(value, *out);
}

std::optional<Rgba> GltfLooks::factor(const JsonValue* of, const char* key, size_t count) {
    if (gltf_member(of, key) == nullptr) return {};
    const std::optional<std::vector<double>> read = gltf_.numbers(*of, key, count);
    if (!read) return {};
    Rgba out{1, 1, 1, 1};
    for (size_t c = 0; c < count; ++c)
        out[c] = std::clamp((*read)[c], 0.0, 1.0);
    return out;
}

/// Colour and picture: those of pbrMetallicRoughness, of specular and glossiness where the material
/// has these, or what it emits where there is nothing else.
void GltfLooks::read_colour(const JsonValue& value, GltfMaterial* out) {
    const JsonValue* pbr = gltf_member(&value, "pbrMetallicRoughness");
    const JsonValue* gloss = gltf_extension(&value, kSpecular);
    std::optional<Rgba> colour = factor(pbr, "baseColorFactor", 4);
    const JsonValue* picture = gltf_member(pbr, "baseColorTexture");
    const char* of_picture = "baseColorTexture";
    if (gloss != nullptr) {
        const std::optional<Rgba> diffuse = factor(gloss, "diffuseFactor", 4);
        const JsonValue* map = gltf_member(gloss, "diffuseTexture");
        const std::optional<Rgba> specular = factor(gloss, "specularFactor", 3);
        const bool has_base = colour || picture != nullptr;
        if (map != nullptr || (picture == nullptr && diffuse && !is_black(*diffuse))) {
            colour = diffuse;
            picture = map;
            of_picture = "diffuseTexture";
        } else if (!has_base && diffuse) {
            // A metal is black but for what it reflects.
            colour = specular;
            if (!colour) colour = Rgba{1, 1, 1, 1};
            (*colour)[3] = (*diffuse)[3];
        }
    }
    std::optional<Rgba> light = factor(&value, "emissiveFactor", 3);
    if (light && !is_black(*light)) {
        const JsonValue* strength = gltf_member(
            gltf_extension(&value, "KHR_materials_emissive_strength"), "emissiveStrength");
        for (size_t c = 0; c < 3 && strength != nullptr; ++c)
            (*light)[c] = std::clamp((*light)[c] * strength->number, 0.0, 1.0);
        const bool is_all = colour ? is_black(*colour) : picture == nullptr;
        if (is_all) {
            const double alpha = colour ? (*colour)[3] : 1;
            colour = light;
            (*colour)[3] = alpha;
            picture = gltf_member(&value, "emissiveTexture");
            of_picture = "emissiveTexture";
        } else {
            mesh_.leave_out(messages::kLightEmitted, out->place, messages::kLightEmittedHelp);
        }
    }
    if (!gltf_.ok()) return;
    const Rgba found = colour.value_or(Rgba{1, 1, 1, 1});
    out->look.color = {found[0], found[1], found[2]};
    out->look.alpha = found[3];
    if (picture != nullptr) read_picture(*picture, of_picture, out);
}

void GltfLooks::read_picture(const JsonValue& info, const char* asked_by, GltfMaterial* out) {
    const JsonValue* texture = gltf_.item("textures", gltf_.integer(info, "index", 0), asked_by);
    if (texture == nullptr) return;
    out->coordinates = gltf_.integer(info, "texCoord", 0);
    read_transform(info, out);
    const std::optional<int64_t> source = source_of(*texture, *out);
    if (!source || !gltf_.ok()) return;
    const JsonValue* image = gltf_.item("images", *source, "a texture");
    if (image == nullptr) return;
    PictureUse picture;
    picture.source = std::to_string(*source);
    picture.name = picture_name(*image, *source);
    picture.wrap = {PictureWrap::kRepeat, PictureWrap::kRepeat};
    // Whatever the picture says of itself (glTF 2.0, on images).
    picture.space = PictureUse::Space::kSrgb;
    if (texture->find("sampler") != nullptr) {
        const JsonValue* sampler =
            gltf_.item("samplers", gltf_.integer(*texture, "sampler", 0), "a texture");
        if (sampler == nullptr) return;
        picture.wrap = {wrap_of(*sampler, "wrapS"), wrap_of(*sampler, "wrapT")};
        constexpr int64_t kNearest = 9728;
        picture.nearest = gltf_.integer(*sampler, "magFilter", 0) == kNearest;
    }
    out->look.picture = std::move(picture);
}

PictureWrap GltfLooks::wrap_of(const JsonValue& sampler, const char* key) {
    constexpr int64_t kRepeat = 10497, kClamp = 33071, kMirror = 33648;
    const int64_t wrap = gltf_.integer(sampler, key, kRepeat);
    return wrap == kClamp    ? PictureWrap::kClamp
           : wrap == kMirror ? PictureWrap::kMirror
                             : PictureWrap::kRepeat;
}

/// The scale first, then the rotation (anticlockwise as the picture is seen), then the offset.
void GltfLooks::read_transform(const JsonValue& info, GltfMaterial* out) {
    const JsonValue* transform = gltf_extension(&info, "KHR_texture_transform");
    if (transform == nullptr) return;
    const std::vector<double> offset =
        gltf_.numbers(*transform, "offset", 2).value_or(std::vector<double>{0, 0});
    const std::vector<double> scale =
        gltf_.numbers(*transform, "scale", 2).value_or(std::vector<double>{1, 1});
    const JsonValue* rotation = gltf_member(transform, "rotation");
    const double angle = rotation != nullptr ? rotation->number : 0;
    const double c = std::cos(angle), s = std::sin(angle);
    out->transform = {c * scale[0],  s * scale[1], offset[0],
                      -s * scale[0], c * scale[1], offset[1]};
    out->coordinates = gltf_.integer(*transform, "texCoord", out->coordinates);
}

/// Returns the image of a texture: its own, else that of an extension.
std::optional<int64_t> GltfLooks::source_of(const JsonValue& texture,
                                            const GltfMaterial& material) {
    if (texture.find("source") != nullptr) return gltf_.integer(texture, "source", 0);
    for (const char* name : {"EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds"}) {
        const JsonValue* extension = gltf_extension(&texture, name);
        if (gltf_member(extension, "source") != nullptr)
            return gltf_.integer(*extension, "source", 0);
    }
    if (gltf_extension(&texture, "KHR_texture_basisu") != nullptr) {
        mesh_.leave_out(messages::kPictureInKtx2, material.place, messages::kPictureInKtx2Help);
    } else {
        mesh_.leave_out(messages::kTextureWithoutPicture, material.place,
                        messages::kTextureWithoutPictureHelp);
    }
    return {};
}

std::string GltfLooks::picture_name(const JsonValue& image, int64_t index) const {
    const std::string uri = GltfFile::text(image, "uri");
    constexpr std::string_view kData = "data:";
    const bool is_data = uri.starts_with(kData);
    constexpr size_t kLongest = 100;
    if (!uri.empty() && !is_data) {
        const std::string name = without_folders(decode_percent(uri));
        // Its end says what it is.
        return name.size() <= kLongest ? name : name.substr(name.size() - kLongest);
    }
    const std::string media_type =
        is_data ? uri.substr(kData.size(), 40) : GltfFile::text(image, "mimeType");
    const std::string extension = extension_of(gltf_.image_head(image), media_type);
    std::string name = without_folders(GltfFile::text(image, "name")).substr(0, kLongest);
    if (name.empty()) name = fmt::format("picture_{}", index);
    return name.ends_with(extension) ? name : name + extension;
}

void GltfLooks::read_alpha(const JsonValue& value, GltfMaterial* out) {
    const std::string mode = GltfFile::text(value, "alphaMode");
    Look& look = out->look;
    out->is_transparent = mode == "BLEND" || mode == "MASK";
    if (!mode.empty() && mode != "OPAQUE" && !out->is_transparent)
        mesh_.leave_out(fmt::format(messages::kTransparencyMode, mode.substr(0, 20)), out->place,
                        messages::kTransparencyModeHelp);
    if (mode == "BLEND") {
        if (look.picture) look.picture->alpha = PictureUse::Alpha::kBlend;
        return;
    }
    const double alpha = look.alpha;
    look.alpha = 1;
    if (look.picture) look.picture->alpha = PictureUse::Alpha::kOpaque;
    if (mode != "MASK") return;
    double from = 0.5;
    if (const JsonValue* cutoff = gltf_member(&value, "alphaCutoff")) from = cutoff->number;
    if (look.picture && alpha > 0) {
        // The picture's alpha counts times that of the colour.
        look.picture->alpha = PictureUse::Alpha::kMask;
        look.picture->mask_from = from / alpha;
    } else if (alpha < from) {
        look.alpha = 0;
    }
}

void GltfLooks::tell_what_is_not_printed(const JsonValue& value, const GltfMaterial& material) {
    const auto tell = [&](const char* what, const char* remedy) {
        mesh_.leave_out(what, material.place, remedy);
    };
    if (value.find("normalTexture") != nullptr)
        tell(messages::kNormalMapMaterial, messages::kOnlyColoursPrinted);
    if (value.find("occlusionTexture") != nullptr)
        tell(messages::kOcclusionMapMaterial, messages::kOnlyColoursPrinted);
    const JsonValue* pbr = gltf_member(&value, "pbrMetallicRoughness");
    if (gltf_member(pbr, "metallicRoughnessTexture") != nullptr)
        tell(messages::kMapMetalRoughness, messages::kShinesAsItsMaterial);
    if (gltf_member(gltf_extension(&value, kSpecular), "specularGlossinessTexture") != nullptr)
        tell(messages::kMapSpecularGlossiness, messages::kShinesAsItsMaterial);
    for (const Effect& effect : kEffects) {
        const JsonValue* extension = gltf_extension(&value, effect.extension);
        if (extension != nullptr && does_something(*extension, effect))
            tell(effect.what, effect.remedy);
    }
}

}  // namespace openfab::mesh
