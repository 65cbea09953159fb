// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/translate/targets.h"

namespace openfab::translate {

/// Methods of mixtures, and `over`.
class Mixtures {
  public:
    Mixtures(Emitter* emit, Formulas* formulas, Layout* layout, const Budget& budget,
             Expressions* expressions, Targets* targets)
        : emit_(*emit),
          formulas_(*formulas),
          layout_(*layout),
          budget_(budget),
          expressions_(*expressions),
          targets_(*targets) {}
    Value composition(const check::Expr& expr);
    Value over(const check::Expr& expr);

  private:
    Emitter& emit_;
    Formulas& formulas_;
    Layout& layout_;
    const Budget& budget_;
    Expressions& expressions_;
    Targets& targets_;
};

}  // namespace openfab::translate
