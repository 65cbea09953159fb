// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// "did you mean": the one known name that a misspelt one is close to.

#include <string>
#include <string_view>
#include <vector>

namespace openfab {

/// The candidate within a third of the name's length (at least one edit; a swap of neighbours
/// counts as one), if exactly one is nearest; else empty.
std::string near_miss(std::string_view name, const std::vector<std::string>& candidates);

/// The end of a message about an unknown name: "did you mean `x`?", else "known: `x`, `y`" (at most
/// 12), else "there are none".
std::string suggest(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace openfab
