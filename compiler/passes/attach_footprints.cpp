// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/attach_footprints.h"

#include <array>
#include <map>
#include <utility>

#include "compiler/functions/differentiate.h"

namespace openfab::passes {

namespace {

using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr int32_t kAxes = 3;
constexpr int32_t kLatticeAxes = 2;
constexpr size_t kPlainSampleArgs = 4;
constexpr size_t kPlainVolumeSampleArgs = 5;

class Differentiator {
  public:
    explicit Differentiator(ir::Stage* stage) : old_(std::move(*stage)), builder_(&new_) {
        new_.kind = old_.kind;
        new_.printfs = old_.printfs;
    }

    ir::Stage run() {
        for (ValueId id = 0; id < old_.instrs.size(); ++id) {
            const ir::Instr& instr = old_.instrs[id];
            ir::Instr copy = instr;
            for (ValueId& arg : copy.args)
                arg = renamed_[arg];
            builder_.set_span(instr.span);
            const bool plain =
                copy.args.size() == kPlainSampleArgs || copy.args.size() == kPlainVolumeSampleArgs;
            if (copy.op == Op::kSample && plain) complete(&copy);
            if (copy.op == Op::kLoop) before_loop(id);
            if (copy.op == Op::kLoopEnd) end_derivatives(&copy);
            if (copy.op == Op::kDerivative) {
                const ValueId d = derivative(copy.args[0], copy.a);
                renamed_.push_back(d == kNoValue ? builder_.constant(0.0f) : d);
                continue;
            }
            const bool head = copy.op == Op::kLoop || copy.op == Op::kLoopVar;
            renamed_.push_back(builder_.append(std::move(copy)));
            if (head && old_.instrs[id + 1].op != Op::kLoopVar) begin_derivatives(id + 1);
        }
        for (ir::Output output : old_.outputs) {
            output.value = renamed_[output.value];
            new_.outputs.push_back(std::move(output));
        }
        return std::move(new_);
    }

  private:
    /// A loop that is open in the new stage: which of its variables have derivatives.
    struct OpenLoop {
        ValueId loop;  ///< in the new stage
        struct Derivative {
            ValueId var;  ///< both in the new stage
            ValueId derivative;
            int32_t axis;
        };
        std::vector<Derivative> derivatives;
    };

    /// Finds the float values whose derivative some lookup needs, by their old ids. If the
    /// footprint of a lookup depends on a loop variable, its derivative is a loop variable, too.
    std::vector<bool> find_needed() const {
        const std::vector<ValueId> ends = ir::loop_ends(old_);
        std::vector<bool> needed(old_.instrs.size(), false);
        std::vector<ValueId> pending;
        for (const ir::Instr& instr : old_.instrs) {
            const bool plain = instr.args.size() == kPlainSampleArgs ||
                               instr.args.size() == kPlainVolumeSampleArgs;
            if (instr.op == Op::kSample && plain) {
                pending.insert(pending.end(), instr.args.begin() + 1, instr.args.end() - 1);
            }
            if (instr.op == Op::kDerivative) pending.push_back(instr.args[0]);
        }
        while (!pending.empty()) {
            const ValueId value = pending.back();
            pending.pop_back();
            if (needed[value]) continue;
            needed[value] = true;
            const ir::Instr& instr = old_.instrs[value];
            if (instr.type != Type::kFloat) continue;
            const size_t number = static_cast<size_t>(instr.a) + ir::kLoopEndNext;
            if (instr.op == Op::kLoopVar) {
                pending.push_back(instr.args[1]);
                pending.push_back(old_.instrs[ends[instr.args[0]]].args[number]);
            } else if (instr.op == Op::kLoopResult) {
                const ValueId loop = old_.instrs[instr.args[0]].args[0];
                pending.push_back(loop + 1 + static_cast<ValueId>(instr.a));
            } else {
                const std::vector<ValueId> args = functions::differentiable_args(instr);
                pending.insert(pending.end(), args.begin(), args.end());
            }
        }
        return needed;
    }

    /// The loop's variables precede `next` in the old stage: adds those for their derivatives.
    void begin_derivatives(ValueId next) {
        if (needed_.empty()) needed_ = find_needed();
        ValueId old_loop = next - 1;
        while (old_.instrs[old_loop].op != Op::kLoop)
            --old_loop;
        OpenLoop open{renamed_[old_loop], {}};
        auto number = static_cast<int32_t>(next - old_loop - 1);
        for (const auto& [old_var, axis, first] : std::exchange(firsts_, {})) {
            const ValueId var = renamed_[old_var];
            const ValueId derivative = builder_.loop_var(open.loop, number++, first);
            known_[{var, axis}] = derivative;
            open.derivatives.push_back({var, derivative, axis});
        }
        open_.push_back(std::move(open));
    }

    /// Computes the derivatives of the variables' initial values, before the Loop is emitted.
    void before_loop(ValueId old_loop) {
        if (needed_.empty()) needed_ = find_needed();
        for (ValueId var = old_loop + 1; old_.instrs[var].op == Op::kLoopVar; ++var) {
            if (!needed_[var] || old_.instrs[var].type != Type::kFloat) continue;
            const ValueId first = renamed_[old_.instrs[var].args[1]];
            for (int32_t axis = 0; axis < kAxes; ++axis) {
                const ValueId d = derivative(first, axis);
                firsts_.push_back({var, axis, d == kNoValue ? builder_.constant(0.0f) : d});
            }
        }
    }

    /// Completes a LoopEnd with the derivatives' next values, and notes the results'.
    void end_derivatives(ir::Instr* end) {
        OpenLoop open = std::move(open_.back());
        open_.pop_back();
        for (const OpenLoop::Derivative& d : open.derivatives) {
            const size_t number = d.var - open.loop - 1 + ir::kLoopEndNext;
            const ValueId next = derivative(end->args[number], d.axis);
            end->args.push_back(next == kNoValue ? builder_.constant(0.0f) : next);
        }
        // Values of the loop are not available after it.
        std::erase_if(known_, [&](const auto& item) {
            return item.second != kNoValue && item.second > open.loop;
        });
        ended_[open.loop] = std::move(open.derivatives);
    }

    /// Returns the derivative of a LoopResult: the result of the derivative's variable.
    ValueId result_derivative(const ir::Instr& result, int32_t axis) {
        const ValueId end = result.args[0];
        const ValueId loop = new_.instrs[end].args[0];
        const ValueId var = loop + 1 + static_cast<ValueId>(result.a);
        for (const OpenLoop::Derivative& d : ended_[loop]) {
            if (d.var != var || d.axis != axis) continue;
            return builder_.loop_result(end, static_cast<int32_t>(d.derivative - loop - 1));
        }
        return kNoValue;
    }

    void complete(ir::Instr* sample) {
        // The coordinates are the arguments between guard and width.
        const std::vector<ValueId> coordinates(sample->args.begin() + 1, sample->args.end() - 1);
        for (const ValueId coordinate : coordinates) {
            for (int32_t axis = 0; axis < kAxes; ++axis) {
                const ValueId d = derivative(coordinate, axis);
                sample->args.push_back(d == kNoValue ? builder_.constant(0.0f) : d);
            }
        }
    }

    /// Returns the change of a value of the new stage per step along the axis; kNoValue for 0.
    /// Values are visited from the earliest on, so that long chains need no deep recursion.
    ValueId derivative(ValueId value, int32_t axis) {
        std::vector<ValueId> pending = {value};
        while (!pending.empty()) {
            const ValueId next = pending.back();
            if (known_.contains({next, axis})) {
                pending.pop_back();
                continue;
            }
            const size_t before = pending.size();
            for (const ValueId arg : functions::differentiable_args(new_.instrs[next])) {
                if (!known_.contains({arg, axis})) pending.push_back(arg);
            }
            if (pending.size() > before) continue;
            known_[{next, axis}] = differentiate(next, axis);
            pending.pop_back();
        }
        return known_[{value, axis}];
    }

    ValueId differentiate(ValueId value, int32_t axis) {
        const ir::Instr instr = new_.instrs[value];
        if (instr.type != Type::kFloat) return kNoValue;
        if (instr.op == Op::kInput) return input(instr, axis);
        if (instr.op == Op::kLoopResult) return result_derivative(instr, axis);
        std::vector<ValueId> changes;
        for (const ValueId arg : instr.args) {
            const auto found = known_.find({arg, axis});
            changes.push_back(found == known_.end() ? kNoValue : found->second);
        }
        return functions::differentiate(value, instr, changes, functions::AtZero::kQuotient,
                                        &builder_);
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
    std::vector<bool> needed_;  ///< by old id; found when the first loop is met
    struct First {
        ValueId old_var;
        int32_t axis;
        ValueId derivative;
    };
    std::vector<First> firsts_;  ///< of the loop that is about to begin
    std::vector<OpenLoop> open_;
    std::map<ValueId, std::vector<OpenLoop::Derivative>> ended_;  ///< by loop in the new stage
};

}  // namespace

void attach_footprints(ir::Stage* stage) {
    *stage = Differentiator(stage).run();
}

}  // namespace openfab::passes
