// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule/apply_schedule.h"

#include <fmt/format.h>

#include <string_view>

#include "compiler/lower/schedule/directive_chain.h"
#include "compiler/schedule/rules.h"

namespace openfab::lower {

namespace {

bool names_func(const schedule::Line& line, std::string_view func) {
    const std::string& pattern = line.func.text;
    const size_t star = pattern.find('*');
    return star == std::string::npos ? func == pattern : func.starts_with(pattern.substr(0, star));
}

std::optional<schedule::Fault> apply_line(const schedule::Line& line, ScheduledKernel* kernel) {
    bool found = false;
    for (size_t k = 0; k < kernel->funcs().size(); ++k) {
        const ScheduledFunc& func = kernel->funcs()[k];
        if (!func.is_listed || !names_func(line, func.name)) continue;
        found = true;
        if (std::optional<schedule::Fault> fault = DirectiveChain(kernel, k, line).run())
            return fault;
    }
    // A pattern may match nothing: which Funcs there are depends on the fablet.
    const bool one = line.func.text.find('*') == std::string::npos;
    if (found || !one) return std::nullopt;
    return schedule::fault_at(line.func,
                              fmt::format("this kernel has no func `{}`", line.func.text),
                              schedule::near_or_all(line.func.text, kernel->names(), "it has"));
}

Halide::LoopLevel level_of(const ScheduledKernel& kernel, const Placement& placement) {
    switch (placement.level) {
        case Placement::Level::kInline:
            return Halide::LoopLevel::inlined();
        case Placement::Level::kRoot:
            return Halide::LoopLevel::root();
        case Placement::Level::kAt:
            break;
    }
    const ScheduledFunc& at = kernel.funcs()[placement.func];
    for (const std::vector<LoopNest>& definition : at.definitions) {
        if (const Loop* loop = definition[0].find(placement.var)) return {at.func, loop->var};
    }
    return Halide::LoopLevel::root();
}

/// Kernels ask for the stack, which is right for what a batch needs; of what another schedule stores
/// only small things of constant size are, unless a line says otherwise.
void choose_memory(ScheduledFunc* func) {
    if (!func->is_result && !func->has_memory) func->func.store_in(Halide::MemoryType::Auto);
}

/// Tells Halide where Funcs are computed, now that it is known to be legal.
void set_levels(ScheduledKernel* kernel, bool built_in) {
    for (ScheduledFunc& func : kernel->funcs()) {
        if (!built_in) choose_memory(&func);
        if (func.compute.directive) func.func.compute_at(level_of(*kernel, func.compute));
        // Halide warns of updates that nobody scheduled.
        for (size_t u = 1; u < func.definitions.size(); ++u) {
            Halide::Stage stage = func.func.update(static_cast<int>(u) - 1);
            if (!func.func.function().update(static_cast<int>(u) - 1).schedule().touched())
                stage.unscheduled();
        }
    }
}

}  // namespace

std::variant<ScheduledKernel, schedule::Fault> apply_schedule(const schedule::Schedule& schedule,
                                                              const Kernel& kernel, bool built_in) {
    ScheduledKernel scheduled(kernel);
    for (const schedule::Line& line : schedule.lines) {
        try {
            if (std::optional<schedule::Fault> fault = apply_line(line, &scheduled)) return *fault;
        } catch (const Halide::Error&) {
            return schedule::fault_at(
                line.func, fmt::format("this line cannot be applied to `{}`", line.func.text),
                "the loops that it asks for cannot be made");
        }
    }
    if (std::optional<schedule::Fault> fault = check_placements(scheduled)) return *fault;
    if (std::optional<schedule::Fault> fault = check_inlining(schedule, scheduled)) return *fault;
    set_levels(&scheduled, built_in);
    if (built_in) {
        scheduled.unroll_loops();
        scheduled.vectorize_parts();
    }
    return scheduled;
}

}  // namespace openfab::lower
