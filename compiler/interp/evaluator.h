// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The walk over a stage that both interpreters share: evaluate.h, on bits, and evaluate_double.h.

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "compiler/ir/arithmetic.h"

namespace openfab::interp {

/// Walks the instructions with a program counter: the end of a loop sets it back. A machine has a type Word, which holds
/// any value (of a bool or an integer its own, so that 0 is false), and the operations below.
template <typename Machine>
class Evaluator {
  public:
    using Word = typename Machine::Word;

    Evaluator(const ir::Stage& stage, Machine machine)
        : stage_(stage),
          machine_(std::move(machine)),
          ends_(ir::loop_ends(stage)),
          values_(stage.instrs.size(), 0) {}

    std::vector<Word> run() {
        while (at_ < stage_.instrs.size())
            step();
        return std::move(values_);
    }

  private:
    void step() {
        const ir::ValueId id = at_++;
        const ir::Instr& instr = stage_.instrs[id];
        args_.clear();
        for (const ir::ValueId arg : instr.args)
            args_.push_back(values_[arg]);
        switch (instr.op) {
            case ir::Op::kLoop:
                return begin_loop(id);
            case ir::Op::kLoopVar:
                return;  // set by the loop's start and end
            case ir::Op::kLoopEnd:
                return end_loop(instr);
            case ir::Op::kLoopResult: {
                const ir::Instr& end = stage_.instrs[instr.args[0]];
                values_[id] = values_[end.args[0] + 1 + static_cast<ir::ValueId>(instr.a)];
                return;
            }
            case ir::Op::kPrintf:
                if (args_[0] == 0) return;
                return machine_.printf(stage_.printfs[instr.a],
                                       std::span<const Word>(args_).subspan(1));
            case ir::Op::kQuery:
            case ir::Op::kQueryResult:
                OPENFAB_IR_CASES(LEAVES)
                OPENFAB_IR_CASES(CHOICES)
                OPENFAB_IR_CASES(LOOKUPS)
                OPENFAB_IR_CASES(FUNCTIONS)
                OPENFAB_IR_CASES(DERIVATIVES)
                OPENFAB_IR_CASES(OPERATIONS)
                values_[id] = evaluate_one(instr);
        }
    }

    void begin_loop(ir::ValueId loop) {
        for (ir::ValueId var = loop + 1; stage_.instrs[var].op == ir::Op::kLoopVar; ++var) {
            values_[var] = values_[stage_.instrs[var].args[1]];
        }
        if (args_[0] == 0) at_ = ends_[loop] + 1;
    }

    void end_loop(const ir::Instr& end) {
        for (size_t k = ir::kLoopEndNext; k < args_.size(); ++k) {
            values_[end.args[0] + 1 + k - ir::kLoopEndNext] = args_[k];
        }
        if (args_[1] != 0) at_ = end.args[0] + 1;
    }

    /// Returns which of `count` elements the first argument names.
    size_t picked(const ir::Instr& instr, size_t count) const {
        return ir::picked_element(stage_.instrs[instr.args[0]].type,
                                  static_cast<uint32_t>(args_[0]), count);
    }

    Word evaluate_query_result(const ir::Instr& instr) const {
        const ir::Instr& query = stage_.instrs[instr.args[0]];
        std::array<Word, 6> args{};
        for (size_t k = 0; k < query.args.size(); ++k)
            args[k] = values_[query.args[k]];
        return args[0] == 0
                   ? 0
                   : machine_.query(query, instr, std::span(args).first(query.args.size()));
    }

    Word evaluate_one(const ir::Instr& instr) const {
        switch (instr.op) {
            case ir::Op::kConst:
                return machine_.constant(instr);
            case ir::Op::kInput:
                return machine_.input(instr.type, instr.kind, instr.a, instr.b);
            case ir::Op::kSample:
                return machine_.sample(instr, args_);
            case ir::Op::kSampleBound:
                return machine_.sample_bound(instr, args_);
            case ir::Op::kQuery:
                return 0;
            case ir::Op::kQueryResult:
                return evaluate_query_result(instr);
            case ir::Op::kConvert:
                return machine_.convert(stage_.instrs[instr.args[0]].type, instr.type, args_[0]);
            case ir::Op::kPick:
                return args_[1 + picked(instr, args_.size() - 1)];
            case ir::Op::kTable: {
                const auto element = static_cast<int32_t>(picked(instr, instr.bits));
                return machine_.input(instr.type, OPENFAB_ARG_UNIFORM, instr.a + instr.b * element,
                                      0);
            }
            case ir::Op::kSelect:
                return args_[0] != 0 ? args_[1] : args_[2];
                OPENFAB_IR_CASES(FUNCTIONS)
                return machine_.function(instr, args_);
            case ir::Op::kBitCast:
                OPENFAB_IR_CASES(DERIVATIVES)
                OPENFAB_IR_CASES(OPERATIONS)
                return machine_.operation(instr, stage_.instrs[instr.args[0]].type, args_[0],
                                          args_.size() > 1 ? args_[1] : 0);
            case ir::Op::kLoop:
            case ir::Op::kLoopVar:
            case ir::Op::kLoopEnd:
            case ir::Op::kLoopResult:
            case ir::Op::kPrintf:
                break;  // evaluate
        }
        return 0;
    }

    const ir::Stage& stage_;
    const Machine machine_;
    const std::vector<ir::ValueId> ends_;
    std::vector<Word> values_;
    std::vector<Word> args_;  ///< of the current instruction
    ir::ValueId at_ = 0;
};

}  // namespace openfab::interp
