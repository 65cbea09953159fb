// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads values of uniforms from a world or a --set.

#include <string>

#include "base/json.h"
#include "base/result.h"
#include "world/json_reader.h"
#include "world/world.h"

namespace openfab::world {

/// Reads a uniform's value; `what` names it in errors, which start with a location in
/// location.file.
Result<UniformBinding> uniform_binding(const JsonValue& value, const SourceLocation& location,
                                       const std::string& what);

/// Reads an object of uniforms by name; `what` names their owner in errors.
UniformBindings read_uniforms(const JsonValue& value, const std::string& what, JsonReader* json);

}  // namespace openfab::world
