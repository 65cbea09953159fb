// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/functions/differentiate_function.h"

#include <algorithm>

#include "compiler/functions/machine.h"

namespace openfab::functions {

namespace {

using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;
using F = Emit::F;

constexpr float kLn2 = 0.693147181f;
constexpr float kLog2OfE = 1.44269504f;
constexpr float kLog10OfE = 0.434294482f;
constexpr float kStep = 1.0f / 64;

class Rules {
  public:
    Rules(F value, const ir::Instr& function, const std::vector<ValueId>& changes, ir::Builder* b)
        : value_(value), function_(function), changes_(changes), b_(b) {}

    ValueId run() {
        if (function_.op == Op::kAtan2) return atan2();
        if (function_.op == Op::kPow) return pow();
        if (ir::family(function_.op) == ir::Family::kNoise) return noise();
        return changes_[0] == kNoValue ? kNoValue : of_one(arg(0), change(0)).id;
    }

  private:
    F arg(size_t k) const { return {b_, function_.args[k]}; }
    F change(size_t k) const { return {b_, changes_[k]}; }
    F call(Op op, F x) const { return {b_, b_->emit(op, {x.id})}; }
    bool still(size_t k) const { return changes_[k] == kNoValue; }

    F of_one(F x, F dx) const {
        switch (function_.op) {
            case Op::kSin:
                return dx * call(Op::kCos, x);
            case Op::kCos:
                return -(dx * call(Op::kSin, x));
            case Op::kTan:
                return dx * (value_ * value_ + 1.0f);
            case Op::kAsin:
                return dx / Emit::sqrt(1.0f - x * x);
            case Op::kAcos:
                return -(dx / Emit::sqrt(1.0f - x * x));
            case Op::kAtan:
                return dx / (x * x + 1.0f);
            case Op::kSinh:
                return dx * call(Op::kCosh, x);
            case Op::kCosh:
                return dx * call(Op::kSinh, x);
            case Op::kTanh:
                return dx * (1.0f - value_ * value_);
            case Op::kExp:
                return dx * value_;
            case Op::kExp2:
                return dx * (value_ * kLn2);
            case Op::kLog:
                return dx / x;
            case Op::kLog2:
                return dx * kLog2OfE / x;
            case Op::kLog10:
                return dx * kLog10OfE / x;
            case Op::kCbrt:
                return dx / (value_ * value_ * 3.0f);
            case Op::kAtan2:
            case Op::kPow:
                OPENFAB_IR_CASES(HASHES)
                OPENFAB_IR_CASES(NOISES)
                OPENFAB_IR_CASES(LEAVES)
                OPENFAB_IR_CASES(CHOICES)
                OPENFAB_IR_CASES(LOOKUPS)
                OPENFAB_IR_CASES(CONTROL)
                OPENFAB_IR_CASES(DERIVATIVES)
                OPENFAB_IR_CASES(OPERATIONS)
                break;  // not of one float
        }
        return dx;
    }

    ValueId sum(ValueId a, ValueId b) const {
        if (a == kNoValue) return b;
        return b == kNoValue ? a : b_->emit(Op::kAdd, {a, b});
    }

    ValueId atan2() const {
        const F y = arg(0);
        const F x = arg(1);
        const ValueId turned = sum(still(0) ? kNoValue : (change(0) * x).id,
                                   still(1) ? kNoValue : (-(change(1) * y)).id);
        return turned == kNoValue ? kNoValue : (F{b_, turned} / (x * x + y * y)).id;
    }

    ValueId pow() const {
        const F x = arg(0);
        const F y = arg(1);
        ValueId out = kNoValue;
        if (!still(0)) {
            const F less{b_, b_->emit(Op::kPow, {x.id, (y - 1.0f).id})};
            out = (change(0) * y * less).id;
        }
        if (!still(1)) out = sum(out, (change(1) * value_ * call(Op::kLog, x)).id);
        return out;
    }

    size_t axes() const {
        size_t count = 0;
        while (count < function_.args.size() && b_->type(function_.args[count]) == Type::kFloat)
            ++count;
        return count;
    }

    ValueId result_at(int32_t which, std::vector<ValueId> args) const {
        ir::Instr instr = function_;
        instr.a = which;
        instr.args = std::move(args);
        return b_->append(std::move(instr));
    }

    ValueId noise() const {
        const int32_t periodic = function_.a & ir::kPeriodic;
        const bool cell = function_.op == Op::kCellular && function_.a == 2;
        const size_t count = axes();
        const bool moves =
            std::any_of(changes_.begin(), changes_.begin() + static_cast<long>(count),
                        [](ValueId change) { return change != kNoValue; });
        if (!moves || cell) return kNoValue;
        if (function_.op == Op::kCellular || function_.a != periodic) return difference(count);
        ValueId out = kNoValue;
        for (size_t k = 0; k < count; ++k) {
            if (still(k)) continue;
            const int32_t which = periodic + static_cast<int32_t>(k) + 1;
            const F slope{b_, result_at(which, function_.args)};
            out = sum(out, (change(k) * slope).id);
        }
        return out;
    }

    ValueId difference(size_t count) const {
        std::vector<ValueId> before = function_.args;
        std::vector<ValueId> after = function_.args;
        for (size_t k = 0; k < count; ++k) {
            if (still(k)) continue;
            const F step = change(k) * kStep;
            before[k] = (arg(k) - step).id;
            after[k] = (arg(k) + step).id;
        }
        const F rise = F{b_, result_at(function_.a, after)} - F{b_, result_at(function_.a, before)};
        return (rise * (0.5f / kStep)).id;
    }

    F value_;
    const ir::Instr& function_;
    const std::vector<ValueId>& changes_;
    ir::Builder* b_;
};

}  // namespace

ValueId differentiate_function(ValueId value, const ir::Instr& function,
                               const std::vector<ValueId>& changes, ir::Builder* builder) {
    return Rules({builder, value}, function, changes, builder).run();
}

}  // namespace openfab::functions
