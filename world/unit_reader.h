// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Units of length that a world names where a file does not say its own.

#include <string>
#include <vector>

#include "base/json.h"
#include "world/json_reader.h"

namespace openfab::world {

inline const std::vector<std::string> kUnits = {"mm", "cm", "m", "um", "in"};

/// Returns the unit that `value` names, the `unit` of `what`, in mm.
inline double read_unit_mm(const JsonValue& value, const std::string& what, JsonReader* json) {
    static constexpr double kSizes[] = {1, 10, 1000, 0.001, 25.4};
    return kSizes[json->choice(value, "`unit` of " + what, kUnits)];
}

}  // namespace openfab::world
