// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Appends IR instructions, each distinct one once, and folds what is constant, so that loop
// counters, `if`s on constants and path conditions come out in their plain form. No folding changes
// a bit of any result.

#include <array>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::sema {

/// Inputs that no run has. Only messages hang on them, so that they are dropped with what else no
/// output needs.
enum Unknown : int32_t {
    kEarlierTrip = -1,  ///< an earlier trip of a loop has assigned a variable
    kSomeTrip = -2,     ///< any trip has
    // Of a function that is looked at by itself:
    kArgument = -3,    ///< a component of its parameters
    kCallResult = -4,  ///< what it gets of another one
    kChange = -5,      ///< a derivative
};

class Emitter {
  public:
    explicit Emitter(ir::Stage* stage) : stage_(stage), builder_(stage) {}

    void set_span(const source::Span& span) { builder_.set_span(span); }
    ir::ValueId constant(ir::Type type, uint32_t bits);
    ir::ValueId constant(float value);
    ir::ValueId boolean(bool value) { return constant(ir::Type::kBool, value ? 1 : 0); }
    ir::ValueId input(ir::Type type, int32_t kind, int32_t a, int32_t b);
    /// What is not known but follows from `args` alone: the same input for the same values.
    ir::ValueId unknown(ir::Type type, int32_t kind, int32_t a, int32_t b,
                        std::vector<ir::ValueId> args);
    ir::ValueId sample(int32_t texture, int32_t channel, const std::array<ir::ValueId, 4>& args);

    /// Of an ImageTexture3D: args {guard, x, y, z, width}.
    ir::ValueId sample_volume(int32_t texture, int32_t channel,
                              const std::array<ir::ValueId, 5>& args);
    ir::ValueId query(int32_t object, const std::array<ir::ValueId, 4>& args);
    ir::ValueId query_result(ir::ValueId query, ir::Type type, openfab_query_result kind, int32_t a,
                             int32_t b);

    void print(int32_t number, std::vector<ir::ValueId> args);

    ir::ValueId unary(ir::Op op, ir::ValueId a);
    ir::ValueId binary(ir::Op op, ir::ValueId a, ir::ValueId b);
    ir::ValueId convert(ir::ValueId value, ir::Type to);
    ir::ValueId bit_cast(ir::ValueId value, ir::Type to);
    /// A function of the IR or a Derivative; `which` is Instr::a.
    ir::ValueId function(ir::Op op, int32_t which, std::vector<ir::ValueId> args);
    /// Loops, as of ir::Instr; what is emitted between `loop` and `end_loop` is of no use after it.
    ir::ValueId loop(ir::ValueId guard) { return builder_.loop(guard); }
    ir::ValueId loop_var(ir::ValueId loop, int32_t number, ir::ValueId first) {
        return builder_.loop_var(loop, number, first);
    }
    ir::ValueId end_loop(ir::ValueId loop, ir::ValueId again, const std::vector<ir::ValueId>& next);
    ir::ValueId loop_result(ir::ValueId end, int32_t number) {
        return builder_.loop_result(end, number);
    }
    /// Removes all instructions from number `size` on.
    void forget_after(size_t size);
    ir::ValueId select(ir::ValueId condition, ir::ValueId if_true, ir::ValueId if_false);
    ir::ValueId logical_and(ir::ValueId a, ir::ValueId b);
    ir::ValueId logical_or(ir::ValueId a, ir::ValueId b);
    ir::ValueId logical_not(ir::ValueId a);

    const ir::Instr& instr(ir::ValueId value) const { return stage_->instrs[value]; }
    ir::Type type(ir::ValueId value) const { return instr(value).type; }
    bool is_constant(ir::ValueId value) const { return instr(value).op == ir::Op::kConst; }
    bool is_true(ir::ValueId value) const { return is_constant(value) && instr(value).bits != 0; }
    bool is_false(ir::ValueId value) const { return is_constant(value) && instr(value).bits == 0; }
    /// True where `condition` is `fact` or a conjunction that holds it.
    bool implies(ir::ValueId condition, ir::ValueId fact) const;
    size_t size() const { return stage_->instrs.size(); }
    /// What the first `size` instructions come to once functions are written out, by what they cost
    /// the compiler: steps and look-ups count for as many operations as take them as long.
    size_t operations(size_t size);
    size_t operations() { return operations(size()); }

  private:
    using Key =
        std::tuple<ir::Op, ir::Type, uint32_t, int32_t, int32_t, int32_t, std::vector<ir::ValueId>>;
    ir::ValueId add(ir::Instr instr);
    void forget_from(ir::ValueId first);
    size_t cost(const ir::Instr& instr);
    bool is_one_of(ir::Op op, ir::ValueId value, ir::ValueId part) const;
    bool are_opposite(ir::ValueId a, ir::ValueId b) const;

    ir::Stage* stage_;
    ir::Builder builder_;
    std::map<Key, ir::ValueId> known_;
    std::vector<size_t> sums_;  ///< operations up to each instruction, as far as asked for
    std::map<std::tuple<ir::Op, int32_t, size_t>, size_t> function_sizes_;
};

}  // namespace openfab::sema
