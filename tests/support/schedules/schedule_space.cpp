// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/schedules/schedule_space.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/lower/apply_schedule.h"

namespace openfab::testing {

namespace {

using lower::Loop;
using lower::LoopNest;
using lower::ScheduledFunc;
using lower::ScheduledKernel;

// std distributions differ between libraries.
size_t below(size_t n, std::mt19937* random) {
    return n == 0 ? 0 : (*random)() % n;
}
bool chance(int percent, std::mt19937* random) {
    return below(100, random) < static_cast<size_t>(percent);
}

}  // namespace

ScheduledKernel ScheduleSpace::apply(const std::string& text, bool* legal) const {
    const lower::Kernel kernel = make_();
    auto parsed = schedule::read({"random.sched", text});
    *legal = std::holds_alternative<schedule::Schedule>(parsed);
    if (!*legal) return ScheduledKernel(kernel);
    auto applied = lower::apply_schedule(std::get<schedule::Schedule>(parsed), kernel);
    *legal = std::holds_alternative<ScheduledKernel>(applied);
    return *legal ? std::get<ScheduledKernel>(std::move(applied)) : ScheduledKernel(kernel);
}

/// Returns the text with a line more, or as it is where that is not legal.
std::string ScheduleSpace::add(const std::string& text, const std::string& line) const {
    bool legal = false;
    const std::string longer = text + line + "\n";
    apply(longer, &legal);
    return legal ? longer : text;
}

std::string ScheduleSpace::add_result(const std::string& text, const ScheduledFunc& func,
                                      std::mt19937* random) const {
    std::string out = text;
    const LoopNest& nest = func.definitions[0][0];
    std::vector<std::string> vars;
    for (const Loop& loop : nest.loops) {
        if (chance(40, random)) {
            constexpr size_t kFactors[] = {2, 3, 4, 5, 8, 16};
            const std::string before = out;
            out = add(out, fmt::format("{0}.split({1}, {1}o, {1}i, {2})", func.name, loop.name,
                                       kFactors[below(6, random)]));
            if (out != before) {
                vars.push_back(loop.name + "i");
                vars.push_back(loop.name + "o");
                continue;
            }
        }
        vars.push_back(loop.name);
    }
    if (chance(70, random)) {
        for (size_t k = vars.size(); k > 1; --k)
            std::swap(vars[k - 1], vars[below(k, random)]);
        out = add(out, fmt::format("{}.reorder({})", func.name, fmt::join(vars, ", ")));
    }
    if (chance(15, random)) {
        bool legal = false;
        const ScheduledKernel kernel = apply(out, &legal);
        for (const ScheduledFunc& each : kernel.funcs()) {
            const size_t loops = each.name == func.name ? each.definitions[0][0].loops.size() : 0;
            if (loops < 2) continue;
            const Loop* inner = &each.definitions[0][0].loops[below(loops - 1, random)];
            out = add(out, fmt::format("{}.fuse({}, {}, fused)", func.name, inner[0].name,
                                       inner[1].name));
        }
    }
    if (chance(30, random)) out = add(out, fmt::format("{}.parallel({})", func.name, vars.back()));
    out = add_loops(out, func.name, nest, "", random);
    if (!chance(20, random)) return out;
    const std::string& var = nest.loops.back().name;
    const char* condition = chance(50, random) ? "{}.specialize({} > {}).unroll({}, 2)"
                                               : "{}.specialize({} % {} == 0).unroll({}, 2)";
    return add(out, fmt::format(fmt::runtime(condition), func.name, var, 64 << below(3, random),
                                vars[below(vars.size(), random)]));
}

/// Chooses the memory, its layout, and what is fetched early.
std::string ScheduleSpace::add_storage(const std::string& text, const ScheduledFunc& func,
                                       std::mt19937* random) const {
    std::string out = text;
    const std::vector<Loop>& loops = func.definitions[0][0].loops;
    if (chance(15, random)) {
        out = add(out, fmt::format("{}.align_storage({}, {})", func.name, loops[0].name,
                                   8 << below(2, random)));
    }
    if (chance(15, random)) {
        out = add(out,
                  fmt::format("{}.store_in({})", func.name, chance(50, random) ? "heap" : "stack"));
    }
    if (loops.size() > 1 && chance(10, random)) {
        out = add(out, fmt::format("{}.reorder_storage({}, {})", func.name, loops.back().name,
                                   loops[0].name));
    }
    return out;
}

/// Vectorizes and unrolls loops, whole or in part.
std::string ScheduleSpace::add_loops(const std::string& text, const std::string& func,
                                     const LoopNest& nest, const std::string& prefix,
                                     std::mt19937* random) const {
    constexpr size_t kLanes[] = {2, 3, 4, 8, 16};
    std::string out = text;
    for (const Loop& loop : nest.loops) {
        if (loop.reduces && !chance(20, random)) continue;
        const size_t kind = below(5, random);
        // Vectors are refused where they are not whole, as most of these are.
        if (kind == 0 && chance(15, random)) {
            out = add(out, fmt::format("{}.{}vectorize({}, {})", func, prefix, loop.name,
                                       kLanes[below(5, random)]));
        } else if (kind == 1 && loop.extent) {
            out = add(out, fmt::format("{}.{}vectorize({})", func, prefix, loop.name));
        } else if (kind == 2) {
            out = add(out, fmt::format("{}.{}unroll({}, {})", func, prefix, loop.name,
                                       2 + below(2, random)));
        }
    }
    return out;
}

std::string ScheduleSpace::add_placement(const std::string& text, size_t func,
                                         std::mt19937* random) const {
    bool legal = false;
    const ScheduledKernel kernel = apply(text, &legal);
    const std::string name = kernel.funcs()[func].name;
    // Places, the innermost last; one that is further out stores more.
    std::vector<std::string> sites = {"root()"};
    for (const lower::LoopSite& site : kernel.loops_around_uses(func))
        sites.push_back(fmt::format("at({}, {})", kernel.funcs()[site.func].name, site.loop->name));
    const size_t chosen = sites.size() - 1 - std::min(below(4, random), sites.size() - 1);
    std::string out = add(text, fmt::format("{}.compute_{}", name, sites[chosen]));
    if (out == text) return out;
    if (chance(25, random))
        out = add(out, fmt::format("{}.store_{}", name, sites[below(chosen + 1, random)]));
    if (chance(10, random) && sites.size() > 1) {
        const lower::LoopSite site = kernel.loops_around_uses(func).back();
        out = add(out, fmt::format("{}.prefetch({}, {}, {})", kernel.funcs()[site.func].name, name,
                                   site.loop->name, 1 + below(3, random)));
    }
    if (kernel.funcs()[func].is_extern()) return out;
    out = add_storage(out, kernel.funcs()[func], random);
    const auto& definitions = kernel.funcs()[func].definitions;
    for (size_t d = 0; d < definitions.size(); ++d) {
        const std::string prefix = d == 0 ? "" : fmt::format("update({}).", d - 1);
        out = add_loops(out, name, definitions[d][0], prefix, random);
    }
    return out;
}

std::string ScheduleSpace::sample(std::mt19937* random) const {
    bool legal = false;
    const ScheduledKernel plain = apply("", &legal);
    std::string text;
    // Where too much would be inline, it is stored until a line places it elsewhere.
    for (const ScheduledFunc& func : plain.funcs()) {
        if (!legal && func.is_listed && !func.is_result)
            text += fmt::format("{}.compute_root()\n", func.name);
    }
    for (size_t k = 0; k < plain.funcs().size(); ++k) {
        const ScheduledFunc& func = plain.funcs()[k];
        if (!func.is_listed) continue;
        text = func.is_result ? add_result(text, func, random) : add_placement(text, k, random);
    }
    return text;
}

}  // namespace openfab::testing
