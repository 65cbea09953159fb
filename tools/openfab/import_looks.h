// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the numbers of a body's faces look like, for the stock fablets.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/load/load_mesh.h"

namespace openfab::tools {

/// The look of one number of the attribute `face`.
struct GroupLook {
    int32_t look = -1;  ///< in LoadedBodies::looks
    std::array<double, 3> tint{1, 1, 1};
    double cover = 0;  ///< how much of the material is covered by the tint
    std::optional<mesh::PictureUse> picture;
    bool own_picture = false;  ///< the one that the command line names
    bool multiply = false;
    /// The material is the look's own; else white, or what the body has.
    bool has_material = false;
    /// Shares of other looks.
    std::vector<std::pair<int32_t, double>> mixture;

    bool has_skin() const { return cover > 0 || picture || own_picture; }
};

/// How a body is made.
struct BodyLook {
    std::vector<GroupLook> groups;  ///< by number; one where all are alike
    std::string fablet;
};

/// Returns what each number of `body` looks like, as in its file.
/// `layered`: the format lays pictures over materials, as 3MF, which are seen where a picture is
/// transparent; in others a picture replaces the colour.
std::vector<GroupLook> group_looks(const mesh::LoadedBodies& loaded, const mesh::LoadedMesh& body,
                                   bool layered);

/// Gives up the skin of all groups, or makes skins of all colours.
void without_pictures(std::vector<GroupLook>* groups);
void all_skins(const std::vector<mesh::Look>& looks, std::vector<GroupLook>* groups);

}  // namespace openfab::tools
