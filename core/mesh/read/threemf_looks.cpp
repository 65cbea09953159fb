// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_looks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

using Group = ThreemfGroup::Kind;

constexpr int32_t kNew = -2;

bool is_in(int64_t index, size_t size) {
    return index >= 0 && static_cast<size_t>(index) < size;
}

std::array<double, 3> rgb_of(const ThreemfColor& color) {
    return {color[0], color[1], color[2]};
}

std::string place_of(const ThreemfPart& part, int64_t id) {
    return fmt::format("{}, group {}", part.name, id);
}

/// Alike mixtures become one, so that a gradient is not a material for each triangle.
std::vector<int> in_steps(const std::vector<double>& shares) {
    constexpr int kSteps = 20;
    std::vector<int> steps;
    int sum = 0;
    for (const double share : shares) {
        steps.push_back(static_cast<int>(std::lround(share * kSteps)));
        sum += steps.back();
    }
    if (!steps.empty()) *std::max_element(steps.begin(), steps.end()) += kSteps - sum;
    return steps;
}

}  // namespace

ThreemfFace ThreemfLooks::face(ThreemfPart* part, const ThreemfObject& object, int64_t id,
                               const Picks& picks) {
    ThreemfFace out;
    const auto it = part->model.groups.find(id);
    if (it == part->model.groups.end()) {
        miss(*part, id);
        return out;
    }
    switch (it->second.kind) {
        case Group::kMaterials:
        case Group::kComposites:
            out.look = base(part, id, picks);
            break;
        case Group::kColors:
            out.color = values(part, id, picks, "color", 3, &color_);
            if (out.color) out.look = look_of({.vertex_colors = true}, "colours");
            tell_of_alpha(*part, id, picks);
            break;
        case Group::kCoordinates: {
            Kind kind{.picture = picture(part, id)};
            // Without its picture, coordinates may serve one of the user's.
            out.uv = values(part, id, picks, "uv", 2, &uv_);
            if (kind.picture < 0 || !out.uv) break;
            const auto& wrap = pictures_[static_cast<size_t>(kind.picture)].wrap;
            if (wrap[0] == PictureWrap::kNone || wrap[1] == PictureWrap::kNone)
                kind.under = default_color(*part, object.group, object.property);
            out.look = look_of(kind, threemf_texture_name(std::to_string(id)));
            break;
        }
        case Group::kMulti:
            out = multi(part, id, picks);
            break;
    }
    return out;
}

int32_t ThreemfLooks::filament(const std::string& name, const std::optional<ThreemfColor>& color) {
    const auto [known, fresh] = materials_.try_emplace({name, color}, kNew, std::string());
    if (!known->second.second.empty()) return known->second.first;
    const int32_t look = plain(name, color);
    if (fresh) known->second.first = look;
    return look;
}

int32_t ThreemfLooks::plain(const std::string& name, const std::optional<ThreemfColor>& color) {
    Look look;
    look.name = name;
    if (color) {
        look.color = rgb_of(*color);
        look.alpha = static_cast<double>((*color)[3]);
    }
    return add(std::move(look));
}

void ThreemfLooks::tell_of_alpha(const ThreemfPart& part, int64_t id, const Picks& picks) {
    const ThreemfGroup& group = part.model.groups.at(id);
    const bool clear = std::any_of(picks.begin(), picks.end(), [&](int64_t pick) {
        return is_in(pick, group.values.size()) && group.values[static_cast<size_t>(pick)][3] < 1;
    });
    if (clear && clear_.emplace(part.name, id).second)
        told_.add(messages::kTransparentColours, place_of(part, id),
                  messages::kTransparentColoursHelp);
}

ThreemfPart::Added& ThreemfLooks::added_of(ThreemfPart* part, int64_t id,
                                           const ThreemfGroup& group) {
    const auto [it, fresh] = part->added.try_emplace(id);
    if (fresh) {
        it->second.values.assign(group.kind == Group::kMaterials ? 0 : group.values.size(), kNew);
        it->second.looks.assign(std::max(group.names.size(), group.shares.size()), kNew);
    }
    return it->second;
}

/// Of materials and composites.
int32_t ThreemfLooks::base(ThreemfPart* part, int64_t id, const Picks& picks) {
    const ThreemfGroup& group = part->model.groups.at(id);
    // Materials have no gradients: the specification lets the first corner decide.
    return group.kind == Group::kMaterials ? material(part, id, picks[0])
                                           : composite(part, id, picks);
}

int32_t ThreemfLooks::material(ThreemfPart* part, int64_t id, int64_t pick) {
    const ThreemfGroup& group = part->model.groups.at(id);
    if (!is_in(pick, group.names.size())) {
        miss(*part, id);
        return -1;
    }
    const auto index = static_cast<size_t>(pick);
    int32_t& look = added_of(part, id, group).looks[index];
    if (look != kNew) return look;
    std::optional<ThreemfColor> color;
    if (group.colored[index]) color = group.values[index];
    // Parts, and the filaments of no part, repeat materials that are one; within a part they are different ones.
    const auto [known, fresh] =
        materials_.try_emplace({group.names[index], color}, kNew, part->name);
    if (!fresh && known->second.second != part->name) return look = known->second.first;
    look = plain(group.names[index], color);
    if (fresh) known->second.first = look;
    return look;
}

int32_t ThreemfLooks::composite(ThreemfPart* part, int64_t id, const Picks& picks) {
    const ThreemfGroup& group = part->model.groups.at(id);
    for (const int64_t pick : picks) {
        if (is_in(pick, group.shares.size())) continue;
        miss(*part, id);
        return -1;
    }
    ThreemfPart::Added& added = added_of(part, id, group);
    if (picks[0] == picks[1] && picks[1] == picks[2]) {
        int32_t& look = added.looks[static_cast<size_t>(picks[0])];
        if (look == kNew) look = mixture(part, group, group.shares[static_cast<size_t>(picks[0])]);
        return look;
    }
    std::vector<double> shares(group.layers.size(), 0.0);
    for (const int64_t pick : picks) {
        for (size_t i = 0; i < shares.size(); ++i)
            shares[i] += group.shares[static_cast<size_t>(pick)][i] / 3;
    }
    const std::vector<int> steps = in_steps(shares);
    const auto [known, fresh] = added.gradients.try_emplace(steps, kNew);
    if (fresh) {
        if (added.gradients.size() == 1)
            told_.add(messages::kCompositeGradients, place_of(*part, id),
                      messages::kCompositeGradientsHelp);
        const int sum = std::max(1, [&] {
            int total = 0;
            for (const int step : steps)
                total += step;
            return total;
        }());
        for (size_t i = 0; i < shares.size(); ++i)
            shares[i] = static_cast<double>(steps[i]) / sum;
        known->second = mixture(part, group, shares);
        bytes_ += static_cast<int64_t>(steps.size() * sizeof(int) + sizeof steps);
    }
    return known->second;
}

int32_t ThreemfLooks::mixture(ThreemfPart* part, const ThreemfGroup& group,
                              const std::vector<double>& shares) {
    const auto materials = part->model.groups.find(group.source);
    if (materials == part->model.groups.end() || materials->second.kind != Group::kMaterials) {
        miss(*part, group.source);
        return -1;
    }
    std::map<int32_t, double> mixed;
    for (size_t i = 0; i < shares.size(); ++i) {
        if (shares[i] <= 0) continue;
        const int32_t look = material(part, group.source, group.layers[i]);
        if (look < 0) return -1;
        mixed[look] += shares[i];
    }
    return mixture(mixed);
}

int32_t ThreemfLooks::mixture(const std::map<int32_t, double>& mixed) {
    if (mixed.size() < 2) return mixed.empty() ? -1 : mixed.begin()->first;
    Look out;
    out.color.emplace();
    out.alpha = 0;
    for (const auto& [look, share] : mixed) {
        const Look& one = mesh_.looks()[static_cast<size_t>(look)];
        out.mixture.emplace_back(look, share);
        out.name +=
            fmt::format("{}{:.3g} % {}", out.name.empty() ? "" : ", ", share * 100, one.name);
        out.alpha += share * one.alpha;
        for (size_t c = 0; out.color && one.color && c < 3; ++c)
            (*out.color)[c] += share * (*one.color)[c];
        if (!one.color) out.color.reset();
    }
    return add(std::move(out));
}

int32_t ThreemfLooks::picture(ThreemfPart* part, int64_t id) {
    const ThreemfGroup& group = part->model.groups.at(id);
    int32_t& index = added_of(part, id, group).picture;
    if (index != kNew) return index;
    const auto it = part->model.textures.find(group.source);
    if (it == part->model.textures.end()) {
        told_.add(messages::kPicturesNotDefined, place_of(*part, id),
                  messages::kPicturesNotDefinedHelp);
        return index = -1;
    }
    const ThreemfTexture& texture = it->second;
    PictureUse use;
    use.source = zip_.resolve(part->name, texture.path);
    use.name = ZipFile::file_name(use.source);
    use.wrap = texture.wrap;
    use.alpha = PictureUse::Alpha::kOpaque;
    use.nearest = texture.nearest;
    const auto [known, fresh] =
        picture_indices_.try_emplace(use, static_cast<int32_t>(pictures_.size()));
    if (fresh) {
        bytes_ += static_cast<int64_t>(6 * sizeof use + 6 * use.source.size());
        pictures_.push_back(std::move(use));
    }
    return index = known->second;
}

ThreemfFace ThreemfLooks::multi(ThreemfPart* part, int64_t id, const Picks& picks) {
    const ThreemfGroup& group = part->model.groups.at(id);
    ThreemfFace out;
    Kind kind;
    Blend blend;
    for (size_t layer = 0; layer < group.layers.size(); ++layer) {
        Picks inner{};
        for (size_t c = 0; c < 3; ++c) {
            if (!is_in(picks[c], group.picks.size())) {
                miss(*part, id);
                return out;
            }
            const auto& pick = group.picks[static_cast<size_t>(picks[c])];
            inner[c] = layer < pick.size() ? pick[layer] : 0;
        }
        const int64_t under = group.layers[layer];
        const auto it = part->model.groups.find(under);
        if (it == part->model.groups.end()) {
            miss(*part, under);
            continue;
        }
        const bool multiply =
            layer > 0 && layer <= group.multiplied.size() && group.multiplied[layer - 1];
        bool fine = false;
        switch (it->second.kind) {
            case Group::kMaterials:
            case Group::kComposites:
                fine = kind.material < 0 && layer == 0;
                if (fine) kind.material = base(part, under, inner);
                break;
            case Group::kColors:
                // With nothing below it, it is opaque.
                if (layer == 0) tell_of_alpha(*part, under, inner);
                fine = blend_color(*part, it->second, inner, multiply, kind.material >= 0, &blend);
                break;
            case Group::kCoordinates:
                fine = blend_picture(part, under, inner, multiply, kind.material >= 0, &blend);
                break;
            case Group::kMulti:
                break;
        }
        if (!fine && missing_.emplace(part->name, -1 - id).second)
            told_.add(messages::kTooManyLayers, place_of(*part, id), messages::kTooManyLayersHelp);
    }
    if (blend.is_colored) {
        std::optional<std::array<double, 3>> under;
        if (kind.material >= 0) under = mesh_.looks()[static_cast<size_t>(kind.material)].color;
        std::array<int32_t, 3> corners{};
        bool any = kind.material < 0;
        for (size_t c = 0; c < 3; ++c) {
            const ThreemfColor& color = blend.colors[c];
            std::array<float, 3> seen{color[0], color[1], color[2]};
            for (size_t i = 0; under && i < 3; ++i)
                seen[i] = seen[i] * color[3] + static_cast<float>((*under)[i]) * (1 - color[3]);
            any = any || color[3] > 0;
            corners[c] = color_value(seen);
        }
        kind.vertex_colors = any;
        if (any) out.color = corners;
    }
    if (blend.picture >= 0) {
        kind.picture = blend.picture;
        kind.tinted = blend.tinted;
        if (blend.over) kind.alpha = PictureUse::Alpha::kBlend;
    }
    out.uv = blend.uv;
    const bool plain = kind.picture < 0 && !kind.vertex_colors;
    out.look =
        plain ? kind.material : look_of(kind, kind.picture >= 0 ? blend.picture_name : "colours");
    return out;
}

/// Blends by the equations of the specification, corner by corner. Returns whether the layer could
/// be taken in.
bool ThreemfLooks::blend_color(const ThreemfPart& part, const ThreemfGroup& layer,
                               const Picks& picks, bool multiply, bool on_material, Blend* blend) {
    std::array<ThreemfColor, 3> colors{};
    for (size_t c = 0; c < 3; ++c) {
        if (!is_in(picks[c], layer.values.size())) {
            miss(part, -1);
            return true;
        }
        colors[c] = layer.values[static_cast<size_t>(picks[c])];
    }
    if (blend->picture >= 0) {
        const auto all = [&](float alpha) {
            return std::all_of(colors.begin(), colors.end(),
                               [&](const ThreemfColor& color) { return color[3] == alpha; });
        };
        if (!multiply && all(0)) return true;
        if (!multiply && all(1)) {
            const std::optional<std::array<int32_t, 3>> uv = blend->uv;
            *blend = {};
            blend->uv = uv;
        } else if (multiply && !blend->over) {
            blend->tinted = true;
        } else {
            return false;
        }
    }
    for (size_t c = 0; c < 3; ++c) {
        ThreemfColor& sum = blend->colors[c];
        const ThreemfColor& one = colors[c];
        if (!blend->is_colored) {
            sum = one;
            // The lowest layer is opaque unless there is a material below it.
            if (!on_material || multiply) sum[3] = 1;
            continue;
        }
        for (size_t i = 0; i < 3; ++i)
            sum[i] = multiply ? sum[i] * one[i] : one[i] * one[3] + sum[i] * (1 - one[3]);
        sum[3] = multiply ? sum[3] * one[3] : one[3] + sum[3] * (1 - one[3]);
    }
    blend->is_colored = true;
    return true;
}

bool ThreemfLooks::blend_picture(ThreemfPart* part, int64_t id, const Picks& picks, bool multiply,
                                 bool on_material, Blend* blend) {
    if (blend->picture >= 0) return false;
    const int32_t found = picture(part, id);
    const auto uv = values(part, id, picks, "uv", 2, &uv_);
    if (!uv) return true;
    blend->uv = *uv;
    if (found < 0) return true;
    blend->picture = found;
    blend->picture_name = threemf_texture_name(std::to_string(id));
    // Upon a material the first colour begins, however it is blended: opaque if it is multiplied.
    blend->tinted = multiply && blend->is_colored;
    blend->over = !multiply && (on_material || blend->is_colored);
    return true;
}

/// Returns the mesh's values for entries of a group, adding them on first use; none if one is not
/// there.
std::optional<std::array<int32_t, 3>> ThreemfLooks::values(ThreemfPart* part, int64_t id,
                                                           const Picks& picks, const char* name,
                                                           int32_t components,
                                                           std::optional<size_t>* attribute) {
    const ThreemfGroup& group = part->model.groups.at(id);
    ThreemfPart::Added& added = added_of(part, id, group);
    if (!*attribute) *attribute = mesh_.attribute(name, components);
    std::array<int32_t, 3> out{-1, -1, -1};
    for (size_t c = 0; c < 3; ++c) {
        if (!is_in(picks[c], added.values.size())) {
            miss(*part, id);
            return {};
        }
        const auto pick = static_cast<size_t>(picks[c]);
        if (added.values[pick] == kNew) {
            const ThreemfColor& value = group.values[pick];
            const std::array<double, 3> wide = rgb_of(value);
            added.values[pick] = mesh_.add_value(**attribute, wide.data());
        }
        out[c] = added.values[pick];
    }
    return out;
}

/// The colour of an object where a picture that does not repeat ends.
std::optional<std::array<float, 3>> ThreemfLooks::default_color(const ThreemfPart& part, int64_t id,
                                                                int64_t pick) const {
    const auto it = part.model.groups.find(id);
    if (it == part.model.groups.end()) return {};
    const ThreemfGroup& group = it->second;
    if (!is_in(pick, group.values.size())) return {};
    const auto index = static_cast<size_t>(pick);
    const bool is_color =
        group.kind == Group::kColors || (group.kind == Group::kMaterials && group.colored[index]);
    if (!is_color) return {};
    const ThreemfColor& color = group.values[index];
    return std::array<float, 3>{color[0], color[1], color[2]};
}

int32_t ThreemfLooks::color_value(const std::array<float, 3>& color) {
    if (!color_) color_ = mesh_.attribute("color", 3);
    const auto [known, fresh] = blended_.try_emplace(color, -1);
    if (fresh) {
        const std::array<double, 3> wide{color[0], color[1], color[2]};
        known->second = mesh_.add_value(*color_, wide.data());
        constexpr int64_t kNode = 64;
        bytes_ += kNode;
    }
    return known->second;
}

int32_t ThreemfLooks::look_of(const Kind& kind, const std::string& name) {
    const auto [known, fresh] = kinds_.try_emplace(kind, kNew);
    if (!fresh) return known->second;
    Look look;
    if (kind.material >= 0) {
        look = mesh_.looks()[static_cast<size_t>(kind.material)];
        // Those of the corners have it in them.
        if (kind.vertex_colors) look.color.reset();
    } else {
        look.name = name;
        look.is_material = false;
    }
    look.vertex_colors = kind.vertex_colors;
    if (kind.under) look.color = {(*kind.under)[0], (*kind.under)[1], (*kind.under)[2]};
    if (kind.picture >= 0) {
        look.picture = pictures_[static_cast<size_t>(kind.picture)];
        look.picture->alpha = kind.alpha;
        look.tinted = kind.tinted;
    }
    return known->second = add(std::move(look));
}

int32_t ThreemfLooks::add(Look look) {
    // The list doubles and is copied then; a map holds the name again.
    constexpr size_t kNode = 200;
    const size_t bytes = sizeof look + look.name.size() +
                         look.mixture.size() * sizeof look.mixture[0] +
                         (look.picture ? 2 * look.picture->source.size() : 0);
    bytes_ += static_cast<int64_t>(3 * bytes + kNode);
    mesh_.looks().push_back(std::move(look));
    return static_cast<int32_t>(mesh_.looks().size() - 1);
}

void ThreemfLooks::miss(const ThreemfPart& part, int64_t id) {
    if (!missing_.emplace(part.name, id).second) return;
    told_.add(messages::kPropertiesNotDefined, place_of(part, id),
              messages::kPropertiesNotDefinedHelp);
}

}  // namespace openfab::mesh
