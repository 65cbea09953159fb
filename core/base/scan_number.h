// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads numbers of text meshes strictly, so that a malformed number is an error and never a 0, and
// independently of the locale.

#include <cstdint>
#include <string>
#include <string_view>

namespace openfab {

enum class Decimal { kFine, kNoNumber, kTooLarge };

/// Reads the whole of `text` as the nearest double, bit for bit as strtod in the C locale; values
/// that are too small become 0 with their sign.
Decimal read_decimal(std::string_view text, double* out);

/// Reads the whole token as a number that fits a float; too small for a double reads as 0. Returns
/// what is wrong, or an empty text: "`x` is not a number", "`1e400` is not finite or too large".
std::string scan_number(std::string_view token, double* out);

/// Reads an integer from least to most, likewise.
std::string scan_integer(std::string_view token, int64_t least, int64_t most, int64_t* out);

/// Removes and returns the next word, up to a blank or the end of a line; empty at the end.
std::string_view take_word(std::string_view* text);

/// Returns whether all three fit a float, as vertices of a mesh must.
bool is_position(double x, double y, double z);

}  // namespace openfab
