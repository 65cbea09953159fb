// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// "did you mean": the one known name that a misspelt one is close to.

#include <span>
#include <string>
#include <string_view>

namespace openfab {

/// Returns the candidate within an edit distance of a third of the name's length, if no other is as
/// near; else empty. Case is ignored, and a swap of neighbours is one edit. A name of two letters
/// may have one edit, a single letter none.
std::string near_miss(std::string_view name, std::span<const std::string> candidates);

/// Returns the end of a message about an unknown name: "did you mean `x`?", else "known: `x`, `y`"
/// (at most 12), else "there are none".
std::string suggest(std::string_view name, std::span<const std::string> candidates);

}  // namespace openfab
