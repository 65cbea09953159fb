// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/back_end.h"
#include "base/say.h"

#include <fmt/format.h>

#include <cstdio>

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

}  // namespace

passes::PipelineResult run_passes(const ir::Fablet& fablet, const BackEndOptions& options) {
    passes::PipelineOptions pipeline;
    pipeline.disabled.insert(options.disabled.begin(), options.disabled.end());
    if (!options.dump_after.empty()) {
        pipeline.after = [&](const std::string& pass, const ir::Stage& stage) {
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
    const std::string what = fault.schedule ? fault.schedule->message : fault.internal;
    return fail(what, kExitBug);
}

}  // namespace openfab::driver
