// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/operators.h"

#include <fmt/format.h>

#include <utility>

namespace openfab::check {

namespace {

struct OpName {
    std::string_view text;
    ir::Op op;
};
constexpr OpName kBinaryOps[] = {
    {"+", ir::Op::kAdd},  {"-", ir::Op::kSub},    {"*", ir::Op::kMul},   {"/", ir::Op::kDiv},
    {"%", ir::Op::kMod},  {"&", ir::Op::kBitAnd}, {"|", ir::Op::kBitOr}, {"^", ir::Op::kBitXor},
    {"<<", ir::Op::kShl}, {">>", ir::Op::kShr},   {"==", ir::Op::kEq},   {"!=", ir::Op::kNe},
    {"<", ir::Op::kLt},   {"<=", ir::Op::kLe},    {">", ir::Op::kGt},    {">=", ir::Op::kGe},
};

bool is_order(std::string_view op) {
    return op == "<" || op == "<=" || op == ">" || op == ">=";
}

}  // namespace

ir::Op binary_op(std::string_view text) {
    for (const OpName& candidate : kBinaryOps) {
        if (candidate.text == text) return candidate.op;
    }
    return ir::Op::kAdd;
}

std::string quoted_types(const Type& a, const Type& b) {
    return fmt::format("`{}` and `{}`", type_name(a), type_name(b));
}

ExprPtr bad_operand(diag::Sink* sink, const ast::Expr& expr, const std::string& types) {
    diag::Diagnostic& d = sink->report(expr.text_span, diag::kBadOperand, expr.text, types);
    if (types.find("`Material`") != std::string::npos) {
        d.help(
            "a material is not a number: `mc.Set(m, 0.5)` sets how much of it a composition holds, "
            "`mc.Add(m, 0.5)` adds more");
    } else if (types.find("`MaterialComposition`") != std::string::npos) {
        d.help("compositions support `a + b`, `a * s`, `lerp(a, b, t)` and `over(a, b)`");
    } else if (expr.text == "^" && types.find("float") != std::string::npos) {
        d.help("a power is written `pow(x, y)`");
    } else if (expr.text == "==" || expr.text == "!=") {
        d.help("arrays, structs and matrices are compared element by element");
    }
    return poison(expr.span);
}

ExprPtr Operators::unary(const ast::Expr& expr) const {
    ExprPtr operand = expressions_.expression(*expr.args[0]);
    if (operand->type.is_error()) return poison(expr.span);
    const Type given = operand->type;
    Type type = given;
    ir::Op op = ir::Op::kNeg;
    if (expr.text == "!") {
        type.base = Base::kBool;
        op = ir::Op::kNot;
    } else if (given.base == Base::kBool) {
        type.base = Base::kInt;
    }
    if (expr.text == "~") op = ir::Op::kBitNot;
    const bool matrix = given.is_matrix() && (expr.text == "-" || expr.text == "+");
    if (!(given.is_numeric() || matrix) || (expr.text == "~" && !type.is_integer())) {
        return bad_operand(sink_, expr, fmt::format("`{}`", type_name(given)));
    }
    operand = conversions_.implicit(std::move(operand), type);
    if (expr.text == "+") return operand;
    ExprPtr out = make(ExprKind::kUnary, type, expr.span);
    out->op = op;
    out->args.push_back(std::move(operand));
    return out;
}

ExprPtr Operators::binary(const ast::Expr& expr) const {
    const bool pointer = (expr.text == "*" || expr.text == "&") &&
                         expr.args[0]->kind == ast::ExprKind::kName &&
                         names_.is_type(expr.args[0]->text);
    if (pointer) {
        sink_->report(expr.args[0]->span, diag::kNotAValue, expr.args[0]->text, "type")
            .help("there are no pointers or references; an `out` parameter gives a value back");
        return poison(expr.span);
    }
    if (unknown_.cast_template(expr)) return poison(expr.span);
    ExprPtr left = expressions_.expression(*expr.args[0]);
    ExprPtr right = expressions_.expression(*expr.args[1]);
    if (left->type.is_error() || right->type.is_error()) return poison(expr.span);
    const Type a = left->type;
    const Type b = right->type;
    if (a.is(Base::kComposition) || b.is(Base::kComposition)) {
        return composition_binary(expr, std::move(left), std::move(right));
    }
    ir::Op op = binary_op(expr.text);
    const bool equality = op == ir::Op::kEq || op == ir::Op::kNe;
    const bool materials = a.is(Base::kMaterial) && b.is(Base::kMaterial) && equality;
    if (a.is_matrix() || b.is_matrix())
        return matrix_binary(expr, std::move(left), std::move(right));
    if (!materials && !(a.is_numeric() && b.is_numeric()))
        return bad_operand(sink_, expr, quoted_types(a, b));
    Type type = materials ? a : common_type(a, b);
    if (type.base == Base::kBool && !equality) type.base = Base::kInt;
    if (ir::is_bitwise(op) && !type.is_integer())
        return bad_operand(sink_, expr, quoted_types(a, b));
    check_foreign_operators(expr, *left, *right);
    ExprPtr out = make(ExprKind::kBinary,
                       ir::is_comparison(op) ? Type{Base::kBool, type.size} : type, expr.span);
    out->op = op;
    out->args.push_back(conversions_.implicit(std::move(left), type));
    out->args.push_back(conversions_.implicit(std::move(right), type));
    return out;
}

/// Component-wise, as in HLSL; a scalar is broadcast.
ExprPtr Operators::matrix_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right) const {
    const Type a = left->type;
    const Type b = right->type;
    const bool fits = (a.is_matrix() && b.is_scalar()) || (b.is_matrix() && a.is_scalar()) ||
                      (a.is_matrix() && b.is_matrix() && a.rows == b.rows && a.size == b.size);
    const ir::Op op = binary_op(expr.text);
    if (!fits || ir::is_bitwise(op) || ir::is_comparison(op)) {
        diag::Diagnostic& d =
            sink_->report(expr.text_span, diag::kBadOperand, expr.text, quoted_types(a, b));
        if (expr.text == "*") {
            d.help("the product of linear algebra is `mul(a, b)`");
            const bool product = a.is_matrix() ? b.is_vector() && a.size == b.size
                                               : a.is_vector() && a.size == b.rows;
            if (product)
                d.insert_before(expr.args[0]->span, "mul(")
                    .replace(expr.text_span, ",")
                    .insert_after(expr.args[1]->span, ")");
        }
        return poison(expr.span);
    }
    const Type type = common_type(a, b);
    ExprPtr out = make(ExprKind::kBinary, type, expr.span);
    out->op = op;
    out->args.push_back(conversions_.implicit(std::move(left), type));
    out->args.push_back(conversions_.implicit(std::move(right), type));
    return out;
}

/// a + b, a * s, s * a: on the amounts of each material.
ExprPtr Operators::composition_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right) const {
    const std::string types = quoted_types(left->type, right->type);
    if (expr.text == "*" && right->type.is(Base::kComposition)) std::swap(left, right);
    const bool sum =
        expr.text == "+" && right->type.is(Base::kComposition) && left->type.is(Base::kComposition);
    const bool product = expr.text == "*" && right->type.is_scalar();
    if (!sum && !product) return bad_operand(sink_, expr, types);
    if (product) right = conversions_.implicit(std::move(right), kFloatType);
    ExprPtr out = make(ExprKind::kBinary, left->type, expr.span);
    out->op = sum ? ir::Op::kAdd : ir::Op::kMul;
    out->args.push_back(std::move(left));
    out->args.push_back(std::move(right));
    return out;
}

/// Warns about notation that means something else in mathematics: `2^3`, `0 < x < 1`.
void Operators::check_foreign_operators(const ast::Expr& expr, const Expr& left,
                                        const Expr& right) const {
    const auto literal = [](const ast::Expr& part) {
        return part.kind == ast::ExprKind::kIntLiteral && part.text.find('x') == std::string::npos;
    };
    if (expr.text == "^" && literal(*expr.args[0]) && literal(*expr.args[1])) {
        sink_->report(expr.text_span, diag::kXorPower, static_cast<int>(left.bits ^ right.bits))
            .help(fmt::format("a power is written `pow({}, {})`", expr.args[0]->text,
                              expr.args[1]->text))
            .replace(expr.span, fmt::format("pow({}, {})", expr.args[0]->text, expr.args[1]->text));
    }
    const ast::Expr& inner = *expr.args[0];
    const bool chained = is_order(expr.text) && inner.kind == ast::ExprKind::kBinary &&
                         is_order(inner.text) && inner.span.begin == inner.args[0]->span.begin;
    if (!chained) return;
    sink_->report(expr.text_span, diag::kChainedComparison, expr.text)
        .help(
            fmt::format("`a {0} b {1} c` compares the result of `a {0} b`, 0 or 1, with `c`; write "
                        "`a {0} b && b {1} c`",
                        inner.text, expr.text));
}

}  // namespace openfab::check
