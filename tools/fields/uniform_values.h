// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The uniforms of a fablet that is known as text only, bound as a print binds them.

#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/part/uniforms.h"
#include "tools/fields/fablet_ir.h"
#include "world/world.h"

namespace openfab::tools {

/// As part::bind_uniforms, for an object of the world and with the bindings of one of its placements.
Result<part::BoundUniforms> bind_uniforms(const world::World& world, const FabletIr& fablet,
                                          const world::UniformBindings& bindings,
                                          const std::string& object,
                                          const SourceLocation& location);

/// As part::apply_settings: what is exported has the values that a command line sets.
Result<void> set_uniforms(const std::vector<std::string>& settings, world::World* world);

}  // namespace openfab::tools
