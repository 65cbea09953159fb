// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// `gradient(f, p, …)` and `mean_curvature(f, p, …)`: f is the name of a function that gives a float of a point; what
// follows p are its other arguments.
#include "compiler/check/fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/check/nodes.h"

namespace openfab::check {

namespace {

constexpr std::string_view kGradient = "gradient", kMeanCurvature = "mean_curvature";

/// Returns what is wrong with a function; empty if it is a field.
std::string fault_of(const Function& f, bool curved) {
    const Type& point = f.parameters[0]->type;
    const bool floats = point.is_numeric() && point.base == Base::kFloat;
    const int least = curved ? 2 : 1;
    const int most = curved ? 3 : 4;
    if (f.return_type != kFloatType)
        return fmt::format("it gives a `{}`, not a `float`", type_name(f.return_type));
    if (!floats || point.is_matrix() || point.size < least || point.size > most) {
        return fmt::format("its first parameter is a `{}`, not {}", type_name(point),
                           curved ? "a `float2` or `float3`" : "a `float` or a vector of floats");
    }
    const bool out = std::any_of(f.parameters.begin(), f.parameters.end(),
                                 [](const auto& p) { return p->is_out; });
    return out ? "it has an `out` parameter" : "";
}

}  // namespace

bool Fields::takes(std::string_view name) {
    return name == kGradient || name == kMeanCurvature;
}

ExprPtr Fields::call(const ast::Expr& expr) const {
    const ast::Expr& callee = *expr.args[0];
    const bool curved = callee.text == kMeanCurvature;
    if (expr.args.size() < 3) {
        wrong_count(sink_, expr, callee.text,
                    "a function, a point and what else the function takes", expr.args.size() - 1);
        return poison(expr.span);
    }
    const ast::Expr& named = *expr.args[1];
    const auto refuse = [&](const std::string& fault) -> diag::Diagnostic& {
        return sink_->report(named.span, diag::kBadField, callee.text, fault);
    };
    const bool is_call =
        named.kind == ast::ExprKind::kCall && named.args[0]->kind == ast::ExprKind::kName;
    if (named.kind != ast::ExprKind::kName) {
        diag::Diagnostic& d = refuse("takes the name of a function, not a value");
        if (is_call) {
            d.help(
                fmt::format("`{}({}, p, …)`: what the function takes beside its point follows "
                            "that",
                            callee.text, named.args[0]->text));
        }
        return poison(expr.span);
    }
    const std::vector<const Function*> candidates = names_.overloads(named.text);
    const Symbol* symbol = names_.find(named.text);
    if (symbol != nullptr && !names_.is_hidden_by_function(*symbol)) {
        names_.record_use(named.span, *symbol);
        if (!symbol->type.is_error()) {
            refuse(fmt::format("takes the name of a function, which `{}` is not", named.text))
                .note(symbol->span, fmt::format("`{}` is declared here", named.text));
        }
        return poison(expr.span);
    }
    if (candidates.empty()) {
        const std::vector<std::string> built_in = function_names();
        if (std::find(built_in.begin(), built_in.end(), named.text) == built_in.end())
            return unknown_.function(named, expr.span);
        refuse(fmt::format("takes a function of the program, and `{}` is built in", named.text))
            .help(
                fmt::format("write one that calls it: `float field(float3 p) {{ return {}(p); }}`",
                            named.text));
        return poison(expr.span);
    }
    std::vector<ExprPtr> args = expressions_.arguments(expr, 2);
    if (any_error(args)) return poison(expr.span);
    ExprPtr out = overloads_.call(named, expr.span, candidates, std::move(args));
    if (out->type.is_error()) return out;
    const Function& f = *out->function;
    if (const std::string fault = fault_of(f, curved); !fault.empty()) {
        refuse(fmt::format("takes a function that gives a `float` of a point, and `{}` is none: {}",
                           f.name, fault))
            .note(f.span, fmt::format("`{}` is here", f.name));
        return poison(expr.span);
    }
    out->kind = curved ? ExprKind::kMeanCurvature : ExprKind::kGradient;
    out->type = curved ? kFloatType : f.parameters[0]->type;
    return out;
}

}  // namespace openfab::check
