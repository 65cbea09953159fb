// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The middle end: from the front end's IR to one stage per kernel. pipeline.cpp has the table of
// passes, in order. Optional passes can be switched off without changing a bit of the output; the
// others are needed for the meaning of a stage or for code generation.

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/passes/cut_segments.h"

namespace openfab::passes {

struct PipelineOptions {
    std::set<std::string> disabled;  ///< names of optional passes
    /// Limit of the operations of an interval form, which is several times as long as its stage; a
    /// longer one is dropped: no culling, same output. One of this length, some ten struts with
    /// fillets, takes half a second to compile.
    size_t longest_bounds = 4000;
    /// Of a shape, without whose interval form all of its box is evaluated.
    size_t longest_shape_bounds = 16000;
    /// Whether a volume is a program of segments that leaves its amounts in states (Amounts::kStates), as derivatives are.
    bool amounts_in_states = false;
    /// Called after each pass on a stage, with the result, and why it did nothing or left something out, where it says so.
    std::function<void(const std::string& pass, const ir::Stage& stage, const std::string& reason)>
        after;
};

/// One stage per kernel. A stage without outputs means no kernel: no @Surface, or an optional
/// kernel whose pass is disabled.
struct KernelStages {
    ir::Stage
        surface;  ///< outputs POSITION x, y, z (displaced, clamped), SURFACE_OUT, SURFACE_STATUS
    ir::Stage surface_bounds;    ///< outputs DISPLACEMENT_LO/HI, SURFACE_OUT_LO/HI
    ir::Stage volume;            ///< outputs WEIGHT
    ir::Stage volume_bounds;     ///< outputs WEIGHT_LO/HI
    ir::Stage volume_demand;     ///< output DEMAND; none if every voxel needs its point
    ir::Stage dither;            ///< output CHOICE; none without a rule
    ir::Stage shape;             ///< output SHAPE_VALUE; none without @Shape
    ir::Stage shape_attributes;  ///< outputs SHAPE_OUT
    ir::Stage shape_bounds;      ///< outputs SHAPE_VALUE_LO/HI
    ir::Stage derived;  ///< outputs DERIVED: uniforms that the others read beside the fablet's
    std::vector<openfab_table_value> table_values;  ///< of the object, behind those
    /// Compiled instead of a stage that must be cut; no steps otherwise.
    SegmentedStage surface_segments;
    SegmentedStage volume_segments;
    SegmentedStage shape_segments;
    SegmentedStage shape_attribute_segments;

    /// Returns the stage of one kernel; not of segments.
    const ir::Stage& of(ir::StageKind kind) const;
    /// Returns the volume of the slab kernel: the stage, or its last segment. Without outputs where
    /// the amounts of segments are in states.
    const ir::Stage& slab() const {
        return volume_segments.steps.empty() ? volume : volume_segments.last;
    }
};

struct PassTime {
    std::string pass;
    double seconds = 0;
};

/// The most operations of a stage once functions are expanded and lookups have footprints, steps of
/// the runtime left out: compiling takes one or two milliseconds for each.
constexpr size_t kMaxStageOperations = 24000;
/// The most operations of a dither rule, which is compiled in one piece.
constexpr size_t kMaxDitherOperations = 4000;

/// A stage that is too long.
struct LongStage {
    ir::StageKind kind = ir::StageKind::kVolume;
    size_t operations = 0;
    source::Span beyond;  ///< where it gets so long
};

struct PipelineResult {
    KernelStages stages;
    std::optional<LongStage> too_long;  ///< the longest above kMaxStageOperations, an error
    size_t dither = 0;  ///< operations of the rule; an error above kMaxDitherOperations
    std::vector<PassTime> times;
    std::string fault;  ///< a bug of ours: what ir::verify found, and after which pass; else empty
};

/// All passes in order, whether one can be switched off, and what it does, as the end of a sentence.
struct PassName {
    const char* name;
    bool optional;
    const char* why;
};
/// Returns all passes in order.
const std::vector<PassName>& pass_names();

/// Runs all passes on the stages of a fablet.
PipelineResult run_pipeline(const ir::Fablet& fablet, const PipelineOptions& options = {});

}  // namespace openfab::passes
