// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/matrix_functions.h"

#include <fmt/format.h>

#include <utility>

#include "compiler/check/nodes.h"

namespace openfab::check {

namespace {

/// Rows and columns of the left or right operand of a product: a vector is a row on the left and a
/// column on the right.
std::pair<int, int> shape(const Type& type, bool left) {
    if (type.is_matrix()) return {type.rows, type.size};
    return left ? std::pair{1, type.size} : std::pair{type.size, 1};
}

}  // namespace

std::vector<StructMember> common_point_members() {
    return {
        {"position", kFloat3Type, {}}, {"normal", kFloat3Type, {}}, {"distance", kFloatType, {}}};
}

ExprPtr MatrixFunctions::call(const ast::Expr& expr, MatrixOp op, std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    const size_t count = op == MatrixOp::kMul ? 2 : 1;
    if (args.size() != count) {
        wrong_count(sink_, expr, callee.text, count == 2 ? "2 arguments" : "1 argument",
                    args.size());
        return poison(expr.span);
    }
    if (op == MatrixOp::kMul) return mul(expr, std::move(args));
    const Type type = args[0]->type;
    const bool square = type.rows == type.size;
    if (!type.is_matrix() || (!square && op != MatrixOp::kTranspose)) {
        sink_->report(callee.span, diag::kNoOverload, callee.text, type_list(args))
            .help(op == MatrixOp::kTranspose ? "it takes a matrix" : "it takes a square matrix");
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kMatrix, type, expr.span);
    if (op == MatrixOp::kTranspose) std::swap(out->type.rows, out->type.size);
    if (op == MatrixOp::kDeterminant) out->type = kFloatType;
    out->matrix_op = op;
    out->args = std::move(args);
    return out;
}

/// Scalars scale; else as in HLSL: a vector on the left is a row, on the right a column.
ExprPtr MatrixFunctions::mul(const ast::Expr& expr, std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    Type a = args[0]->type;
    Type b = args[1]->type;
    if (!a.is_arithmetic() || !b.is_arithmetic()) {
        sink_->report(callee.span, diag::kNoOverload, callee.text, type_list(args));
        return poison(expr.span);
    }
    a.base = b.base = Base::kFloat;
    const auto [rows, inner] = shape(a, true);
    const auto [inner_right, columns] = shape(b, false);
    const bool scales = a.is_scalar() || b.is_scalar();
    if (!scales && inner != inner_right) {
        sink_->report(callee.span, diag::kNoOverload, callee.text, type_list(args))
            .help(fmt::format("the left one has {} columns, the right one {} rows", inner,
                              inner_right));
        return poison(expr.span);
    }
    args[0] = conversions_.implicit(std::move(args[0]), a);
    args[1] = conversions_.implicit(std::move(args[1]), b);
    if (scales) {
        Type type = a.is_scalar() ? b : a;
        ExprPtr out = make(ExprKind::kBinary, type, expr.span);
        out->op = ir::Op::kMul;
        for (ExprPtr& arg : args)
            out->args.push_back(conversions_.implicit(std::move(arg), type));
        return out;
    }
    Type type = kFloatType;
    if (a.is_matrix() && b.is_matrix()) {
        type.rows = rows;
        type.size = columns;
    } else if (a.is_matrix() || b.is_matrix()) {
        type.size = a.is_matrix() ? rows : columns;
    }
    ExprPtr out = make(ExprKind::kMatrix, type, expr.span);
    out->matrix_op = MatrixOp::kMul;
    out->args = std::move(args);
    return out;
}

ExprPtr MatrixFunctions::over(const ast::Expr& expr, std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    if (args.size() != 2) {
        wrong_count(sink_, expr, callee.text, "2 arguments", args.size());
        return poison(expr.span);
    }
    if (!args[0]->type.is(Base::kComposition) || !args[1]->type.is(Base::kComposition)) {
        sink_->report(callee.span, diag::kNoOverload, callee.text, type_list(args))
            .help("it puts one `MaterialComposition` over another one");
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kOver, args[0]->type, expr.span);
    out->args = std::move(args);
    return out;
}

}  // namespace openfab::check
