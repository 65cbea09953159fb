// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "compiler/translate/statements.h"
#include "compiler/translate/targets.h"

namespace openfab::translate {

/// Calls of the program's functions, which are inlined.
class Calls {
  public:
    Calls(diag::Sink* sink, const Place& place, Emitter* emit, Paths* paths, Layout* layout,
          Budget* budget, const Facts& facts, Expressions* expressions, Targets* targets,
          StatementTranslator* statements)
        : sink_(sink),
          place_(place),
          emit_(*emit),
          paths_(*paths),
          layout_(*layout),
          budget_(*budget),
          facts_(facts),
          expressions_(*expressions),
          targets_(*targets),
          statements_(*statements) {}
    Value inline_call(const check::Expr& expr);
    /// Returns the body's result; `results` receives the final values of its parameters.
    Value run_body(const check::Function& f, std::vector<Variable> arguments,
                   std::vector<Value>* results);
    Value result(const check::Function& f, const check::Type& type, int32_t number,
                 const std::vector<Variable>& arguments);
    void check_returned(const source::Span& span, const std::string& what, const check::Type& type,
                        const check::Stmt& body);
    void check_assigned(const Variable& v, const check::Symbol& symbol);
    /// The functions that were called.
    const std::set<const check::Function*>& inlined() const { return inlined_; }
    void add_inlined(const check::Function& f) { inlined_.insert(&f); }

  private:
    Value call(const check::Expr& expr);

    diag::Sink* sink_;
    const Place& place_;
    Emitter& emit_;
    Paths& paths_;
    Layout& layout_;
    Budget& budget_;
    const Facts& facts_;
    Expressions& expressions_;
    Targets& targets_;
    StatementTranslator& statements_;
    std::map<const check::Function*, int32_t> callees_;
    std::set<const check::Function*> inlined_;
};

}  // namespace openfab::translate
