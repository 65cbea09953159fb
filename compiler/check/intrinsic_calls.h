// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/check/conditions.h"
#include "compiler/check/own_functions.h"

namespace openfab::check {

/// Calls of built-in functions: compiler/check/intrinsics.h.
class Intrinsics {
  public:
    Intrinsics(diag::Sink* sink, const Conversions& conversions, const Conditions& conditions,
               const OwnFunctions& own)
        : sink_(sink), conversions_(conversions), conditions_(conditions), own_(own) {}
    ExprPtr call(const ast::Expr& expr, const IntrinsicInfo& info, std::vector<ExprPtr> args) const;

  private:
    ExprPtr bits(const ast::Expr& expr, const IntrinsicInfo& info, std::vector<ExprPtr> args) const;

    diag::Sink* sink_;
    const Conversions& conversions_;
    const Conditions& conditions_;
    const OwnFunctions& own_;
};

}  // namespace openfab::check
