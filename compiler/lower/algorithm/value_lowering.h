// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The values of one stage as Halide's.

#include <Halide.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/lower/algorithm/deferred.h"
#include "compiler/lower/algorithm/kernel.h"
#include "compiler/lower/algorithm/kernel_inputs.h"

namespace openfab::lower {

class ValueLowering {
  public:
    /// `name`: of the Funcs that values are stored in. All that is referred to must outlive this.
    ValueLowering(const ir::Stage& stage, const char* name, const KernelInputs& inputs,
                  LoweringContext* context, Deferred* deferred)
        : stage_(stage), name_(name), inputs_(inputs), context_(context), deferred_(deferred) {}

    /// Computes all values of the stage.
    void run();

    /// Returns what a Func stores that needs the value.
    Value value(size_t id);
    /// Returns the bits of one of the values, by number.
    Halide::Expr one_of(const std::vector<ir::ValueId>& ids, const Halide::Expr& number);

  private:
    /// Returns the last lookup in a picture; 0 (never a lookup) if there is none.
    size_t last_picture_sample(const std::vector<bool>& live) const;
    /// Finds the last instruction that uses each value; past the end for outputs.
    std::vector<size_t> last_uses(const std::vector<bool>& live) const;
    /// values_k: what the chunk computes and instructions from `next` on still need.
    void store_chunk(size_t next, const std::vector<size_t>& last_use);
    std::vector<Value> arguments(const ir::Instr& instr);
    /// Lowers channels read at one coordinate together: they share footprint, taps and addresses.
    void lower_sample_group(size_t id, const std::vector<bool>& live);
    void lower_bound_pair(size_t id, const std::vector<bool>& live);

    const ir::Stage& stage_;
    const char* const name_;
    const KernelInputs& inputs_;
    LoweringContext* const context_;
    Deferred* const deferred_;
    std::vector<Value> values_;  ///< what Halide sees; undefined: deferred
    std::vector<size_t> chunk_;  ///< values not stored in a Func yet
    int32_t chunks_ = 0;
};

}  // namespace openfab::lower
