// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers of materials that were measured at several temperatures and rates of loading: soft resins are several times as
// stiff when they are cold, or loaded quickly.

#include <optional>
#include <string>

#include "base/json.h"
#include "base/result.h"

namespace openfab {

/// Temperature in degrees Celsius, and rate in 1/s: one over the time in which a load is applied, 2 pi f of an oscillation.
struct Conditions {
    std::optional<double> temperature_C, rate_1_s;
};

/// Parses `23C`. A bare number is an error.
Result<double> parse_temperature(const std::string& text);
/// Parses `0.01/s`, `10Hz` (2 pi times as much), or the time of a load, `100s`.
Result<double> parse_rate(const std::string& text);

/// Parses both, of which any may be empty.
Result<Conditions> parse_conditions(const std::string& temperature, const std::string& rate);

struct ConditionedNumber {
    double value = 0;
    bool is_conditioned = false;  ///< the file says at which temperature and rate
};

/// Reads a number above 0, or a list of `{"T_C": 23, "rate_1_s": 0.01, "value": 1.2}`. Of a list, logarithms of values are
/// linear in the logarithm of the rate and in the temperature; nothing is extrapolated, and what was measured at one
/// temperature, or one rate, needs none to be asked. Errors have the place in `file`; `name` is what the number is of.
Result<ConditionedNumber> number_at(const JsonValue& value, const std::string& name,
                                    const Conditions& asked, const std::string& file);

}  // namespace openfab
