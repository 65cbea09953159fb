// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/facts.h"

#include <algorithm>

#include "compiler/translate/proof.h"

namespace openfab::translate {

using ir::ValueId;

// --- calls

bool Facts::always(ValueId condition) const {
    return emit_.is_true(condition) || follows(stage_, {}, condition);
}

bool Facts::is_implied(ValueId fact, ValueId and_where) const {
    std::vector<ValueId> given = paths_.outer_live;
    given.push_back(paths_.live);
    given.push_back(and_where);
    return std::any_of(given.begin(), given.end(),
                       [&](ValueId condition) { return emit_.implies(condition, fact); }) ||
           follows(stage_, given, fact);
}

/// Returns `assigned`, or true in an unknown iteration.
ValueId Facts::assigned_by_a_trip(ValueId assigned, int32_t which) {
    if (emit_.is_true(assigned)) return assigned;
    const ValueId unknown = emit_.input(ir::Type::kBool, which, emit_.next_unknown(), 0);
    return emit_.logical_or(assigned, unknown);
}

/// Returns whether only an earlier iteration can have assigned it.
bool Facts::unassigned_in_first_trip(ValueId assigned) const {
    const ir::Instr& instr = emit_.instr(assigned);
    if (instr.op == ir::Op::kInput) return instr.kind == kEarlierTrip;
    return instr.op == ir::Op::kOr && unassigned_in_first_trip(instr.args[0]) &&
           unassigned_in_first_trip(instr.args[1]);
}

/// Returns whether loops are open and the first iteration of each reaches the current point.
bool Facts::first_trip_comes_here() const {
    if (paths_.outer_live.empty()) return false;
    return emit_.is_true(paths_.live) &&
           std::all_of(paths_.outer_live.begin() + 1, paths_.outer_live.end(),
                       [&](ValueId guard) { return emit_.is_true(guard); });
}

}  // namespace openfab::translate
