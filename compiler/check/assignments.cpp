// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/assignments.h"

#include <fmt/format.h>

#include <utility>

#include "compiler/check/operators.h"

namespace openfab::check {

ExprPtr Assignments::assign(const ast::Expr& expr) const {
    if (report_undeclared(expr)) return poison(expr.span);
    ExprPtr target = expressions_.expression(*expr.args[0]);
    const Type type = target->type;
    const bool plain = expr.text == "=";
    const bool list = plain && expr.args[1]->kind == ast::ExprKind::kInitList;
    ExprPtr value =
        list ? initializers_.of(*expr.args[1], type) : expressions_.expression(*expr.args[1]);
    if (type.is_error() || value->type.is_error()) return poison(expr.span);
    if (!targets_.assignable(*target)) return poison(expr.span);
    ExprPtr out = make(ExprKind::kAssign, type, expr.span);
    if (plain) {
        value = conversions_.implicit(std::move(value), type);
        out->operand_type = type;
    } else {
        out->compound = true;
        out->op = binary_op(expr.text.substr(0, expr.text.size() - 1));
        const bool mixture = type.is(Base::kComposition);
        if (type.is_matrix() && !ir::is_bitwise(out->op) && value->type.is_arithmetic() &&
            (value->type.is_scalar() ||
             (value->type.rows == type.rows && value->type.size == type.size))) {
            out->operand_type = type;
            out->args.push_back(std::move(target));
            out->args.push_back(conversions_.implicit(std::move(value), type));
            return out;
        }
        const bool sum = mixture && out->op == ir::Op::kAdd && value->type == type;
        const bool product = mixture && out->op == ir::Op::kMul && value->type.is_scalar();
        if (!sum && !product && !(type.is_numeric() && value->type.is_numeric())) {
            return bad_operand(sink_, expr, quoted_types(type, value->type));
        }
        Type common = mixture ? type : common_type(type, value->type);
        if (common.base == Base::kBool) common.base = Base::kInt;
        if (ir::is_bitwise(out->op) && !common.is_integer()) {
            return bad_operand(sink_, expr, quoted_types(type, value->type));
        }
        // The operation may be wider than the target; converting its result back is then a
        // narrowing.
        if (!mixture && value->type.base == Base::kFloat && type.base != Base::kFloat) {
            sink_->report(expr.span, diag::kNarrowing, "float", type_name(type))
                .help(fmt::format("write the conversion: `a = {}(a {} b)`", type_name(type),
                                  expr.text.substr(0, expr.text.size() - 1)));
        }
        common.size = type.size;
        out->operand_type = common;
        value = conversions_.implicit(std::move(value), product ? kFloatType : common);
    }
    if (value->type.is_error()) return poison(expr.span);
    out->args.push_back(std::move(target));
    out->args.push_back(std::move(value));
    return out;
}

ExprPtr Assignments::increment(const ast::Expr& expr) const {
    ExprPtr target = expressions_.expression(*expr.args[0]);
    if (target->type.is_error()) return poison(expr.span);
    if (!target->type.is_numeric() || target->type.base == Base::kBool) {
        return bad_operand(sink_, expr, fmt::format("`{}`", type_name(target->type)));
    }
    if (!targets_.assignable(*target)) return poison(expr.span);
    ExprPtr out = make(ExprKind::kIncrement, target->type, expr.span);
    out->op = expr.text == "++" ? ir::Op::kAdd : ir::Op::kSub;
    out->postfix = expr.kind == ast::ExprKind::kPostfix;
    out->args.push_back(std::move(target));
    return out;
}

/// `x = 1` where no `x` is declared; false at any other assignment.
bool Assignments::report_undeclared(const ast::Expr& expr) const {
    const ast::Expr& target = *expr.args[0];
    const bool known = names_.find(target.text) != nullptr || !find_type(target.text).is_error() ||
                       !names_.overloads(target.text).empty() ||
                       find_intrinsic(target.text) != nullptr;
    if (expr.text != "=" || target.kind != ast::ExprKind::kName || known ||
        expr.args[1]->kind == ast::ExprKind::kInitList)
        return false;
    const ExprPtr value = expressions_.expression(*expr.args[1]);
    unknown_.name(target, value->type == kVoidType ? Type{} : value->type);
    return true;
}

}  // namespace openfab::check
