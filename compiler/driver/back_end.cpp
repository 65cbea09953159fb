// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/back_end.h"
#include "base/say.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

namespace openfab::driver {

namespace {

void report_schedule(const lower::ScheduleFault& fault, uint32_t file,
                     const source::SourceManager& sources, const CommonOptions& common) {
    diag::Sink sink;
    const auto begin = static_cast<uint32_t>(fault.offset);
    const source::Span span{file, begin, begin + static_cast<uint32_t>(fault.length)};
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

int load_schedule(const std::string& path, source::SourceManager* sources,
                  const CommonOptions& common, UserSchedule* out) {
    std::string fault;
    const std::optional<uint32_t> file = sources->load(path, &fault);
    if (!file) return fail(fault, unread_exit_code(path));
    const std::string name = std::filesystem::path(path).filename().string();
    const std::string kernel = name.substr(0, name.find('.'));
    const bool known = kernel == "surface" || kernel == "surface_bounds" || kernel == "slab" ||
                       kernel == "volume_bounds" || kernel == "volume_demand";
    if (!known) {
        return fail(
            fmt::format("{}: no kernel is called `{}`; name the file after the kernel it is for: "
                        "surface, surface_bounds, slab, volume_bounds or volume_demand, as in "
                        "slab.sched",
                        path, kernel),
            kExitUserInput);
    }
    auto parsed = lower::parse_schedule(path, sources->text(*file));
    if (const auto* bad = std::get_if<lower::ScheduleFault>(&parsed)) {
        report_schedule(*bad, *file, *sources, common);
        return kExitUserInput;
    }
    *out = {kernel, *file, std::move(std::get<lower::Schedule>(parsed))};
    return kExitDone;
}

int report_fault(const lower::Fault& fault, const UserSchedule& schedule,
                 const source::SourceManager& sources, const CommonOptions& common) {
    if (fault.schedule && schedule.file != 0) {
        report_schedule(*fault.schedule, schedule.file, sources, common);
        return kExitUserInput;
    }
    const std::string what = fault.schedule ? fault.schedule->message : fault.internal;
    return fail(what, kExitBug);
}

}  // namespace openfab::driver
