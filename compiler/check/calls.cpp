// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/calls.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>
#include <utility>

namespace openfab::check {

namespace {

std::optional<MatrixOp> matrix_function(std::string_view name) {
    if (name == "mul") return MatrixOp::kMul;
    if (name == "transpose") return MatrixOp::kTranspose;
    if (name == "determinant") return MatrixOp::kDeterminant;
    if (name == "inverse") return MatrixOp::kInverse;
    return std::nullopt;
}

bool is_printf(std::string_view name) {
    return name == "printf" || name == "assert";
}

}  // namespace

ExprPtr Calls::call(const ast::Expr& expr) const {
    const ast::Expr& callee = *expr.args[0];
    if (callee.kind == ast::ExprKind::kMember) return methods_.call(expr);
    if (unknown_.array_constructor(expr)) return poison(expr.span);
    if (callee.kind != ast::ExprKind::kName) {
        ExprPtr value = expressions_.expression(callee);
        if (!value->type.is_error()) {
            sink_->report(callee.span, diag::kNotAFunction, type_name(value->type));
        }
        return poison(expr.span);
    }
    if (const Symbol* symbol = names_.find(callee.text);
        symbol != nullptr && !names_.is_hidden_by_function(*symbol)) {
        names_.record_use(callee.span, *symbol);
        if (symbol->kind == SymbolKind::kType && symbol->type.is(Base::kStruct)) {
            return constructors_.construct_struct(expr, symbol->type);
        }
        if (symbol->kind == SymbolKind::kType && symbol->type == kIntType)
            return constructors_.construct(expr, symbol->type, expressions_.arguments(expr));
        if (!symbol->type.is_error()) {
            sink_->report(callee.span, diag::kNotAFunction, callee.text)
                .note(symbol->span, fmt::format("`{}` is declared here", callee.text));
        }
        return poison(expr.span);
    }
    const Type type = find_type(callee.text);
    const IntrinsicInfo* info = find_intrinsic(callee.text);
    const std::vector<const Function*> candidates = names_.overloads(callee.text);
    const std::optional<MatrixOp> matrix = matrix_function(callee.text);
    const bool is_over = callee.text == "over";
    const bool asks = Queries::asks(callee.text);
    const bool known = info != nullptr || matrix || is_over || asks;
    if (candidates.empty() && is_printf(callee.text)) return printing_.call(expr);
    if (candidates.empty() && Fields::takes(callee.text)) return fields_.call(expr);
    if (candidates.empty() && type.is_error() && !known) {
        return unknown_.function(callee, expr.span, &expr);
    }
    std::vector<ExprPtr> args = expressions_.arguments(expr);
    if (any_error(args)) return poison(expr.span);
    // Falls back to a built-in function if none of the program fits.
    if (!candidates.empty() && (!known || any_match(candidates, args))) {
        return overloads_.call(callee, expr.span, candidates, std::move(args));
    }
    if (!type.is_error()) return constructors_.construct(expr, type, std::move(args));
    if (matrix) return matrices_.call(expr, *matrix, std::move(args));
    if (is_over) return matrices_.over(expr, std::move(args));
    if (asks) return queries_.surface(expr, std::move(args));
    if (info->id == Intrinsic::kDistance && args.size() == 1) {
        return queries_.distance(expr, std::move(args));
    }
    return intrinsics_.call(expr, *info, std::move(args));
}

}  // namespace openfab::check
