// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Conditions, and what they choose between: `?:`, `&&`, `||`, and their equals for vectors, `select`, `and`, `or`.
#include "compiler/check/conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace openfab::check {

namespace {

std::string quoted(const Type& type) {
    return fmt::format("`{}`", type_name(type));
}

/// Returns whether an expression is an assignment like `k = 2` without its own parentheses, which
/// would mark it as intended.
bool is_bare_assignment(const ast::Expr& expr) {
    return expr.kind == ast::ExprKind::kAssign && expr.text == "=" &&
           expr.span.begin == expr.args[0]->span.begin;
}

/// Returns the type of what a condition of `lanes` components chooses; an error type where the values do not go
/// together.
Type choice_type(int lanes, const Type& yes, const Type& no) {
    if (yes == no && lanes == 1) return yes == kVoidType || yes.is_attributes() ? Type{} : yes;
    const bool numbers = yes.is_numeric() && no.is_numeric();
    const bool scaled = (yes.is_matrix() && no.is_scalar()) || (yes.is_scalar() && no.is_matrix());
    if (lanes == 1) return numbers || scaled ? common_type(yes, no) : Type{};
    const auto fits = [&](const Type& type) { return type.size == 1 || type.size == lanes; };
    if (!numbers || !fits(yes) || !fits(no)) return {};
    Type out = common_type(yes, no);
    out.size = lanes;
    return out;
}

}  // namespace

/// Checks a value that decides: a scalar, or where its user allows it a vector.
ExprPtr Conditions::tested(const ast::Expr& expr) const {
    if (is_bare_assignment(expr)) {
        sink_->report(expr.text_span, diag::kAssignedCondition)
            .help("`==` compares; if the assignment is intended, put it in parentheses")
            .replace(expr.text_span, "==");
    }
    return expressions_.expression(expr);
}

ExprPtr Conditions::condition(const ast::Expr& expr) const {
    ExprPtr out = tested(expr);
    if (out->type.is_error()) return out;
    if (!out->type.is_scalar()) {
        diag::Diagnostic& d = sink_->report(expr.span, diag::kBadCondition, type_name(out->type));
        if (out->type.is_vector()) d.help("write `all(…)` or `any(…)`");
        return poison(expr.span);
    }
    return conversions_.implicit(std::move(out), kBoolType);
}

ExprPtr Conditions::logical(const ast::Expr& expr) const {
    const bool is_and = expr.text == "&&";
    std::vector<ExprPtr> sides;
    for (const ast::ExprPtr& arg : expr.args)
        sides.push_back(tested(*arg));
    if (any_error(sides)) return poison(expr.span);
    const bool numbers = std::all_of(sides.begin(), sides.end(),
                                     [](const ExprPtr& side) { return side->type.is_numeric(); });
    if (!numbers || sides[0]->type.is_vector() || sides[1]->type.is_vector()) {
        diag::Diagnostic& d =
            sink_->report(expr.text_span, diag::kBadOperand, expr.text,
                          quoted(sides[0]->type) + " and " + quoted(sides[1]->type));
        if (!numbers) return poison(expr.span);
        const std::string name = is_and ? "and" : "or";
        d.help(fmt::format("component by component it is `{}(a, b)`; for one answer ask `all(…)` "
                           "or `any(…)` of each side",
                           name))
            .insert_before(expr.args[0]->span, name + "(")
            .replace(expr.text_span, ",")
            .insert_after(expr.args[1]->span, ")");
        return poison(expr.span);
    }
    ExprPtr out = make(is_and ? ExprKind::kAndThen : ExprKind::kOrElse, kBoolType, expr.span);
    for (ExprPtr& side : sides)
        out->args.push_back(conversions_.implicit(std::move(side), kBoolType));
    return out;
}

/// Chooses component by component; both values are computed.
ExprPtr Conditions::choose(const ast::Expr& expr, const source::Span& at, std::string_view name,
                           std::vector<ExprPtr> args) const {
    const Type mask = args[0]->type;
    const Type type =
        mask.is_numeric() ? choice_type(mask.size, args[1]->type, args[2]->type) : Type{};
    if (type.is_error()) {
        diag::Diagnostic& d =
            sink_->report(at, diag::kBadOperand, name,
                          fmt::format("{}, {} and {}", quoted(mask), quoted(args[1]->type),
                                      quoted(args[2]->type)));
        if (mask.is_vector())
            d.help(
                fmt::format("a condition of {0} components chooses between numbers of {0}, or of 1",
                            mask.size));
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kIntrinsic, type, expr.span);
    out->intrinsic = Intrinsic::kSelect;
    out->args.push_back(conversions_.implicit(std::move(args[0]), {Base::kBool, mask.size}));
    out->args.push_back(conversions_.implicit(std::move(args[1]), type));
    out->args.push_back(conversions_.implicit(std::move(args[2]), type));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

ExprPtr Conditions::conditional(const ast::Expr& expr) const {
    std::vector<ExprPtr> args;
    args.push_back(tested(*expr.args[0]));
    args.push_back(expressions_.expression(*expr.args[1]));
    args.push_back(expressions_.expression(*expr.args[2]));
    if (any_error(args)) return poison(expr.span);
    const Type test = args[0]->type;
    if (test.is_vector()) return choose(expr, expr.text_span, "?:", std::move(args));
    if (!test.is_scalar()) {
        sink_->report(expr.args[0]->span, diag::kBadCondition, type_name(test));
        return poison(expr.span);
    }
    const Type type = choice_type(1, args[1]->type, args[2]->type);
    if (type.is_error()) {
        diag::Diagnostic& d =
            sink_->report(expr.text_span, diag::kBadOperand,
                          "?:", quoted(args[1]->type) + " and " + quoted(args[2]->type));
        if (args[1]->type == kVoidType)
            d.help("a choice between statements is written `if … else …`");
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kConditional, type, expr.span);
    out->args.push_back(conversions_.implicit(std::move(args[0]), kBoolType));
    out->args.push_back(conversions_.implicit(std::move(args[1]), type));
    out->args.push_back(conversions_.implicit(std::move(args[2]), type));
    return out;
}

/// `and(a, b)` and `or(a, b)`; a scalar goes with each component.
ExprPtr Conditions::bools(const ast::Expr& expr, const IntrinsicInfo& info,
                          std::vector<ExprPtr> args) const {
    const bool numbers = std::all_of(args.begin(), args.end(),
                                     [](const ExprPtr& arg) { return arg->type.is_numeric(); });
    if (!numbers) {
        sink_->report(expr.args[0]->span, diag::kNoOverload, info.name, type_list(args));
        return poison(expr.span);
    }
    const Type type{Base::kBool, common_type(args[0]->type, args[1]->type).size};
    ExprPtr out = make(ExprKind::kIntrinsic, type, expr.span);
    out->intrinsic = info.id;
    for (ExprPtr& arg : args)
        out->args.push_back(conversions_.implicit(std::move(arg), type));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

}  // namespace openfab::check
