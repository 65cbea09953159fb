// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Clumps that a program of the user's makes, by lines (docs/how-to/programs.md has them).

#include <memory>

#include "abi/fablet_table.h"
#include "runtime/part/program_stage.h"
#include "runtime/solid/grow/clump.h"
#include "runtime/solid/kind.h"
#include "runtime/surface/surface.h"

namespace openfab::solid {

/// As make_rule_source.
std::unique_ptr<const ClumpSource> make_program_source(const part::GrownGeometry& of,
                                                       const openfab_fablet& fablet,
                                                       const Bodies& bodies,
                                                       const surface::SurfaceOptions& options);

}  // namespace openfab::solid
