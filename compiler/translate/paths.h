// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Control flow in a stage, private to compiler/translate. The code is one straight line of
// instructions. A branch is translated under a scope that records which variables it changes;
// afterwards each becomes a select of the two values. `live` is the condition under which the
// current point is reached; texture lookups take it as their guard. Inside a real loop it restarts
// with each iteration. `return`, `break` and `continue` set a bool variable, and what follows them
// in the same block is translated as a branch that is taken where none of them is set.

#include <functional>
#include <map>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/translate/emitter.h"
#include "compiler/translate/formulas.h"

namespace openfab::translate {

using VariableId = size_t;

/// A variable's components, and for each whether it has been assigned, as a bool value.
struct Variable {
    Value value;
    Value assigned;
};

/// The variables that a branch changed: their state before it or, once left, after it.
using Changes = std::map<VariableId, Variable>;

/// An open branch: its changes so far, and the state outside.
struct Branch {
    Changes before;
    size_t variables = 0;
    ir::ValueId live = 0;
};

/// One function that is being inlined, or the stage's body.
struct Frame {
    std::map<const check::Symbol*, VariableId> variables;
    VariableId result = 0;
    VariableId returned = 0;
    bool in_loop = false;
    VariableId broken = 0;
    VariableId continued = 0;
};

/// The variables of a stage under translation, and the paths that reach the current point.
class Paths {
  public:
    explicit Paths(Emitter* emit) : emit_(*emit) {}

    VariableId variable_of(const check::Symbol& symbol) const {
        return frame.variables.at(&symbol);
    }
    VariableId add_variable(Variable v);
    VariableId add_flag();
    void set(VariableId id, Variable v);
    void set_flag(VariableId id, ir::ValueId value);
    ir::ValueId flag(VariableId id) const { return variables[id].value[0]; }
    void enter(ir::ValueId condition);
    Changes leave();
    void merge(ir::ValueId condition, const Changes& yes, const Changes& no);
    void branch(ir::ValueId condition, const std::function<void()>& yes,
                const std::function<void()>& no);
    ir::ValueId exited();
    void unwind(const std::vector<ir::ValueId>& pending);

    std::vector<Variable> variables;
    std::vector<Branch> open;
    Frame frame;
    ir::ValueId live = 0;
    std::vector<ir::ValueId> outer_live;  ///< the condition around each open real loop

  private:
    Emitter& emit_;
};

}  // namespace openfab::translate
