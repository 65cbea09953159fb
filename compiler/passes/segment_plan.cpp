// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/segment_plan.h"

#include <algorithm>

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::ValueId;

// The most operations rematerialized rather than spilled, which costs a store, a copy and a load.
constexpr int kCheap = 4;
constexpr int kNotCheap = 1 << 20;

class SegmentPlanner {
  public:
    explicit SegmentPlanner(const ir::Stage& stage) : stage_(stage) {}

    SegmentPlan run() {
        find_regions();
        find_levels();
        find_segments();
        find_costs();
        return std::move(out_);
    }

  private:
    const Instr& at(ValueId id) const { return stage_.instrs[id]; }
    Region& region_of(ValueId id) { return out_.regions.at(out_.inside[id]); }

    void find_regions() {
        out_.regions[kNoValue] = {};
        std::vector<ValueId> open;
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            const Op op = at(id).op;
            if (op == Op::kLoopEnd) open.pop_back();
            out_.inside.push_back(open.empty() ? kNoValue : open.back());
            if (is_barrier(op)) region_of(id).barriers.push_back(id);
            if (op == Op::kLoop) {
                out_.regions[id].loop = id;
                open.push_back(id);
            }
        }
    }

    /// Returns what represents `id` in the region: itself, or the loop of the region that contains
    /// it.
    ValueId in_region(ValueId id, ValueId region) const {
        while (out_.inside[id] != region)
            id = out_.inside[id];
        return id;
    }

    /// Puts barriers as early as their operands allow, so that independent queries share a level;
    /// printfs, and loops with printfs, keep their order.
    void find_levels() {
        const size_t count = stage_.instrs.size();
        std::vector<size_t> ready(count, 0);  // first segment of its region that may use the value
        out_.level.assign(count, 0);
        std::map<ValueId, size_t> after_print;  // by region
        for (ValueId id = 0; id < count; ++id) {
            const Instr& instr = at(id);
            // A loop needs what its body uses; an instruction is charged to all loops around it.
            const bool ends = instr.op == Op::kLoopEnd;
            for (const ValueId arg : instr.args) {
                if (at(arg).op == Op::kLoop || (ends && out_.inside[arg] == instr.args[0]))
                    continue;
                ValueId user = ends ? instr.args[0] : id;
                while (true) {
                    if (out_.inside[user] == out_.inside[arg]) {
                        ready[user] = std::max(ready[user], ready[arg]);
                    }
                    if (out_.inside[user] == kNoValue || out_.inside[user] == out_.inside[arg])
                        break;
                    user = out_.inside[user];
                }
            }
            if (instr.op == Op::kPrintf) {
                for (ValueId user = id;; user = out_.inside[user]) {
                    size_t& next = after_print[out_.inside[user]];
                    ready[user] = std::max(ready[user], next);
                    next = ready[user];
                    if (out_.inside[user] == kNoValue) break;
                }
            }
            if (ends && after_print.count(instr.args[0]) != 0) {
                size_t& next = after_print[out_.inside[id]];
                next = std::max(next, ready[instr.args[0]]);
            }
            if (instr.op == Op::kQuery || instr.op == Op::kPrintf) out_.level[id] = ready[id];
            if (instr.op == Op::kLoopEnd) {
                const ValueId loop = instr.args[0];
                out_.level[loop] = ready[loop];
                ready[id] = ready[loop] + 1;
            }
            if (instr.op == Op::kQuery) ++ready[id];
        }
        for (auto& item : out_.regions) {
            Region& region = item.second;
            for (const ValueId barrier : region.barriers)
                region.last = std::max(region.last, out_.level[barrier] + 1);
        }
    }

    /// Puts values as late as their first use allows: a value used in one segment only needs no
    /// state.
    void find_segments() {
        const size_t count = stage_.instrs.size();
        out_.segment.resize(count);
        for (ValueId id = 0; id < count; ++id)
            out_.segment[id] = region_of(id).last;
        for (ValueId id = static_cast<ValueId>(count); id-- > 0;) {
            const Instr& instr = at(id);
            for (const ValueId arg : instr.args) {
                const size_t when = use_segment(id, out_.inside[arg]);
                out_.segment[arg] = std::min(out_.segment[arg], when);
            }
        }
    }

    /// Returns the segment of `region` in which `user` needs its arguments.
    size_t use_segment(ValueId user, ValueId region) {
        const Instr& instr = at(user);
        if (instr.op == Op::kLoopEnd && instr.args[0] == region) return out_.regions[region].last;
        if (instr.op == Op::kLoopEnd) user = instr.args[0];
        const ValueId item = in_region(user, region);
        return is_barrier(at(item).op) ? out_.level[item] : out_.segment[item];
    }

    /// Computes the cost of rematerializing each value from inputs.
    void find_costs() {
        for (const Instr& instr : stage_.instrs) {
            cost_.push_back(cost_of(instr));
            out_.rematerialized.push_back(instr.op == Op::kInput || cost_.back() <= kCheap);
        }
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

    const ir::Stage& stage_;
    SegmentPlan out_;
    std::vector<int> cost_;
};

}  // namespace

SegmentPlan plan_segments(const ir::Stage& stage) {
    return SegmentPlanner(stage).run();
}

}  // namespace openfab::passes
