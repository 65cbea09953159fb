// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Members of the nodes of a @Grow, as attributes.

#include <algorithm>
#include <string_view>

#include "abi/grow_table.h"

namespace openfab::part {

/// Returns whether a member has a value for each end of its beam: an array of two floats or vectors.
inline bool has_two_ends(const openfab_varying& member) {
    return member.scalar == OPENFAB_FLOAT && std::string_view(member.type_name).ends_with("[2]");
}

/// Returns whether nodes may place objects: they have a member that says which.
inline bool places_objects(const openfab_shape& shape) {
    return openfab_grows(&shape) != 0 &&
           std::any_of(
               shape.outputs, shape.outputs + shape.output_count,
               [](const openfab_varying& m) { return std::string_view(m.name) == "object"; });
}

}  // namespace openfab::part
