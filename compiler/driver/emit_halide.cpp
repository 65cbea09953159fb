// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <map>

#include "abi/kernel_call.h"
#include "base/say.h"
#include "compiler/driver/back_end.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/schedules.h"
#include "compiler/lower/code/fablet_data.h"

namespace openfab::driver {

namespace {

lower::TextForm text_form(const std::string& form) {
    using Form = lower::TextForm;
    const std::map<std::string, Form> forms = {
        {"halide", Form::kHalide}, {"schedule", Form::kSchedule}, {"loops", Form::kLoops},
        {"stmt", Form::kStmt},     {"llvm", Form::kLlvm},         {"asm", Form::kAsm}};
    return forms.at(form);
}

}  // namespace

int emit_lowered(const ir::Fablet& fablet, ir::StageKind stage, const EmitOptions& options,
                 source::SourceManager* sources, const CommonOptions& common) {
    const std::string& form = options.form;
    const passes::PipelineResult result = run_passes(fablet, {});
    if (form == "ir" && result.fault.empty()) {
        show(ir::dump(result.stages.of(stage)));
        return kExitDone;
    }
    const bool slab = stage == ir::StageKind::kVolume;
    const ir::Stage& chosen = slab ? result.stages.slab() : result.stages.of(stage);
    const bool several =
        slab ? chosen.outputs.empty() && !result.stages.volume_segments.steps.empty()
             : passes::needs_segments(chosen);
    if (result.fault.empty() && several) {
        return fail(
            "the stage is several kernels; `--as ir` shows it "
            "whole",
            kExitUserInput);
    }
    if (result.fault.empty() && chosen.outputs.empty()) {
        return fail(
            fmt::format("the stage has no such kernel: {}",
                        stage == ir::StageKind::kVolumeDemand
                            ? "no voxel needs its nearest surface point, or every one may"
                        : stage == ir::StageKind::kShapeAttributes
                            ? "the shape has no `out` varyings"
                            : "no bounds are known for whole blocks, so every voxel is evaluated"),
            kExitUserInput);
    }
    lower::KernelRequest request;
    request.stage = &chosen;
    if (slab) request.inside = lower::stages_inside_slab(result.stages);
    request.function = fmt::format("openfab_{}", lower::schedule_name(stage));
    for (const openfab_isa isa : abi::isas()) {
        if (options.target == abi::isa_name(isa)) request.isa = isa;
    }
    Schedules schedules(sources, common);
    if (const int code = schedules.load(options.schedules, {request.isa}); code != kExitDone)
        return code;
    const auto mine = schedules.bound().find({lower::schedule_name(stage), request.isa});
    if (mine != schedules.bound().end()) request.schedule = &mine->second;
    std::variant<std::string, lower::Fault> emitted;
    if (!result.fault.empty()) {
        lower::Fault fault;
        fault.trouble = result.fault;
        emitted = fault;
    } else {
        emitted = lower::emit_text(request, text_form(form));
    }
    if (const auto* fault = std::get_if<lower::Fault>(&emitted))
        return report_fault(*fault, *sources, common);
    show(std::get<std::string>(emitted));
    return kExitDone;
}

}  // namespace openfab::driver
