// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/check/conversions.h"
#include "compiler/check/nodes.h"

namespace openfab::check {

/// First values: expressions, and lists in `{ }`.
class Initializers {
  public:
    Initializers(diag::Sink* sink, const Conversions& conversions, Expressions* expressions)
        : sink_(sink), conversions_(conversions), expressions_(*expressions) {}
    /// Checks an initializer of type `to`.
    ExprPtr of(const ast::Expr& expr, const Type& to) const;

  private:
    ExprPtr list(const ast::Expr& expr, const Type& to) const;
    ExprPtr list_of(const ast::Expr& expr, const Type& to, const std::vector<Type>& parts) const;
    bool flatten(const ast::Expr& expr, const Type& to, std::vector<ExprPtr>* out) const;

    diag::Sink* sink_;
    const Conversions& conversions_;
    Expressions& expressions_;
};

}  // namespace openfab::check
