// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Conditions over bool values of a stage, built by `and` and `or`; each value may be negated.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Index of a node in PathConditions; equal conditions have equal indices.
using Condition = uint32_t;
constexpr Condition kNever = 0;
constexpr Condition kAlways = 1;

/// Binary decision diagrams (Bryant 1986), values in the order of their ids: a condition that
/// always holds is kAlways however it was built. One that grows too large becomes kAlways, which is
/// conservative for all uses.
class PathConditions {
  public:
    Condition holds(ir::ValueId value) { return node(value, kAlways, kNever); }
    Condition fails(ir::ValueId value) { return node(value, kNever, kAlways); }
    Condition both(Condition a, Condition b) { return combine(a, b, kNever); }
    Condition either(Condition a, Condition b) { return combine(a, b, kAlways); }

    /// Returns the values that it depends on, ascending.
    std::vector<ir::ValueId> tested(Condition condition) const;
    /// Emits it as a bool; `value` maps ids to the stage written to. Neither kNever nor kAlways.
    ir::ValueId write(Condition condition, const std::function<ir::ValueId(ir::ValueId)>& value,
                      ir::Builder* builder) const;

  private:
    struct Node {
        ir::ValueId value = ir::kNoValue;
        Condition if_true = kAlways;
        Condition if_false = kAlways;
    };

    Condition node(ir::ValueId value, Condition if_true, Condition if_false);
    Condition combine(Condition a, Condition b, Condition decides);
    std::vector<bool> reached(Condition condition) const;

    std::vector<Node> nodes_ = {{}, {}};  ///< kNever and kAlways stand for themselves
    std::map<std::array<uint32_t, 3>, Condition> unique_table_;
    std::map<std::array<uint32_t, 3>, Condition> computed_table_;
};

}  // namespace openfab::passes
