// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/check/conversions.h"
#include "compiler/check/targets.h"
#include "compiler/syntax/ast.h"

namespace openfab::check {

/// Returns whether a built-in function has an `out` parameter.
bool writes_an_argument(Intrinsic id);

/// Calls of the built-in functions whose arguments are not all of one type.
class OwnFunctions {
  public:
    OwnFunctions(diag::Sink* sink, const Place& place, const StageRules& rules,
                 const Conversions& conversions, const Targets& targets)
        : sink_(sink), place_(place), rules_(rules), conversions_(conversions), targets_(targets) {}
    ExprPtr call(const ast::Expr& expr, const IntrinsicInfo& info, std::vector<ExprPtr> args) const;

  private:
    ExprPtr convert_arguments(const ast::Expr& expr, const IntrinsicInfo& info,
                              const char* parameters, char result, int size,
                              std::vector<ExprPtr> args) const;

    diag::Sink* sink_;
    const Place& place_;
    const StageRules& rules_;
    const Conversions& conversions_;
    const Targets& targets_;
};

}  // namespace openfab::check
