// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/cut_segments.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "compiler/passes/cut_elements.h"
#include "compiler/passes/segment_plan.h"
#include "compiler/passes/split_kernel.h"

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

/// True for values that always live in a state.
bool lives_in_state(Op op) {
    return op == Op::kLoopVar || op == Op::kLoopResult || op == Op::kQueryResult;
}

class Cutter {
  public:
    Cutter(const ir::Stage& stage, size_t longest, Amounts amounts)
        : stage_(stage),
          longest_(longest),
          in_states_(stage.kind == ir::StageKind::kVolume && amounts == Amounts::kStates),
          ends_(ir::loop_ends(stage)),
          plan_(plan_segments(stage)) {
        segment_kind_ = stage.kind == ir::StageKind::kVolume    ? ir::StageKind::kVolumeSegment
                        : stage.kind == ir::StageKind::kSurface ? ir::StageKind::kSurfaceSegment
                                                                : ir::StageKind::kShapeSegment;
    }

    SegmentedStage run() {
        new_state(Type::kBool);
        if (in_states_) {
            for (const ir::Output& output : stage_.outputs)
                new_state(at(output.value).type);
        }
        number_states();
        run_region(kNoValue);
        return std::move(out_);
    }

  private:
    const Instr& at(ValueId id) const { return stage_.instrs[id]; }

    int32_t new_state(Type type) {
        out_.states.push_back(type);
        return static_cast<int32_t>(out_.states.size() - 1);
    }

    void number_states() {
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            const Instr& instr = at(id);
            if (instr.op == Op::kLoop) plan_.regions[id].active = new_state(Type::kBool);
            if (instr.op == Op::kLoopVar) state_[id] = new_state(instr.type);
            if (instr.op == Op::kQueryResult) state_[id] = new_state(instr.type);
            if (instr.op == Op::kLoopResult) {
                const ValueId loop = at(instr.args[0]).args[0];
                state_[id] = state_.at(loop + 1 + static_cast<ValueId>(instr.a));
            }
            if (instr.op == Op::kLoopResult || instr.op == Op::kQueryResult) continue;
            for (const ValueId arg : instr.args)
                spill_if_live_out(arg, kernel_that_uses(id));
        }
        for (const ir::Output& output : stage_.outputs)
            spill_if_live_out(output.value, {kNoValue, plan_.regions[kNoValue].last});
    }

    using SegmentId = std::pair<ValueId, size_t>;  ///< a kernel: region and segment

    SegmentId kernel_that_uses(ValueId user) {
        const Instr& instr = at(user);
        if (instr.op == Op::kLoopEnd) return {instr.args[0], plan_.regions[instr.args[0]].last};
        if (instr.op == Op::kLoopVar) user = instr.args[0];
        return {plan_.inside[user],
                is_barrier(at(user).op) ? plan_.level[user] : plan_.segment[user]};
    }

    void spill_if_live_out(ValueId value, const SegmentId& user) {
        const Op op = at(value).op;
        if (is_barrier(op) || lives_in_state(op) || plan_.rematerialized[value] ||
            state_.count(value) != 0)
            return;
        if (user != SegmentId{plan_.inside[value], plan_.segment[value]}) {
            state_[value] = new_state(at(value).type);
        }
    }

    // --- kernels

    /// The kernel of one segment, while it is built.
    class Kernel {
      public:
        Kernel(Cutter* cutter, ValueId region, size_t segment)
            : cutter_(*cutter), region_(region), segment_(segment), builder_(&stage_) {
            stage_.kind = cutter->segment_kind_;
        }

        ir::Builder& builder() { return builder_; }
        ir::Stage& stage() { return stage_; }
        bool empty() const { return stage_.outputs.empty(); }

        ValueId get(ValueId id) {
            const auto found = made_.find(id);
            if (found != made_.end()) return found->second;
            const Instr& instr = cutter_.at(id);
            ValueId value = kNoValue;
            const bool here =
                cutter_.plan_.inside[id] == region_ && cutter_.plan_.segment[id] == segment_;
            const auto state = cutter_.state_.find(id);
            if (state != cutter_.state_.end() && (lives_in_state(instr.op) || !here)) {
                value = read(state->second, instr.type);
            } else {
                value = copy(instr);
            }
            made_[id] = value;
            return value;
        }

        ValueId read(int32_t state, Type type) {
            return builder_.input(type, OPENFAB_ARG_STATE, state, 0);
        }

        void write(int32_t state, ValueId value) {
            stage_.outputs.push_back(
                {fmt::format("state_{}", state), OPENFAB_ARG_STATE_OUT, state, 0, value});
        }

        ValueId active() { return read(cutter_.plan_.regions.at(region_).active, Type::kBool); }

      private:
        ValueId copy(const Instr& instr) {
            Instr out = instr;
            for (ValueId& arg : out.args)
                arg = get(arg);
            builder_.set_span(instr.span);
            if (instr.op == Op::kSample && region_ != kNoValue) {
                out.args[0] = builder_.emit(Op::kAnd, {out.args[0], active()});
            }
            return builder_.append(std::move(out));
        }

        Cutter& cutter_;
        const ValueId region_;
        const size_t segment_;
        ir::Stage stage_;
        ir::Builder builder_;
        std::map<ValueId, ValueId> made_;
    };

    void run_region(ValueId loop) {
        const Region& region = plan_.regions.at(loop);
        for (size_t k = 0; k <= region.last; ++k) {
            make_kernel(region, k);
            for (const ValueId barrier : region.barriers) {
                if (plan_.level[barrier] == k && k < region.last) run_barrier(barrier);
            }
        }
    }

    void add_step(openfab_step_kind kind, size_t a, size_t b = 0) {
        out_.steps.push_back({kind, static_cast<int32_t>(a), static_cast<int32_t>(b)});
    }

    void run_barrier(ValueId barrier) {
        const Op op = at(barrier).op;
        if (op == Op::kQuery) return add_step(OPENFAB_STEP_QUERY, query_of_.at(barrier));
        if (op == Op::kPrintf) return add_step(OPENFAB_STEP_PRINTF, printf_of_.at(barrier));
        const auto active = static_cast<size_t>(plan_.regions.at(barrier).active);
        const size_t head = out_.steps.size();
        add_step(OPENFAB_STEP_LOOP, active);
        run_region(barrier);
        add_step(OPENFAB_STEP_LOOP_END, active, head + 1);
        out_.steps[head].b = static_cast<int32_t>(out_.steps.size());
    }

    void make_kernel(const Region& region, size_t segment) {
        Kernel kernel(this, region.loop, segment);
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            if (plan_.inside[id] != region.loop || plan_.segment[id] != segment) continue;
            const Op op = at(id).op;
            if (is_barrier(op) || lives_in_state(op) || op == Op::kLoopEnd ||
                plan_.rematerialized[id])
                continue;
            const ValueId value = kernel.get(id);
            if (const auto state = state_.find(id); state != state_.end()) {
                kernel.write(state->second, value);
            }
        }
        for (const ValueId barrier : region.barriers) {
            if (plan_.level[barrier] == segment && segment < region.last)
                prepare_barrier(barrier, &kernel);
        }
        if (segment == region.last) finish_region(region, &kernel);
        if (kernel.empty()) return;
        const bool ends = region.loop == kNoValue && segment == region.last;
        if (!is_wide(kernel.stage())) return add_pieces(std::move(kernel.stage()), ends);
        std::vector<ElementPart> parts = cut_elements(kernel.stage(), &out_.states);
        for (ElementPart& part : parts) {
            if (!part.kernel.outputs.empty())
                add_pieces(std::move(part.kernel), ends && &part == &parts.back());
            for (const openfab_elements& elements : part.steps) {
                add_step(OPENFAB_STEP_ELEMENTS, out_.elements.size());
                out_.elements.push_back(elements);
            }
        }
    }

    void add_pieces(ir::Stage kernel, bool ends) {
        std::vector<ir::Stage> pieces;
        if (needs_splitting(kernel, longest_)) {
            pieces = split_kernel(kernel, &out_.states, longest_);
        } else {
            pieces.push_back(std::move(kernel));
        }
        if (ends && stage_.kind == ir::StageKind::kVolume && !in_states_) keep_last(&pieces);
        for (ir::Stage& piece : pieces)
            add_kernel(std::move(piece));
    }

    /// Takes the last segment of a volume stage, or the last piece of it, out of the program. What
    /// other pieces have of the stage's outputs comes to it through states.
    void keep_last(std::vector<ir::Stage>* pieces) {
        ir::Stage& last = out_.last;
        last = std::move(pieces->back());
        pieces->pop_back();
        last.kind = stage_.kind;
        ir::Builder builder(&last);
        for (ir::Stage& piece : *pieces) {
            for (ir::Output& output : piece.outputs) {
                if (output.kind == OPENFAB_ARG_STATE_OUT) continue;
                const Type type = piece.instrs[output.value].type;
                const int32_t state = new_state(type);
                last.outputs.push_back(output);
                last.outputs.back().value = builder.input(type, OPENFAB_ARG_STATE, state, 0);
                output = {fmt::format("state_{}", state), OPENFAB_ARG_STATE_OUT, state, 0,
                          output.value};
            }
        }
        std::ranges::sort(last.outputs, {}, &ir::Output::a);
    }

    void add_kernel(ir::Stage kernel) {
        add_step(OPENFAB_STEP_KERNEL, out_.kernels.size());
        out_.kernels.push_back(std::move(kernel));
    }

    /// Writes the operands of a barrier to state, at the end of the kernel before it.
    void prepare_barrier(ValueId barrier, Kernel* kernel) {
        const Instr& instr = at(barrier);
        const ValueId guard =
            kernel->builder().emit(Op::kAnd, {kernel->get(instr.args[0]), kernel->active()});
        const auto keep = [&](ValueId value) {
            const int32_t state = new_state(at(value).type);
            kernel->write(state, kernel->get(value));
            return state;
        };
        if (instr.op == Op::kLoop) {
            kernel->write(plan_.regions.at(barrier).active, guard);
            for (ValueId var = barrier + 1; at(var).op == Op::kLoopVar; ++var) {
                kernel->write(state_.at(var), kernel->get(at(var).args[1]));
            }
            return;
        }
        const int32_t guard_state = new_state(Type::kBool);
        kernel->write(guard_state, guard);
        if (instr.op == Op::kPrintf) {
            SegmentPrintf call{stage_.printfs[instr.a], guard_state, {}, {}};
            for (size_t k = 1; k < instr.args.size(); ++k) {
                call.values.push_back(keep(instr.args[k]));
                call.types.push_back(at(instr.args[k]).type);
            }
            printf_of_[barrier] = out_.printfs.size();
            out_.printfs.push_back(std::move(call));
            return;
        }
        SegmentQuery query{instr.a, guard_state};
        for (size_t k = 0; k < query.point.size(); ++k)
            query.point[k] = keep(instr.args[k + 1]);
        if (ir::is_walk(instr)) {
            query.stop = keep(instr.args[4]);
            query.seed = keep(instr.args[5]);
        }
        for (ValueId id = barrier + 1; id < stage_.instrs.size(); ++id) {
            const Instr& result = at(id);
            if (result.op != Op::kQueryResult || result.args[0] != barrier) continue;
            query.outputs.push_back({static_cast<openfab_query_result>(result.kind), result.a,
                                     result.b, state_.at(id)});
        }
        query_of_[barrier] = out_.queries.size();
        out_.queries.push_back(std::move(query));
    }

    /// Writes the variables of the loop's next trip, or the stage's outputs.
    void finish_region(const Region& region, Kernel* kernel) {
        if (region.loop == kNoValue) {
            for (ir::Output output : stage_.outputs) {
                output.value = kernel->get(output.value);
                if (in_states_) {
                    kernel->write(output.a + 1, output.value);
                } else {
                    kernel->stage().outputs.push_back(std::move(output));
                }
            }
            return;
        }
        const Instr& end = at(ends_[region.loop]);
        const ValueId active = kernel->active();
        for (size_t k = ir::kLoopEndNext; k < end.args.size(); ++k) {
            const ValueId var = region.loop + 1 + static_cast<ValueId>(k - ir::kLoopEndNext);
            if (end.args[k] == var) continue;
            const ValueId next = kernel->get(end.args[k]);
            kernel->write(state_.at(var), kernel->builder().select(active, next, kernel->get(var)));
        }
        const ValueId again = kernel->builder().emit(Op::kAnd, {active, kernel->get(end.args[1])});
        kernel->write(region.active, again);
    }

    const ir::Stage& stage_;
    const size_t longest_;
    const bool in_states_;  ///< the amounts of a volume
    const std::vector<ValueId> ends_;
    SegmentPlan plan_;
    ir::StageKind segment_kind_;
    SegmentedStage out_;
    std::map<ValueId, int32_t> state_;
    std::map<ValueId, size_t> query_of_;
    std::map<ValueId, size_t> printf_of_;
};

}  // namespace

bool needs_segments(const ir::Stage& stage, size_t longest) {
    return needs_splitting(stage, longest) ||
           std::any_of(stage.instrs.begin(), stage.instrs.end(),
                       [](const Instr& instr) { return is_barrier(instr.op); });
}

SegmentedStage cut_segments(const ir::Stage& stage, size_t longest, Amounts amounts) {
    return Cutter(stage, longest, amounts).run();
}

}  // namespace openfab::passes
