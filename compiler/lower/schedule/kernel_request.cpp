// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule/kernel_request.h"

#include <algorithm>

#include "abi/kernel_call.h"
#include "compiler/lower/algorithm/sample_parts.h"

namespace openfab::lower {

namespace {

/// Returns whether a kernel looks anything up in pictures, asks for nearest surface points, applies a
/// dither rule, or goes on after segments.
bool does_more_than_arithmetic(const KernelRequest& request) {
    const ir::Stage& stage = *request.stage;
    return request.inside.dither != nullptr || request.inside.after_segments ||
           std::any_of(stage.instrs.begin(), stage.instrs.end(), [&](const ir::Instr& instr) {
               if (instr.op == ir::Op::kInput)
                   return stage.kind == ir::StageKind::kVolume && is_field(instr.kind);
               return instr.op == ir::Op::kSample && !is_volume_sample(instr.args.size());
           });
}

}  // namespace

const char* schedule_name(ir::StageKind kind) {
    return kernel_name(kind);
}

const std::vector<std::string>& pipeline_names() {
    using Kind = ir::StageKind;
    static const std::vector<std::string> names = [] {
        std::vector<std::string> out;
        for (const Kind kind :
             {Kind::kSurface, Kind::kSurfaceBounds, Kind::kVolume, Kind::kVolumeBounds,
              Kind::kSurfaceSegment, Kind::kVolumeSegment, Kind::kDerived, Kind::kVolumeDemand,
              Kind::kShape, Kind::kShapeAttributes, Kind::kShapeBounds, Kind::kShapeSegment})
            out.emplace_back(kernel_name(kind));
        return out;
    }();
    return names;
}

const schedule::Schedule& schedule_of(const KernelRequest& request) {
    if (request.schedule != nullptr) return *request.schedule;
    return schedule::default_schedule(kernel_name(request.stage->kind), abi::isa_name(request.isa),
                                      does_more_than_arithmetic(request));
}

}  // namespace openfab::lower
