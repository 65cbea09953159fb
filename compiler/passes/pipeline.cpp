// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/pipeline.h"

#include <algorithm>
#include <chrono>

#include "compiler/passes/attach_footprints.h"
#include "compiler/passes/bound_displacement.h"
#include "compiler/passes/cut_phases.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/eliminate_dead_values.h"
#include "compiler/passes/expand_functions.h"
#include "compiler/passes/form_demand.h"
#include "compiler/passes/form_surface_bounds.h"
#include "compiler/passes/form_volume_bounds.h"
#include "compiler/passes/hoist_invariants.h"
#include "compiler/passes/hoist_uniforms.h"
#include "compiler/passes/simplify.h"
#include "compiler/passes/split_kernel.h"

namespace openfab::passes {

namespace {

class Runner {
  public:
    Runner(const PipelineOptions& options, PipelineResult* result)
        : options_(options), result_(result) {}

    const PipelineOptions& options() const { return options_; }
    bool enabled(const char* pass) const { return !options_.disabled.contains(pass); }

    template <typename Pass>
    void run(const char* name, ir::Stage* stage, Pass&& pass) {
        if (!enabled(name) || !result_->fault.empty()) return;
        const auto begin = std::chrono::steady_clock::now();
        pass(stage);
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
        add_time(name, spent.count());
        const std::string fault = ir::verify(*stage);
        if (!fault.empty()) result_->fault = std::string("after ") + name + ": " + fault;
        if (options_.after) options_.after(name, *stage);
    }

    void cut(const ir::Stage& stage, PhasedStage* out) {
        if (!needs_phases(stage)) return;
        ir::Stage copy = stage;
        ir::drop_dead_values(&copy);
        const auto begin = std::chrono::steady_clock::now();
        *out = cut_phases(copy);
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
        add_time("cut_phases", spent.count());
        for (ir::Stage& kernel : out->kernels) {
            run("cut_phases", &kernel, [](ir::Stage* /*stage*/) {});
            clean(&kernel);
        }
    }

    void clean(ir::Stage* stage) {
        run("simplify", stage, simplify);
        run("eliminate_common_values", stage, eliminate_common_values);
        run("eliminate_dead_values", stage, eliminate_dead_values);
    }

    /// After all that asks what a function is; before hoisting, which may move parts of one.
    void write_out(ir::Stage* stage) {
        const bool any =
            std::any_of(stage->instrs.begin(), stage->instrs.end(),
                        [](const ir::Instr& instr) { return ir::is_function(instr.op); });
        run("expand_functions", stage, expand_functions);
        if (any) clean(stage);
    }

  private:
    void add_time(const char* name, double seconds) {
        for (PassTime& time : result_->times) {
            if (time.pass == name) {
                time.seconds += seconds;
                return;
            }
        }
        result_->times.push_back({name, seconds});
    }

    const PipelineOptions& options_;
    PipelineResult* result_;
};

/// A query takes about 0.1 us (docs/measurements). So many operations, on eight voxels at once, stay
/// below that; more of them would be felt, in compiling first.
constexpr size_t kMostDemand = 400;
// An interval form has two outputs for each material.
constexpr size_t kMostBoundsOutputs = 192;

void drop_above(size_t most, ir::Stage* stage) {
    if (kernel_operations(*stage) <= most && stage->outputs.size() <= kMostBoundsOutputs) return;
    stage->instrs.clear();
    stage->outputs.clear();
}

}  // namespace

const std::vector<PassName>& pass_names() {
    static const std::vector<PassName> names = {
        {"simplify", true},
        {"eliminate_common_values", true},
        {"eliminate_dead_values", true},
        {"attach_footprints", false},
        {"form_surface_bounds", true},
        {"form_volume_bounds", true},
        {"form_demand", true},
        {"bound_displacement", false},
        {"expand_functions", false},
        {"hoist_invariants", true},
        {"hoist_uniforms", true},
        {"cut_phases", false},
    };
    return names;
}

namespace {

void run_volume(const ir::Fablet& fablet, Runner& runner, KernelStages* stages) {
    stages->volume = fablet.volume;
    runner.clean(&stages->volume);
    runner.run("attach_footprints", &stages->volume, attach_footprints);
    runner.clean(&stages->volume);
    // After the footprints: the interval of a look-up depends on how widely it filters.
    // A block that is filled at once would not print.
    if (stages->volume.prints.empty()) {
        runner.run("form_volume_bounds", &stages->volume_bounds,
                   [&](ir::Stage* out) { *out = form_volume_bounds(stages->volume); });
    }
    runner.clean(&stages->volume_bounds);
    runner.write_out(&stages->volume_bounds);
    drop_above(runner.options().longest_bounds, &stages->volume_bounds);
    // After the footprints, which use the nearest inputs too.
    runner.run("form_demand", &stages->volume_demand,
               [&](ir::Stage* out) { *out = form_demand(stages->volume); });
    if (!stages->volume_demand.outputs.empty()) {
        runner.clean(&stages->volume_demand);
        runner.write_out(&stages->volume_demand);
        drop_above(kMostDemand, &stages->volume_demand);
    }
    // Before functions are written out: a function moves as a whole or stays.
    runner.run("hoist_invariants", &stages->volume, hoist_invariants);
    runner.write_out(&stages->volume);
}

void run_surface(const ir::Fablet& fablet, Runner& runner, KernelStages* stages) {
    stages->surface = fablet.surface;
    runner.clean(&stages->surface);
    runner.run("attach_footprints", &stages->surface, attach_footprints);
    runner.clean(&stages->surface);
    // Before bound_displacement, whose quotients have no useful interval: the pass knows their
    // effect.
    runner.run("form_surface_bounds", &stages->surface_bounds,
               [&](ir::Stage* out) { *out = form_surface_bounds(stages->surface); });
    runner.clean(&stages->surface_bounds);
    runner.write_out(&stages->surface_bounds);
    drop_above(runner.options().longest_bounds, &stages->surface_bounds);
    runner.run("bound_displacement", &stages->surface, bound_displacement);
    runner.clean(&stages->surface);
    // Before functions are written out: a function moves as a whole or stays.
    runner.run("hoist_invariants", &stages->surface, hoist_invariants);
    runner.write_out(&stages->surface);
}

/// Last: parts of functions move too.
void run_derived(const ir::Fablet& fablet, Runner& runner, KernelStages* stages) {
    UniformHoister hoister(fablet.uniform_value_count);
    for (ir::Stage* stage : {&stages->volume, &stages->volume_bounds, &stages->volume_demand,
                             &stages->surface, &stages->surface_bounds}) {
        const UniformHoister before = hoister;
        const ir::Stage whole = *stage;
        runner.run("hoist_uniforms", stage, [&](ir::Stage* of) { hoister.hoist(of); });
        // One kernel computes all that is derived, and no pieces of it can.
        if (needs_splitting(hoister.derived())) {
            hoister = before;
            *stage = whole;
        }
        runner.run("eliminate_dead_values", stage, eliminate_dead_values);
    }
    stages->derived = hoister.derived();
}

}  // namespace

PipelineResult run_pipeline(const ir::Fablet& fablet, const PipelineOptions& options) {
    PipelineResult result;
    KernelStages& stages = result.stages;
    Runner runner(options, &result);
    stages.surface_bounds.kind = ir::StageKind::kSurfaceBounds;
    stages.volume_bounds.kind = ir::StageKind::kVolumeBounds;
    stages.volume_demand.kind = ir::StageKind::kVolumeDemand;
    stages.surface.kind = ir::StageKind::kSurface;
    run_volume(fablet, runner, &stages);
    if (fablet.has_surface) run_surface(fablet, runner, &stages);
    result.longest = std::max(kernel_operations(stages.volume), kernel_operations(stages.surface));
    if (result.longest > kMostOperations) return result;
    run_derived(fablet, runner, &stages);
    runner.cut(stages.volume, &stages.volume_phases);
    if (fablet.has_surface) runner.cut(stages.surface, &stages.surface_phases);
    return result;
}

}  // namespace openfab::passes
