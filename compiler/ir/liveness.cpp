// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "compiler/ir/ir.h"

namespace openfab::ir {

namespace {

class Liveness {
  public:
    explicit Liveness(const Stage& stage)
        : stage_(stage), ends_(loop_ends(stage)), live_(stage.instrs.size(), false) {
        find_loops();
    }

    std::vector<bool> run() {
        for (const Output& output : stage_.outputs)
            mark(output.value);
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            if (stage_.instrs[id].op == Op::kPrintf) mark(id);
        }
        while (!pending_.empty()) {
            const ValueId id = pending_.back();
            pending_.pop_back();
            visit(id);
        }
        return std::move(live_);
    }

  private:
    void find_loops() {
        inside_.assign(stage_.instrs.size(), kNoValue);
        std::vector<ValueId> open;
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            const Op op = stage_.instrs[id].op;
            if (op == Op::kLoopEnd) open.pop_back();
            if (!open.empty()) inside_[id] = open.back();
            if (op == Op::kLoop) open.push_back(id);
        }
    }

    void mark(ValueId id) {
        if (live_[id]) return;
        live_[id] = true;
        pending_.push_back(id);
    }

    void visit(ValueId id) {
        const Instr& instr = stage_.instrs[id];
        // A live value inside a loop keeps the loop's condition alive.
        if (inside_[id] != kNoValue) mark(ends_[inside_[id]]);
        switch (instr.op) {
            case Op::kLoopEnd:
                mark(instr.args[0]);
                mark(instr.args[1]);
                return;
            case Op::kLoopVar: {
                mark_next(ends_[instr.args[0]], instr.a);
                break;
            }
            case Op::kLoopResult: {
                const ValueId loop = stage_.instrs[instr.args[0]].args[0];
                mark(loop + 1 + static_cast<ValueId>(instr.a));
                break;
            }
            case Op::kLoop:
            case Op::kQuery:
            case Op::kQueryResult:
            case Op::kPrintf:
                OPENFAB_IR_CASES(LEAVES)
                OPENFAB_IR_CASES(CHOICES)
                OPENFAB_IR_CASES(LOOKUPS)
                OPENFAB_IR_CASES(FUNCTIONS)
                OPENFAB_IR_CASES(DERIVATIVES)
                OPENFAB_IR_CASES(OPERATIONS)
                break;
        }
        for (const ValueId arg : instr.args)
            mark(arg);
    }

    void mark_next(ValueId end, int32_t number) {
        mark(stage_.instrs[end].args[kLoopEndNext + static_cast<size_t>(number)]);
    }

    const Stage& stage_;
    const std::vector<ValueId> ends_;
    std::vector<bool> live_;
    std::vector<ValueId> inside_;  ///< the innermost loop around each instruction
    std::vector<ValueId> pending_;
};

}  // namespace

std::vector<ValueId> loop_ends(const Stage& stage) {
    std::vector<ValueId> ends(stage.instrs.size(), kNoValue);
    for (ValueId id = 0; id < stage.instrs.size(); ++id) {
        if (stage.instrs[id].op == Op::kLoopEnd) ends[stage.instrs[id].args[0]] = id;
    }
    return ends;
}

std::vector<bool> live_values(const Stage& stage) {
    return Liveness(stage).run();
}

void drop_dead_values(Stage* stage) {
    const std::vector<bool> live = live_values(*stage);
    std::vector<ValueId> renamed(stage->instrs.size(), kNoValue);
    std::vector<int32_t> number(stage->instrs.size(), 0);  // of LoopVars, among the remaining ones
    std::vector<int32_t> kept_vars(stage->instrs.size(), 0);
    std::vector<Instr> kept;
    for (ValueId id = 0; id < stage->instrs.size(); ++id) {
        if (!live[id]) continue;
        Instr instr = std::move(stage->instrs[id]);
        if (instr.op == Op::kLoopVar) {
            number[id] = kept_vars[instr.args[0]]++;
            instr.a = number[id];
        } else if (instr.op == Op::kLoopEnd) {
            const ValueId first = instr.args[0] + 1;
            std::vector<ValueId> args = {instr.args[0], instr.args[1]};
            for (size_t k = kLoopEndNext; k < instr.args.size(); ++k) {
                if (live[first + k - kLoopEndNext]) args.push_back(instr.args[k]);
            }
            number[id] = static_cast<int32_t>(first);
            instr.args = std::move(args);
        } else if (instr.op == Op::kLoopResult) {
            const auto first = static_cast<ValueId>(number[instr.args[0]]);
            instr.a = number[first + static_cast<ValueId>(instr.a)];
        }
        for (ValueId& arg : instr.args)
            arg = renamed[arg];
        renamed[id] = static_cast<ValueId>(kept.size());
        kept.push_back(std::move(instr));
    }
    stage->instrs = std::move(kept);
    for (Output& output : stage->outputs)
        output.value = renamed[output.value];
}

}  // namespace openfab::ir
