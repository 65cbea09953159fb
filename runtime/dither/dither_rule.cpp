// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/dither/dither_rule.h"

namespace openfab::dither {

namespace {

struct Name {
    const char* name;
    DitherRule rule;
};
constexpr Name kNames[] = {{kOwnDitherName, kDefaultDither},
                           {"floyd_steinberg", DitherRule::kFloydSteinberg},
                           {"decorrelated", DitherRule::kDecorrelated},
                           {"blue_noise", DitherRule::kBlueNoise},
                           {"majority", DitherRule::kMajority}};

}  // namespace

std::optional<DitherRule> find_dither(std::string_view name) {
    for (const Name& n : kNames) {
        if (name == n.name) return n.rule;
    }
    return std::nullopt;
}

std::string dither_names() {
    std::string names;
    for (const Name& n : kNames)
        names += (names.empty() ? "" : ", ") + std::string(n.name);
    return names;
}

}  // namespace openfab::dither
