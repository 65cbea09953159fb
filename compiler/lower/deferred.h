// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Keeps a stage's operations out of Halide's way until its loops are scheduled, vectorized and
// simplified. Halide's passes walk every expression some sixty times, as a tree, and several of
// them once for each value that a Func stores; none of them needs to know more of a value than what
// it is computed from. So a Func stores a call that names the value, whose arguments are what it
// reads: inputs, what other Funcs store, results of lookups. As Halide's last pass each call is
// replaced by its operations, vectors by then, each a let of its own: values that stores beside
// each other have in common are computed once.

#include <Halide.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/lower/ops.h"

namespace openfab::lower {

/// One call: a value of a stage.
struct DeferredValue {
    const ir::Stage* stage = nullptr;
    ir::ValueId id = ir::kNoValue;
    std::vector<ir::ValueId> reads;  ///< the value that each argument is
};

/// The calls of one kernel by name. The stages must outlive it.
class Deferred {
  public:
    /// Returns a call that stands for a value of `stage`; `known`: of each value the Expr that Halide
    /// is to see, undefined for those to compute. `prefix`: of the call's name, one for each stage.
    Value value(const ir::Stage& stage, const std::string& prefix, ir::ValueId id,
                const std::vector<Value>& known);

    const DeferredValue* find(const std::string& name) const;

  private:
    std::map<std::string, DeferredValue> values_;
};

/// Returns the pass that replaces the calls. Halide takes it over.
Halide::Internal::IRMutator* make_expander(std::shared_ptr<const Deferred> deferred);

}  // namespace openfab::lower
