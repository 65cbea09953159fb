// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>

#include "compiler/ir/grows.h"
#include "compiler/passes/attach_footprints.h"
#include "compiler/passes/bound_displacement.h"
#include "compiler/passes/compiled_operations.h"
#include "compiler/passes/cut_segments.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/eliminate_dead_values.h"
#include "compiler/passes/expand_functions.h"
#include "compiler/passes/expand_picks.h"
#include "compiler/passes/form_demand.h"
#include "compiler/passes/form_shape_bounds.h"
#include "compiler/passes/form_surface_bounds.h"
#include "compiler/passes/form_tables.h"
#include "compiler/passes/form_volume_bounds.h"
#include "compiler/passes/hoist_invariants.h"
#include "compiler/passes/hoist_uniforms.h"
#include "compiler/passes/simplify.h"
#include "compiler/passes/split_kernel.h"

namespace openfab::passes {

namespace {

using ir::Stage;
using ir::StageKind;

/// A query takes about 0.1 us (docs/measurements). This many operations, on eight voxels at once,
/// take less; more would cost, first of all in compile time.
constexpr size_t kMaxDemandOperations = 400;
// An interval form has two outputs for each material.
constexpr size_t kMaxBoundsOutputs = 192;

/// One fablet on its way through the passes.
struct Work {
    const PipelineOptions& options;
    KernelStages& stages;
    UniformHoister hoister;
    int32_t uniforms;                   ///< values of the object before any pass
    std::optional<TableFormer> tables;  ///< once all derived values are known
    std::optional<LongStage>& too_long;
    size_t& dither;
    std::string reason;  ///< of the pass that runs (PipelineOptions::after)
};

/// The stages that a pass wrote; none if it had nothing to do.
using Written = std::vector<Stage*>;

template <void (*rewrite)(Stage*)>
Written rewrites(Work* /*work*/, Stage* stage) {
    rewrite(stage);
    return {stage};
}

/// Derives a stage from the volume or the surface stage, which stays unchanged.
template <Stage (*form)(const Stage&), Stage KernelStages::*kSource>
Written forms(Work* work, Stage* stage) {
    *stage = form(work->stages.*kSource);
    return {stage};
}

Written volume_bounds(Work* work, Stage* stage) {
    // A block that is filled without evaluation would skip its printfs.
    if (!work->stages.volume.printfs.empty()) {
        work->reason = "it has printfs, which a block that is filled without evaluation would skip";
        return {};
    }
    return forms<form_volume_bounds, &KernelStages::volume>(work, stage);
}

Written expand(Work* work, Stage* stage) {
    const bool any = std::any_of(stage->instrs.begin(), stage->instrs.end(),
                                 [](const ir::Instr& instr) { return ir::is_function(instr.op); });
    if (!any) {
        if (!stage->instrs.empty()) work->reason = "it calls no function";
        return {};
    }
    expand_functions(stage);
    return {stage};
}

Written drop_long(Work* work, Stage* stage) {
    const bool demand = stage->kind == StageKind::kVolumeDemand;
    const bool shape = stage->kind == StageKind::kShapeBounds;
    const size_t limit = demand  ? kMaxDemandOperations
                         : shape ? work->options.longest_shape_bounds
                                 : work->options.longest_bounds;
    const auto fits = [&] {
        return kernel_operations(*stage) <= limit && stage->outputs.size() <= kMaxBoundsOutputs;
    };
    if ((shape || stage->kind == StageKind::kVolumeBounds) && (!says_looks(*stage) || !fits()))
        drop_looks(stage);
    if (fits()) return {stage};
    work->reason = fmt::format(
        "{} operations and {} outputs, of at most {} and {}: compiling it would take longer than "
        "it saves",
        kernel_operations(*stage), stage->outputs.size(), limit, kMaxBoundsOutputs);
    stage->instrs.clear();
    stage->outputs.clear();
    return {stage};
}

Written measure(Work* work, Stage* stage) {
    if (stage->kind == StageKind::kDither) {
        work->dither = kernel_operations(*stage);
        return {};
    }
    const CompiledOperations found = compiled_operations(*stage, kMaxStageOperations);
    const size_t longest = work->too_long ? work->too_long->operations : kMaxStageOperations;
    if (found.count > longest) work->too_long = {stage->kind, found.count, found.beyond};
    return {};
}

Written uniforms(Work* work, Stage* stage) {
    const UniformHoister before = work->hoister;
    const Stage whole = *stage;
    work->hoister.hoist(stage);
    // One kernel computes all derived values; it cannot be split.
    if (needs_splitting(work->hoister.derived())) {
        work->reason = "the kernel of derived values would be too long for one";
        work->hoister = before;
        *stage = whole;
    }
    ir::drop_dead_values(stage);
    work->stages.derived = work->hoister.derived();
    return {stage};
}

Written tables(Work* work, Stage* stage) {
    Stage& derived = work->stages.derived;
    if (!work->tables)
        work->tables.emplace(work->uniforms + static_cast<int32_t>(derived.outputs.size()));
    work->tables->form(&derived);
    work->tables->form(stage);
    work->stages.table_values = work->tables->values();
    return {stage};
}

SegmentedStage KernelStages::*segments_of(StageKind kind) {
    switch (kind) {
        case StageKind::kVolume:
            return &KernelStages::volume_segments;
        case StageKind::kShape:
            return &KernelStages::shape_segments;
        case StageKind::kShapeAttributes:
            return &KernelStages::shape_attribute_segments;
        case StageKind::kSurface:
        case StageKind::kSurfaceBounds:
        case StageKind::kVolumeBounds:
        case StageKind::kSurfaceSegment:
        case StageKind::kVolumeSegment:
        case StageKind::kDerived:
        case StageKind::kVolumeDemand:
        case StageKind::kDither:
        case StageKind::kShapeBounds:
        case StageKind::kShapeSegment:
            break;  // a surface, or never cut
    }
    return &KernelStages::surface_segments;
}

Written cut(Work* work, Stage* stage) {
    const bool in_states = work->options.amounts_in_states && stage->kind == StageKind::kVolume;
    if (!in_states && !needs_segments(*stage)) {
        work->reason = "it has no loop, query or printf, and fits one kernel";
        return {};
    }
    SegmentedStage& out = work->stages.*segments_of(stage->kind);
    Stage live = *stage;
    ir::drop_dead_values(&live);
    out = cut_segments(live, kMaxSegmentOperations, in_states ? Amounts::kStates : Amounts::kLast);
    // What made it need segments may have been dead.
    if (out.steps.empty()) {
        work->reason = "what would need segments is not used";
        out = {};
        return {};
    }
    Written kernels;
    for (Stage& kernel : out.kernels)
        kernels.push_back(&kernel);
    if (!out.last.outputs.empty()) kernels.push_back(&out.last);
    return kernels;
}

/// The stages of a fablet, in the order in which passes run on them.
struct StageSlot {
    StageKind kind;
    Stage KernelStages::*stage;
};
constexpr StageSlot kStageSlots[] = {
    {StageKind::kVolume, &KernelStages::volume},
    {StageKind::kVolumeBounds, &KernelStages::volume_bounds},
    {StageKind::kVolumeDemand, &KernelStages::volume_demand},
    {StageKind::kSurface, &KernelStages::surface},
    {StageKind::kSurfaceBounds, &KernelStages::surface_bounds},
    {StageKind::kDither, &KernelStages::dither},
    {StageKind::kShape, &KernelStages::shape},
    {StageKind::kShapeAttributes, &KernelStages::shape_attributes},
    {StageKind::kShapeBounds, &KernelStages::shape_bounds},
};

constexpr unsigned on(StageKind kind) {
    return 1u << static_cast<unsigned>(kind);
}
constexpr unsigned kSurface = on(StageKind::kSurface);
constexpr unsigned kSurfaceBounds = on(StageKind::kSurfaceBounds);
constexpr unsigned kVolume = on(StageKind::kVolume);
constexpr unsigned kVolumeBounds = on(StageKind::kVolumeBounds);
constexpr unsigned kVolumeDemand = on(StageKind::kVolumeDemand);
constexpr unsigned kDither = on(StageKind::kDither);
constexpr unsigned kShapeBounds = on(StageKind::kShapeBounds);
constexpr unsigned kShapes = on(StageKind::kShape) | on(StageKind::kShapeAttributes);
constexpr unsigned kGiven = kVolume | kSurface | kShapes;
constexpr unsigned kFormed = kVolumeBounds | kVolumeDemand | kSurfaceBounds | kShapeBounds;

constexpr bool kOptional = true;
constexpr bool kRequired = false;

enum class Cleaning {
    kNone,
    kIs,      ///< a clean-up pass
    kFollows  ///< clean-up passes follow
};

struct Pass {
    const char* name;
    const char* why;
    bool optional;
    Cleaning cleaning;
    unsigned stages;
    Written (*run)(Work* work, Stage* stage);
};

/// All passes, in order.
constexpr Pass kPasses[] = {
    // First, and again after each pass that leaves work for them. Common values after
    // simplification, which makes more of them equal; dead values last, since both leave some.
    {"simplify", "folds constants, and applies identities that hold for every bit pattern",
     kOptional, Cleaning::kIs, kGiven | kDither, rewrites<simplify>},
    {"eliminate_common_values", "computes equal instructions once", kOptional, Cleaning::kIs,
     kGiven | kDither, rewrites<eliminate_common_values>},
    {"eliminate_dead_values", "drops what no output or printf needs", kOptional, Cleaning::kIs,
     kGiven | kDither, rewrites<eliminate_dead_values>},

    // Before attach_footprints, bounds and demand, which know Picks of uniform values only.
    {"expand_picks",
     "turns choices of an element into selects or arithmetic, but for uniforms, which become "
     "tables",
     kRequired, Cleaning::kFollows, kGiven | kDither, rewrites<expand_picks>},

    // Before bounds and demand: the footprint of a lookup decides what it may return, and
    // footprints use nearest inputs, too. Before expand_functions: derivatives are known for
    // functions.
    {"attach_footprints",
     "adds to each texture lookup how its coordinates change from voxel to voxel", kRequired,
     Cleaning::kFollows, kGiven, rewrites<attach_footprints>},

    // Before expand_functions: intervals are known for functions; those of their operations would
    // be useless.
    {"form_volume_bounds",
     "derives the least and the greatest amounts in a block of voxels: blocks of one mixture are "
     "filled at once",
     kOptional, Cleaning::kFollows, kVolumeBounds, volume_bounds},
    // Before bound_displacement, whose quotients have no useful interval, but whose effect is
    // known.
    {"form_surface_bounds",
     "derives how far a patch may be displaced: patches that are far need no micropolygons",
     kOptional, Cleaning::kFollows, kSurfaceBounds,
     forms<form_surface_bounds, &KernelStages::surface>},
    {"form_shape_bounds",
     "derives a shape's least and greatest value in a box: boxes without surface are decided at "
     "once",
     kOptional, Cleaning::kFollows, kShapeBounds, forms<form_shape_bounds, &KernelStages::shape>},
    // Any time after the footprints.
    {"form_demand", "derives which voxels need the nearest surface point: others make no query",
     kOptional, Cleaning::kFollows, kVolumeDemand, forms<form_demand, &KernelStages::volume>},

    {"bound_displacement", "limits a displacement to the longest that the world allows", kRequired,
     Cleaning::kFollows, kSurface, rewrites<bound_displacement>},

    // Before expand_functions: a function is hoisted as a whole or not at all.
    {"hoist_invariants", "moves what a loop does not change to before the loop", kOptional,
     Cleaning::kNone, kGiven, rewrites<hoist_invariants>},

    // After all passes that know functions.
    {"expand_functions",
     "replaces functions (sin, pow, noise) by operations, the same on every machine", kRequired,
     Cleaning::kFollows, kGiven | kFormed | kDither, expand},

    // After expand_functions, which makes most of the operations.
    {"drop_long_bounds", "drops derived stages that cost more than they save", kRequired,
     Cleaning::kNone, kFormed, drop_long},
    {"measure_stages", "counts operations: stages that are too long are errors", kRequired,
     Cleaning::kNone, kGiven | kDither, measure},

    // After expand_functions: parts of functions move, too. A stage that is too long was rejected
    // before.
    {"hoist_uniforms",
     "moves what depends on uniforms alone into a kernel that runs once an object", kOptional,
     Cleaning::kNone, kGiven | kFormed | kDither, uniforms},

    // After hoist_uniforms, which makes elements that are computed values of the object.
    {"form_tables", "turns choices among uniforms into loads", kRequired, Cleaning::kNone,
     kGiven | kFormed | kDither, tables},

    // Last: segments are straight-line code, and no pass above knows states.
    {"cut_segments",
     "cuts stages with loops, queries or printfs into straight kernels and the steps between them",
     kRequired, Cleaning::kFollows, kGiven, cut},
};

/// Returns a stage with its outputs of one kind, and what these need.
Stage keep_outputs(const Stage& stage, StageKind kind, int32_t output) {
    Stage out = stage;
    out.kind = kind;
    std::erase_if(out.outputs, [&](const ir::Output& o) { return o.kind != output; });
    ir::drop_dead_values(&out);
    return out;
}

class Runner {
  public:
    Runner(const ir::Fablet& fablet, const PipelineOptions& options, PipelineResult* result)
        : work_{options,
                result->stages,
                UniformHoister(fablet.uniform_value_count),
                fablet.uniform_value_count,
                {},
                result->too_long,
                result->dither},
          has_surface_(fablet.has_surface),
          has_dither_(fablet.has_dither),
          has_shape_(fablet.has_shape && !ir::grows(fablet)),
          has_shape_outputs_(!fablet.shape_outputs.empty()),
          result_(*result) {}

    void run() {
        for (const Pass& pass : kPasses) {
            if (result_.too_long || result_.dither > kMaxDitherOperations) return;
            for (const StageSlot& slot : kStageSlots) {
                if ((pass.stages & on(slot.kind)) != 0 && exists(slot.kind))
                    run(pass, &(result_.stages.*slot.stage));
            }
        }
    }

  private:
    bool exists(StageKind kind) const {
        if (kind == StageKind::kDither) return has_dither_;
        if (kind == StageKind::kShapeAttributes) return has_shape_outputs_;
        if (kind == StageKind::kShape || kind == StageKind::kShapeBounds) return has_shape_;
        return has_surface_ || (on(kind) & (kSurface | kSurfaceBounds)) == 0;
    }

    void run(const Pass& pass, Stage* stage) {
        const bool off = pass.optional && work_.options.disabled.contains(pass.name);
        if (off || !result_.fault.empty()) return;
        work_.reason.clear();
        const auto begin = std::chrono::steady_clock::now();
        const Written written = pass.run(&work_, stage);
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
        add_time(pass.name, spent.count());
        if (written.empty()) finish(pass, *stage);
        for (Stage* of : written) {
            finish(pass, *of);
            if (pass.cleaning == Cleaning::kFollows) clean(of);
        }
    }

    void clean(Stage* stage) {
        for (const Pass& pass : kPasses) {
            if (pass.cleaning == Cleaning::kIs) run(pass, stage);
        }
    }

    void finish(const Pass& pass, const Stage& stage) {
        const std::string fault = ir::verify(stage);
        if (!fault.empty()) result_.fault = std::string("after ") + pass.name + ": " + fault;
        if (work_.options.after) work_.options.after(pass.name, stage, work_.reason);
    }

    void add_time(const char* name, double seconds) {
        for (PassTime& time : result_.times) {
            if (time.pass == name) {
                time.seconds += seconds;
                return;
            }
        }
        result_.times.push_back({name, seconds});
    }

    Work work_;
    const bool has_surface_;
    const bool has_dither_;
    const bool has_shape_;
    const bool has_shape_outputs_;
    PipelineResult& result_;
};

}  // namespace

const Stage& KernelStages::of(StageKind kind) const {
    const StageSlot* slot = std::find_if(std::begin(kStageSlots), std::end(kStageSlots),
                                         [&](const StageSlot& p) { return p.kind == kind; });
    return slot == std::end(kStageSlots) ? derived : this->*slot->stage;
}

const std::vector<PassName>& pass_names() {
    static const std::vector<PassName> names = [] {
        std::vector<PassName> out;
        for (const Pass& pass : kPasses)
            out.push_back({pass.name, pass.optional, pass.why});
        return out;
    }();
    return names;
}

PipelineResult run_pipeline(const ir::Fablet& fablet, const PipelineOptions& options) {
    PipelineResult result;
    for (const StageSlot& slot : kStageSlots)
        (result.stages.*slot.stage).kind = slot.kind;
    result.stages.volume = fablet.volume;
    if (fablet.has_surface) result.stages.surface = fablet.surface;
    if (fablet.has_dither) result.stages.dither = fablet.dither;
    if (fablet.has_shape) {
        if (!ir::grows(fablet)) {
            result.stages.shape =
                keep_outputs(fablet.shape, StageKind::kShape, OPENFAB_ARG_SHAPE_VALUE);
        }
        result.stages.shape_attributes =
            keep_outputs(fablet.shape, StageKind::kShapeAttributes, OPENFAB_ARG_SHAPE_OUT);
    }
    Runner(fablet, options, &result).run();
    return result;
}

}  // namespace openfab::passes
