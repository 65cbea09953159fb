// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/simplify.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "compiler/functions/functions.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::Op;
using ir::Type;
using ir::ValueId;

class Simplifier {
  public:
    explicit Simplifier(ir::Stage* stage) : stage_(stage), alias_(stage->instrs.size()) {
        std::iota(alias_.begin(), alias_.end(), ValueId{0});
    }

    void run() {
        const std::vector<ValueId> ends = ir::loop_ends(*stage_);
        for (ValueId id = 0; id < stage_->instrs.size(); ++id) {
            Instr& instr = stage_->instrs[id];
            for (ValueId& arg : instr.args)
                arg = alias_[arg];
            if (instr.op == Op::kLoopVar) {
                if (stays_as_it_is(id, ends[instr.args[0]])) alias_[id] = instr.args[1];
            } else if (instr.op == Op::kLoopResult) {
                alias_[id] = result_of(id);
            } else if (std::optional<uint32_t> bits = fold(instr)) {
                make_constant(&instr, *bits);
            } else if (std::optional<ValueId> same = identity(instr)) {
                alias_[id] = *same;
            }
        }
        for (ir::Output& output : stage_->outputs)
            output.value = alias_[output.value];
    }

  private:
    const Instr& arg(const Instr& instr, size_t k) const { return stage_->instrs[instr.args[k]]; }
    bool is_const(const Instr& instr) const { return instr.op == Op::kConst; }
    bool is_const(ValueId id, uint32_t bits) const {
        return is_const(stage_->instrs[id]) && stage_->instrs[id].bits == bits;
    }

    /// A variable that no iteration changes. `end` is still unmodified.
    bool stays_as_it_is(ValueId var, ValueId end) const {
        const Instr& instr = stage_->instrs[var];
        const ValueId next =
            stage_->instrs[end].args[ir::kLoopEndNext + static_cast<size_t>(instr.a)];
        const ValueId first = instr.args[1];
        if (next == var || next == first) return true;
        const Instr& value = stage_->instrs[next];
        return is_const(value) && is_const(first, value.bits);
    }

    /// The result of a variable that never changes, or of a loop that never runs, is the initial
    /// value.
    ValueId result_of(ValueId id) const {
        const Instr& instr = stage_->instrs[id];
        const ValueId loop = stage_->instrs[instr.args[0]].args[0];
        const ValueId var = loop + 1 + static_cast<ValueId>(instr.a);
        if (alias_[var] != var) return alias_[var];
        const bool never = is_const(stage_->instrs[loop].args[0], 0);
        return never ? stage_->instrs[var].args[1] : id;
    }

    static void make_constant(Instr* instr, uint32_t bits) {
        instr->op = Op::kConst;
        instr->bits = bits;
        instr->args.clear();
    }

    std::optional<uint32_t> fold(const Instr& instr) const {
        if (instr.op == Op::kSample) {
            // A lookup that is never reached yields 0.
            return is_const(instr.args[0], 0) ? std::optional<uint32_t>(0) : std::nullopt;
        }
        if (instr.op == Op::kQueryResult && is_const(arg(instr, 0).args[0], 0)) return 0;
        const std::optional<uint32_t> bits = functions::fold(*stage_, instr);
        return bits ? bits : fold_partly(instr);
    }

    /// Constant although one argument is not.
    std::optional<uint32_t> fold_partly(const Instr& instr) const {
        if (instr.args.size() != 2) return std::nullopt;
        const bool zero = is_const(instr.args[0], 0) || is_const(instr.args[1], 0);
        const bool one = is_const(instr.args[0], 1) || is_const(instr.args[1], 1);
        if (instr.op == Op::kAnd && zero) return 0;
        if (instr.op == Op::kOr && one) return 1;
        if (instr.type == Type::kFloat || instr.type == Type::kBool) return std::nullopt;
        if ((instr.op == Op::kMul || instr.op == Op::kBitAnd) && zero) return 0;
        return std::nullopt;
    }

    std::optional<ValueId> identity(const Instr& instr) const {
        if (instr.op == Op::kConvert && arg(instr, 0).type == instr.type) return instr.args[0];
        if (instr.op == Op::kSelect) return identity_of_select(instr);
        if (instr.op == Op::kPick) return identity_of_pick(instr);
        if (instr.op == Op::kNot && arg(instr, 0).op == Op::kNot) return arg(instr, 0).args[0];
        if (instr.args.size() != 2) return std::nullopt;
        const ValueId a = instr.args[0];
        const ValueId b = instr.args[1];
        if (keeps(instr.op, instr.type, b)) return a;
        const bool commutes = instr.op != Op::kSub && instr.op != Op::kDiv &&
                              instr.op != Op::kShl && instr.op != Op::kShr;
        if (commutes && keeps(instr.op, instr.type, a)) return b;
        return std::nullopt;
    }

    std::optional<ValueId> identity_of_pick(const Instr& instr) const {
        const Instr& index = arg(instr, 0);
        if (is_const(index)) {
            const size_t count = instr.args.size() - 1;
            return instr.args[1 + ir::picked_element(index.type, index.bits, count)];
        }
        const bool same = std::all_of(instr.args.begin() + 1, instr.args.end(),
                                      [&](ValueId element) { return element == instr.args[1]; });
        return same ? std::optional(instr.args[1]) : std::nullopt;
    }

    std::optional<ValueId> identity_of_select(const Instr& instr) const {
        if (is_const(arg(instr, 0))) return instr.args[arg(instr, 0).bits != 0 ? 1 : 2];
        if (instr.args[1] == instr.args[2]) return instr.args[1];
        if (instr.type == Type::kBool && is_const(instr.args[1], 1) && is_const(instr.args[2], 0)) {
            return instr.args[0];
        }
        return std::nullopt;
    }

    /// Returns whether x op `right` has the bits of x for every x (a NaN stays some NaN).
    bool keeps(Op op, Type type, ValueId right) const {
        const Instr& constant = stage_->instrs[right];
        if (!is_const(constant)) return false;
        const bool is_float = type == Type::kFloat;
        const uint32_t one = is_float ? ir::as_bits(1.0f) : 1u;
        switch (op) {
            case Op::kAdd:
                return constant.bits == (is_float ? ir::as_bits(-0.0f) : 0u);
            case Op::kSub:
            case Op::kShl:
            case Op::kShr:
                return constant.bits == 0;
            case Op::kMul:
            case Op::kDiv:
                return constant.bits == one;
            case Op::kBitOr:
            case Op::kBitXor:
            case Op::kOr:
                return constant.bits == 0;
            case Op::kAnd:
                return constant.bits == 1;
            case Op::kMod:
            case Op::kNeg:
            case Op::kBitAnd:
            case Op::kBitNot:
            case Op::kNot:
                OPENFAB_IR_CASES(COMPARISONS)
                OPENFAB_IR_CASES(EXTREMES)
                OPENFAB_IR_CASES(FLOAT_PARTS)
                OPENFAB_IR_CASES(STRUCTURE)
                break;
        }
        return false;
    }

    ir::Stage* stage_;
    std::vector<ValueId> alias_;
};

}  // namespace

void simplify(ir::Stage* stage) {
    Simplifier(stage).run();
}

}  // namespace openfab::passes
