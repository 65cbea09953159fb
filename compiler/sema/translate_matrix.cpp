// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Functions of matrices and the switch statement. Components of a matrix stand row by row. Sums go
// from the first term to the last, each product rounded.
#include <numeric>

#include "compiler/sema/translate_state.h"

namespace openfab::sema {

using ir::Op;
using ir::ValueId;

namespace {

/// The value without row `r` and column `c` of an n by n matrix.
Value minor_of(const Value& m, size_t n, size_t r, size_t c) {
    Value out;
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; j < n; ++j) {
            if (i != r && j != c) out.push_back(m[i * n + j]);
        }
    }
    return out;
}

}  // namespace

/// Row by row and column by column; `inner` terms each.
Value StageTranslator::product(const Value& a, const Value& b, size_t inner) {
    const size_t rows = a.size() / inner;
    const size_t columns = b.size() / inner;
    Value out;
    for (size_t i = 0; i < rows; ++i) {
        for (size_t j = 0; j < columns; ++j) {
            Value row;
            Value column;
            for (size_t k = 0; k < inner; ++k) {
                row.push_back(a[i * inner + k]);
                column.push_back(b[k * columns + j]);
            }
            out.push_back(dot(row, column));
        }
    }
    return out;
}

/// By the first row: m00 * |minor| - m01 * |minor| + …
ValueId StageTranslator::determinant(const Value& m, size_t n) {
    if (n == 1) return m[0];
    ValueId sum = 0;
    for (size_t c = 0; c < n; ++c) {
        const ValueId term = emit_.binary(Op::kMul, m[c], determinant(minor_of(m, n, 0, c), n - 1));
        sum = c == 0 ? term : emit_.binary(c % 2 == 0 ? Op::kAdd : Op::kSub, sum, term);
    }
    return sum;
}

/// The transposed cofactors, each divided by the determinant; of a singular matrix not finite.
Value StageTranslator::inverse(const Value& m, size_t n) {
    const ValueId whole = determinant(m, n);
    Value out;
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; j < n; ++j) {
            ValueId cofactor = determinant(minor_of(m, n, j, i), n - 1);
            if ((i + j) % 2 != 0) cofactor = emit_.unary(Op::kNeg, cofactor);
            out.push_back(emit_.binary(Op::kDiv, cofactor, whole));
        }
    }
    return out;
}

Value StageTranslator::matrix(const Expr& expr) {
    std::vector<Value> args;
    for (const ExprPtr& arg : expr.args)
        args.push_back(expression(*arg));
    if (gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    const Type& type = expr.args[0]->type;
    const auto columns = static_cast<size_t>(type.size);
    switch (expr.matrix_op) {
        case MatrixOp::kMul:
            return product(args[0], args[1], columns);
        case MatrixOp::kTranspose: {
            Value out;
            for (size_t j = 0; j < columns; ++j) {
                for (size_t i = 0; i < static_cast<size_t>(type.rows); ++i)
                    out.push_back(args[0][i * columns + j]);
            }
            return out;
        }
        case MatrixOp::kDeterminant:
            return {determinant(args[0], columns)};
        case MatrixOp::kInverse:
            return inverse(args[0], columns);
    }
    return zero(expr.type);
}

/// The amounts of the upper one, and of the lower one what it leaves free:
/// above + below * (1 - saturate(above.Total())).
Value StageTranslator::over(const Expr& expr) {
    const Value above = expression(*expr.args[0]);
    const Value below = expression(*expr.args[1]);
    if (above.empty() || gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    const ValueId total = clamp(sum(above), emit_.constant(0.0f), emit_.constant(1.0f));
    const ValueId rest = emit_.binary(Op::kSub, emit_.constant(1.0f), total);
    return binary_values(Op::kAdd, above, binary_values(Op::kMul, below, {rest}));
}

/// Nothing at all unless printing was asked for; the values then belong to the path that gets here.
Value StageTranslator::print(const Expr& expr) {
    if (!prints_ || gave_up_) return {};
    ValueId guard = live_;
    std::vector<ValueId> args = {guard};
    for (size_t i = 0; i < expr.args.size(); ++i) {
        const Value part = expression(*expr.args[i]);
        if (expr.is_assert && i == 0) {
            args[0] = emit_.logical_and(guard, emit_.logical_not(part[0]));
        } else {
            args.insert(args.end(), part.begin(), part.end());
        }
    }
    if (gave_up_ || emit_.is_false(args[0])) return {};
    emit_.set_span(expr.span);
    emit_.print(static_cast<int32_t>(stage_->prints.size()), std::move(args));
    stage_->prints.push_back({expr.text, expr.is_assert, expr.span});
    return {};
}

/// Sections exclude each other, since none runs into the next: a chain of branches. `break` leaves
/// the chain as it leaves a loop; `continue` goes on to the loop around it.
void StageTranslator::switch_statement(const Stmt& stmt) {
    const ValueId selector = scalar(*stmt.expr);
    if (gave_up_) return;
    ValueId any = emit_.boolean(false);
    std::vector<ValueId> conditions;
    for (const Stmt::Labels& labels : stmt.labels) {
        ValueId here = emit_.boolean(false);
        for (uint32_t value : labels.values) {
            const ValueId label = emit_.constant(emit_.type(selector), value);
            here = emit_.logical_or(here, emit_.binary(Op::kEq, selector, label));
        }
        conditions.push_back(here);
        any = emit_.logical_or(any, here);
    }
    for (size_t i = 0; i < stmt.labels.size(); ++i) {
        if (!stmt.labels[i].is_default) continue;
        conditions[i] = emit_.logical_or(conditions[i], emit_.logical_not(any));
    }
    const Frame outer = frame_;
    frame_.in_loop = true;
    frame_.broken = add_flag();
    if (!outer.in_loop) frame_.continued = add_flag();
    switch_sections(stmt, conditions, 0);
    frame_.in_loop = outer.in_loop;
    frame_.broken = outer.broken;
    frame_.continued = outer.continued;
}

void StageTranslator::switch_sections(const Stmt& stmt, const std::vector<ValueId>& conditions,
                                      size_t at) {
    if (at == stmt.body.size() || gave_up_) return;
    branch(
        conditions[at], [&] { statements(stmt.body[at]->body); },
        [&] { switch_sections(stmt, conditions, at + 1); });
}

}  // namespace openfab::sema
