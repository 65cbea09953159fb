// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tables of mixtures whose property was measured, JSON, as modules of OpenFL for `import property`:
//
//   {"property": "tensile modulus", "unit": "MPa", "materials": ["soft", "rigid"],
//    "measured": true, "source": "who measured it, where, by which standard",
//    "rows": [{"mixture": [1, 0], "value": 0.6}, {"mixture": [0.5, 0.5], "value": 30}, ...]}
//
// A value may be a list of what was measured at temperatures and rates (base/conditions.h); `deviation` and `count` of a row
// are those of its specimens.

#include <string>
#include <string_view>

#include "base/conditions.h"
#include "base/json.h"
#include "base/result.h"

namespace openfab::tools {

/// Returns the module of the table `text` of the file `file`, whose name without its extension names
/// the module's constants. Errors are located in the file: what is missing; mixtures whose fractions
/// are not 0 ... 1 with a sum of 1; values that neither rise nor fall from row to row, which no
/// request could be found in.
Result<std::string> property_module(std::string_view text, const std::string& file,
                                    const Conditions& asked = {});

/// The same of a table with a `parameter`, a uniform, in place of materials: a function that gives the
/// parameter of a value. `property_module` calls it.
Result<std::string> sweep_module(const JsonValue& table, const std::string& file);

}  // namespace openfab::tools
