// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The translator of one stage, private to compiler/translate. It holds what its statements, expressions and
// loops share.

#include <set>
#include <vector>

#include "compiler/translate/expression_translator.h"
#include "compiler/translate/loops.h"
#include "compiler/translate/translate.h"

namespace openfab::translate {

class StageTranslator {
  public:
    StageTranslator(const check::Fablet& fablet, ir::StageKind kind, ir::Stage* out,
                    diag::Sink* sink)
        : place_{fablet, kind},
          stage_(out),
          sink_(sink),
          emit_(out),
          paths_(&emit_),
          layout_(&emit_, place_),
          budget_(&emit_, sink),
          facts_(&emit_, paths_, *out),
          statements_(sink, place_, &emit_, &paths_, &layout_, &budget_, facts_, &expressions_,
                      &loops_),
          expressions_(sink, place_, out, &emit_, &paths_, &layout_, &budget_, facts_,
                       &statements_),
          loops_(sink, out, &emit_, &paths_, &budget_, &facts_, &expressions_, &statements_) {}
    StageTranslator(const StageTranslator&) = delete;
    StageTranslator& operator=(const StageTranslator&) = delete;

    /// Translates the stage's own body with its outputs.
    void run(const check::Stage& stage, const TranslateOptions& options);
    /// Evaluates an expression outside a stage, such as a uniform's default: empty unless all its
    /// components are constants.
    std::vector<uint32_t> constant_bits(const check::Expr& expr);
    /// Translates a function in isolation, with unknown arguments; only the diagnostics are of use.
    void run(const check::Function& function);
    /// Returns the functions that were called.
    const std::set<const check::Function*>& inlined() { return expressions_.calls().inlined(); }
    /// Returns the number of statements and calls that were translated.
    size_t steps() const { return budget_.steps; }

  private:
    void add_symbol(const check::Symbol& symbol);

    Place place_;
    ir::Stage* stage_;
    diag::Sink* sink_;
    Emitter emit_;
    Paths paths_;
    Layout layout_;
    Budget budget_;
    Facts facts_;
    StatementTranslator statements_;
    ExpressionTranslator expressions_;
    Loops loops_;
};

}  // namespace openfab::translate
