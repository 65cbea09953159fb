// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_demand.h"

#include <algorithm>
#include <map>

#include "compiler/passes/path_condition.h"

namespace openfab::passes {

namespace {

using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

bool is_nearest(const ir::Instr& instr) {
    return instr.op == Op::kInput &&
           (instr.kind == OPENFAB_ARG_NEAREST || instr.kind == OPENFAB_ARG_NEAREST_GRAD ||
            instr.kind == OPENFAB_ARG_DISTANCE);
}

/// True for operations that are cheap to compute before any query: not lookups.
bool is_plain(Op op) {
    return !ir::is_effectful(op) && op != Op::kSample && op != Op::kSampleBound &&
           op != Op::kDerivative;
}

/// The conditions under which a bool may be true and may be false, for some nearest inputs.
/// Conservative: they hold at least where it can be.
struct Outcomes {
    Condition may_be_true = kAlways;
    Condition may_be_false = kAlways;
};

class Demand {
  public:
    explicit Demand(const ir::Stage& stage) : stage_(stage) {}

    ir::Stage run() {
        ir::Stage out;
        out.kind = ir::StageKind::kVolumeDemand;
        find_loops();
        find_outcomes();
        find_needs();
        Condition demand = kNever;
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            if (is_nearest(stage_.instrs[id])) demand = conditions_.either(demand, needs_[id]);
        }
        if (demand == kNever || demand == kAlways) return out;
        write(demand, &out);
        return out;
    }

  private:
    size_t count() const { return stage_.instrs.size(); }

    /// Finds the outermost loop around each instruction; a LoopEnd counts as inside.
    void find_loops() {
        outermost_.assign(count(), kNoValue);
        int depth = 0;
        ValueId outermost = kNoValue;
        for (ValueId id = 0; id < count(); ++id) {
            if (depth > 0) outermost_[id] = outermost;
            if (stage_.instrs[id].op == Op::kLoop && depth++ == 0) outermost = id;
            if (stage_.instrs[id].op == Op::kLoopEnd) --depth;
        }
    }

    void find_outcomes() {
        is_input_independent_.assign(count(), false);
        outcomes_.assign(count(), {});
        for (ValueId id = 0; id < count(); ++id) {
            const ir::Instr& instr = stage_.instrs[id];
            is_input_independent_[id] =
                outermost_[id] == kNoValue && is_plain(instr.op) && !is_nearest(instr) &&
                std::all_of(instr.args.begin(), instr.args.end(),
                            [&](ValueId arg) { return is_input_independent_[arg]; });
            // A value inside a loop has no single outcome for all iterations.
            if (instr.type == Type::kBool && outermost_[id] == kNoValue)
                outcomes_[id] = outcomes_of(id);
        }
    }

    Outcomes outcomes_of(ValueId id) {
        const ir::Instr& instr = stage_.instrs[id];
        const auto arg = [&](size_t k) { return outcomes_[instr.args[k]]; };
        const auto both = [&](Condition a, Condition b) { return conditions_.both(a, b); };
        const auto either = [&](Condition a, Condition b) { return conditions_.either(a, b); };
        switch (instr.op) {
            case Op::kConst:
                return instr.bits != 0 ? Outcomes{kAlways, kNever} : Outcomes{kNever, kAlways};
            case Op::kNot:
                return {arg(0).may_be_false, arg(0).may_be_true};
            case Op::kAnd:
                return {both(arg(0).may_be_true, arg(1).may_be_true),
                        either(arg(0).may_be_false, arg(1).may_be_false)};
            case Op::kOr:
                return {either(arg(0).may_be_true, arg(1).may_be_true),
                        both(arg(0).may_be_false, arg(1).may_be_false)};
            case Op::kSelect:
                return {either(both(arg(0).may_be_true, arg(1).may_be_true),
                               both(arg(0).may_be_false, arg(2).may_be_true)),
                        either(both(arg(0).may_be_true, arg(1).may_be_false),
                               both(arg(0).may_be_false, arg(2).may_be_false))};
                OPENFAB_IR_CASES(COMPARISONS)
            case Op::kInput:
            case Op::kIsNan:
            case Op::kConvert:
                OPENFAB_IR_CASES(LOOKUPS)
                OPENFAB_IR_CASES(CONTROL)
                OPENFAB_IR_CASES(ARITHMETIC)
                OPENFAB_IR_CASES(BITS)
                OPENFAB_IR_CASES(EXTREMES)
            case Op::kSqrt:
            case Op::kFloor:
            case Op::kCeil:
            case Op::kRound:
            case Op::kTrunc:
                OPENFAB_IR_CASES(FUNCTIONS)
                OPENFAB_IR_CASES(DERIVATIVES)
                break;  // an atom, or no bool
        }
        if (!is_input_independent_[id]) return {};
        return {conditions_.holds(id), conditions_.fails(id)};
    }

    void need(ValueId id, Condition when) { needs_[id] = conditions_.either(needs_[id], when); }
    void need(ValueId id, Condition when, Condition also) {
        need(id, conditions_.both(when, also));
    }

    void find_needs() {
        needs_.assign(count(), kNever);
        for (const ir::Output& output : stage_.outputs)
            needs_[output.value] = kAlways;
        for (ValueId id = static_cast<ValueId>(count()); id-- > 0;)
            propagate(id);
    }

    /// Propagates the need for an instruction to its arguments.
    void propagate(ValueId id) {
        const ir::Instr& instr = stage_.instrs[id];
        if (outermost_[id] != kNoValue) {
            // A loop that runs is needed entirely: its control and its results.
            const ValueId guard = stage_.instrs[outermost_[id]].args[0];
            for (const ValueId arg : instr.args)
                need(arg, outcomes_[guard].may_be_true);
            return;
        }
        const Condition when = needs_[id];
        const auto outcomes = [&](size_t k) { return outcomes_[instr.args[k]]; };
        switch (instr.op) {
            case Op::kLoop:
            case Op::kQuery:
            case Op::kPrintf:
                // They have side effects, whether or not an output uses their results.
                propagate_guarded(instr, kAlways);
                return;
            case Op::kLoopResult: {
                // If no iteration ran, it is the variable's initial value.
                const ValueId loop = stage_.instrs[instr.args[0]].args[0];
                const ValueId variable = loop + 1 + static_cast<ValueId>(instr.a);
                need(stage_.instrs[variable].args[1], when);
                return;
            }
            case Op::kSample:
                propagate_guarded(instr, when);
                return;
            case Op::kSelect:
                need(instr.args[0], when);
                need(instr.args[1], when, outcomes(0).may_be_true);
                need(instr.args[2], when, outcomes(0).may_be_false);
                return;
            // An operand is not needed where the other one decides the result for any nearest
            // inputs; where both decide, neither is needed.
            case Op::kAnd:
                need(instr.args[0], when, outcomes(1).may_be_true);
                need(instr.args[1], when, outcomes(0).may_be_true);
                return;
            case Op::kOr:
                need(instr.args[0], when, outcomes(1).may_be_false);
                need(instr.args[1], when, outcomes(0).may_be_false);
                return;
            case Op::kNot:
            case Op::kConvert:
            case Op::kSampleBound:
            case Op::kBitCast:
            case Op::kPick:
            case Op::kTable:
            case Op::kLoopVar:
            case Op::kLoopEnd:
            case Op::kQueryResult:
                OPENFAB_IR_CASES(LEAVES)
                OPENFAB_IR_CASES(ARITHMETIC)
                OPENFAB_IR_CASES(BITS)
                OPENFAB_IR_CASES(COMPARISONS)
                OPENFAB_IR_CASES(EXTREMES)
                OPENFAB_IR_CASES(FLOAT_PARTS)
                OPENFAB_IR_CASES(FUNCTIONS)
                OPENFAB_IR_CASES(DERIVATIVES)
                for (const ValueId arg : instr.args)
                    need(arg, when);
        }
    }

    /// The first argument is the guard of the others.
    void propagate_guarded(const ir::Instr& instr, Condition when) {
        need(instr.args[0], when);
        for (size_t k = 1; k < instr.args.size(); ++k)
            need(instr.args[k], when, outcomes_[instr.args[0]].may_be_true);
    }

    /// Emits the values that the condition tests, with their operands, then the condition.
    void write(Condition demand, ir::Stage* out) {
        std::vector<bool> wanted(count(), false);
        for (const ValueId value : conditions_.tested(demand))
            wanted[value] = true;
        for (ValueId id = static_cast<ValueId>(count()); id-- > 0;) {
            if (!wanted[id]) continue;
            for (const ValueId arg : stage_.instrs[id].args)
                wanted[arg] = true;
        }
        ir::Builder builder(out);
        std::vector<ValueId> renamed(count(), kNoValue);
        for (ValueId id = 0; id < count(); ++id) {
            if (!wanted[id]) continue;
            ir::Instr copy = stage_.instrs[id];
            for (ValueId& arg : copy.args)
                arg = renamed[arg];
            renamed[id] = builder.append(std::move(copy));
        }
        const ValueId value = conditions_.write(
            demand, [&](ValueId id) { return renamed[id]; }, &builder);
        out->outputs = {{"demand", OPENFAB_ARG_DEMAND, 0, 0, value}};
    }

    const ir::Stage& stage_;
    PathConditions conditions_;
    std::vector<ValueId> outermost_;
    std::vector<bool> is_input_independent_;  ///< computed from uniforms, frame and voxel
    std::vector<Outcomes> outcomes_;
    std::vector<Condition> needs_;
};

}  // namespace

ir::Stage form_demand(const ir::Stage& volume) {
    ir::Stage live = volume;
    ir::drop_dead_values(&live);
    return Demand(live).run();
}

}  // namespace openfab::passes
