// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A stage with loops, queries or prints, or one that is too long for one kernel, as a program over
// groups of 8 places: straight-line kernels and the steps between them, as openfab_phases in
// abi/fablet_table.h describes. What one kernel computes and another needs is state, unless
// it is cheaper to compute it twice.

#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/passes/split_kernel.h"

namespace openfab::passes {

struct PhaseQuery {
    int32_t object = -1;
    int32_t guard = 0;
    std::array<int32_t, 3> point{};
    std::vector<openfab_query_output> outputs;
};

struct PhasePrint {
    ir::Print print;
    int32_t guard = 0;
    std::vector<int32_t> values;
    std::vector<ir::Type> types;
};

struct PhasedStage {
    /// Of kind kSurfacePhase or kVolumePhase. Inputs beside those of the stage: OPENFAB_ARG_STATE;
    /// outputs: OPENFAB_ARG_STATE_OUT, and of the last kernel those of the stage.
    std::vector<ir::Stage> kernels;
    std::vector<openfab_step> steps;
    std::vector<PhaseQuery> queries;
    std::vector<PhasePrint> prints;
    std::vector<ir::Type> states;  ///< state 0 is the runtime's: the places that are asked for
};

/// True where the stage must be cut; a kernel has at most `longest` operations.
bool needs_phases(const ir::Stage& stage, size_t longest = kLongestKernel);

/// `stage` is a surface or volume stage that passes ir::verify, with nothing dead in it.
PhasedStage cut_phases(const ir::Stage& stage, size_t longest = kLongestKernel);

}  // namespace openfab::passes
