// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/schedule/rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/messages.h"
#include "base/near_miss.h"

namespace openfab::schedule {

namespace {

using enum ArgKind;

const std::vector<DirectiveRule>& rules() {
    static const std::vector<DirectiveRule> all = {
#define OPENFAB_DIRECTIVE(name, scope, least, repeats, form, ...) \
    {#name, {__VA_ARGS__}, least, repeats, form},
#include "compiler/schedule/directives.def"
#undef OPENFAB_DIRECTIVE
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
    if (!near.empty()) return fmt::format(openfab::messages::kDidYouMean, near);
    return names.empty() ? std::string() : fmt::format("{} {}", all, fmt::join(names, ", "));
}

}  // namespace openfab::schedule
