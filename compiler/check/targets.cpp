// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/targets.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/nodes.h"

namespace openfab::check {

namespace {

/// Returns whether a swizzle names a component twice.
bool names_twice(const Expr& swizzle) {
    const auto end = swizzle.lanes.begin() + swizzle.type.size;
    for (auto lane = swizzle.lanes.begin(); lane != end; ++lane) {
        if (std::find(swizzle.lanes.begin(), lane, *lane) != lane) return true;
    }
    return false;
}

}  // namespace

/// Says that nothing can be assigned to an expression, and what to write instead.
void Targets::refuse(const Expr& target) const {
    if (target.kind == ExprKind::kGet) {
        sink_->report(target.span, diag::kNotAssignable, "the result of `Get`")
            .help("write `mc.Set(m, amount)`");
        return;
    }
    if (target.kind != ExprKind::kAttribute) {
        sink_->report(target.span, diag::kNotAssignable, "this expression");
        return;
    }
    const bool surface = place_.context == StageContext::kSurface;
    const bool dither = place_.context == StageContext::kDither;
    sink_->report(target.span, diag::kNotAssignable, "a stage attribute")
        .help(place_.context == StageContext::kGrow
                  ? "attributes are read-only; work on a copy: `uint path = attr.path;`"
              : place_.context == StageContext::kShape
                  ? "attributes are read-only; work on a copy: `float3 p = attr.p;`"
              : surface ? "attributes are read-only; the displacement that the stage "
                          "returns moves the surface"
              : dither  ? "attributes are read-only; work on a copy: `int3 at = attr.voxel;`"
                        : "attributes are read-only; work on a copy: `float3 p = "
                          "attr.voxelCenter;`");
}

bool Targets::assignable(const Expr& target) const {
    switch (traits(target.kind).target) {
        case Target::kError:
            return false;
        case Target::kNone:
            refuse(target);
            return false;
        case Target::kPart:
            if (target.kind == ExprKind::kSwizzle && names_twice(target)) {
                sink_->report(target.span, diag::kNotAssignable,
                              "a swizzle that names a component twice");
                return false;
            }
            return assignable(*target.args[0]);
        case Target::kSymbol:
            break;
    }
    const Symbol& symbol = *target.symbol;
    const char* what = nullptr;
    if (symbol.kind == SymbolKind::kUniform) what = "uniform";
    if (symbol.kind == SymbolKind::kVoid) what = "built-in material";
    if (symbol.kind == SymbolKind::kAttributes) what = "stage's attributes";
    if (symbol.kind == SymbolKind::kConstant || symbol.is_const) what = "constant";
    if (what == nullptr) return true;
    diag::Diagnostic& d = sink_->report(target.span, diag::kNotAssignable,
                                        fmt::format("`{}`, a {},", symbol.name, what));
    if (symbol.span.file != 0)
        d.note(symbol.span, fmt::format("`{}` is declared here", symbol.name));
    if (symbol.kind == SymbolKind::kUniform && symbol.type.is_arithmetic()) {
        d.help(fmt::format("the world sets a uniform; work on a copy: `{0} copy = {1};`",
                           type_name(symbol.type), symbol.name));
    }
    return false;
}

}  // namespace openfab::check
