// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The builder of the front end: folds constants and merges equal values, so that loop counters,
// `if`s on constants and path conditions come out in simple form. Folding never changes a bit of a
// result.

#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::translate {

/// Placeholder inputs that no kernel has. Only diagnostics depend on them, so that dead value
/// elimination removes them.
enum Unknown : int32_t {
    kEarlierTrip = -1,  ///< an earlier iteration of a loop has assigned a variable
    kSomeTrip = -2,     ///< any iteration has
    // In a function that is checked in isolation:
    kArgument = -3,    ///< a component of its parameters
    kCallResult = -4,  ///< a result of another function
    kChange = -5,      ///< a derivative
    kSeed = -6,        ///< what a field is differentiated by, until its values are put in
};

class Emitter : public ir::Builder {
  public:
    using ir::Builder::Builder;

    /// Ends a loop. Values emitted since `loop` are not available after it, and are never reused.
    ir::ValueId loop_end(ir::ValueId loop, ir::ValueId again,
                         const std::vector<ir::ValueId>& next) override;
    /// Returns an unknown value that is a function of `args`: equal arguments give the same value.
    ir::ValueId unknown(ir::Type type, int32_t kind, int32_t a, int32_t b,
                        std::vector<ir::ValueId> args);
    /// Returns a number that no other placeholder has.
    int32_t next_unknown() { return unknowns_++; }
    /// Emits an operation of other instructions, which may fold.
    ir::ValueId again(ir::Instr instr) { return add(std::move(instr)); }
    /// Removes all instructions from number `size` on.
    void truncate(size_t size);

    ir::ValueId logical_and(ir::ValueId a, ir::ValueId b) { return binary(ir::Op::kAnd, a, b); }
    ir::ValueId logical_or(ir::ValueId a, ir::ValueId b) { return binary(ir::Op::kOr, a, b); }
    ir::ValueId logical_not(ir::ValueId a) { return unary(ir::Op::kNot, a); }

    bool is_constant(ir::ValueId value) const { return instr(value).op == ir::Op::kConst; }
    bool is_true(ir::ValueId value) const { return is_constant(value) && instr(value).bits != 0; }
    bool is_false(ir::ValueId value) const { return is_constant(value) && instr(value).bits == 0; }
    bool is_zero(ir::ValueId value) const { return is_constant(value) && instr(value).bits == 0; }
    /// Returns whether `condition` is `fact` or a conjunction that contains it.
    bool implies(ir::ValueId condition, ir::ValueId fact) const;
    size_t size() const { return stage_->instrs.size(); }
    /// Returns the compile cost of the first `size` instructions once functions are expanded, in
    /// operations: loops, queries and lookups count as many.
    size_t operations(size_t size);
    size_t operations() { return operations(size()); }
    /// The same, but accesses to large arrays count as the steps that they may become.
    size_t operations_by_steps() { return sum(size()).by_steps; }
    /// Says that the instructions from number `from` on are an access to a large array.
    void count_as_step(size_t from);
    /// Counts no operations for the instructions from number `from` on, which only diagnostics use.
    void count_none(size_t from);

  private:
    struct Sum {
        size_t operations = 0, by_steps = 0;
    };
    using Key =
        std::tuple<ir::Op, ir::Type, uint32_t, int32_t, int32_t, int32_t, std::vector<ir::ValueId>>;

    ir::ValueId add(ir::Instr instr) override;
    std::optional<ir::ValueId> simplified(const ir::Instr& made);
    std::optional<ir::ValueId> simplified_and(ir::ValueId a, ir::ValueId b);
    std::optional<ir::ValueId> simplified_or(ir::ValueId a, ir::ValueId b);
    std::optional<ir::ValueId> simplified_select(ir::ValueId condition, ir::ValueId if_true,
                                                 ir::ValueId if_false);
    std::optional<ir::ValueId> simplified_pick(const ir::Instr& pick) const;
    size_t pick_cost(const ir::Instr& pick) const;
    Sum sum(size_t size);
    void forget_from(ir::ValueId first);
    size_t cost(const ir::Instr& instr);
    bool is_one_of(ir::Op op, ir::ValueId value, ir::ValueId part) const;
    bool are_opposite(ir::ValueId a, ir::ValueId b) const;

    std::map<Key, ir::ValueId> known_;
    int32_t unknowns_ = 0;
    std::vector<Sum> sums_;  ///< of operations up to each instruction, computed on demand
    std::map<std::tuple<ir::Op, int32_t, size_t>, size_t> function_sizes_;
};

}  // namespace openfab::translate
