// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "compiler/translate/budget.h"
#include "compiler/translate/expressions.h"
#include "compiler/translate/layout.h"

namespace openfab::translate {

/// Values of constants.
class Constants {
  public:
    Constants(Emitter* emit, const Layout& layout, Budget* budget, Expressions* expressions)
        : emit_(*emit), layout_(layout), budget_(*budget), expressions_(*expressions) {}
    Value value(const check::Symbol& symbol);
    /// Evaluates outside the limits of a loop that is being unrolled around it.
    Value expression(const check::Expr& expr);

  private:
    Emitter& emit_;
    const Layout& layout_;
    Budget& budget_;
    Expressions& expressions_;
    std::map<const check::Symbol*, std::vector<uint32_t>> known_;  ///< tables, by component
};

}  // namespace openfab::translate
