// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/translate/budget.h"
#include "compiler/translate/expressions.h"
#include "compiler/translate/paths.h"
#include "compiler/translate/stage_rules.h"

namespace openfab::translate {

/// `printf` and `assert`, which emit nothing unless they are enabled.
class Printing {
  public:
    Printing(ir::Stage* stage, Emitter* emit, const Paths& paths, const Budget& budget,
             StageRules* rules, Expressions* expressions)
        : stage_(stage),
          emit_(*emit),
          paths_(paths),
          budget_(budget),
          rules_(*rules),
          expressions_(*expressions) {}
    Value call(const check::Expr& expr);

    bool enabled = false;

  private:
    ir::Stage* stage_;
    Emitter& emit_;
    const Paths& paths_;
    const Budget& budget_;
    StageRules& rules_;
    Expressions& expressions_;
};

}  // namespace openfab::translate
