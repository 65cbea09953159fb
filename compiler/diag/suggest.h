// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace openfab::diag {

/// The candidate nearest to `word`, where it is near (case apart, at most a third of the letters
/// differ; a swap of neighbours counts as one) and no other is as near; else empty.
std::string suggest(std::string_view word, std::span<const std::string> candidates);

}  // namespace openfab::diag
