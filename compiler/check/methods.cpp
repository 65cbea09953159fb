// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Lookups in curves: `spline.At(x)`, `ramp.At(x)`.

#include <vector>

#include "compiler/check/expression_checker.h"

namespace openfab::check {

ExprPtr ExpressionChecker::curve_method(const ast::Expr& expr, ExprPtr curve,
                                        std::vector<ExprPtr> args) {
    const ast::Expr& callee = *expr.args[0];
    const Type result{Base::kFloat, curve_channels(curve->type)};
    if (callee.text != "At") {
        sink_->report(callee.text_span, diag::kUnknownMember, type_name(curve->type), callee.text)
            .suggest(callee.text_span, callee.text, std::vector<std::string>{"At"},
                     "it has `At(x)`, its value at x");
        return poison(expr.span);
    }
    if (args.size() != 1) {
        wrong_count(expr, callee.text, "1 argument, where on the curve", args.size());
        return poison(expr.span);
    }
    if (!args[0]->type.is_scalar()) {
        sink_->report(args[0]->span, diag::kNoConversion, type_name(args[0]->type), "float");
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kCurve, result, expr.span);
    out->args.push_back(std::move(curve));
    out->args.push_back(convert(std::move(args[0]), kFloatType));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

}  // namespace openfab::check
