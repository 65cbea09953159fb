// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which members of a @Grow stage's struct mean something to what grows.

#include <cstdint>
#include <string_view>

#include "abi/fablet_table.h"

namespace openfab::solid {

/// Where these members begin, in components; -1: there is none.
struct RuleRoles {
    int32_t end = -1, radius = -1, children = -1, reach = -1, box = -1, flat = -1;
    int32_t object = -1, axes = -1;
    bool two_radii = false;

    void take(const openfab_varying& member, int32_t first) {
        const std::string_view name = member.name;
        if (name == "end") end = first;
        if (name == "children") children = first;
        if (name == "reach") reach = first;
        if (name == "box") box = first;
        if (name == "flat") flat = first;
        if (name == "object") object = first;
        if (name == "axes") axes = first;
        if (name != "radius") return;
        radius = first;
        two_radii = member.components == 2;
    }
};

}  // namespace openfab::solid
