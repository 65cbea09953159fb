// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Members of the nodes of a @Grow, as attributes.

#include <string_view>

#include "abi/grow_table.h"

namespace openfab::part {

/// Returns whether a member has a value for each end of its beam: an array of two floats or vectors.
inline bool has_two_ends(const openfab_varying& member) {
    return member.scalar == OPENFAB_FLOAT && std::string_view(member.type_name).ends_with("[2]");
}

}  // namespace openfab::part
