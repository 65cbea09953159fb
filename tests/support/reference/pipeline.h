// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A plain implementation of the whole print: fablets run by the interpreter, surfaces diced one
// micro-vertex at a time, point in solid by winding number, nearest point by trying every
// micropolygon, textbook dither. Slow, small and independent of the slab loop, the voxeliser, the
// query engine, culling, and generated code. The pipeline's output must equal this bit for bit.

#include <cstdint>
#include <vector>

#include "compiler/ir/ir.h"
#include "runtime/part/part.h"

namespace openfab::reference {

struct ReferencePart {
    const part::Part* part = nullptr;
    const ir::Fablet* fablet = nullptr;  ///< what part->fablet was compiled from
};

/// Material codes of the grid: x fastest, then y, then z. `materials` is the number of the print's
/// materials, codes 1 to that; parts are in build order.
std::vector<uint8_t> print(const std::vector<ReferencePart>& parts, const part::Grid& grid,
                           int32_t materials, uint64_t seed);

}  // namespace openfab::reference
