// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of uniforms as a world, or a --set, writes them.

#include <string>

#include "base/json.h"
#include "base/result.h"
#include "world/json_reader.h"
#include "world/world.h"

namespace openfab::scene {

/// A uniform's value; `what` names it in the error, which starts with a place in place.file.
Result<UniformBinding> uniform_binding(const JsonValue& value, const SourceLocation& place,
                                       const std::string& what);

/// An object of them, by name; `what` is whose they are.
UniformBindings read_uniforms(const JsonValue& value, const std::string& what, JsonReader* json);

}  // namespace openfab::scene
