// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/gltf_attributes.h"

#include <fmt/format.h>

#include "base/text.h"

namespace openfab::mesh {

std::vector<GltfTarget> gltf_targets(const JsonValue& attributes, const std::string& key,
                                     int64_t picture) {
    if (key == "NORMAL") return {{"n"}};
    if (key == "COLOR_0") return {{"color"}};
    if (key.starts_with(kGltfTexture)) {
        const std::string number = key.substr(kGltfTexture.size());
        const bool is_number = !number.empty() && number.size() <= 3 &&
                               number.find_first_not_of("0123456789") == std::string::npos;
        if (!is_number) return {};
        if (number == std::to_string(picture) && picture == 0) return {{"uv", true}};
        if (number == std::to_string(picture)) return {{"uv", true}, {"uv" + number}};
        return {{"uv" + number}};
    }
    if (!key.starts_with('_') || key.size() == 1) return {};
    const std::string name = lower_ascii(key.substr(1));
    // Where the primitive has the format's own attribute of that name, it is that.
    const std::string number = name.starts_with("uv") ? name.substr(2) : "";
    const std::string own = name == "n"       ? "NORMAL"
                            : name == "color" ? "COLOR_0"
                            : name == "uv"    ? fmt::format("{}{}", kGltfTexture, picture)
                            : number.empty()  ? ""
                                              : fmt::format("{}{}", kGltfTexture, number);
    if (attributes.find(own) != nullptr) return {};
    return {{name}};
}

}  // namespace openfab::mesh
