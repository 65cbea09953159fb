// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/obj_attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/color.h"
#include "base/own_threads.h"
#include "base/text.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

/// Brings colours from the range that they are written in to 0 … 1 of linear light.
void linearise(const std::string& file, std::vector<float>* colors, MeshSource* source) {
    float largest = 0;
    bool whole = true, outside = false;
    for (const float c : *colors) {
        if (std::isnan(c)) continue;
        largest = std::max(largest, c);
        whole = whole && c == std::floor(c);
        outside = outside || c < 0 || c > 1;
    }
    // 0 … 1 is the rule; some programs write bytes, and a few 16 bits.
    const double range = largest <= 1 || !(whole || largest > 16) ? 1
                         : largest <= 255                         ? 255
                         : largest <= 65535                       ? 65535
                                                                  : 1;
    if (range == 1 && outside) {
        source->warnings.push_back(fmt::format(messages::kColoursBeyondOne, file, largest));
    }
    constexpr size_t kPart = 1 << 16;
    on_own_threads((colors->size() + kPart - 1) / kPart, [&](size_t part) {
        float last = 0, last_linear = 0;  // neighbours are often alike
        const size_t end = std::min(colors->size(), (part + 1) * kPart);
        for (size_t i = part * kPart; i < end; ++i) {
            float& c = (*colors)[i];
            if (std::isnan(c)) continue;
            if (c != last) {
                last = c;
                const double value = static_cast<double>(c) / range;
                last_linear = static_cast<float>(srgb_to_linear(std::clamp(value, 0.0, 1.0)));
            }
            c = last_linear;
        }
    });
}

bool is_grey(const std::array<double, 3>& color) {
    return color[0] == color[1] && color[1] == color[2];
}

}  // namespace

void add_obj_colors(std::vector<float> colors, const std::string& file, MeshSource* source) {
    Mesh& mesh = source->mesh;
    if (colors.empty()) return;
    colors.resize(mesh.positions.size() * 3, NAN);
    linearise(file, &colors, source);
    const auto look_of = [&](size_t triangle) {
        return source->groups[source->face_groups[triangle]].look;
    };
    const auto is_bare = [&](int32_t v) { return std::isnan(colors[static_cast<size_t>(v) * 3]); };
    std::vector<Look>& looks = source->looks;
    std::vector<uint8_t> colored(looks.size());
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto look = static_cast<size_t>(look_of(t));
        if (colored[look] != 0) continue;
        for (const int32_t v : mesh.triangles[t]) {
            const float* c = &colors[static_cast<size_t>(v) * 3];
            // White says nothing where a material has a colour of its own.
            const bool counts =
                !is_bare(v) && (!looks[look].is_material || c[0] != 1 || c[1] != 1 || c[2] != 1);
            if (counts) colored[look] = 1;
        }
    }
    if (std::find(colored.begin(), colored.end(), 1) == colored.end()) return;
    MeshAttribute out;
    out.name = "color";
    out.components = 3;
    out.corners = mesh.triangles;
    int64_t bare = 0;
    int32_t first_bare = -1;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (colored[static_cast<size_t>(look_of(t))] == 0) {
            out.corners[t] = {-1, -1, -1};
            continue;
        }
        for (const int32_t v : mesh.triangles[t]) {
            if (!is_bare(v)) continue;
            std::fill_n(colors.begin() + static_cast<std::ptrdiff_t>(v) * 3, 3, 1.0f);
            if (bare++ == 0) first_bare = static_cast<int32_t>(t);
        }
    }
    // Of vertices that no coloured face has.
    std::replace_if(
        colors.begin(), colors.end(), [](float c) { return std::isnan(c); }, 1.0f);
    out.values = std::move(colors);
    mesh.attributes.push_back(std::move(out));
    if (bare > 0) {
        source->left_out.push_back({messages::kVerticesWithoutColour,
                                    source->origin.str(first_bare),
                                    messages::kVerticesWithoutColourHelp, bare});
    }
    for (size_t i = 0; i < looks.size(); ++i) {
        if (colored[i] == 0) continue;
        Look& look = looks[i];
        if (look.color && !look.picture && !is_grey(*look.color)) {
            source->leave_out(
                fmt::format(messages::kColourOfColouredVertices, printable(look.name)), file,
                messages::kColourOfColouredVerticesHelp);
        }
        look.color = {1, 1, 1};
        look.vertex_colors = true;
    }
}

bool move_obj_pictures(const std::vector<const MtlMaterial*>& material_of_look, int64_t most,
                       MeshSource* source) {
    const auto uv = std::find_if(source->mesh.attributes.begin(), source->mesh.attributes.end(),
                                 [](const MeshAttribute& a) { return a.name == "uv"; });
    if (uv == source->mesh.attributes.end()) return true;
    const size_t count = uv->values.size() / 2;
    for (size_t look = 0; look < material_of_look.size(); ++look) {
        const MtlMaterial* material = material_of_look[look];
        if (material == nullptr || !material->moves_picture()) continue;
        std::vector<int32_t> moved(count, -1);
        for (size_t t = 0; t < uv->corners.size(); ++t) {
            if (source->groups[source->face_groups[t]].look != static_cast<int32_t>(look)) continue;
            for (int32_t& corner : uv->corners[t]) {
                if (corner < 0) continue;
                int32_t& to = moved[corner];
                if (to < 0) {
                    if (--most < 0) return false;
                    to = static_cast<int32_t>(uv->values.size() / 2);
                    for (size_t c = 0; c < 2; ++c) {
                        const double value =
                            static_cast<double>(uv->values[static_cast<size_t>(corner) * 2 + c]);
                        uv->values.push_back(
                            static_cast<float>(value * material->scale[c] + material->offset[c]));
                    }
                }
                corner = to;
            }
        }
    }
    return true;
}

}  // namespace openfab::mesh
