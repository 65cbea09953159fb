// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads the text that ir::print writes, for tests of passes and of lowering that start from
// hand-written IR.

#include <optional>
#include <string>
#include <string_view>

#include "compiler/ir/ir.h"

namespace openfab::ir {

/// Reads the fablet that `print` wrote, all but its spans, which the text does not hold. Empty
/// lines and lines that start with `#` are skipped. On a fault: empty, and `fault` says
/// `line N: what`.
std::optional<Fablet> read(std::string_view text, std::string* fault);

}  // namespace openfab::ir
