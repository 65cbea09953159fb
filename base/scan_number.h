// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers in text meshes: strict, so that a bad number is an error and never a 0, and independent
// of the locale.

#include <cstdint>
#include <string>
#include <string_view>

namespace openfab::scene {

enum class Decimal { kFine, kNoNumber, kTooLarge };

/// Reads the whole of `text` as the nearest double, to the bit what strtod gives in the C locale:
/// what is too small is 0 with its sign.
Decimal read_decimal(std::string_view text, double* out);

/// Reads the whole token as a number that fits a float; too small for a double reads as 0. Returns
/// what is wrong, empty where nothing is: "`x` is no number", "`1e400` is not finite or too large".
std::string scan_number(std::string_view token, double* out);

/// The same for a whole number from least to most.
std::string scan_integer(std::string_view token, int64_t least, int64_t most, int64_t* out);

/// Whether all three fit a float; what does not is no place in a mesh.
bool is_position(double x, double y, double z);

}  // namespace openfab::scene
