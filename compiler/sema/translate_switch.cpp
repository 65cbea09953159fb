// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/sema/translate_state.h"

namespace openfab::sema {

using ir::Op;
using ir::ValueId;

/// Sections exclude each other, since none runs into the next: a chain of branches. `break` leaves
/// the chain as it leaves a loop; `continue` goes on to the loop around it.
void StageTranslator::switch_statement(const Stmt& stmt) {
    const ValueId selector = scalar(*stmt.expr);
    if (gave_up_) return;
    ValueId any = emit_.boolean(false);
    std::vector<ValueId> conditions;
    for (const Stmt::Labels& labels : stmt.labels) {
        ValueId here = emit_.boolean(false);
        for (uint32_t value : labels.values) {
            const ValueId label = emit_.constant(emit_.type(selector), value);
            here = emit_.logical_or(here, emit_.binary(Op::kEq, selector, label));
        }
        conditions.push_back(here);
        any = emit_.logical_or(any, here);
    }
    for (size_t i = 0; i < stmt.labels.size(); ++i) {
        if (!stmt.labels[i].is_default) continue;
        conditions[i] = emit_.logical_or(conditions[i], emit_.logical_not(any));
    }
    const Frame outer = frame_;
    frame_.in_loop = true;
    frame_.broken = add_flag();
    if (!outer.in_loop) frame_.continued = add_flag();
    switch_sections(stmt, conditions, 0);
    frame_.in_loop = outer.in_loop;
    frame_.broken = outer.broken;
    frame_.continued = outer.continued;
}

void StageTranslator::switch_sections(const Stmt& stmt, const std::vector<ValueId>& conditions,
                                      size_t at) {
    if (at == stmt.body.size() || gave_up_) return;
    branch(
        conditions[at], [&] { statements(stmt.body[at]->body); },
        [&] { switch_sections(stmt, conditions, at + 1); });
}

}  // namespace openfab::sema
