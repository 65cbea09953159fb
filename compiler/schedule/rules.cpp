// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/schedule/rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/near_miss.h"

namespace openfab::schedule {

namespace {

constexpr ArgKind kVar = ArgKind::kVar;
constexpr ArgKind kNew = ArgKind::kNewVar;
constexpr ArgKind kFunc = ArgKind::kFunc;
constexpr ArgKind kNumber = ArgKind::kNumber;

const std::vector<DirectiveRule>& rules() {
    static const std::vector<DirectiveRule> all = {
        {"split", {kVar, kNew, kNew, kNumber}, 4, false, "split(var, outer, inner, factor)"},
        {"tile",
         {kVar, kVar, kNew, kNew, kNew, kNew, kNumber, kNumber},
         8,
         false,
         "tile(x, y, xo, yo, xi, yi, factor_x, factor_y)"},
        {"fuse", {kVar, kVar, kNew}, 3, false, "fuse(inner, outer, fused)"},
        {"reorder", {kVar}, 2, true, "reorder(innermost, …, outermost)"},
        {"unroll", {kVar, kNumber}, 1, false, "unroll(var[, factor])"},
        {"vectorize", {kVar, kNumber}, 1, false, "vectorize(var[, factor])"},
        {"parallel", {kVar}, 1, false, "parallel(var)"},
        {"compute_at", {kFunc, kVar}, 2, false, "compute_at(func, var)"},
        {"compute_root", {}, 0, false, "compute_root()"},
        {"compute_inline", {}, 0, false, "compute_inline()"},
        {"store_at", {kFunc, kVar}, 2, false, "store_at(func, var)"},
        {"store_root", {}, 0, false, "store_root()"},
        {"store_in", {ArgKind::kMemory}, 1, false, "store_in(heap) or store_in(stack)"},
        {"reorder_storage", {kVar}, 2, true, "reorder_storage(innermost, …, outermost)"},
        {"align_storage", {kVar, kNumber}, 2, false, "align_storage(var, multiple)"},
        {"bound_storage", {kVar, kNumber}, 2, false, "bound_storage(var, extent)"},
        {"fold_storage", {kVar, kNumber}, 2, false, "fold_storage(var, extent)"},
        {"prefetch", {kFunc, kVar, kNumber}, 3, false, "prefetch(func, var, distance)"},
        {"specialize", {ArgKind::kCondition}, 1, false, "specialize(var >= number)"},
        {"update", {kNumber}, 0, false, "update([number])"},
    };
    return all;
}

constexpr const char* kOrder =
    "floats are added up in one order in every schedule, or their last bits would differ";
constexpr const char* kShape =
    "what a kernel computes is not the schedule's to say: bounds are part of the kernel";
constexpr const char* kProcessor = "kernels run on the processor";

constexpr std::array<std::pair<const char*, const char*>, 23> kRefused = {{
    {"rfactor", kOrder},
    {"atomic", kOrder},
    {"allow_race_conditions", kOrder},
    {"approximate", "every schedule gives the same bits"},
    {"memoize", "a kernel keeps nothing from one call to the next"},
    {"async", "threads are those of `parallel`"},
    {"compute_with", "place both funcs in one loop with compute_at"},
    {"bound", kShape},
    {"bound_extent", kShape},
    {"align_bounds", kShape},
    {"align_extent", kShape},
    {"set_estimate", kShape},
    {"set_estimates", kShape},
    {"in", "write compute_at for the func itself"},
    {"clone_in", "write compute_at for the func itself"},
    {"rename", "`split` names the loops that it makes"},
    {"serial", "a loop is serial unless a directive says otherwise"},
    {"gpu", kProcessor},
    {"gpu_blocks", kProcessor},
    {"gpu_threads", kProcessor},
    {"gpu_lanes", kProcessor},
    {"gpu_tile", kProcessor},
    {"hexagon", kProcessor},
}};

}  // namespace

const DirectiveRule* find_rule(std::string_view name) {
    const auto rule = std::find_if(rules().begin(), rules().end(),
                                   [&](const DirectiveRule& r) { return name == r.name; });
    return rule == rules().end() ? nullptr : &*rule;
}

std::vector<std::string> directive_names() {
    std::vector<std::string> out;
    for (const DirectiveRule& rule : rules())
        out.emplace_back(rule.name);
    return out;
}

std::string why_refused(std::string_view name) {
    for (const auto& [refused, why] : kRefused) {
        if (name == refused) return why;
    }
    return {};
}

std::string near_or_all(std::string_view word, std::span<const std::string> names,
                        const char* all) {
    const std::string near = near_miss(word, names);
    if (!near.empty()) return fmt::format("did you mean `{}`?", near);
    return names.empty() ? std::string() : fmt::format("{} {}", all, fmt::join(names, ", "));
}

}  // namespace openfab::schedule
