// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/back_end.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "base/say.h"
#include "compiler/ir/grows.h"
#include "compiler/passes/split_kernel.h"

namespace openfab::driver {

namespace {

void report_schedule(const schedule::Fault& fault, const source::SourceManager& sources,
                     const CommonOptions& common) {
    diag::Sink sink;
    const auto begin = static_cast<uint32_t>(fault.offset);
    const source::Span span{fault.file, begin, begin + static_cast<uint32_t>(fault.length)};
    diag::Diagnostic& diagnostic = sink.report(span, diag::kScheduleIllegal, fault.message);
    if (!fault.help.empty()) diagnostic.help(fault.help);
    print_diagnostics(sink, sources, common);
}

/// Returns how people write a stage's name.
const char* name_of(const ir::Fablet& fablet, ir::StageKind kind) {
    if (kind == ir::StageKind::kSurface) return "@Surface";
    if (kind == ir::StageKind::kVolume) return "@Volume";
    return ir::grows(fablet) ? "@Grow" : "@Shape";
}

/// Says that a stage is too long, and where it gets so.
void refuse_stage(const ir::Fablet& fablet, const passes::KernelStages& stages,
                  const passes::LongStage& found, diag::Sink* sink) {
    const ir::Stage& stage = stages.of(found.kind);
    const bool placed = found.beyond.file != 0;
    diag::Diagnostic& d =
        sink->report(placed ? found.beyond : fablet.span, diag::kTooComplex,
                     fmt::format("the `{}` stage of `{}` has {} operations; the limit is {}",
                                 name_of(fablet, found.kind), fablet.name, found.operations,
                                 passes::kMaxStageOperations));
    const bool lookups =
        std::any_of(stage.instrs.begin(), stage.instrs.end(),
                    [](const ir::Instr& instr) { return instr.op == ir::Op::kSample; });
    if (placed) d.note(fablet.span, "the fablet is here");
    if (lookups) {
        d.help(
            "filtering a texture differentiates its coordinates, which repeats the computation of "
            "them: pass a width to the lookup, or simplify its coordinates");
    } else {
        d.help(
            "functions are inlined and short loops unrolled: make the innermost ones smaller, or "
            "write what is repeated as a loop");
    }
}

}  // namespace

bool refuse_long_stages(const ir::Fablet& fablet, const passes::PipelineResult& result,
                        diag::Sink* sink) {
    if (result.too_long) {
        refuse_stage(fablet, result.stages, *result.too_long, sink);
        return true;
    }
    if (result.dither <= passes::kMaxDitherOperations) return false;
    sink->report(fablet.span, diag::kTooComplex,
                 fmt::format("the dither rule of `{}` has {} operations; the limit is {}",
                             fablet.name, result.dither, passes::kMaxDitherOperations))
        .help(fmt::format("loops over the fractions, of which there are {}, repeat their bodies",
                          fablet.slot_count + 1));
    return true;
}

passes::PipelineResult run_passes(const ir::Fablet& fablet, const BackEndOptions& options,
                                  bool amounts_in_states) {
    passes::PipelineOptions pipeline;
    pipeline.amounts_in_states = amounts_in_states;
    // A block of one mixture has derivatives all the same.
    if (amounts_in_states) pipeline.disabled.insert("form_volume_bounds");
    pipeline.disabled.insert(options.disabled.begin(), options.disabled.end());
    if (!options.dump_after.empty()) {
        pipeline.after = [&](const std::string& pass, const ir::Stage& stage,
                             const std::string& /*reason*/) {
            if (pass != options.dump_after) return;
            say(fmt::format("# {} after {}\n{}", fablet.name, pass, ir::dump(stage)));
        };
    }
    passes::PipelineResult result = passes::run_pipeline(fablet, pipeline);
    if (options.time_passes) {
        for (const passes::PassTime& time : result.times) {
            say(fmt::format("{:>8.4f} s  {}\n", time.seconds, time.pass));
        }
    }
    return result;
}

int report_fault(const lower::Fault& fault, const source::SourceManager& sources,
                 const CommonOptions& common) {
    // Files of the user's have a number.
    if (fault.schedule && fault.schedule->file != 0) {
        report_schedule(*fault.schedule, sources, common);
        return kExitUserInput;
    }
    const std::string what = fault.schedule ? fault.schedule->message : fault.trouble;
    return fail(what, fault.is_outside ? kExitOutside : kExitBug);
}

}  // namespace openfab::driver
