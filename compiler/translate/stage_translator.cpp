// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

/// Sections are exclusive, since there is no fallthrough: a chain of branches, in which `default`,
/// wherever it is written, comes last and runs if no other section does. `break` leaves the chain
/// as it leaves a loop; `continue` applies to the enclosing loop.
void StageTranslator::switch_statement(const check::Stmt& stmt) {
    const ValueId selector = scalar(*stmt.expr);
    if (gave_up_) return;
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
    const Frame outer = frame_;
    frame_.in_loop = true;
    frame_.broken = add_flag();
    if (!outer.in_loop) frame_.continued = add_flag();
    switch_sections(sections, 0);
    frame_.in_loop = outer.in_loop;
    frame_.broken = outer.broken;
    frame_.continued = outer.continued;
}

void StageTranslator::switch_sections(const std::vector<Section>& sections, size_t at) {
    if (at == sections.size() || gave_up_) return;
    branch(
        sections[at].condition, [&] { statements(sections[at].stmt->body); },
        [&] { switch_sections(sections, at + 1); });
}

}  // namespace openfab::translate
