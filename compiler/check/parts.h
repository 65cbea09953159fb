// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/check/conversions.h"
#include "compiler/check/nodes.h"
#include "compiler/check/unknown_names.h"

namespace openfab::check {

/// Parts of values: members, attributes, elements, and components of vectors and matrices.
class Parts {
  public:
    Parts(diag::Sink* sink, Names* names, const Place& place, const UnknownNames& unknown,
          const Conversions& conversions, Expressions* expressions)
        : sink_(sink),
          names_(*names),
          place_(place),
          unknown_(unknown),
          conversions_(conversions),
          expressions_(*expressions) {}
    ExprPtr member(const ast::Expr& expr) const;
    ExprPtr index(const ast::Expr& expr) const;

  private:
    ExprPtr struct_member(const ast::Expr& expr, ExprPtr object,
                          const std::vector<StructMember>& members) const;
    ExprPtr attribute_member(const ast::Expr& expr, const Type& attributes) const;
    ExprPtr swizzle(const ast::Expr& expr, ExprPtr object) const;
    ExprPtr matrix_swizzle(const ast::Expr& expr, ExprPtr object) const;

    diag::Sink* sink_;
    Names& names_;
    const Place& place_;
    const UnknownNames& unknown_;
    const Conversions& conversions_;
    Expressions& expressions_;
};

}  // namespace openfab::check
