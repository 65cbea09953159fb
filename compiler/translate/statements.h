// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "compiler/diag/sink.h"
#include "compiler/translate/budget.h"
#include "compiler/translate/expressions.h"
#include "compiler/translate/facts.h"
#include "compiler/translate/layout.h"

namespace openfab::translate {

class Loops;

class StatementTranslator {
  public:
    StatementTranslator(diag::Sink* sink, const Place& place, Emitter* emit, Paths* paths,
                        Layout* layout, Budget* budget, const Facts& facts,
                        Expressions* expressions, Loops* loops)
        : sink_(sink),
          place_(place),
          emit_(*emit),
          paths_(*paths),
          layout_(*layout),
          budget_(*budget),
          facts_(facts),
          expressions_(*expressions),
          loops_(*loops) {}
    void statement(const check::Stmt& stmt);
    void list(const std::vector<check::StmtPtr>& list);
    bool skip_where_exited(std::vector<ir::ValueId>* pending);

  private:
    /// One section of a `switch`.
    struct Section {
        ir::ValueId condition = 0;
        const check::Stmt* stmt = nullptr;
    };

    void declare(const check::Stmt& stmt);
    void return_statement(const check::Stmt& stmt);
    void switch_statement(const check::Stmt& stmt);
    void sections(const std::vector<Section>& sections, size_t at);

    diag::Sink* sink_;
    const Place& place_;
    Emitter& emit_;
    Paths& paths_;
    Layout& layout_;
    Budget& budget_;
    const Facts& facts_;
    Expressions& expressions_;
    Loops& loops_;
};

}  // namespace openfab::translate
