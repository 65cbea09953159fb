// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The looks of a 3MF's triangles: what the materials extension layers on them, in one Look each.

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mesh/model/mesh_assembly.h"
#include "mesh/read/threemf_model.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {

/// Returns the name of looks of texture group `id`, which has none.
inline std::string threemf_texture_name(const std::string& id) {
    return "texture " + id;
}

/// A model part. Ids of its resources are its own.
struct ThreemfPart {
    std::string name;  ///< in the archive
    ThreemfModel model;

    /// What was added to the mesh for a group; -2: not yet.
    struct Added {
        std::vector<int32_t> values;  ///< by entry: index of the colour or coordinates
        std::vector<int32_t> looks;   ///< by entry of materials and composites
        int32_t picture = -2;
        std::map<std::vector<int>, int32_t> gradients;  ///< composites between entries
    };
    std::map<int64_t, Added> added;
};

/// A triangle's look, and its values by corner.
struct ThreemfFace {
    int32_t look = -1;
    std::optional<std::array<int32_t, 3>> color, uv;
};

class ThreemfLooks {
  public:
    ThreemfLooks(MeshAssembly* mesh, const ZipFile& zip, ThreemfTold* told)
        : mesh_(*mesh), zip_(zip), told_(*told) {}

    /// Returns the look of a triangle of `object` with these entries of a group at its corners.
    ThreemfFace face(ThreemfPart* part, const ThreemfObject& object, int64_t group,
                     const std::array<int64_t, 3>& picks);

    /// Returns the look of a filament: that of a material of its name and colour, if there is one.
    int32_t filament(const std::string& name, const std::optional<ThreemfColor>& color);

    /// Returns the look of a mixture of looks in these shares; of one alone itself, of none -1.
    int32_t mixture(const std::map<int32_t, double>& shares);

    std::optional<size_t> color() const { return color_; }
    std::optional<size_t> uv() const { return uv_; }
    /// Bytes of all looks.
    int64_t bytes() const { return bytes_; }

  private:
    using Picks = std::array<int64_t, 3>;

    /// Looks that differ in nothing but their name are one, unless they are materials.
    struct Kind {
        int32_t material = -1;  ///< a look
        int32_t picture = -1;
        PictureUse::Alpha alpha = PictureUse::Alpha::kOpaque;
        bool tinted = false;
        bool vertex_colors = false;
        std::optional<std::array<float, 3>> under;
        auto operator<=>(const Kind&) const = default;
    };

    /// Layers of multi-properties, blended so far.
    struct Blend {
        bool is_colored = false;
        std::array<ThreemfColor, 3> colors{};  ///< by corner
        int32_t picture = -1;
        std::string picture_name;
        bool over = false;    ///< the picture is over what is below
        bool tinted = false;  ///< it is multiplied by what is below
        std::optional<std::array<int32_t, 3>> uv;
    };

    ThreemfPart::Added& added_of(ThreemfPart* part, int64_t id, const ThreemfGroup& group);
    int32_t plain(const std::string& name, const std::optional<ThreemfColor>& color);
    int32_t material(ThreemfPart* part, int64_t id, int64_t pick);
    int32_t composite(ThreemfPart* part, int64_t id, const Picks& picks);
    int32_t mixture(ThreemfPart* part, const ThreemfGroup& group,
                    const std::vector<double>& shares);
    int32_t base(ThreemfPart* part, int64_t id, const Picks& picks);
    int32_t picture(ThreemfPart* part, int64_t id);
    ThreemfFace multi(ThreemfPart* part, int64_t id, const Picks& picks);
    bool blend_color(const ThreemfPart& part, const ThreemfGroup& layer, const Picks& picks,
                     bool multiply, bool on_material, Blend* blend);
    bool blend_picture(ThreemfPart* part, int64_t id, const Picks& picks, bool multiply,
                       bool on_material, Blend* blend);
    std::optional<std::array<int32_t, 3>> values(ThreemfPart* part, int64_t id, const Picks& picks,
                                                 const char* name, int32_t components,
                                                 std::optional<size_t>* attribute);
    std::optional<std::array<float, 3>> default_color(const ThreemfPart& part, int64_t id,
                                                      int64_t pick) const;
    int32_t color_value(const std::array<float, 3>& color);
    int32_t look_of(const Kind& kind, const std::string& name);
    int32_t add(Look look);
    void tell_of_alpha(const ThreemfPart& part, int64_t id, const Picks& picks);
    void miss(const ThreemfPart& part, int64_t id);

    MeshAssembly& mesh_;
    const ZipFile& zip_;
    ThreemfTold& told_;
    std::optional<size_t> color_, uv_;  ///< attributes of the mesh
    /// Materials by name and colour, with the part that has them first; filaments are of none.
    std::map<std::pair<std::string, std::optional<ThreemfColor>>, std::pair<int32_t, std::string>>
        materials_;
    std::vector<PictureUse> pictures_;
    std::map<PictureUse, int32_t> picture_indices_;
    std::map<Kind, int32_t> kinds_;
    std::map<std::array<float, 3>, int32_t> blended_;  ///< indices of values
    std::set<std::pair<std::string, int64_t>> missing_;
    std::set<std::pair<std::string, int64_t>> clear_;  ///< groups whose transparency was told
    int64_t bytes_ = 0;
};

}  // namespace openfab::mesh
