// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/check/initializers.h"
#include "compiler/check/targets.h"
#include "compiler/check/unknown_names.h"

namespace openfab::check {

/// `=`, `+=`, `++` and the like.
class Assignments {
  public:
    Assignments(diag::Sink* sink, const Names& names, UnknownNames* unknown,
                const Conversions& conversions, const Targets& targets,
                const Initializers& initializers, Expressions* expressions)
        : sink_(sink),
          names_(names),
          unknown_(*unknown),
          conversions_(conversions),
          targets_(targets),
          initializers_(initializers),
          expressions_(*expressions) {}
    ExprPtr assign(const ast::Expr& expr) const;
    ExprPtr increment(const ast::Expr& expr) const;

  private:
    bool report_undeclared(const ast::Expr& expr) const;

    diag::Sink* sink_;
    const Names& names_;
    UnknownNames& unknown_;
    const Conversions& conversions_;
    const Targets& targets_;
    const Initializers& initializers_;
    Expressions& expressions_;
};

}  // namespace openfab::check
