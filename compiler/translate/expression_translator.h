// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Expressions: operators and variables here, each other kind in a class of its own.

#include "compiler/translate/built_ins.h"
#include "compiler/translate/calls.h"
#include "compiler/translate/constants.h"
#include "compiler/translate/fields.h"
#include "compiler/translate/mixtures.h"
#include "compiler/translate/queries.h"

namespace openfab::translate {

class ExpressionTranslator final : public Expressions {
  public:
    ExpressionTranslator(diag::Sink* sink, const Place& place, ir::Stage* stage, Emitter* emit,
                         Paths* paths, Layout* layout, Budget* budget, const Facts& facts,
                         StatementTranslator* statements)
        : place_(place),
          emit_(*emit),
          paths_(*paths),
          layout_(*layout),
          budget_(*budget),
          formulas_(emit),
          rules_(sink, place),
          inputs_(emit, &formulas_, place),
          constants_(emit, *layout, budget, this),
          targets_(sink, emit, paths, layout, budget, facts, this),
          calls_(sink, place, emit, paths, layout, budget, facts, this, &targets_, statements),
          printing_(stage, emit, *paths, *budget, &rules_, this),
          fields_(sink, place, emit, layout, budget, this, &calls_, &printing_),
          built_ins_(sink, place, emit, &formulas_, layout, *budget, &rules_, this, &targets_),
          queries_(sink, place, emit, &formulas_, *paths, layout, *budget, &rules_, &inputs_, this),
          mixtures_(emit, &formulas_, layout, *budget, this, &targets_) {}
    ExpressionTranslator(const ExpressionTranslator&) = delete;
    ExpressionTranslator& operator=(const ExpressionTranslator&) = delete;
    ~ExpressionTranslator() = default;

    Value expression(const check::Expr& expr) override;

    Calls& calls() { return calls_; }
    Constants& constants() { return constants_; }
    Printing& printing() { return printing_; }

  private:
    Value variable(const check::Expr& expr);
    Value convert(const Value& from, const check::Type& from_type, const check::Type& to);
    Value logical(const check::Expr& expr);
    Value conditional(const check::Expr& expr);
    Value assign(const check::Expr& expr);
    Value increment(const check::Expr& expr);

    const Place& place_;
    Emitter& emit_;
    Paths& paths_;
    Layout& layout_;
    Budget& budget_;
    Formulas formulas_;
    StageRules rules_;
    StageInputs inputs_;
    Constants constants_;
    Targets targets_;
    Calls calls_;
    Printing printing_;
    Fields fields_;
    BuiltIns built_ins_;
    Queries queries_;
    Mixtures mixtures_;
};

}  // namespace openfab::translate
