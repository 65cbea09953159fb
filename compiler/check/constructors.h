// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/check/declared_types.h"
#include "compiler/check/initializers.h"

namespace openfab::check {

/// Values of a named type: `float3(1, 2, 3)`, `Pair(1, 2)`, and casts.
class Constructors {
  public:
    Constructors(diag::Sink* sink, const Conversions& conversions, DeclaredTypes* types,
                 const Initializers& initializers, Expressions* expressions)
        : sink_(sink),
          conversions_(conversions),
          types_(*types),
          initializers_(initializers),
          expressions_(*expressions) {}
    ExprPtr construct(const ast::Expr& expr, const Type& type, std::vector<ExprPtr> args) const;
    ExprPtr construct_struct(const ast::Expr& expr, const Type& type) const;
    ExprPtr cast(const ast::Expr& expr) const;

  private:
    Type cast_type(const ast::Expr& expr) const;
    void check_matrix_of(const ast::Expr& expr, const Type& type, const Expr& value) const;

    diag::Sink* sink_;
    const Conversions& conversions_;
    DeclaredTypes& types_;
    const Initializers& initializers_;
    Expressions& expressions_;
};

}  // namespace openfab::check
