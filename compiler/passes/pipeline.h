// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The middle of the compiler: from the IR that the front end makes to one stage per kernel.
// pipeline.cpp has the table of passes, in order. Those that are optional can be switched off, and
// no output changes by a bit; the others complete the meaning of a stage, or there is no code
// without them.

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/passes/cut_phases.h"

namespace openfab::passes {

struct PipelineOptions {
    std::set<std::string> disabled;  ///< names of optional passes
    /// Operations of an interval form. It is several times as long as its stage, and compiling
    /// takes some milliseconds for each; beyond this nothing is culled and the output is the same.
    size_t longest_bounds = 2000;
    /// Told after each pass and stage, with the stage as it then is.
    std::function<void(const std::string& pass, const ir::Stage& stage)> after;
};

/// One stage per kernel. A stage with no outputs stands for no kernel: no @Surface, or an
/// optional kernel whose pass is switched off.
struct KernelStages {
    ir::Stage
        surface;  ///< outputs POSITION x, y, z (displaced, clamped), SURFACE_OUT, SURFACE_STATUS
    ir::Stage surface_bounds;  ///< outputs DISPLACEMENT_LO/HI, SURFACE_OUT_LO/HI
    ir::Stage volume;          ///< outputs WEIGHT
    ir::Stage volume_bounds;   ///< outputs WEIGHT_LO/HI
    ir::Stage volume_demand;   ///< output DEMAND; none where every voxel asks
    ir::Stage derived;  ///< outputs DERIVED: uniforms that the others read beside the fablet's
    /// Where a stage must be cut: what is compiled in its place. No steps otherwise.
    PhasedStage surface_phases;
    PhasedStage volume_phases;

    /// The stage of one kernel; not of phases.
    const ir::Stage& of(ir::StageKind kind) const;
};

struct PassTime {
    std::string pass;
    double seconds = 0;
};

/// Of a stage once functions are written out and look-ups have footprints: compiling takes one or
/// two milliseconds for each.
constexpr size_t kMostOperations = 24000;

struct PipelineResult {
    KernelStages stages;
    size_t longest = 0;  ///< operations of the longer stage; above kMostOperations it is not done
    std::vector<PassTime> times;
    std::string fault;  ///< a bug of ours: what ir::verify found, and after which pass; else empty
};

/// All passes in order, and whether one can be switched off.
struct PassName {
    const char* name;
    bool optional;
};
const std::vector<PassName>& pass_names();

PipelineResult run_pipeline(const ir::Fablet& fablet, const PipelineOptions& options = {});

}  // namespace openfab::passes
