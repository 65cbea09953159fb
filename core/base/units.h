// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parses and formats quantities as users type them: "27um", "0.1mm", "3mm:5mm", "1.5GB", "600x300".

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab {

/// The default of `--memory`, for every program that has the option.
constexpr int64_t kDefaultMemoryBytes = 1'500'000'000;

/// Parses a length with its unit (um, mm, cm, m, in) into millimetres. A bare number is an error.
Result<double> parse_length_mm(std::string_view text);
/// Parses a size in bytes: B, kB, MB, GB (powers of 1000), KiB, MiB, GiB.
Result<int64_t> parse_bytes(std::string_view text);
/// Parses the text of `--memory`; empty: the default.
Result<int64_t> parse_memory_option(const std::string& text);
/// Parses a duration in seconds: ms, s, min or m, h.
Result<double> parse_duration(std::string_view text);
/// Formats a size: "1.5 GB", "300 MB", "12 kB".
std::string format_bytes(int64_t bytes);
/// Formats a duration: "2 h 05 min", "3 min 20 s", "4.2 s".
std::string format_seconds(double seconds);

}  // namespace openfab
