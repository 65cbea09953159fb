// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Texts of options that have a form of their own, as front ends get them. What they say is read here; whether it
// makes sense is up to validate_options.

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::program {

/// Makes the error of an option's value: what it is, and what could stand there.
Error bad_value(std::string_view option, std::string_view text, std::string_view what,
                std::string_view example);

/// A length with its unit, in mm.
Result<double> parse_length(std::string_view option, const std::string& text);
/// `X`, or `XxY`.
Result<Vec2<double>> parse_dpi(const std::string& text);
/// `A:B`, two lengths.
Result<Vec2<double>> parse_heights(const std::string& text);
/// `A:B`, two numbers; `A:` to the end (pipeline::kToTheEnd), `:B` from the first.
Result<Vec2<int32_t>> parse_slices(const std::string& text);
/// `I/N`
Result<Vec2<int32_t>> parse_part(const std::string& text);
/// `X,Y,Z`
Result<Vec3d> parse_vector(std::string_view option, const std::string& text,
                           std::string_view example);
/// A whole number, and nothing else.
bool parse_whole(std::string_view text, int32_t* value);
bool parse_whole(std::string_view text, uint64_t* value);

}  // namespace openfab::program
