// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "compiler/check/conversions.h"
#include "compiler/check/nodes.h"
#include "compiler/check/unknown_names.h"

namespace openfab::check {

ir::Op binary_op(std::string_view text);
/// Returns "`float` and `int`", for messages.
std::string quoted_types(const Type& a, const Type& b);
/// Reports operands that an operator does not take.
ExprPtr bad_operand(diag::Sink* sink, const ast::Expr& expr, const std::string& types);

/// Operators without effects, but those of conditions.
class Operators {
  public:
    Operators(diag::Sink* sink, const Names& names, const UnknownNames& unknown,
              const Conversions& conversions, Expressions* expressions)
        : sink_(sink),
          names_(names),
          unknown_(unknown),
          conversions_(conversions),
          expressions_(*expressions) {}
    ExprPtr unary(const ast::Expr& expr) const;
    ExprPtr binary(const ast::Expr& expr) const;

  private:
    ExprPtr matrix_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right) const;
    ExprPtr composition_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right) const;
    void check_foreign_operators(const ast::Expr& expr, const Expr& left, const Expr& right) const;

    diag::Sink* sink_;
    const Names& names_;
    const UnknownNames& unknown_;
    const Conversions& conversions_;
    Expressions& expressions_;
};

}  // namespace openfab::check
