// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/check/constructors.h"
#include "compiler/check/fields.h"
#include "compiler/check/intrinsic_calls.h"
#include "compiler/check/matrix_functions.h"
#include "compiler/check/methods.h"
#include "compiler/check/printing.h"
#include "compiler/check/queries.h"

namespace openfab::check {

/// Finds what a call calls.
class Calls {
  public:
    Calls(diag::Sink* sink, Names* names, const Place& place, const StageRules& rules,
          const UnknownNames& unknown, const Conversions& conversions, const Targets& targets,
          const Conditions& conditions, const Constructors& constructors, Expressions* expressions)
        : sink_(sink),
          names_(*names),
          unknown_(unknown),
          constructors_(constructors),
          expressions_(*expressions),
          overloads_(sink, names, place, conversions, targets),
          fields_(sink, names, unknown, overloads_, expressions),
          own_(sink, place, rules, conversions, targets),
          intrinsics_(sink, conversions, conditions, own_),
          matrices_(sink, conversions),
          queries_(sink, place, rules, conversions),
          methods_(sink, place, rules, unknown, conversions, targets, expressions),
          printing_(sink, place, rules, conversions, conditions, expressions) {}
    ExprPtr call(const ast::Expr& expr) const;

  private:
    diag::Sink* sink_;
    Names& names_;
    const UnknownNames& unknown_;
    const Constructors& constructors_;
    Expressions& expressions_;
    const Overloads overloads_;
    const Fields fields_;
    const OwnFunctions own_;
    const Intrinsics intrinsics_;
    const MatrixFunctions matrices_;
    const Queries queries_;
    const Methods methods_;
    const Printing printing_;
};

}  // namespace openfab::check
