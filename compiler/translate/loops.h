// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Loops: unrolled if the number of iterations is constant and the result stays small, else real
// loops. A real loop is translated as `if (test) do { body; step; } while (test)`, since every
// iteration costs a pass over memory. A failed attempt is rolled back, code and diagnostics, before
// the next.

#include <map>
#include <set>
#include <vector>

#include "compiler/translate/statements.h"

namespace openfab::translate {

class Loops {
  public:
    Loops(diag::Sink* sink, ir::Stage* stage, Emitter* emit, Paths* paths, Budget* budget,
          Facts* facts, Expressions* expressions, StatementTranslator* statements)
        : sink_(sink),
          stage_(stage),
          emit_(*emit),
          paths_(*paths),
          budget_(*budget),
          facts_(*facts),
          expressions_(*expressions),
          statements_(*statements) {}
    void loop(const check::Stmt& stmt);

  private:
    /// The state to roll back to when an attempt at a loop fails.
    struct Attempt {
        size_t instructions = 0;
        size_t printfs = 0;
        diag::Sink::Mark reported;
        std::vector<Variable> variables;
        std::vector<Branch> open;
        Frame frame;
        ir::ValueId live = 0;
        int inline_depth = 0;
    };
    /// A real loop before its end is emitted. The variables are in the order of `changes`.
    struct RealLoop {
        ir::ValueId id = 0;
        ir::ValueId again = 0;
        ir::ValueId count = ir::kNoValue;  ///< iteration counter, after the variables; with @bound
        size_t vars = 0;                   ///< components
        Changes changes;
        std::map<VariableId, Value> assigned_before;  ///< at the start of any iteration
    };

    Attempt attempt() const;
    void rollback_code(const Attempt& start);
    void rollback(const Attempt& start);
    bool fits_unroll_budget(size_t begin, int trips);
    bool unroll(const check::Stmt& stmt);
    bool unroll_in_steps(const check::Stmt& stmt);
    std::set<VariableId> guess_changed(const check::Stmt& stmt) const;
    void run_loop(const check::Stmt& stmt);
    void push_start_test(const check::Stmt& stmt);
    RealLoop make_loop(const check::Stmt& stmt, ir::ValueId guard,
                       const std::set<VariableId>& changed);
    void finish_loop(const check::Stmt& stmt, const RealLoop& loop, ir::ValueId guard,
                     bool certain);

    diag::Sink* sink_;
    ir::Stage* stage_;
    Emitter& emit_;
    Paths& paths_;
    Budget& budget_;
    Facts& facts_;
    Expressions& expressions_;
    StatementTranslator& statements_;
    std::vector<ir::ValueId> tests_;         ///< of the open real loops, in this iteration
    std::set<const check::Stmt*> too_long_;  ///< loops that reached the limit of unrolling
};

}  // namespace openfab::translate
