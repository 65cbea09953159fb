// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Clumps that a fablet's @Grow stage makes.

#include <memory>

#include "abi/fablet_table.h"
#include "runtime/solid/grow/clump.h"
#include "runtime/solid/kind.h"

namespace openfab::part {
struct Part;
}

namespace openfab::solid {

/// `stage`: the part of Part::shape, whose mesh is the box of all; `fablet` has the @nearest inputs. Both
/// must outlive what is returned. `bodies`: of the stage, as kinds get them.
std::unique_ptr<const ClumpSource> make_rule_source(const part::ShapeStage& stage,
                                                    const openfab_fablet& fablet,
                                                    const Bodies& bodies, openfab_isa isa);

}  // namespace openfab::solid
