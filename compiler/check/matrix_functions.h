// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/check/conversions.h"
#include "compiler/syntax/ast.h"

namespace openfab::check {

/// Functions of matrices, and `over`, of compositions.
class MatrixFunctions {
  public:
    MatrixFunctions(diag::Sink* sink, const Conversions& conversions)
        : sink_(sink), conversions_(conversions) {}
    ExprPtr call(const ast::Expr& expr, MatrixOp op, std::vector<ExprPtr> args) const;
    ExprPtr over(const ast::Expr& expr, std::vector<ExprPtr> args) const;

  private:
    ExprPtr mul(const ast::Expr& expr, std::vector<ExprPtr> args) const;

    diag::Sink* sink_;
    const Conversions& conversions_;
};

}  // namespace openfab::check
