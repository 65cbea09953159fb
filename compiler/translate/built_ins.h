// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls of built-in functions of values. Names, types and defaults: compiler/check. Formulas: formulas.cpp,
// compiler/functions.

#include "compiler/translate/targets.h"

namespace openfab::translate {

class BuiltIns {
  public:
    BuiltIns(diag::Sink* sink, const Place& place, Emitter* emit, Formulas* formulas,
             Layout* layout, const Budget& budget, StageRules* rules, Expressions* expressions,
             Targets* targets)
        : sink_(sink),
          place_(place),
          emit_(*emit),
          formulas_(*formulas),
          layout_(*layout),
          budget_(budget),
          rules_(*rules),
          expressions_(*expressions),
          targets_(*targets) {}
    Value intrinsic(const check::Expr& expr);
    Value matrix(const check::Expr& expr);
    Value curve(const check::Expr& expr);

  private:
    Value function(const check::Expr& expr);
    Value several_results(const check::Expr& expr);
    Value derivatives(const check::Expr& expr, const Value& x);

    diag::Sink* sink_;
    const Place& place_;
    Emitter& emit_;
    Formulas& formulas_;
    Layout& layout_;
    const Budget& budget_;
    StageRules& rules_;
    Expressions& expressions_;
    Targets& targets_;
};

}  // namespace openfab::translate
