// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/ply_looks.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "mesh/read/beside_files.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

/// The picture of faces, by a property that programs call differently.
const MeshAttribute* picture_numbers(const Mesh& mesh) {
    for (const char* name : {"texnumber", "texture_number", "tex_number", "texid", "tex_index"}) {
        const MeshAttribute* found = mesh.find(name);
        if (found != nullptr && found->is_int && found->components == 1) return found;
    }
    return nullptr;
}

bool has_all(const MeshAttribute* attribute, size_t triangle) {
    const auto& corners = attribute->corners[triangle];
    return corners[0] >= 0 && corners[1] >= 0 && corners[2] >= 0;
}

}  // namespace

void add_ply_looks(const PlyHeader& header, MeshSource* source) {
    const Mesh& mesh = source->mesh;
    const auto coordinates = [&](const char* name, int32_t components) {
        const MeshAttribute* found = mesh.find(name);
        return found != nullptr && !found->is_int && found->components == components ? found
                                                                                     : nullptr;
    };
    const MeshAttribute* uv = coordinates("uv", 2);
    const MeshAttribute* colors = coordinates("color", 3);
    const MeshAttribute* numbers = picture_numbers(mesh);
    if (uv == nullptr) {
        for (const std::string& picture : header.pictures)
            source->leave_out(fmt::format(messages::kPictureNeedsCoordinates, printable(picture)),
                              source->origin.file, messages::kPictureNeedsCoordinatesHelp);
    }
    const size_t pictures = uv != nullptr ? header.pictures.size() : 0;
    if (pictures == 0 && colors == nullptr) return;
    // The look of each picture, and behind them that of faces without one; -1 if it has no faces.
    std::vector<int32_t> groups(pictures + 1, -1);
    const auto group_of = [&](size_t look) {
        if (groups[look] >= 0) return groups[look];
        FaceGroup group;
        if (look < pictures || colors != nullptr) {
            Look added;
            added.is_material = false;
            added.vertex_colors = colors != nullptr;
            if (colors != nullptr) added.color = {1, 1, 1};
            if (look < pictures) {
                PictureUse picture;
                picture.source = header.pictures[look];
                picture.name =
                    utf8_or_latin1(with_slashes(header.pictures[look]).filename().string());
                added.name = picture.name;
                added.picture = std::move(picture);
            }
            group.look = static_cast<int32_t>(source->looks.size());
            source->looks.push_back(std::move(added));
        }
        return groups[look] = source->group_index(group);
    };
    source->face_groups.reserve(mesh.triangles.size());
    int64_t unknown = 0;
    int32_t first_unknown = 0;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        size_t look = pictures;
        if (pictures > 0 && has_all(uv, t)) {
            const int32_t number = numbers != nullptr ? numbers->faces[t] : 0;
            if (number >= 0 && static_cast<size_t>(number) < pictures) {
                look = static_cast<size_t>(number);
            } else if (number >= 0 && unknown++ == 0) {
                first_unknown = static_cast<int32_t>(t);
            }
        }
        source->face_groups.push_back(group_of(look));
    }
    if (unknown > 0) {
        source->left_out.push_back({fmt::format(messages::kPictureBeyondHeader, pictures),
                                    source->origin.str(first_unknown),
                                    messages::kPictureBeyondHeaderHelp, unknown});
    }
    for (size_t i = 0; i < pictures; ++i) {
        if (groups[i] < 0) {
            source->leave_out(
                fmt::format(messages::kPictureNotUsed, printable(header.pictures[i])),
                source->origin.file,
                numbers == nullptr ? messages::kPictureNotUsedHelp : messages::kPictureCountHelp);
        }
    }
}

}  // namespace openfab::mesh
