// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How long a stage is for who compiles it. Where loops write arrays, each access is, in the stage, a
// choice among all elements; of that the runtime makes steps, and the kernels of the segments are what
// is left to compile (cut_elements). So a long stage is judged by its segments.

#include <cstddef>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Returns how many operations of a stage are compiled, and, where they are more than `most`, where it
/// gets so long; nowhere if that is not known.
struct CompiledOperations {
    size_t count = 0;
    source::Span beyond;
};
CompiledOperations compiled_operations(const ir::Stage& stage, size_t most);

}  // namespace openfab::passes
