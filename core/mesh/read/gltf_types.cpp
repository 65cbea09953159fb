// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/gltf_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

using Kind = JsonValue::Kind;

// Names that have one type wherever glTF 2.0 and Khronos's extensions of materials use them. Whole numbers are checked where they
// are read, with their ranges.
constexpr std::string_view kObjects[] = {
    "asset",
    "attributes",
    "baseColorTexture",
    "diffuseTexture",
    "emissiveTexture",
    "extensions",
    "metallicRoughnessTexture",
    "normalTexture",
    "occlusionTexture",
    "pbrMetallicRoughness",
    "sparse",
    "specularGlossinessTexture",
};
constexpr std::string_view kArrays[] = {
    "accessors",      "animations", "baseColorFactor", "bufferViews",    "buffers",
    "cameras",        "children",   "diffuseFactor",   "emissiveFactor", "extensionsRequired",
    "extensionsUsed", "images",     "joints",          "materials",      "matrix",
    "meshes",         "nodes",      "primitives",      "samplers",       "scenes",
    "skins",          "targets",    "textures",
};
constexpr std::string_view kArraysOfObjects[] = {
    "accessors", "animations", "bufferViews", "buffers", "cameras", "images",  "materials",
    "meshes",    "primitives", "samplers",    "scenes",  "skins",   "targets", "textures",
};
constexpr std::string_view kNumbers[] = {"alphaCutoff", "emissiveStrength", "metallicFactor",
                                         "roughnessFactor", "strength"};
constexpr std::string_view kStrings[] = {"alphaMode", "mimeType", "name", "uri"};
constexpr std::string_view kBooleans[] = {"doubleSided", "normalized"};

bool holds(const auto& names, std::string_view name) {
    return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

/// Returns the type of a name's values; kNull if they may be of any.
Kind kind_of(std::string_view name) {
    if (holds(kObjects, name)) return Kind::kObject;
    if (holds(kArrays, name)) return Kind::kArray;
    if (holds(kNumbers, name)) return Kind::kNumber;
    if (holds(kStrings, name)) return Kind::kString;
    if (holds(kBooleans, name)) return Kind::kBool;
    return Kind::kNull;
}

class Types {
  public:
    explicit Types(const std::string& file) : file_(file) {}

    /// parse_json bounds how deep this goes.
    Result<void> check(const JsonValue& value) const {
        for (const JsonMember& m : value.members) {
            if (m.key == "extras") continue;
            if (Result<void> fine = is(m.value, m.key, kind_of(m.key)); !fine) return fine;
            if (Result<void> fine =
                    m.key == "extensions" ? check_extensions(m.value) : check(m.value);
                !fine)
                return fine;
            if (!holds(kArraysOfObjects, m.key)) continue;
            for (const JsonValue& item : m.value.items) {
                if (Result<void> fine = is(item, m.key, Kind::kObject); !fine) return fine;
            }
        }
        for (const JsonValue& item : value.items) {
            if (Result<void> fine = check(item); !fine) return fine;
        }
        return Ok{};
    }

  private:
    Result<void> check_extensions(const JsonValue& extensions) const {
        for (const JsonMember& m : extensions.members) {
            if (Result<void> fine = is(m.value, m.key, Kind::kObject); !fine) return fine;
            const bool names_mean_the_same =
                m.key.starts_with("KHR_materials_") || m.key.starts_with("KHR_texture_");
            if (!names_mean_the_same) continue;
            if (Result<void> fine = check(m.value); !fine) return fine;
        }
        return Ok{};
    }

    Result<void> is(const JsonValue& value, std::string_view name, Kind kind) const {
        if (kind == Kind::kNull || value.is(kind)) return Ok{};
        JsonValue wanted;
        wanted.kind = kind;
        return error_at(
            {file_, value.line, value.column},
            fmt::format(messages::kWrongType, name, value.kind_name(), wanted.kind_name()),
            messages::kWrongTypeHelp);
    }

    const std::string& file_;
};

}  // namespace

Result<void> check_gltf_types(const JsonValue& root, const std::string& file) {
    return Types(file).check(root);
}

}  // namespace openfab::mesh
