// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_looks.h"

#include <algorithm>

namespace openfab::tools {

namespace {

/// Adds the parts of a look in this share; mixtures of mixtures are flat.
void add_parts(const std::vector<mesh::Look>& looks, int32_t look, double share, int depth,
               std::vector<std::pair<int32_t, double>>* parts) {
    const mesh::Look& of = looks[static_cast<size_t>(look)];
    constexpr int kDeepest = 8;
    if (of.mixture.empty() || depth == kDeepest) {
        const auto known = std::find_if(parts->begin(), parts->end(),
                                        [&](const auto& part) { return part.first == look; });
        if (known != parts->end()) {
            known->second += share;
        } else {
            parts->emplace_back(look, share);
        }
        return;
    }
    for (const auto& [part, of_it] : of.mixture)
        add_parts(looks, part, share * of_it, depth + 1, parts);
}

GroupLook group_look(const std::vector<mesh::Look>& looks, int32_t index, bool has_uv,
                     bool has_colors, bool layered) {
    GroupLook out;
    out.look = index;
    if (index < 0) return out;
    const mesh::Look& look = looks[static_cast<size_t>(index)];
    const bool colored = look.vertex_colors && has_colors;
    if (look.picture && has_uv) out.picture = look.picture;
    if (look.color) out.tint = *look.color;
    out.multiply = out.picture && look.tinted;
    out.has_material = look.is_material && !colored;
    const bool only_shown = look.color && !look.is_material;
    if (out.picture) {
        // A tint, and a colour without a material under the picture, are painted. A material is
        // there where the picture is not.
        out.has_material = layered && out.has_material && look.color && !look.tinted &&
                           look.picture->alpha != mesh::PictureUse::Alpha::kOpaque;
        if (look.tinted || only_shown || colored) out.cover = look.alpha;
    } else if (colored || only_shown) {
        out.cover = look.alpha;
    } else if (!look.mixture.empty()) {
        add_parts(looks, index, 1, 0, &out.mixture);
    }
    return out;
}

}  // namespace

std::vector<GroupLook> group_looks(const mesh::LoadedBodies& loaded, const mesh::LoadedMesh& body,
                                   bool layered) {
    const auto has = [&](const char* name, int32_t components) {
        const mesh::MeshAttribute* a = body.mesh.find(name);
        return a != nullptr && !a->is_int && a->components == components;
    };
    const bool uv = has("uv", 2), colors = has("color", 3);
    std::vector<int32_t> look_of = body.look_of;
    if (look_of.empty()) look_of.push_back(-1);
    if (std::all_of(look_of.begin(), look_of.end(), [&](int32_t l) { return l == look_of[0]; }))
        look_of.resize(1);
    std::vector<GroupLook> out;
    for (const int32_t look : look_of)
        out.push_back(group_look(loaded.looks, look, uv, colors, layered));
    return out;
}

void without_pictures(std::vector<GroupLook>* groups) {
    for (GroupLook& group : *groups) {
        group.picture.reset();
        group.own_picture = group.multiply = false;
    }
}

void all_skins(const std::vector<mesh::Look>& looks, std::vector<GroupLook>* groups) {
    for (GroupLook& group : *groups) {
        if (group.has_skin() || group.look < 0) continue;
        const mesh::Look& look = looks[static_cast<size_t>(group.look)];
        if (!look.color) continue;
        group.cover = look.alpha;
        group.has_material = false;
        group.mixture.clear();
    }
}

}  // namespace openfab::tools
