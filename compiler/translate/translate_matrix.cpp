// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Functions of matrices. Components of a matrix stand row by row. Sums go from the first term to
// the last, each product rounded.
#include "compiler/translate/translate_state.h"

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

}  // namespace openfab::sema
