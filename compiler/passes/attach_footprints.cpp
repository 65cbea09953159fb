// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/attach_footprints.h"

#include <array>
#include <map>
#include <utility>

namespace openfab::passes {

namespace {

using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr int32_t kAxes = 3;
constexpr int32_t kLatticeAxes = 2;
constexpr size_t kPlainSampleArgs = 4;

class Differentiator {
  public:
    explicit Differentiator(ir::Stage* stage) : old_(std::move(*stage)), builder_(&new_) {
        new_.kind = old_.kind;
    }

    ir::Stage run() {
        for (const ir::Instr& instr : old_.instrs) {
            ir::Instr copy = instr;
            for (ValueId& arg : copy.args)
                arg = renamed_[arg];
            builder_.set_span(instr.span);
            if (copy.op == Op::kSample && copy.args.size() == kPlainSampleArgs) complete(&copy);
            renamed_.push_back(builder_.append(std::move(copy)));
        }
        for (ir::Output output : old_.outputs) {
            output.value = renamed_[output.value];
            new_.outputs.push_back(std::move(output));
        }
        return std::move(new_);
    }

  private:
    void complete(ir::Instr* sample) {
        const ValueId u = sample->args[1];
        const ValueId v = sample->args[2];
        for (const ValueId coordinate : {u, v}) {
            for (int32_t axis = 0; axis < kAxes; ++axis) {
                const ValueId d = derivative(coordinate, axis);
                sample->args.push_back(d == kNoValue ? builder_.constant(0.0f) : d);
            }
        }
    }

    /// Change of a value of the new stage per step along the axis; kNoValue where it is 0. Values
    /// are visited from the earliest on, so that long chains need no deep recursion.
    ValueId derivative(ValueId value, int32_t axis) {
        std::vector<ValueId> pending = {value};
        while (!pending.empty()) {
            const ValueId next = pending.back();
            if (known_.contains({next, axis})) {
                pending.pop_back();
                continue;
            }
            const size_t before = pending.size();
            for (const ValueId arg : relevant_args(next)) {
                if (!known_.contains({arg, axis})) pending.push_back(arg);
            }
            if (pending.size() > before) continue;
            known_[{next, axis}] = differentiate(next, axis);
            pending.pop_back();
        }
        return known_[{value, axis}];
    }

    std::vector<ValueId> relevant_args(ValueId value) const {
        const ir::Instr& instr = new_.instrs[value];
        if (instr.type != Type::kFloat || instr.op == Op::kSample || instr.op == Op::kConvert) {
            return {};
        }
        if (instr.op == Op::kSelect) return {instr.args[1], instr.args[2]};
        return instr.args;
    }

    ValueId of(ValueId arg, int32_t axis) const { return known_.at({arg, axis}); }
    ValueId add(ValueId a, ValueId b) {
        if (a == kNoValue) return b;
        return b == kNoValue ? a : builder_.emit(Op::kAdd, {a, b});
    }
    ValueId subtract(ValueId a, ValueId b) {
        if (b == kNoValue) return a;
        return a == kNoValue ? builder_.emit(Op::kNeg, {b}) : builder_.emit(Op::kSub, {a, b});
    }
    ValueId times(ValueId a, ValueId factor) {
        return a == kNoValue ? kNoValue : builder_.emit(Op::kMul, {a, factor});
    }
    ValueId choose(ValueId condition, ValueId a, ValueId b) {
        if (a == kNoValue && b == kNoValue) return kNoValue;
        if (a == kNoValue) a = builder_.constant(0.0f);
        if (b == kNoValue) b = builder_.constant(0.0f);
        return builder_.select(condition, a, b);
    }

    ValueId differentiate(ValueId value, int32_t axis) {
        const ir::Instr instr = new_.instrs[value];
        if (instr.type != Type::kFloat) return kNoValue;
        if (instr.op == Op::kInput) return input(instr, axis);
        if (relevant_args(value).empty()) return kNoValue;
        const bool select = instr.op == Op::kSelect;
        const ValueId a = instr.args[select ? 1 : 0];
        const ValueId b = instr.args.size() > 1 ? instr.args[select ? 2 : 1] : a;
        const ValueId da = of(a, axis);
        const ValueId db = of(b, axis);
        switch (instr.op) {
            case Op::kAdd:
                return add(da, db);
            case Op::kSub:
                return subtract(da, db);
            case Op::kMul:
                return add(times(da, b), times(db, a));
            case Op::kDiv:
                return over(subtract(da, times(db, value)), b);
            case Op::kMod:
                return subtract(da, times_quotient(db, a, b));
            case Op::kNeg:
                return subtract(kNoValue, da);
            case Op::kMin:
                return choose(builder_.emit(Op::kLt, {a, b}), da, db);
            case Op::kMax:
                return choose(builder_.emit(Op::kGt, {a, b}), da, db);
            case Op::kAbs:
                return da == kNoValue ? kNoValue : of_abs(a, da);
            case Op::kSqrt:
                return da == kNoValue ? kNoValue : of_sqrt(value, da);
            case Op::kSelect:
                return choose(instr.args[0], da, db);
            default:
                return kNoValue;
        }
    }

    ValueId over(ValueId a, ValueId divisor) {
        return a == kNoValue ? kNoValue : builder_.emit(Op::kDiv, {a, divisor});
    }
    ValueId times_quotient(ValueId db, ValueId a, ValueId b) {
        if (db == kNoValue) return kNoValue;
        const ValueId whole = builder_.emit(Op::kTrunc, {builder_.emit(Op::kDiv, {a, b})});
        return times(db, whole);
    }
    ValueId of_abs(ValueId a, ValueId da) {
        const ValueId below = builder_.emit(Op::kLt, {a, builder_.constant(0.0f)});
        return builder_.select(below, builder_.emit(Op::kNeg, {da}), da);
    }
    ValueId of_sqrt(ValueId root, ValueId da) {
        return over(da, builder_.emit(Op::kMul, {root, builder_.constant(2.0f)}));
    }

    ValueId input(const ir::Instr& instr, int32_t axis) {
        switch (instr.kind) {
            case ir::kVoxelCoord:
                return instr.a == axis ? builder_.constant(1.0f) : kNoValue;
            case OPENFAB_ARG_NEAREST:
                return builder_.input(Type::kFloat, OPENFAB_ARG_NEAREST_GRAD, instr.a,
                                      instr.b * kAxes + axis);
            case OPENFAB_ARG_SURFACE_IN:
                return on_lattice(OPENFAB_ARG_SURFACE_IN_GRAD, instr, axis);
            case OPENFAB_ARG_SURFACE_ATTR:
                return on_lattice(OPENFAB_ARG_SURFACE_ATTR_GRAD, instr, axis);
            default:
                return kNoValue;
        }
    }
    ValueId on_lattice(int32_t kind, const ir::Instr& instr, int32_t axis) {
        if (axis >= kLatticeAxes) return kNoValue;
        return builder_.input(Type::kFloat, kind, instr.a, instr.b * kLatticeAxes + axis);
    }

    const ir::Stage old_;
    ir::Stage new_;
    ir::Builder builder_;
    std::vector<ValueId> renamed_;
    std::map<std::pair<ValueId, int32_t>, ValueId> known_;
};

}  // namespace

void attach_footprints(ir::Stage* stage) {
    *stage = Differentiator(stage).run();
}

}  // namespace openfab::passes
