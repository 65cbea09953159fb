// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of uniforms between the page, which has them as JSON, and a world.

#include <string>

#include "base/json.h"
#include "base/json_text.h"
#include "world/world.h"

namespace openfab::viewer {

/// Whether a uniform can have this value: a number, truth, name, a list of such, or a curve.
bool is_uniform_value(const JsonValue& value);

/// Writes what the world binds, as a list in any case.
void write_binding(const world::UniformBinding& binding, JsonText* out);

/// Writes a value that the page has set, as a list in any case.
void write_override(const std::string& json, JsonText* out);

}  // namespace openfab::viewer
