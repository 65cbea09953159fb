// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/cut_segments.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "compiler/passes/cut_elements.h"
#include "compiler/passes/split_kernel.h"

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

// The most operations rematerialized rather than spilled, which costs a store, a copy and a load.
constexpr int kCheap = 4;
constexpr int kNotCheap = 1 << 20;
constexpr int32_t kLive = 0;

bool is_barrier(Op op) {
    return op == Op::kLoop || op == Op::kQuery || op == Op::kPrintf;
}

/// True for values that always live in a state.
bool lives_in_state(Op op) {
    return op == Op::kLoopVar || op == Op::kLoopResult || op == Op::kQueryResult;
}

/// The body of a loop, or the stage. Its segments 0, 1, … are straight-line code; the barriers of
/// level k come between segment k and k + 1.
struct Region {
    ValueId loop = kNoValue;
    size_t last = 0;                ///< segment
    std::vector<ValueId> barriers;  ///< in the order of the program
    int32_t active = kLive;         ///< state: the active lanes
};

class Cutter {
  public:
    Cutter(const ir::Stage& stage, size_t longest, Amounts amounts)
        : stage_(stage),
          longest_(longest),
          in_states_(stage.kind == ir::StageKind::kVolume && amounts == Amounts::kStates),
          ends_(ir::loop_ends(stage)) {
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
        find_regions();
        find_levels();
        find_segments();
        find_costs();
        number_states();
        run_region(kNoValue);
        return std::move(out_);
    }

  private:
    const Instr& at(ValueId id) const { return stage_.instrs[id]; }
    Region& region_of(ValueId id) { return regions_.at(inside_[id]); }

    int32_t new_state(Type type) {
        out_.states.push_back(type);
        return static_cast<int32_t>(out_.states.size() - 1);
    }

    void find_regions() {
        regions_[kNoValue] = {};
        std::vector<ValueId> open;
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            const Op op = at(id).op;
            if (op == Op::kLoopEnd) open.pop_back();
            inside_.push_back(open.empty() ? kNoValue : open.back());
            if (is_barrier(op)) region_of(id).barriers.push_back(id);
            if (op == Op::kLoop) {
                regions_[id].loop = id;
                open.push_back(id);
            }
        }
    }

    /// Returns what represents `id` in the region: itself, or the loop of the region that contains
    /// it.
    ValueId in_region(ValueId id, ValueId region) const {
        while (inside_[id] != region)
            id = inside_[id];
        return id;
    }
    bool encloses(ValueId region, ValueId id) const {
        for (ValueId loop = inside_[id]; loop != region; loop = inside_[loop]) {
            if (loop == kNoValue) return false;
        }
        return true;
    }

    /// Puts barriers as early as their operands allow, so that independent queries share a level;
    /// printfs, and loops with printfs, keep their order.
    void find_levels() {
        const size_t count = stage_.instrs.size();
        std::vector<size_t> ready(count, 0);  // first segment of its region that may use the value
        level_.assign(count, 0);
        std::map<ValueId, size_t> after_print;  // by region
        for (ValueId id = 0; id < count; ++id) {
            const Instr& instr = at(id);
            // A loop needs what its body uses; an instruction is charged to all loops around it.
            const bool ends = instr.op == Op::kLoopEnd;
            for (const ValueId arg : instr.args) {
                if (at(arg).op == Op::kLoop || (ends && inside_[arg] == instr.args[0])) continue;
                ValueId user = ends ? instr.args[0] : id;
                while (true) {
                    if (inside_[user] == inside_[arg]) {
                        ready[user] = std::max(ready[user], ready[arg]);
                    }
                    if (inside_[user] == kNoValue || inside_[user] == inside_[arg]) break;
                    user = inside_[user];
                }
            }
            if (instr.op == Op::kPrintf) {
                for (ValueId user = id;; user = inside_[user]) {
                    size_t& next = after_print[inside_[user]];
                    ready[user] = std::max(ready[user], next);
                    next = ready[user];
                    if (inside_[user] == kNoValue) break;
                }
            }
            if (ends && after_print.count(instr.args[0]) != 0) {
                size_t& next = after_print[inside_[id]];
                next = std::max(next, ready[instr.args[0]]);
            }
            if (instr.op == Op::kQuery || instr.op == Op::kPrintf) level_[id] = ready[id];
            if (instr.op == Op::kLoopEnd) {
                const ValueId loop = instr.args[0];
                level_[loop] = ready[loop];
                ready[id] = ready[loop] + 1;
            }
            if (instr.op == Op::kQuery) ++ready[id];
        }
        for (auto& item : regions_) {
            Region& region = item.second;
            for (const ValueId barrier : region.barriers)
                region.last = std::max(region.last, level_[barrier] + 1);
        }
    }

    /// Puts values as late as their first use allows: a value used in one segment only needs no
    /// state.
    void find_segments() {
        const size_t count = stage_.instrs.size();
        segment_.resize(count);
        for (ValueId id = 0; id < count; ++id)
            segment_[id] = region_of(id).last;
        for (ValueId id = static_cast<ValueId>(count); id-- > 0;) {
            const Instr& instr = at(id);
            for (const ValueId arg : instr.args) {
                const size_t when = use_segment(id, inside_[arg]);
                segment_[arg] = std::min(segment_[arg], when);
            }
        }
    }

    /// Returns the segment of `region` in which `user` needs its arguments.
    size_t use_segment(ValueId user, ValueId region) {
        const Instr& instr = at(user);
        if (instr.op == Op::kLoopEnd && instr.args[0] == region) return regions_[region].last;
        if (instr.op == Op::kLoopEnd) user = instr.args[0];
        const ValueId item = in_region(user, region);
        return is_barrier(at(item).op) ? level_[item] : segment_[item];
    }

    /// Computes the cost of rematerializing each value from inputs.
    void find_costs() {
        for (ValueId id = 0; id < stage_.instrs.size(); ++id)
            cost_.push_back(cost_of(at(id)));
    }
    int cost_of(const Instr& instr) const {
        if (ir::is_effectful(instr.op)) return kNotCheap;
        switch (instr.op) {
            case Op::kConst:
                return 0;
            case Op::kInput:
                return instr.kind == OPENFAB_ARG_UNIFORM || instr.kind == OPENFAB_ARG_FRAME ? 0 : 1;
            case Op::kDiv:
            case Op::kMod:
            case Op::kSqrt:
            case Op::kSample:
                return kNotCheap;
            case Op::kAdd:
            case Op::kSub:
            case Op::kMul:
            case Op::kNeg:
            case Op::kSampleBound:
            case Op::kBitCast:
            case Op::kPick:
            case Op::kTable:
            case Op::kFloor:
            case Op::kCeil:
            case Op::kRound:
            case Op::kTrunc:
            case Op::kIsNan:
                OPENFAB_IR_CASES(CONTROL)
                OPENFAB_IR_CASES(BITS)
                OPENFAB_IR_CASES(LOGIC)
                OPENFAB_IR_CASES(COMPARISONS)
                OPENFAB_IR_CASES(CHOICES)
                OPENFAB_IR_CASES(EXTREMES)
                OPENFAB_IR_CASES(FUNCTIONS)
                OPENFAB_IR_CASES(DERIVATIVES)
                break;
        }
        int cost = 1;
        for (const ValueId arg : instr.args)
            cost = std::min(cost + cost_[arg], kNotCheap);
        return cost;
    }
    bool is_rematerialized(ValueId id) const {
        return at(id).op == Op::kInput || cost_[id] <= kCheap;
    }

    void number_states() {
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            const Instr& instr = at(id);
            if (instr.op == Op::kLoop) regions_[id].active = new_state(Type::kBool);
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
            spill_if_live_out(output.value, {kNoValue, regions_[kNoValue].last});
    }

    using SegmentId = std::pair<ValueId, size_t>;  ///< a kernel: region and segment

    SegmentId kernel_that_uses(ValueId user) {
        const Instr& instr = at(user);
        if (instr.op == Op::kLoopEnd) return {instr.args[0], regions_[instr.args[0]].last};
        if (instr.op == Op::kLoopVar) user = instr.args[0];
        return {inside_[user], is_barrier(at(user).op) ? level_[user] : segment_[user]};
    }

    void spill_if_live_out(ValueId value, const SegmentId& user) {
        const Op op = at(value).op;
        if (is_barrier(op) || lives_in_state(op) || is_rematerialized(value) ||
            state_.count(value) != 0)
            return;
        if (user != SegmentId{inside_[value], segment_[value]}) {
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
            const bool here = cutter_.inside_[id] == region_ && cutter_.segment_[id] == segment_;
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

        ValueId active() { return read(cutter_.regions_.at(region_).active, Type::kBool); }

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
        const Region& region = regions_.at(loop);
        for (size_t k = 0; k <= region.last; ++k) {
            make_kernel(region, k);
            for (const ValueId barrier : region.barriers) {
                if (level_[barrier] == k && k < region.last) run_barrier(barrier);
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
        const auto active = static_cast<size_t>(regions_.at(barrier).active);
        const size_t head = out_.steps.size();
        add_step(OPENFAB_STEP_LOOP, active);
        run_region(barrier);
        add_step(OPENFAB_STEP_LOOP_END, active, head + 1);
        out_.steps[head].b = static_cast<int32_t>(out_.steps.size());
    }

    void make_kernel(const Region& region, size_t segment) {
        Kernel kernel(this, region.loop, segment);
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            if (inside_[id] != region.loop || segment_[id] != segment) continue;
            const Op op = at(id).op;
            if (is_barrier(op) || lives_in_state(op) || op == Op::kLoopEnd || is_rematerialized(id))
                continue;
            const ValueId value = kernel.get(id);
            if (const auto state = state_.find(id); state != state_.end()) {
                kernel.write(state->second, value);
            }
        }
        for (const ValueId barrier : region.barriers) {
            if (level_[barrier] == segment && segment < region.last)
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
            kernel->write(regions_.at(barrier).active, guard);
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
        SegmentQuery query{instr.a, guard_state, {}, {}};
        for (size_t k = 0; k < query.point.size(); ++k)
            query.point[k] = keep(instr.args[k + 1]);
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
    ir::StageKind segment_kind_;
    SegmentedStage out_;
    std::map<ValueId, Region> regions_;  ///< by loop
    std::vector<ValueId> inside_;        ///< the innermost loop around each instruction
    std::vector<size_t> level_;          ///< of barriers
    std::vector<size_t> segment_;
    std::vector<int> cost_;
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
