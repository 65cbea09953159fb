// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cuts a stage with loops, queries or printfs, or one too long for one kernel, into segments: a
// program over groups of 8 lanes, of straight-line kernels and the steps between them, see
// openfab_segments in abi/fablet_table.h. Values that cross segments are spilled to state, or
// rematerialized if that is cheaper. The last segment of a volume stage is part of the slab kernel.

#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/passes/split_kernel.h"

namespace openfab::passes {

struct SegmentQuery {
    int32_t object = -1;
    int32_t guard = 0;
    std::array<int32_t, 3> point{};
    int32_t stop = -1;  ///< of a walk, as in openfab_query
    int32_t seed = -1;
    std::vector<openfab_query_output> outputs;
};

struct SegmentPrintf {
    ir::Printf call;
    int32_t guard = 0;
    std::vector<int32_t> values;
    std::vector<ir::Type> types;
};

struct SegmentedStage {
    /// Kernels of kind kSurfaceSegment or kVolumeSegment. Inputs: those of the stage, and
    /// OPENFAB_ARG_STATE; outputs: OPENFAB_ARG_STATE_OUT, and of a surface stage in the last kernels
    /// those of the stage.
    std::vector<ir::Stage> kernels;
    std::vector<openfab_step> steps;
    std::vector<SegmentQuery> queries;
    std::vector<SegmentPrintf> printfs;
    std::vector<openfab_elements> elements;
    std::vector<ir::Type> states;  ///< state 0 is the runtime's: the active lanes
    /// Of a volume stage, of that kind: its last segment, which comes after the steps. Reads the
    /// inputs of the stage and OPENFAB_ARG_STATE, and has the outputs of the stage. Without outputs
    /// where amounts are in states.
    ir::Stage last;
};

/// True if the stage must be cut; a kernel has at most `longest` operations.
bool needs_segments(const ir::Stage& stage, size_t longest = kMaxKernelOperations);

/// Where a volume stage has its amounts.
enum class Amounts {
    kLast,   ///< in SegmentedStage::last
    kStates  ///< in states, that of slot k in k + 1; then no segment is kept apart
};

/// Cuts a surface or volume stage that passes ir::verify and has no dead values.
SegmentedStage cut_segments(const ir::Stage& stage, size_t longest = kMaxSegmentOperations,
                            Amounts amounts = Amounts::kLast);

}  // namespace openfab::passes
