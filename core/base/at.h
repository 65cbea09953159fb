// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Items by signed indices, which builds for tests check.

#include <cstddef>
#include <utility>

#include "base/check.h"

namespace openfab {

/// Returns the item of a vector, an array or a span at an index of any whole type; one that is outside is our bug.
template <typename Items, typename Index>
constexpr decltype(auto) at(Items&& items, Index index) {
    OPENFAB_DCHECK(std::cmp_greater_equal(index, 0) && std::cmp_less(index, std::size(items)));
    return items[static_cast<size_t>(index)];
}

}  // namespace openfab
