// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/schedules/schedule_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <utility>
#include <variant>

#include "compiler/lower/schedule/apply_schedule.h"

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

lower::Kernel make_kernel(const lower::KernelRequest& request) {
    return lower::make_kernel(*request.stage, request.inside, request.isa);
}

/// Returns whether a loop, or what it is a part of, is over what one place has several of.
bool is_within_place(const Loop& loop) {
    const auto begins = [&](const char* var) { return loop.name.starts_with(var); };
    return begins("slot") || begins("channel") || begins("level") || begins("field");
}

}  // namespace

ScheduleSpace::ScheduleSpace(std::vector<lower::KernelRequest> kernels)
    : kernels_(std::move(kernels)) {
    std::stable_sort(kernels_.begin(), kernels_.end(), [](const auto& a, const auto& b) {
        return make_kernel(a).funcs.size() > make_kernel(b).funcs.size();
    });
    for (const lower::KernelRequest& request : kernels_)
        funcs_.push_back(ScheduledKernel(make_kernel(request)).names());
}

/// Returns the first kernel under a schedule, which is legal where all of them take it; without one
/// where the first does not.
ScheduledKernel ScheduleSpace::apply(const std::string& text, bool* legal) const {
    const auto parsed = schedule::read({"random.sched", text});
    const auto* read = std::get_if<schedule::Schedule>(&parsed);
    *legal = read != nullptr;
    std::optional<ScheduledKernel> first;
    for (size_t k = 0; k < kernels_.size() && *legal; ++k) {
        auto applied = lower::apply_schedule(*read, make_kernel(kernels_[k]));
        *legal = std::holds_alternative<ScheduledKernel>(applied);
        if (*legal && k == 0) first = std::get<ScheduledKernel>(std::move(applied));
    }
    return first ? std::move(*first) : ScheduledKernel(make_kernel(kernels_[0]));
}

/// Returns the line, from 0, of a schedule that only lowered code shows to be refused: it would store
/// or write out too much, vectors are not whole, or Halide cannot lower it.
std::optional<int32_t> ScheduleSpace::refused_line(const std::string& text) const {
    const auto parsed = schedule::read({"random.sched", text});
    for (lower::KernelRequest request : kernels_) {
        request.schedule = &std::get<schedule::Schedule>(parsed);
        const auto loops = lower::emit_text(request, lower::TextForm::kLoops);
        const auto* fault = std::get_if<lower::Fault>(&loops);
        if (fault == nullptr || !fault->schedule) continue;
        // Any other is a mistake of ours.
        for (const char* reason : {"; the limit is ", "it is not certain that vectors of ",
                                   "Halide 14 cannot do that"}) {
            if (fault->schedule->message.find(reason) != std::string::npos)
                return fault->schedule->line - 1;
        }
    }
    return std::nullopt;
}

/// Returns what a line may begin with: a Func's name; one that not every kernel has is a pattern.
std::string ScheduleSpace::pattern_of(const ScheduledFunc& func) const {
    const bool everywhere = std::all_of(funcs_.begin(), funcs_.end(), [&](const auto& names) {
        return std::find(names.begin(), names.end(), func.name) != names.end();
    });
    return everywhere ? func.name : func.name + "*";
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
    const std::string name = pattern_of(func);
    const LoopNest& nest = func.definitions[0][0];
    std::vector<std::string> vars;
    for (const Loop& loop : nest.loops) {
        if (chance(40, random)) {
            constexpr size_t kFactors[] = {2, 3, 4, 5, 8, 16};
            const std::string before = out;
            out = add(out, fmt::format("{0}.split({1}, {1}o, {1}i, {2})", name, loop.name,
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
        out = add(out, fmt::format("{}.reorder({})", name, fmt::join(vars, ", ")));
    }
    if (chance(15, random)) {
        bool legal = false;
        const ScheduledKernel kernel = apply(out, &legal);
        for (const ScheduledFunc& each : kernel.funcs()) {
            const size_t loops = each.name == func.name ? each.definitions[0][0].loops.size() : 0;
            if (loops < 2) continue;
            const Loop* inner = &each.definitions[0][0].loops[below(loops - 1, random)];
            out =
                add(out, fmt::format("{}.fuse({}, {}, fused)", name, inner[0].name, inner[1].name));
        }
    }
    if (chance(30, random)) out = add(out, fmt::format("{}.parallel({})", name, vars.back()));
    out = add_loops(out, name, nest, "", random);
    if (!chance(20, random)) return out;
    const std::string& var = nest.loops.back().name;
    const char* condition = chance(50, random) ? "{}.specialize({} > {}).unroll({}, 2)"
                                               : "{}.specialize({} % {} == 0).unroll({}, 2)";
    return add(out, fmt::format(fmt::runtime(condition), name, var, 64 << below(3, random),
                                vars[below(vars.size(), random)]));
}

/// Chooses the memory, its layout, and what is fetched early.
std::string ScheduleSpace::add_storage(const std::string& text, const ScheduledFunc& func,
                                       std::mt19937* random) const {
    std::string out = text;
    const std::string name = pattern_of(func);
    const std::vector<Loop>& loops = func.definitions[0][0].loops;
    if (chance(15, random)) {
        out = add(out, fmt::format("{}.align_storage({}, {})", name, loops[0].name,
                                   8 << below(2, random)));
    }
    if (chance(15, random)) {
        out = add(out, fmt::format("{}.store_in({})", name, chance(50, random) ? "heap" : "stack"));
    }
    if (loops.size() > 1 && chance(10, random)) {
        out = add(
            out, fmt::format("{}.reorder_storage({}, {})", name, loops.back().name, loops[0].name));
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
    const std::string name = pattern_of(kernel.funcs()[func]);
    // Places, the innermost last; one that is further out stores more.
    std::vector<std::string> sites = {"root()"};
    for (const lower::LoopSite& site : kernel.loops_around_uses(func)) {
        // Asked again for every slot or channel, the runtime takes hours.
        if (kernel.funcs()[func].is_extern() && is_within_place(*site.loop)) break;
        sites.push_back(fmt::format("at({}, {})", kernel.funcs()[site.func].name, site.loop->name));
    }
    const size_t chosen = sites.size() - 1 - std::min(below(4, random), sites.size() - 1);
    std::string out = add(text, fmt::format("{}.compute_{}", name, sites[chosen]));
    if (out == text) return out;
    if (chance(25, random))
        out = add(out, fmt::format("{}.store_{}", name, sites[below(chosen + 1, random)]));
    if (chance(10, random) && sites.size() > 1) {
        const lower::LoopSite site = kernel.loops_around_uses(func).back();
        out =
            add(out, fmt::format("{}.prefetch({}, {}, {})", pattern_of(kernel.funcs()[site.func]),
                                 kernel.funcs()[func].name, site.loop->name, 1 + below(3, random)));
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
    std::string stored;
    // Where too much would be inline, it is stored until a line places it elsewhere.
    for (const ScheduledFunc& func : plain.funcs()) {
        if (!legal && func.is_listed && !func.is_result)
            stored += fmt::format("{}.compute_root()\n", pattern_of(func));
    }
    std::string text = stored;
    for (size_t k = 0; k < plain.funcs().size(); ++k) {
        const ScheduledFunc& func = plain.funcs()[k];
        if (!func.is_listed) continue;
        text = func.is_result ? add_result(text, func, random) : add_placement(text, k, random);
    }
    while (const std::optional<int32_t> refused = refused_line(text)) {
        std::istringstream lines(text.substr(stored.size()));
        const auto kept = std::count(stored.begin(), stored.end(), '\n');
        if (*refused < kept) return sample(random);
        // So are those that go on from it.
        text = stored;
        std::string line;
        for (auto k = kept; std::getline(lines, line); ++k)
            if (k != *refused) text = add(text, line);
    }
    return text;
}

}  // namespace openfab::testing
