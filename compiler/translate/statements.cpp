// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/statements.h"

#include <fmt/format.h>

#include <utility>

#include "compiler/translate/loops.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

/// Called between two statements: returns false if the second one is unreachable. If some paths
/// reach it, the rest becomes a branch, which `unwind` closes.
bool StatementTranslator::skip_where_exited(std::vector<ValueId>* pending) {
    const ValueId exit = paths_.exited();
    if (facts_.always(exit) || budget_.gave_up) return false;
    if (emit_.is_false(exit)) return true;
    pending->push_back(exit);
    paths_.enter(emit_.logical_not(exit));
    // Known to be false inside; merging restores the old values where they were true. A flag that
    // was false anyway does not become a variable of the loops around.
    const auto clear = [&](VariableId id) {
        if (!emit_.is_false(paths_.flag(id))) paths_.set_flag(id, emit_.constant(false));
    };
    clear(paths_.frame.returned);
    if (paths_.frame.in_loop) {
        clear(paths_.frame.broken);
        clear(paths_.frame.continued);
    }
    return true;
}

void StatementTranslator::list(const std::vector<check::StmtPtr>& list) {
    std::vector<ValueId> pending;
    for (const check::StmtPtr& child : list) {
        if (!skip_where_exited(&pending)) break;
        statement(*child);
    }
    paths_.unwind(pending);
}

void StatementTranslator::statement(const check::Stmt& stmt) {
    if (budget_.too_complex(stmt.span)) return;
    switch (stmt.kind) {
        case check::StmtKind::kBlock:
            return list(stmt.body);
        case check::StmtKind::kDeclare:
            return declare(stmt);
        case check::StmtKind::kExpression:
            expressions_.expression(*stmt.expr);
            return;
        case check::StmtKind::kIf:
            return paths_.branch(
                expressions_.scalar(*stmt.expr), [&] { statement(*stmt.body[0]); },
                [&] {
                    if (stmt.body.size() > 1) statement(*stmt.body[1]);
                });
        case check::StmtKind::kLoop:
            return loops_.loop(stmt);
        case check::StmtKind::kBreak:
            return paths_.set_flag(paths_.frame.broken, emit_.constant(true));
        case check::StmtKind::kContinue:
            return paths_.set_flag(paths_.frame.continued, emit_.constant(true));
        case check::StmtKind::kReturn:
            return return_statement(stmt);
        case check::StmtKind::kSwitch:
            return switch_statement(stmt);
    }
}

void StatementTranslator::declare(const check::Stmt& stmt) {
    // Before it is built, since a composition has a component for each material.
    if (check::min_components(stmt.symbol->type, place_.fablet.ir.slot_count) >
        check::kMaxComponents) {
        sink_->report(
            stmt.span, diag::kTooComplex,
            fmt::format("`{}` has more than {} components, counting those of each material",
                        stmt.symbol->name, check::kMaxComponents));
        budget_.gave_up = true;
        return;
    }
    Variable v;
    if (stmt.expr != nullptr) {
        v.value = expressions_.expression(*stmt.expr);
    } else {
        v.value = layout_.zero(stmt.symbol->type);
        v.assigned = layout_.unassigned(stmt.symbol->type);
    }
    paths_.frame.variables[stmt.symbol.get()] = paths_.add_variable(std::move(v));
}

void StatementTranslator::return_statement(const check::Stmt& stmt) {
    if (stmt.expr != nullptr) {
        Value value = expressions_.expression(*stmt.expr);
        if (!value.empty()) paths_.set(paths_.frame.result, {std::move(value), {}});
    }
    paths_.set_flag(paths_.frame.returned, emit_.constant(true));
}

/// Sections are exclusive, since there is no fallthrough: a chain of branches, in which `default`,
/// wherever it is written, comes last and runs if no other section does. `break` leaves the chain
/// as it leaves a loop; `continue` applies to the enclosing loop.
void StatementTranslator::switch_statement(const check::Stmt& stmt) {
    const ValueId selector = expressions_.scalar(*stmt.expr);
    if (budget_.gave_up) return;
    std::vector<Section> sections;
    const check::Stmt* otherwise = nullptr;
    for (size_t i = 0; i < stmt.labels.size(); ++i) {
        if (stmt.labels[i].is_default) {
            otherwise = stmt.body[i].get();
            continue;
        }
        ValueId here = emit_.constant(false);
        for (uint32_t value : stmt.labels[i].values) {
            const ValueId label = emit_.constant(emit_.type(selector), value);
            here = emit_.logical_or(here, emit_.binary(Op::kEq, selector, label));
        }
        sections.push_back({here, stmt.body[i].get()});
    }
    if (otherwise != nullptr) sections.push_back({emit_.constant(true), otherwise});
    const Frame outer = paths_.frame;
    paths_.frame.in_loop = true;
    paths_.frame.broken = paths_.add_flag();
    if (!outer.in_loop) paths_.frame.continued = paths_.add_flag();
    this->sections(sections, 0);
    paths_.frame.in_loop = outer.in_loop;
    paths_.frame.broken = outer.broken;
    paths_.frame.continued = outer.continued;
}

void StatementTranslator::sections(const std::vector<Section>& sections, size_t at) {
    if (at == sections.size() || budget_.gave_up) return;
    paths_.branch(
        sections[at].condition, [&] { list(sections[at].stmt->body); },
        [&] { this->sections(sections, at + 1); });
}

}  // namespace openfab::translate
