// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/check/conversions.h"
#include "compiler/check/nodes.h"
#include "compiler/check/targets.h"
#include "compiler/check/unknown_names.h"

namespace openfab::check {

class Methods {
  public:
    Methods(diag::Sink* sink, const Place& place, const StageRules& rules,
            const UnknownNames& unknown, const Conversions& conversions, const Targets& targets,
            Expressions* expressions)
        : sink_(sink),
          place_(place),
          rules_(rules),
          unknown_(unknown),
          conversions_(conversions),
          targets_(targets),
          expressions_(*expressions) {}
    ExprPtr call(const ast::Expr& expr) const;

  private:
    ExprPtr lookup(const ast::Expr& expr, ExprPtr texture, std::vector<ExprPtr> args) const;
    ExprPtr unknown_lookup(const ast::Expr& expr, const Type& texture) const;
    ExprPtr of_curve(const ast::Expr& expr, ExprPtr curve, std::vector<ExprPtr> args) const;
    ExprPtr of_dither(const ast::Expr& expr, std::vector<ExprPtr> args) const;
    ExprPtr of_composition(const ast::Expr& expr, ExprPtr object, std::vector<ExprPtr> args) const;

    diag::Sink* sink_;
    const Place& place_;
    const StageRules& rules_;
    const UnknownNames& unknown_;
    const Conversions& conversions_;
    const Targets& targets_;
    Expressions& expressions_;
};

}  // namespace openfab::check
