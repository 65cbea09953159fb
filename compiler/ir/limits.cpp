// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <limits>
#include <string_view>

#include "compiler/ir/ir.h"

namespace openfab::ir {

std::optional<std::array<double, 2>> limits(const Uniform& uniform) {
    const bool numbers =
        uniform.kind == OPENFAB_UNIFORM_VALUE || uniform.kind == OPENFAB_UNIFORM_CURVE;
    if (!numbers || uniform.type == Type::kBool) return std::nullopt;
    constexpr double kMax = std::numeric_limits<double>::max();
    std::array<double, 2> out{-kMax, kMax};
    bool any = false;
    for (const auto& [name, text] : uniform.annotations) {
        double value = 0;
        const auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), value);
        // Only a suffix may follow the number; other annotations are for tools.
        const std::string_view suffix(rest, static_cast<size_t>(text.data() + text.size() - rest));
        const bool number = status == std::errc() &&
                            (suffix.empty() || suffix == "f" || suffix == "F" || suffix == "u");
        if (!number || (name != "min" && name != "max")) continue;
        out[name == "min" ? 0 : 1] = value;
        any = true;
    }
    return any ? std::optional(out) : std::nullopt;
}

}  // namespace openfab::ir
