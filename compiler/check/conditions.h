// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "compiler/check/conversions.h"
#include "compiler/check/nodes.h"

namespace openfab::check {

class Conditions {
  public:
    Conditions(diag::Sink* sink, const Conversions& conversions, Expressions* expressions)
        : sink_(sink), conversions_(conversions), expressions_(*expressions) {}
    /// Checks a condition of one answer, as a bool.
    ExprPtr condition(const ast::Expr& expr) const;
    ExprPtr logical(const ast::Expr& expr) const;
    ExprPtr conditional(const ast::Expr& expr) const;
    ExprPtr choose(const ast::Expr& expr, const source::Span& at, std::string_view name,
                   std::vector<ExprPtr> args) const;
    ExprPtr bools(const ast::Expr& expr, const IntrinsicInfo& info,
                  std::vector<ExprPtr> args) const;

  private:
    ExprPtr tested(const ast::Expr& expr) const;

    diag::Sink* sink_;
    const Conversions& conversions_;
    Expressions& expressions_;
};

}  // namespace openfab::check
