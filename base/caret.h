// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How an Error is shown to a person: with the source line and a caret where it has a place in a
// text file.

#include <string>

#include "base/result.h"

namespace openfab {

/// For an error at a line of a file that can be read:
///
///     world.fab.json:7:9: error: unknown key `scael`
///      7 |         "scael": 2
///        |         ^~~~~~~
///     help: did you mean `scale`?
///
/// Any other becomes `error: message; help`. Ends with a line feed.
std::string render_error(const Error& error);

}  // namespace openfab
