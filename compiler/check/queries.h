// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "compiler/check/conversions.h"
#include "compiler/check/stage_rules.h"
#include "compiler/syntax/ast.h"

namespace openfab::check {

class Queries {
  public:
    Queries(diag::Sink* sink, const Place& place, const StageRules& rules,
            const Conversions& conversions)
        : sink_(sink), place_(place), rules_(rules), conversions_(conversions) {}
    static bool asks(std::string_view name);
    ExprPtr distance(const ast::Expr& expr, std::vector<ExprPtr> args) const;
    /// `nearest(p)` or `distance_to(object, p)`.
    ExprPtr surface(const ast::Expr& expr, std::vector<ExprPtr> args) const;

    /// `walk_end(p, stop, seed)` or `walk_end(object, p, stop, seed)`.
    ExprPtr walk(const ast::Expr& expr, std::vector<ExprPtr> args) const;

  private:
    bool is_in_volume(const ast::Expr& callee, const char* help) const;

    diag::Sink* sink_;
    const Place& place_;
    const StageRules& rules_;
    const Conversions& conversions_;
};

}  // namespace openfab::check
