// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Functions of matrices, which are row-major.
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

Value StageTranslator::matrix(const check::Expr& expr) {
    std::vector<Value> args;
    for (const check::ExprPtr& arg : expr.args)
        args.push_back(expression(*arg));
    if (gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    const check::Type& type = expr.args[0]->type;
    const auto columns = static_cast<size_t>(type.size);
    switch (expr.matrix_op) {
        case check::MatrixOp::kMul:
            return formulas_.product(args[0], args[1], columns);
        case check::MatrixOp::kTranspose: {
            Value out;
            for (size_t j = 0; j < columns; ++j) {
                for (size_t i = 0; i < static_cast<size_t>(type.rows); ++i)
                    out.push_back(args[0][i * columns + j]);
            }
            return out;
        }
        case check::MatrixOp::kDeterminant:
            return {formulas_.determinant(args[0], columns)};
        case check::MatrixOp::kInverse:
            return formulas_.inverse(args[0], columns);
    }
    return zero(expr.type);
}

}  // namespace openfab::translate
