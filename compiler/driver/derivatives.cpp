// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/derivatives.h"

#include <fmt/format.h>

#include <algorithm>

#include "abi/curve_table.h"
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

/// Adds the directions of a curve's key, one for each channel, each that of a table of changes (abi/curve_table.h), by
/// whose first number it is called.
void add_key(const ir::Uniform& curve, int32_t key, ir::Fablet* fablet, std::vector<int32_t>* names,
             std::vector<passes::Direction>* directions) {
    const int32_t channels = abi::curve_channels(curve.components);
    ir::Uniform changes = curve;
    changes.name = fmt::format("{}[{}]", curve.name, key);
    changes.kind = OPENFAB_UNIFORM_CURVE_CHANGE;
    changes.components = channels * curve.components;
    changes.first_index = fablet->uniform_value_count;
    changes.annotations.clear();
    fablet->uniform_value_count += changes.components;
    for (int32_t channel = 0; channel < channels; ++channel) {
        const int32_t table = changes.first_index + channel * curve.components;
        passes::Direction& direction = directions->emplace_back();
        const auto add = [&](int32_t at) {
            direction.seeds.push_back({curve.first_index + at, table + at});
        };
        add(2 + 2 * channel);
        add(3 + 2 * channel);
        // A slope depends on a key at each side, at the ends on two.
        const int32_t end = std::min(key + 2, abi::kCurveKeys);
        for (int32_t stretch = std::max(key - 2, 0); stretch < end; ++stretch) {
            for (int32_t c = 0; c < 4; ++c)
                add(abi::curve_coefficients(channels, stretch, channel) + c);
        }
        names->push_back(table);
    }
    fablet->uniforms.push_back(std::move(changes));
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
    std::vector<passes::Direction> wanted;
    for (const std::string& asked : names) {
        const abi::Element element = abi::element_of(asked);
        const std::string& name = element.name;
        const auto found = std::ranges::find(fablet->uniforms, name, &ir::Uniform::name);
        if (found == fablet->uniforms.end()) continue;
        const ir::Uniform uniform = *found;
        if (uniform.kind == OPENFAB_UNIFORM_CURVE) {
            if (element.index < 0) {
                sink->report(uniform.span, diag::kNoDerivative,
                             fmt::format("the fractions by all of `{}`, a `{}`", name,
                                         uniform.type_name))
                    .help(fmt::format("ask for keys: `{0}[0]` is the value of its first", name));
                return false;
            }
            if (element.index < abi::kCurveKeys)
                add_key(uniform, element.index, fablet, directions, &wanted);
            continue;
        }
        if (element.index >= uniform.array_length) continue;
        if (uniform.kind != OPENFAB_UNIFORM_VALUE || uniform.type != ir::Type::kFloat) {
            sink->report(uniform.span, diag::kNoDerivative,
                         fmt::format("the fractions by `{}`, a `{}`", name, uniform.type_name))
                .help(
                    "there are those by uniforms of floats, their vectors, matrices and arrays, "
                    "and by keys of curves");
            return false;
        }
        const abi::Numbers numbers =
            abi::numbers_of(element, uniform.components, uniform.array_length);
        for (int32_t k = 0; k < numbers.count; ++k) {
            directions->push_back(uniform.first_index + numbers.first + k);
            wanted.push_back({{{directions->back(), -1}}});
        }
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
