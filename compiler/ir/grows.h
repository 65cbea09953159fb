// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::ir {

/// Returns whether the solid of a fablet is a @Grow: Fablet::shape then has the members of a node as outputs,
/// OPENFAB_ARG_SHAPE_OUT, and no value, and shape_outputs are these members.
inline bool grows(const Fablet& fablet) {
    return fablet.has_shape && fablet.shape.kind == StageKind::kShapeAttributes;
}

}  // namespace openfab::ir
