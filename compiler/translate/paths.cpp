// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/paths.h"

#include <utility>

namespace openfab::translate {

using ir::ValueId;

VariableId Paths::add_variable(Variable v) {
    variables.push_back(std::move(v));
    return variables.size() - 1;
}

VariableId Paths::add_flag() {
    return add_variable({{emit_.constant(false)}, {}});
}

void Paths::set(VariableId id, Variable v) {
    if (!open.empty()) open.back().before.try_emplace(id, variables[id]);
    variables[id] = std::move(v);
}

void Paths::set_flag(VariableId id, ValueId value) {
    set(id, {{value}, {}});
}

void Paths::enter(ValueId condition) {
    open.push_back({{}, variables.size(), live});
    live = emit_.logical_and(live, condition);
}

Changes Paths::leave() {
    Branch branch = std::move(open.back());
    open.pop_back();
    live = branch.live;
    Changes after;
    for (auto& [id, before] : branch.before) {
        if (id >= branch.variables) continue;  // declared inside: not visible outside
        after.emplace(id, std::exchange(variables[id], std::move(before)));
    }
    variables.resize(branch.variables);
    return after;
}

void Paths::merge(ValueId condition, const Changes& yes, const Changes& no) {
    Changes all = yes;
    for (const auto& [id, v] : no)
        all.emplace(id, v);
    for (const auto& item : all) {
        const VariableId id = item.first;
        const Variable& a = yes.count(id) != 0 ? yes.at(id) : variables[id];
        const Variable& b = no.count(id) != 0 ? no.at(id) : variables[id];
        Variable merged;
        for (size_t i = 0; i < a.value.size(); ++i) {
            merged.value.push_back(emit_.select(condition, a.value[i], b.value[i]));
            if (a.assigned.empty() && b.assigned.empty()) continue;
            const ValueId yes_set = a.assigned.empty() ? emit_.constant(true) : a.assigned[i];
            const ValueId no_set = b.assigned.empty() ? emit_.constant(true) : b.assigned[i];
            merged.assigned.push_back(emit_.select(condition, yes_set, no_set));
        }
        set(id, std::move(merged));
    }
}

void Paths::branch(ValueId condition, const std::function<void()>& yes,
                   const std::function<void()>& no) {
    if (emit_.is_constant(condition)) return emit_.is_true(condition) ? yes() : no();
    enter(condition);
    yes();
    const Changes yes_changes = leave();
    enter(emit_.logical_not(condition));
    no();
    const Changes no_changes = leave();
    merge(condition, yes_changes, no_changes);
}

ValueId Paths::exited() {
    ValueId out = flag(frame.returned);
    if (!frame.in_loop) return out;
    out = emit_.logical_or(out, flag(frame.broken));
    return emit_.logical_or(out, flag(frame.continued));
}

void Paths::unwind(const std::vector<ValueId>& pending) {
    for (auto exit = pending.rbegin(); exit != pending.rend(); ++exit) {
        const Changes changes = leave();
        merge(*exit, {}, changes);
    }
}

}  // namespace openfab::translate
