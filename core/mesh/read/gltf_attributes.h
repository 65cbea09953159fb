// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Attributes of glTF by the names that they have here.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"

namespace openfab::mesh {

constexpr std::string_view kGltfTexture = "TEXCOORD_";
constexpr std::string_view kGltfColours = "COLOR_";

/// An attribute of ours that is made of one of the file's.
struct GltfTarget {
    std::string name;
    bool at_picture = false;  ///< coordinates of the primitive's picture
};

/// Returns what an attribute of a primitive becomes, whose picture is at TEXCOORD_`picture`; empty
/// for those that are not kept.
std::vector<GltfTarget> gltf_targets(const JsonValue& attributes, const std::string& key,
                                     int64_t picture);

}  // namespace openfab::mesh
