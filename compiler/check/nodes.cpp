// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/expression_checker.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::check {

namespace {

std::optional<uint32_t> known_choice(const Expr& expr) {
    const std::optional<uint32_t> test = known_bits(*expr.args[0]);
    if (!test) return std::nullopt;
    return known_bits(*expr.args[*test != 0 ? 1 : 2]);
}

std::optional<uint32_t> own_bits(const Expr& expr) {
    if (expr.kind == ExprKind::kConstant) return expr.bits;
    return expr.kind == ExprKind::kVariable ? expr.symbol->known : known_choice(expr);
}

}  // namespace

std::optional<uint32_t> known_bits(const Expr& expr) {
    if (!expr.type.is_scalar()) return std::nullopt;
    switch (traits(expr.kind).folding) {
        case Folding::kNever:
            return std::nullopt;
        case Folding::kOwn:
            return own_bits(expr);
        case Folding::kOperands:
            break;
    }
    const std::optional<uint32_t> a = known_bits(*expr.args[0]);
    if (!a) return std::nullopt;
    const ir::Type type = component_type(expr.args[0]->type);
    if (expr.kind == ExprKind::kConvert) {
        return ir::eval_convert(type, component_type(expr.type), *a);
    }
    if (expr.kind == ExprKind::kUnary) return ir::eval(expr.op, type, *a, 0, 0);
    if (expr.kind == ExprKind::kAndThen && *a == 0) return 0u;
    if (expr.kind == ExprKind::kOrElse && *a != 0) return 1u;
    const std::optional<uint32_t> b = known_bits(*expr.args[1]);
    if (!b || expr.kind != ExprKind::kBinary) return b;
    return ir::eval(expr.op, type, *a, *b, 0);
}

}  // namespace openfab::check
