// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a function looks like: its values over a square of 24 mm, by the interpreter.

#include <string>

#include "base/json_text.h"
#include "base/result.h"
#include "compiler/graph/palette.h"

namespace openfab::graph {

/// Writes {"side", "channels", "values"}: rows from the top, bytes from the least value, 0, to the largest, 255. A user
/// error for what cannot be shown so.
Result<void> write_picture(const std::string& signature, const std::string& module, JsonText* out);

}  // namespace openfab::graph
