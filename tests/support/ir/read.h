// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads the text that ir::dump writes, for tests that start from IR written by hand.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/ir/ir.h"

namespace openfab::ir {

/// Reads the fablet that `dump` wrote, all but its spans, which the text does not hold; or stages
/// alone, each of any kind, which are the fablet's surface or volume. Empty lines and lines that
/// start with `#` are skipped. On a fault: empty, and `fault` says `line N: what`.
std::optional<Fablet> read(std::string_view text, std::string* fault);

/// Returns the input or output kind of this name (kind_name in compiler/ir/text.h).
std::optional<int32_t> kind_from_name(std::string_view name);

}  // namespace openfab::ir
