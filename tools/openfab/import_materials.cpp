// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/color.h"
#include "base/json_text.h"

namespace openfab::tools {

namespace {

std::string hex(const std::array<int, 3>& key) {
    return fmt::format("#{:02x}{:02x}{:02x}", key[0], key[1], key[2]);
}

}  // namespace

ImportMaterials::Key ImportMaterials::free_key(Key key) {
    while (std::find(keys_.begin(), keys_.end(), key) != keys_.end()) {
        for (size_t c = 3; c-- > 0;) {
            key[c] = (key[c] + 1) % 256;
            if (key[c] != 0) break;
        }
    }
    keys_.push_back(key);
    return key;
}

std::string ImportMaterials::add(const std::string& name, const LinearColor& linear, double alpha,
                                 bool in_white) {
    Key key{};
    for (size_t c = 0; c < 3; ++c)
        key[c] = linear_to_srgb8(linear[c]);
    // Pictures have a white ground, on which white would not show.
    constexpr Key kPaper{255, 255, 255}, kOffWhite{244, 242, 236};
    std::string unique = names_.unique(name == "VOID" ? "void" : name);
    const auto opacity = static_cast<int>(std::lround(255 * std::clamp(alpha, 0.0, 1.0)));
    lines_.push_back(fmt::format("{}: {{\"key\": \"{}\", \"preview\": \"{}{:02x}\"}}",
                                 json_string(unique), hex(free_key(key)),
                                 hex(in_white || key == kPaper ? kOffWhite : key), opacity));
    return unique;
}

void ImportMaterials::add_inks() {
    if (has_inks_) return;
    has_inks_ = true;
    of("ink cyan", "cyan", {0, 0.3, 0.8});
    of("ink magenta", "magenta", {0.75, 0, 0.2});
    of("ink yellow", "yellow", {1, 0.8, 0});
    of("ink black", "black", {0, 0, 0});
    of("white", "white", {1, 1, 1});
}

std::string ImportMaterials::of(const std::string& what, const std::string& name,
                                const LinearColor& color) {
    const auto [known, fresh] = of_.try_emplace(what);
    if (fresh) known->second = add(name, color, 1);
    return known->second;
}

std::string ImportMaterials::of_look(int32_t look) {
    const auto [known, fresh] = of_look_.try_emplace(look);
    if (!fresh) return known->second;
    const mesh::Look& of = looks_[static_cast<size_t>(look)];
    const std::string name = of.name.empty() ? "material" : of.name;
    return known->second = of.color ? add(name, *of.color, of.alpha) : grey(name);
}

std::string ImportMaterials::grey(const std::string& name) {
    // White first, then darker ones that are told apart.
    constexpr int kSteps = 8;
    const double share = static_cast<double>(greys_++ % kSteps) / kSteps;
    const double grey = 1 - 0.8 * share;
    return add(name, {grey, grey, grey}, 1, one_white_);
}

}  // namespace openfab::tools
