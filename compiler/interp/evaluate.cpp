// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/interp/evaluate.h"

#include <array>

#include "compiler/functions/functions.h"
#include "compiler/interp/sample_volume.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::interp {

namespace {

constexpr uint32_t kQuietNan = 0x7fc00000u;
constexpr size_t kSampleArgsWithFootprint = 10;
constexpr size_t kVolumeSampleArgs = 5;
constexpr size_t kVolumeSampleArgsWithFootprint = 14;

uint32_t evaluate_volume_sample(const ir::Instr& instr, std::span<const uint32_t> args,
                                const Environment& environment) {
    VolumeSampleArgs at;
    for (size_t k = 0; k < 3; ++k)
        at.p[k] = ir::as_float(args[1 + k]);
    at.width = ir::as_float(args[4]);
    for (size_t k = 0; k < 9 && args.size() == kVolumeSampleArgsWithFootprint; ++k)
        at.dp[k / 3][k % 3] = ir::as_float(args[5 + k]);
    return ir::as_bits(sample_volume(environment.texture(instr.a), instr.b, at));
}

uint32_t evaluate_sample(const ir::Instr& instr, std::span<const uint32_t> args,
                         const Environment& environment) {
    if (args[0] == 0) return 0;
    if (args.size() == kVolumeSampleArgs || args.size() == kVolumeSampleArgsWithFootprint)
        return evaluate_volume_sample(instr, args, environment);
    SampleArgs at;
    at.u = ir::as_float(args[1]);
    at.v = ir::as_float(args[2]);
    at.width = ir::as_float(args[3]);
    if (args.size() == kSampleArgsWithFootprint) {
        for (size_t k = 0; k < 3; ++k) {
            at.du[k] = ir::as_float(args[4 + k]);
            at.dv[k] = ir::as_float(args[7 + k]);
        }
    }
    return ir::as_bits(sample(environment.texture(instr.a), instr.b, at));
}

/// Walks the instructions with a program counter: the end of a loop sets it back.
class Evaluator {
  public:
    Evaluator(const ir::Stage& stage, const Environment& environment)
        : stage_(stage),
          environment_(environment),
          ends_(ir::loop_ends(stage)),
          values_(stage.instrs.size(), 0) {}

    std::vector<uint32_t> run() {
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
                return environment_.printf(stage_.printfs[instr.a],
                                           std::span<const uint32_t>(args_).subspan(1));
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
        return ir::picked_element(stage_.instrs[instr.args[0]].type, args_[0], count);
    }

    uint32_t evaluate_query_result(const ir::Instr& instr) const {
        const ir::Instr& query = stage_.instrs[instr.args[0]];
        std::array<uint32_t, 4> args{};
        for (size_t k = 0; k < args.size(); ++k)
            args[k] = values_[query.args[k]];
        return args[0] == 0 ? 0 : environment_.query(query, instr, args);
    }

    uint32_t evaluate_one(const ir::Instr& instr) const {
        switch (instr.op) {
            case ir::Op::kConst:
                return instr.bits;
            case ir::Op::kInput:
                return environment_.input(instr.kind, instr.a, instr.b);
            case ir::Op::kSample:
                return evaluate_sample(instr, args_, environment_);
            case ir::Op::kSampleBound:
                return environment_.sample_bound(instr, args_);
            case ir::Op::kQuery:
                return 0;
            case ir::Op::kQueryResult:
                return evaluate_query_result(instr);
            case ir::Op::kConvert:
                return ir::eval_convert(stage_.instrs[instr.args[0]].type, instr.type, args_[0]);
            case ir::Op::kPick:
                return args_[1 + picked(instr, args_.size() - 1)];
            case ir::Op::kTable: {
                const auto element = static_cast<int32_t>(picked(instr, instr.bits));
                return environment_.input(OPENFAB_ARG_UNIFORM, instr.a + instr.b * element, 0);
            }
            case ir::Op::kSelect:
                return args_[0] != 0 ? args_[1] : args_[2];
                OPENFAB_IR_CASES(FUNCTIONS)
                return functions::evaluate(instr, args_);
            case ir::Op::kBitCast:
                OPENFAB_IR_CASES(DERIVATIVES)
                OPENFAB_IR_CASES(OPERATIONS)
                return ir::eval(instr.op, stage_.instrs[instr.args[0]].type, args_[0],
                                args_.size() > 1 ? args_[1] : 0, 0);
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
    const Environment& environment_;
    const std::vector<ir::ValueId> ends_;
    std::vector<uint32_t> values_;
    std::vector<uint32_t> args_;  ///< of the current instruction
    ir::ValueId at_ = 0;
};

}  // namespace

uint32_t Environment::sample_bound(const ir::Instr& /*instr*/,
                                   std::span<const uint32_t> /*args*/) const {
    return kQuietNan;
}

uint32_t Environment::query(const ir::Instr& /*query*/, const ir::Instr& /*result*/,
                            std::span<const uint32_t> /*args*/) const {
    return 0;
}

void Environment::printf(const ir::Printf& /*call*/, std::span<const uint32_t> /*values*/) const {}

std::vector<uint32_t> evaluate_all(const ir::Stage& stage, const Environment& environment) {
    return Evaluator(stage, environment).run();
}

std::vector<uint32_t> evaluate(const ir::Stage& stage, const Environment& environment) {
    const std::vector<uint32_t> values = evaluate_all(stage, environment);
    std::vector<uint32_t> out;
    out.reserve(stage.outputs.size());
    for (const ir::Output& output : stage.outputs)
        out.push_back(values[output.value]);
    return out;
}

}  // namespace openfab::interp
