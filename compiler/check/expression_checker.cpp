// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/expression_checker.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace openfab::check {

ExprPtr ExpressionChecker::expression(const ast::Expr& expr) {
    ExprPtr out = of_kind(expr);
    names_.record_type(expr.span, out->type);
    return out;
}

ExprPtr ExpressionChecker::of_kind(const ast::Expr& expr) {
    switch (expr.kind) {
        case ast::ExprKind::kBad:
            return poison(expr.span);
        case ast::ExprKind::kBoolLiteral:
        case ast::ExprKind::kIntLiteral:
        case ast::ExprKind::kUintLiteral:
        case ast::ExprKind::kFloatLiteral: {
            const Type type = expr.kind == ast::ExprKind::kBoolLiteral   ? kBoolType
                              : expr.kind == ast::ExprKind::kIntLiteral  ? kIntType
                              : expr.kind == ast::ExprKind::kUintLiteral ? kUintType
                                                                         : kFloatType;
            ExprPtr out = make(ExprKind::kConstant, type, expr.span);
            out->bits = expr.bits;
            return out;
        }
        case ast::ExprKind::kStringLiteral:
            sink_->report(expr.span, diag::kNotAValue, expr.text, "string")
                .help("strings are allowed only in `printf`, `assert` and annotations");
            return poison(expr.span);
        case ast::ExprKind::kInitList:
            sink_->report(expr.span, diag::kNotAValue, "{ }", "list")
                .help(
                    "a list initializes or assigns a variable; elsewhere name the type: `float3(1, "
                    "2, 3)`");
            return poison(expr.span);
        case ast::ExprKind::kName:
            return name(expr);
        case ast::ExprKind::kUnary:
            return operators_.unary(expr);
        case ast::ExprKind::kPrefix:
        case ast::ExprKind::kPostfix:
            return assignments_.increment(expr);
        case ast::ExprKind::kBinary:
            return expr.text == "&&" || expr.text == "||" ? conditions_.logical(expr)
                                                          : operators_.binary(expr);
        case ast::ExprKind::kConditional:
            return conditions_.conditional(expr);
        case ast::ExprKind::kAssign:
            return assignments_.assign(expr);
        case ast::ExprKind::kComma:
            return comma(expr);
        case ast::ExprKind::kIndex:
            return parts_.index(expr);
        case ast::ExprKind::kMember:
            return parts_.member(expr);
        case ast::ExprKind::kCall:
            return calls_.call(expr);
        case ast::ExprKind::kCast:
            return constructors_.cast(expr);
    }
    return poison(expr.span);
}

ExprPtr ExpressionChecker::name(const ast::Expr& expr) {
    const Symbol* symbol = names_.find(expr.text);
    if (symbol != nullptr) {
        names_.record_use(expr.span, *symbol);
        if (symbol->type.is_error()) return poison(expr.span);
        if (symbol->kind == SymbolKind::kType) {
            sink_->report(expr.span, diag::kNotAValue, expr.text, "type");
            return poison(expr.span);
        }
        if (symbol->kind == SymbolKind::kVoid && place_.fablet->ir.void_slot < 0) {
            place_.fablet->ir.void_slot = place_.fablet->ir.slot_count++;
        }
        ExprPtr out = make(ExprKind::kVariable, symbol->type, expr.span);
        out->symbol = symbol;
        return out;
    }
    if (!find_type(expr.text).is_error()) {
        sink_->report(expr.span, diag::kNotAValue, expr.text, "type");
        return poison(expr.span);
    }
    if (!names_.overloads(expr.text).empty() || find_intrinsic(expr.text) != nullptr) {
        sink_->report(expr.span, diag::kNotAValue, expr.text, "function");
        return poison(expr.span);
    }
    return unknown_.name(expr, {});
}

/// The value of `a, b` is `b`: `a` is useless without an effect.
ExprPtr ExpressionChecker::comma(const ast::Expr& expr) {
    std::vector<const ast::Expr*> parts;  // from the last to the first
    const ast::Expr* at = &expr;
    for (; at->kind == ast::ExprKind::kComma; at = at->args[0].get())
        parts.push_back(at->args[1].get());
    ExprPtr out = expression(*at);
    bool numbers = out->type.is_numeric();
    const bool unused = !out->type.is_error() && side_effect(*out) == nullptr;
    for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
        ExprPtr second = expression(**part);
        numbers = numbers && second->type.is_numeric();
        ExprPtr both = make(ExprKind::kComma, second->type, expr.span);
        both->args.push_back(std::move(out));
        both->args.push_back(std::move(second));
        out = std::move(both);
    }
    if (unused) {
        diag::Diagnostic& d = sink_->report(at->span, diag::kUnusedValue);
        const size_t count = parts.size() + 1;
        if (numbers && count <= 4) {
            d.help(fmt::format("`a, b` evaluates to `b`; a vector is written `float{}(…)`", count));
        } else {
            d.help("`a, b` evaluates to `b`");
        }
    }
    return out;
}

}  // namespace openfab::check
