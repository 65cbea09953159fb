// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/check/conversions.h"
#include "compiler/check/names.h"
#include "compiler/check/targets.h"
#include "compiler/syntax/ast.h"

namespace openfab::check {

/// Returns whether one of the functions takes the arguments, perhaps converted.
bool any_match(const std::vector<const Function*>& candidates, const std::vector<ExprPtr>& args);

/// Calls of the program's functions.
class Overloads {
  public:
    Overloads(diag::Sink* sink, Names* names, const Place& place, const Conversions& conversions,
              const Targets& targets)
        : sink_(sink),
          names_(*names),
          place_(place),
          conversions_(conversions),
          targets_(targets) {}
    /// `callee`: the name; `span`: of the call.
    ExprPtr call(const ast::Expr& callee, const source::Span& span,
                 const std::vector<const Function*>& candidates, std::vector<ExprPtr> args) const;

  private:
    diag::Sink* sink_;
    Names& names_;
    const Place& place_;
    const Conversions& conversions_;
    const Targets& targets_;
};

}  // namespace openfab::check
