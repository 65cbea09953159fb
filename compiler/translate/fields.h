// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/translate/calls.h"
#include "compiler/translate/printing.h"

namespace openfab::translate {

/// `gradient` and `mean_curvature`.
class Fields {
  public:
    Fields(diag::Sink* sink, const Place& place, Emitter* emit, Layout* layout, Budget* budget,
           Expressions* expressions, Calls* calls, Printing* printing)
        : sink_(sink),
          place_(place),
          emit_(*emit),
          layout_(*layout),
          budget_(*budget),
          expressions_(*expressions),
          calls_(*calls),
          printing_(*printing) {}
    Value field(const check::Expr& expr);

  private:
    void report(const check::Expr& expr, const ir::Instr& fault);

    diag::Sink* sink_;
    const Place& place_;
    Emitter& emit_;
    Layout& layout_;
    Budget& budget_;
    Expressions& expressions_;
    Calls& calls_;
    Printing& printing_;
};

}  // namespace openfab::translate
