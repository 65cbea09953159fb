// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Materials of a glTF file as looks: colour, picture, transparency. What of them cannot be printed
// is told.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mesh/model/look.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/read/gltf_file.h"

namespace openfab::mesh {

/// From a file's coordinates to those of a picture, both with v down: u' = m0 u + m1 v + m2, v' =
/// m3 u + m4 v + m5.
using GltfTextureTransform = std::array<double, 6>;

/// A material, as any primitive may use it.
struct GltfMaterial {
    std::string name;
    std::string place;        ///< for messages
    Look look;                ///< without vertex colours
    int64_t coordinates = 0;  ///< the picture is at TEXCOORD_N
    GltfTextureTransform transform{1, 0, 0, 0, 1, 0};
    bool is_transparent = false;  ///< alpha counts
};

/// How a primitive looks.
struct GltfSkin {
    std::string material;  ///< its name; empty without one
    std::string place;
    int32_t look = -1;
    int64_t coordinates = 0;
    GltfTextureTransform transform{1, 0, 0, 0, 1, 0};
    bool is_transparent = false;
};

class GltfLooks {
  public:
    /// Tells what is left out to `mesh`, and adds the looks to it, as they are used.
    GltfLooks(GltfFile* gltf, MeshAssembly* mesh) : gltf_(*gltf), mesh_(*mesh) {}

    /// Returns how a primitive looks; the file keeps errors.
    GltfSkin of(const JsonValue& primitive);

  private:
    struct Key {
        int64_t material;
        bool vertex_colors;
        bool picture;
        auto operator<=>(const Key&) const = default;
    };

    const GltfMaterial* material(int64_t index);
    void read_material(const JsonValue& value, int64_t index, GltfMaterial* out);
    void read_colour(const JsonValue& value, GltfMaterial* out);
    void read_picture(const JsonValue& info, const char* asked_by, GltfMaterial* out);
    void read_transform(const JsonValue& info, GltfMaterial* out);
    void read_alpha(const JsonValue& value, GltfMaterial* out);
    std::optional<int64_t> source_of(const JsonValue& texture, const GltfMaterial& material);
    std::string picture_name(const JsonValue& image, int64_t index) const;
    PictureWrap wrap_of(const JsonValue& sampler, const char* key);
    void tell_what_is_not_printed(const JsonValue& value, const GltfMaterial& material);
    std::optional<std::array<double, 4>> factor(const JsonValue* of, const char* key, size_t count);

    GltfFile& gltf_;
    MeshAssembly& mesh_;
    std::map<int64_t, GltfMaterial> materials_;
    std::map<Key, int32_t> looks_;
};

}  // namespace openfab::mesh
