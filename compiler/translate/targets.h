// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/diag/sink.h"
#include "compiler/translate/budget.h"
#include "compiler/translate/expressions.h"
#include "compiler/translate/facts.h"
#include "compiler/translate/layout.h"

namespace openfab::translate {

/// Components of a variable or value, selected where `condition` holds.
struct Alternative {
    ir::ValueId condition = 0;  ///< kNoValue until make_conditions
    std::vector<size_t> lanes;
};

/// A varying index, of so many elements.
struct VaryingIndex {
    ir::ValueId value = 0;
    size_t count = 0;
};

/// The target of an assignment or a selection: one of several alternatives, of which exactly
/// one condition holds. Without alternatives after an error.
struct Target {
    const check::Symbol* symbol = nullptr;  ///< the variable, or null: `value`
    Value value;
    std::vector<Alternative> alternatives;
    std::vector<VaryingIndex> indices;  ///< whose product is how many there are
};

/// Reads and writes parts of variables and values.
class Targets {
  public:
    Targets(diag::Sink* sink, Emitter* emit, Paths* paths, Layout* layout, Budget* budget,
            const Facts& facts, Expressions* expressions)
        : sink_(sink),
          emit_(*emit),
          paths_(*paths),
          layout_(*layout),
          budget_(*budget),
          facts_(facts),
          expressions_(*expressions) {}
    Target target(const check::Expr& expr);
    Value read(const Target& target, const check::Expr& expr);
    void store(Target target, const Value& value);

  private:
    ir::ValueId index_is(ir::ValueId index, int k, int count);
    void pick_element(const check::Expr& expr, Target* target);
    void make_conditions(Target* target);
    ir::ValueId picked_alternative(const Target& target);
    void check_read(const Target& of, const source::Span& span);
    void take_as_assigned(const Target& target);

    diag::Sink* sink_;
    Emitter& emit_;
    Paths& paths_;
    Layout& layout_;
    Budget& budget_;
    const Facts& facts_;
    Expressions& expressions_;
};

}  // namespace openfab::translate
