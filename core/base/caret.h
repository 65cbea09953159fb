// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Renders an Error for a person: with the source line and a caret where it has a location in a text
// file.

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab {

/// Formats a source line and, below it, a caret at `column`, which counts code points from 1, with
/// a tail of `length - 1`. `line` must be printable; `length` is at least 1.
///
///      7 |         "scael": 2
///        |         ^~~~~~~
std::string caret_lines(std::string_view line, int64_t number, size_t column, size_t length);

/// Renders an error at a line of a readable file as
///
///     world.fab.json:7:9: error: unknown key `scael`
///      7 |         "scael": 2
///        |         ^~~~~~~
///     help: did you mean `scale`?
///
/// Any other becomes `error: message; help`. Ends with a line feed.
std::string render_error(const Error& error);

}  // namespace openfab
