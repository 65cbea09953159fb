// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/derivatives.h"

#include <fmt/format.h>

#include <algorithm>

#include "abi/element_name.h"
#include "compiler/passes/find_jumps.h"
#include "compiler/passes/form_jacobian.h"

namespace openfab::driver {

namespace {

const char* name_of(passes::JumpKind kind) {
    switch (kind) {
        case passes::JumpKind::kComparison:
            return "what this comparison decides";
        case passes::JumpKind::kRounding:
            return "a rounded number";
        case passes::JumpKind::kRemainder:
            return "a remainder";
        case passes::JumpKind::kCell:
            return "the number of a cell";
        case passes::JumpKind::kBorder:
            return "what is inside the part, whose border moves,";
    }
    return "";
}

const char* remedy_of(passes::JumpKind kind) {
    switch (kind) {
        case passes::JumpKind::kComparison:
            return "`smoothstep(a - w, a + w, x)` goes from 0 to 1 over a width instead of jumping "
                   "at `x > a`, "
                   "and `lerp` mixes two values by it; of distances `shell_soft` (shell) and "
                   "`solid_union_smooth` (solids) do";
        case passes::JumpKind::kRounding:
        case passes::JumpKind::kRemainder:
            return "waves of `sin` repeat without a jump, and `stripes_soft` (pattern) are stripes "
                   "with soft "
                   "edges";
        case passes::JumpKind::kCell:
            return "the distances of `cellular` have no jumps";
        case passes::JumpKind::kBorder:
            return "sums over voxels lack those that come and go at the border: take differences "
                   "of "
                   "sums; the fractions of voxels that stay are right";
    }
    return "";
}

}  // namespace

void warn_of_jumps(const ir::Fablet& fablet, diag::Sink* sink,
                   const std::vector<std::string>& names) {
    for (const passes::Jump& jump : passes::find_jumps(fablet)) {
        const bool asked = std::ranges::any_of(names, [&](const std::string& name) {
            return std::ranges::count(jump.uniforms, abi::element_of(name).name) > 0;
        });
        if (!names.empty() && !asked) continue;
        sink->report(jump.span, diag::kJump, name_of(jump.kind),
                     fmt::format("{}", fmt::join(jump.uniforms, "`, `")))
            .note(fablet.span, "in this fablet")
            .help(remedy_of(jump.kind));
    }
}

bool differentiate(const std::vector<std::string>& names, ir::Fablet* fablet,
                   std::vector<int32_t>* directions, diag::Sink* sink) {
    for (const std::string& asked : names) {
        const abi::Element element = abi::element_of(asked);
        const std::string& name = element.name;
        const auto found = std::ranges::find(fablet->uniforms, name, &ir::Uniform::name);
        if (found == fablet->uniforms.end()) continue;
        const ir::Uniform& uniform = *found;
        if (element.index >= uniform.array_length) continue;
        if (uniform.kind != OPENFAB_UNIFORM_VALUE || uniform.type != ir::Type::kFloat) {
            sink->report(uniform.span, diag::kNoDerivative,
                         fmt::format("the fractions by `{}`, a `{}`", name, uniform.type_name))
                .help("there are those by uniforms of floats, their vectors, matrices and arrays");
            return false;
        }
        const abi::Numbers numbers =
            abi::numbers_of(element, uniform.components, uniform.array_length);
        for (int32_t k = 0; k < numbers.count; ++k)
            directions->push_back(uniform.first_index + numbers.first + k);
    }
    if (directions->empty()) return true;
    if (directions->size() > passes::kMostDirections) {
        sink->report(fablet->span, diag::kTooComplex,
                     fmt::format("derivatives of `{}` by {} numbers at once; the limit is {}",
                                 fablet->name, directions->size(), passes::kMostDirections))
            .help(
                "ask for some of the uniforms, then for the others; of an array for elements, as "
                "`table[3]`");
        return false;
    }
    std::vector<passes::Direction> wanted;
    for (const int32_t value : *directions)
        wanted.push_back({{{value, -1}}});
    passes::Jacobian jacobian = passes::form_jacobian(*fablet, wanted);
    for (const passes::NoDerivative& none : jacobian.none) {
        sink->report(none.span, diag::kNoDerivative, none.what)
            .note(fablet->span, "asked for, of this fablet");
    }
    if (!jacobian.none.empty()) return false;
    warn_of_jumps(*fablet, sink, names);
    fablet->volume = std::move(jacobian.stage);
    fablet->has_dither = false;  // nothing is dithered
    return true;
}

}  // namespace openfab::driver
