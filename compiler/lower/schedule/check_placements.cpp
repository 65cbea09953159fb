// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "compiler/lower/schedule/apply_schedule.h"
#include "compiler/schedule/rules.h"

namespace openfab::lower {

namespace {

class PlacementCheck {
  public:
    explicit PlacementCheck(const ScheduledKernel& kernel) : kernel_(kernel) {}

    std::optional<schedule::Fault> run() {
        // A Func is placed in one that reads it: that these exist comes first, as paths follow
        // them.
        for (size_t k = 0; k < funcs().size(); ++k) {
            if (!is_at_reader(k, funcs()[k].compute)) return fault_;
            if (funcs()[k].store && !is_at_reader(k, *funcs()[k].store)) return fault_;
        }
        for (size_t k = 0; k < funcs().size(); ++k) {
            if (!inlines(k) || !compute(k) || !store(k) || !specializations(k) || !prefetches(k))
                return fault_;
        }
        return std::nullopt;
    }

  private:
    const std::vector<ScheduledFunc>& funcs() const { return kernel_.funcs(); }

    bool fail(const Placement& placement, std::string message, std::string help = {}) {
        fault_ = schedule::fault_at(*placement.directive, std::move(message), std::move(help));
        return false;
    }

    bool is_at_reader(size_t k, const Placement& placement) {
        if (placement.level != Placement::Level::kAt || !placement.directive) return true;
        const ScheduledFunc& func = funcs()[k];
        const ScheduledFunc& at = funcs()[placement.func];
        if (!kernel_.reads(placement.func, k)) {
            return fail(
                placement, fmt::format("`{}` does not read `{}`", at.name, func.name),
                fmt::format("a func is computed inside a loop of one that reads it{}", readers(k)));
        }
        if (at.is_inline()) {
            return fail(placement,
                        fmt::format("`{}` is inline: it has no loops of its own", at.name),
                        fmt::format("place `{}` first, or choose one that reads it", at.name));
        }
        std::vector<std::string> names;
        bool found = false;
        for (const std::vector<LoopNest>& definition : at.definitions) {
            for (const Loop& loop : definition[0].loops) {
                names.push_back(loop.name);
                found = found || loop.name == placement.var;
            }
        }
        if (found) return true;
        return fail(placement,
                    fmt::format("`{}` has no var `{}` after all lines", at.name, placement.var),
                    schedule::near_or_all(placement.var, names, "it has"));
    }

    std::string readers(size_t k) const {
        std::vector<std::string> names;
        for (const ScheduledFunc& func : funcs()) {
            const bool direct = std::any_of(func.calls.begin(), func.calls.end(),
                                            [&](const auto& calls) { return calls.contains(k); });
            if (direct && func.is_listed) names.push_back("`" + func.name + "`");
        }
        return names.empty() ? std::string() : fmt::format(": {}", fmt::join(names, ", "));
    }

    static bool passes(const std::vector<LoopSite>& path, const Placement& placement) {
        return std::any_of(path.begin(), path.end(), [&](const LoopSite& site) {
            return site.func == placement.func && site.loop->name == placement.var;
        });
    }

    /// What is part of another Func has that one's loops.
    bool inlines(size_t k) {
        const ScheduledFunc& func = funcs()[k];
        if (!func.is_inline() || func.is_reduction() || func.is_extern()) return true;
        if (!func.definitions[0][0].is_changed()) return true;
        const bool asked = func.compute.directive.has_value();
        const bool named = func.last_word.has_value();
        if (!asked && !named) return true;
        fault_ = schedule::fault_at(
            asked ? *func.compute.directive : *func.last_word,
            fmt::format("`{}` is part of what reads it, so it has no loops that are vectorized, "
                        "unrolled, parallel or split",
                        func.name),
            fmt::format("place it, as in `{}.compute_at(func, var)`", func.name));
        return false;
    }

    bool compute(size_t k) {
        const ScheduledFunc& func = funcs()[k];
        const Placement& placement = func.compute;
        if (placement.level != Placement::Level::kAt || !placement.directive) return true;
        const ScheduledFunc& at = funcs()[placement.func];
        for (const ScheduledKernel::Use& use : kernel_.uses(k)) {
            if (use.func == placement.func || passes(kernel_.path(use.func), placement)) continue;
            return fail(placement,
                        fmt::format("`{}` reads `{}` too, outside the loop `{}` of `{}`",
                                    funcs()[use.func].name, func.name, placement.var, at.name),
                        common_place(k));
        }
        const std::set<size_t> definitions = kernel_.definitions_that_need(placement.func, k);
        if (definitions.empty()) return true;
        if (definitions.size() > 1) {
            return fail(placement,
                        fmt::format("`{}` reads `{}` in {} loops, its definition and its updates",
                                    at.name, func.name, definitions.size()),
                        common_place(k));
        }
        for (const LoopNest& nest : at.definitions[*definitions.begin()]) {
            if (nest.find(placement.var) != nullptr) continue;
            const std::string where =
                nest.condition.empty()
                    ? std::string(*definitions.begin() == 0 ? "" : "the update of ")
                    : fmt::format("the specialization `{}` of ", nest.condition);
            return fail(placement, fmt::format("{}`{}`, which reads `{}`, has no loop `{}`", where,
                                               at.name, func.name, placement.var));
        }
        // Halide looks at a reduction's condition before the reduction begins.
        for (const LoopSite& site : kernel_.path(k)) {
            if (!site.loop->reduces || !kernel_.decides(k, site.func)) continue;
            return fail(placement,
                        fmt::format("`{}` decides which steps the loop `{}` of `{}` has: it is not "
                                    "computed inside it",
                                    func.name, site.loop->name, funcs()[site.func].name),
                        "choose a loop outside it");
        }
        for (const LoopSite& site : kernel_.path(k)) {
            if (site.loop->kind != Loop::Kind::kVector) continue;
            return fail(placement,
                        fmt::format("the loop `{}` of `{}` is vectorized: nothing is computed "
                                    "inside it",
                                    site.loop->name, funcs()[site.func].name),
                        "choose a loop outside it");
        }
        return true;
    }

    /// Returns advice: the innermost loop around all that reads the Func.
    std::string common_place(size_t k) const {
        const std::vector<LoopSite> common = kernel_.loops_around_uses(k);
        if (common.empty()) return "`compute_root()` is around all that reads it";
        return fmt::format("`compute_at({}, {})` is around all that reads it",
                           funcs()[common.back().func].name, common.back().loop->name);
    }

    bool store(size_t k) {
        const ScheduledFunc& func = funcs()[k];
        if (!func.store) return true;
        if (func.is_inline()) {
            return fail(*func.store,
                        fmt::format("`{}` is inline: nothing of it is stored", func.name),
                        "say where it is computed: compute_at, compute_root");
        }
        const std::vector<LoopSite> path = kernel_.path(k);
        const size_t first = kernel_.loops_to_storage(k);
        if (first > path.size()) {
            return fail(*func.store,
                        fmt::format("`{}` is not computed inside the loop `{}` of `{}`", func.name,
                                    func.store->var, funcs()[func.store->func].name),
                        "a func is stored where it is computed, or in a loop outside");
        }
        for (size_t s = first; s < path.size(); ++s) {
            if (path[s].loop->kind != Loop::Kind::kParallel) continue;
            return fail_race(func, fmt::format("the loop `{}` of `{}`", path[s].loop->name,
                                               funcs()[path[s].func].name));
        }
        return true;
    }

    /// The outermost loops around a Func are a result's, which may have other versions of them.
    bool specializations(size_t k) {
        const ScheduledFunc& func = funcs()[k];
        const std::vector<LoopSite> path = kernel_.path(k);
        if (path.empty() || !func.compute.directive) return true;
        const size_t result = path.front().func;
        const auto last = std::find_if(path.rbegin(), path.rend(),
                                       [&](const LoopSite& site) { return site.func == result; });
        const bool stored_outside =
            func.store && (func.store->level == Placement::Level::kRoot ||
                           (func.store->func == result && func.store->var != last->loop->name));
        for (const LoopNest& nest : funcs()[result].definitions[0]) {
            bool after_store = func.store && func.store->level == Placement::Level::kRoot;
            for (auto loop = nest.loops.rbegin(); loop != nest.loops.rend(); ++loop) {
                const std::string where = fmt::format(
                    "the loop `{}` of `{}`{}", loop->name, funcs()[result].name,
                    nest.condition.empty() ? "" : fmt::format(" if {}", nest.condition));
                if (loop->kind == Loop::Kind::kVector) {
                    return fail(func.compute,
                                where + " is vectorized: nothing is computed inside it",
                                "choose a loop outside it");
                }
                if (after_store && loop->kind == Loop::Kind::kParallel)
                    return fail_race(func, where);
                if (func.store && func.store->var == loop->name && stored_outside)
                    after_store = true;
                if (loop->name == last->loop->name) break;
            }
            if (stored_outside && !after_store) {
                return fail(
                    *func.store,
                    fmt::format("the loop `{}` of `{}` is not around `{}` if {}", func.store->var,
                                funcs()[result].name, last->loop->name, nest.condition));
            }
        }
        return true;
    }

    bool prefetches(size_t k) {
        for (const Prefetch& prefetch : funcs()[k].prefetches) {
            const ScheduledFunc& read = funcs()[prefetch.func];
            const std::vector<LoopSite> path = kernel_.path(prefetch.func);
            const bool inside = std::any_of(path.begin(), path.end(), [&](const LoopSite& site) {
                return site.func == k && site.loop->name == prefetch.var;
            });
            if (!inside && !read.is_inline()) continue;
            fault_ =
                schedule::fault_at(prefetch.directive,
                                   fmt::format("`{}` is not stored before the loop `{}` of `{}`",
                                               read.name, prefetch.var, funcs()[k].name),
                                   "what is fetched early is what a loop outside has computed");
            return false;
        }
        return true;
    }

    bool fail_race(const ScheduledFunc& func, const std::string& where) {
        return fail(*func.store,
                    fmt::format("{}, between where `{}` is stored and where it is computed, is "
                                "parallel: threads would write over each other",
                                where, func.name),
                    "store it inside that loop");
    }

    const ScheduledKernel& kernel_;
    schedule::Fault fault_;
};

}  // namespace

std::optional<schedule::Fault> check_placements(const ScheduledKernel& kernel) {
    return PlacementCheck(kernel).run();
}

}  // namespace openfab::lower
