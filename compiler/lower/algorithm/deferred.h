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
#include "compiler/lower/algorithm/ops.h"

namespace openfab::lower {

/// One call: a value of a stage.
struct DeferredValue {
    const ir::Stage* stage = nullptr;
    ir::ValueId id = ir::kNoValue;
    std::vector<ir::ValueId> choices;  ///< one of these instead, by the first argument
    std::vector<ir::ValueId> reads;    ///< the value that each argument is; kNoValue: none
};

/// The calls of one kernel by name. The stages must outlive it.
class Deferred {
  public:
    /// Returns a call that stands for a value of `stage`; `known`: of each value the Expr that Halide
    /// is to see, undefined for those to compute. `prefix`: of the call's name, one for each stage.
    Value value(const ir::Stage& stage, const std::string& prefix, ir::ValueId id,
                const std::vector<Value>& known);

    /// Returns a call that stands for the bits of one of the values `ids`, by number. A loop over
    /// `number` is written out where the calls are replaced, so that Halide sees one value instead of
    /// many: several of its passes take the square of how many there are.
    Halide::Expr one_of(const ir::Stage& stage, const std::string& prefix,
                        std::vector<ir::ValueId> ids, const std::vector<Value>& known,
                        const Halide::Expr& number);

    const DeferredValue* find(const std::string& name) const;

    /// Sets the buffer that Tables load from.
    void set_values(const Halide::ImageParam& values) { object_values_ = values; }
    const Halide::ImageParam& object_values() const { return object_values_; }

  private:
    void collect_reads(const ir::Stage& stage, std::vector<ir::ValueId> open,
                       const std::vector<Value>& known, DeferredValue* value,
                       std::vector<Halide::Expr>* args) const;
    std::string add(const std::string& name, const DeferredValue& value);

    Halide::ImageParam object_values_;
    std::map<std::string, DeferredValue> values_;
};

/// Returns the pass that replaces the calls. Halide takes it over.
Halide::Internal::IRMutator* make_expander(std::shared_ptr<const Deferred> deferred);

}  // namespace openfab::lower
