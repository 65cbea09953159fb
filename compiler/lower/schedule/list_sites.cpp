// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule/list_sites.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/lower/algorithm/kernel.h"
#include "compiler/lower/schedule/apply_schedule.h"

namespace openfab::lower {

namespace {

std::string site_of(const ScheduledKernel& kernel, const Placement& placement) {
    if (placement.level == Placement::Level::kRoot) return "compute_root()";
    return fmt::format("compute_at({}, {})", kernel.funcs()[placement.func].name, placement.var);
}

FuncSites sites_of(const ScheduledKernel& kernel, size_t index) {
    const ScheduledFunc& func = kernel.funcs()[index];
    FuncSites out;
    out.func = func.name;
    out.is_result = func.is_result;
    if (!func.definitions.empty()) {
        for (const Loop& loop : func.definitions[0][0].loops) {
            if (loop.kind == Loop::Kind::kSerial && !loop.reduces)
                out.serial_loops.push_back(loop.name);
        }
    }
    if (func.is_result) return out;
    out.sites.emplace_back("compute_root()");
    for (const LoopSite& site : kernel.loops_around_uses(index)) {
        out.sites.push_back(
            fmt::format("compute_at({}, {})", kernel.funcs()[site.func].name, site.loop->name));
    }
    if (func.is_inline()) return out;
    const auto here = std::find(out.sites.begin(), out.sites.end(), site_of(kernel, func.compute));
    if (here != out.sites.end()) out.current = static_cast<size_t>(here - out.sites.begin());
    return out;
}

}  // namespace

std::variant<std::vector<FuncSites>, schedule::Fault> list_sites(const KernelRequest& request) {
    const schedule::Schedule& schedule = schedule_of(request);
    const Kernel kernel = make_kernel(*request.stage, request.inside, request.isa);
    auto applied = apply_schedule(schedule, kernel, request.schedule == nullptr);
    if (auto* fault = std::get_if<schedule::Fault>(&applied)) return std::move(*fault);
    const auto& scheduled = std::get<ScheduledKernel>(applied);
    std::vector<FuncSites> out;
    for (size_t k = 0; k < scheduled.funcs().size(); ++k) {
        if (scheduled.funcs()[k].is_listed) out.push_back(sites_of(scheduled, k));
    }
    return out;
}

}  // namespace openfab::lower
