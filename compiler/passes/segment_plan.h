// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which instructions of a stage run in which segment. A region is the body of a loop, or the stage; its
// segments are straight-line code, with barriers between them: loops, queries, printfs.

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

inline bool is_barrier(ir::Op op) {
    return op == ir::Op::kLoop || op == ir::Op::kQuery || op == ir::Op::kPrintf;
}

/// The body of a loop, or the stage. Its segments 0, 1, … are straight-line code; the barriers of
/// level k come between segment k and k + 1.
struct Region {
    ir::ValueId loop = ir::kNoValue;
    size_t last = 0;                    ///< segment
    std::vector<ir::ValueId> barriers;  ///< in the order of the program
    int32_t active = 0;                 ///< state: the active lanes
};

struct SegmentPlan {
    std::map<ir::ValueId, Region> regions;  ///< by loop
    std::vector<ir::ValueId> inside;        ///< the innermost loop around each instruction
    std::vector<size_t> level;              ///< of barriers
    std::vector<size_t> segment;
    std::vector<bool> rematerialized;  ///< computed again in each segment rather than spilled
};

/// Puts barriers as early as their operands allow, and other instructions as late as their first use
/// does.
SegmentPlan plan_segments(const ir::Stage& stage);

}  // namespace openfab::passes
