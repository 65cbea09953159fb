// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Copies a stage with the changes of its values in several directions (dual numbers).

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// A set of directions.
using Mask = uint32_t;

/// What changes by itself: inputs and what is asked of surfaces. kNoValue is no change, everywhere.
class Seeds {
  public:
    virtual ~Seeds() = default;
    /// Returns the directions in which an input changes.
    virtual Mask active(const ir::Instr& input) const = 0;
    /// Returns what stands for an input; kNoValue: itself.
    virtual ir::ValueId value(const ir::Instr& /*input*/) { return ir::kNoValue; }
    /// Returns the change of an input in one of its directions.
    virtual ir::ValueId change(const ir::Instr& input, size_t direction) = 0;
    /// Returns in which directions the result of a query changes whose point does in `point`.
    virtual Mask active_result(const ir::Instr& /*query*/, const ir::Instr& /*result*/,
                               Mask point) const {
        return point;
    }
    /// Adds up `changes`, one for each direction, of a query's result `value`, where its point changes by `points`.
    virtual void query_changes(ir::ValueId /*query*/, const ir::Instr& result,
                               ir::ValueId /*value*/,
                               std::span<const std::array<ir::ValueId, 3>> /*points*/,
                               std::vector<ir::ValueId>* /*changes*/) {
        refuse(result.span, "a query");
    }
    /// Notes what has no derivative.
    virtual void refuse(const source::Span& /*span*/, const char* /*what*/) {}
};

/// Returns, for each value of a stage, the directions in which it changes.
std::vector<Mask> active_directions(const ir::Stage& stage, const Seeds& seeds);

/// Expands noises that change and whose derivatives are no results of their own: gradients and cellular distances.
ir::Stage with_open_noises(const ir::Stage& stage, const Seeds& seeds);

class ChangeCarrier {
  public:
    /// The arguments must outlive this object; the copy is appended to the builder's stage. At most 32 directions.
    ChangeCarrier(const ir::Stage& stage, size_t directions, Seeds* seeds, ir::Builder* builder);

    void run();
    /// Returns the copy of a value, and its change.
    ir::ValueId value(ir::ValueId old) const { return values_[old]; }
    ir::ValueId change(ir::ValueId old, size_t direction) const { return changes_[direction][old]; }

  private:
    bool moves(ir::ValueId old, size_t direction) const {
        return (active_[old] >> direction & 1) != 0;
    }
    /// Returns whether a value changes in any direction.
    bool changes(ir::ValueId old) const;
    ir::ValueId change_or_zero(ir::ValueId old, size_t direction);
    void before_loop(ir::ValueId loop);
    void begin_loop(ir::ValueId next);
    void end_loop(const ir::Instr& old, ir::Instr* end);
    void differentiate(ir::ValueId id);
    ir::ValueId differentiate(ir::ValueId id, size_t direction);
    void differentiate_result(ir::ValueId id);
    ir::ValueId differentiate_pick(const ir::Instr& pick, size_t direction);
    ir::ValueId differentiate_extreme(ir::ValueId id, size_t direction);
    ir::ValueId differentiate_power(ir::ValueId id, size_t direction);
    ir::ValueId still_at_rest(const ir::Instr& old, size_t direction, ir::ValueId change);

    const ir::Stage& old_;
    const size_t directions_;
    Seeds& seeds_;
    ir::Builder& builder_;
    const std::vector<Mask> active_;
    std::vector<ir::ValueId> values_;                ///< by old id
    std::vector<std::vector<ir::ValueId>> changes_;  ///< [direction][old id]
    /// The change of a loop's variable is a variable, too.
    struct Variable {
        ir::ValueId old = ir::kNoValue;
        size_t direction = 0;
        ir::ValueId first = ir::kNoValue;
    };
    std::vector<Variable> firsts_;               ///< of the loop that is about to begin
    std::vector<std::vector<Variable>> open_;    ///< of loops that are open
    std::vector<std::vector<int32_t>> numbers_;  ///< [direction][old id of a variable]
};

}  // namespace openfab::passes
