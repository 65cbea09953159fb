// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/interp/evaluate.h"

#include "compiler/ir/arithmetic.h"

namespace openfab::interp {

namespace {

constexpr uint32_t kQuietNan = 0x7fc00000u;
constexpr size_t kSampleArgsWithFootprint = 10;

uint32_t evaluate_sample(const ir::Instr& instr, std::span<const uint32_t> args,
                         const Environment& environment) {
    if (args[0] == 0) return 0;
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

uint32_t evaluate_one(const ir::Stage& stage, const ir::Instr& instr,
                      std::span<const uint32_t> args, const Environment& environment) {
    switch (instr.op) {
        case ir::Op::kConst:
            return instr.bits;
        case ir::Op::kInput:
            return environment.input(instr.kind, instr.a, instr.b);
        case ir::Op::kSample:
            return evaluate_sample(instr, args, environment);
        case ir::Op::kSampleBound:
            return environment.sample_bound(instr, args);
        case ir::Op::kConvert:
            return ir::eval_convert(stage.instrs[instr.args[0]].type, instr.type, args[0]);
        case ir::Op::kSelect:
            return args[0] != 0 ? args[1] : args[2];
        default:
            break;
    }
    return ir::eval(instr.op, stage.instrs[instr.args[0]].type, args[0],
                    args.size() > 1 ? args[1] : 0, 0);
}

}  // namespace

uint32_t Environment::sample_bound(const ir::Instr& /*instr*/,
                                   std::span<const uint32_t> /*args*/) const {
    return kQuietNan;
}

std::vector<uint32_t> evaluate_all(const ir::Stage& stage, const Environment& environment) {
    std::vector<uint32_t> values;
    values.reserve(stage.instrs.size());
    std::vector<uint32_t> args;
    for (const ir::Instr& instr : stage.instrs) {
        args.clear();
        for (ir::ValueId arg : instr.args)
            args.push_back(values[arg]);
        values.push_back(evaluate_one(stage, instr, args, environment));
    }
    return values;
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
