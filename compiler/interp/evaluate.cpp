// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/interp/evaluate.h"

#include <array>

#include "compiler/functions/functions.h"
#include "compiler/interp/evaluator.h"
#include "compiler/interp/sample_volume.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::interp {

namespace {

constexpr uint32_t kQuietNan = 0x7fc00000u;
constexpr size_t kSampleArgsWithFootprint = 10;
constexpr size_t kVolumeSampleArgs = 5;
constexpr size_t kVolumeSampleArgsWithFootprint = 14;

uint32_t evaluate_volume_sample(const TextureView& texture, int32_t channel,
                                std::span<const uint32_t> args) {
    VolumeSampleArgs at;
    for (size_t k = 0; k < 3; ++k)
        at.p[k] = ir::as_float(args[1 + k]);
    at.width = ir::as_float(args[4]);
    for (size_t k = 0; k < 9 && args.size() == kVolumeSampleArgsWithFootprint; ++k)
        at.dp[k / 3][k % 3] = ir::as_float(args[5 + k]);
    return ir::as_bits(sample_volume(texture, channel, at));
}

/// Computes on the bits that kernels have.
class BitMachine {
  public:
    using Word = uint32_t;
    explicit BitMachine(const Environment& environment) : environment_(environment) {}

    Word constant(const ir::Instr& instr) const { return instr.bits; }
    Word input(ir::Type /*type*/, int32_t kind, int32_t a, int32_t b) const {
        return environment_.input(kind, a, b);
    }
    Word sample(const ir::Instr& instr, std::span<const Word> args) const {
        return args[0] == 0 ? 0 : evaluate_sample(environment_.texture(instr.a), instr.b, args);
    }
    Word sample_bound(const ir::Instr& instr, std::span<const Word> args) const {
        return environment_.sample_bound(instr, args);
    }
    Word query(const ir::Instr& query, const ir::Instr& result, std::span<const Word> args) const {
        return environment_.query(query, result, args);
    }
    void printf(const ir::Printf& call, std::span<const Word> values) const {
        environment_.printf(call, values);
    }
    Word function(const ir::Instr& instr, std::span<const Word> args) const {
        return functions::evaluate(instr, args);
    }
    Word convert(ir::Type from, ir::Type to, Word x) const { return ir::eval_convert(from, to, x); }
    Word operation(const ir::Instr& instr, ir::Type type, Word a, Word b) const {
        return ir::eval(instr.op, type, a, b, 0);
    }

  private:
    const Environment& environment_;
};

}  // namespace

uint32_t evaluate_sample(const TextureView& texture, int32_t channel,
                         std::span<const uint32_t> args) {
    if (args.size() == kVolumeSampleArgs || args.size() == kVolumeSampleArgsWithFootprint)
        return evaluate_volume_sample(texture, channel, args);
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
    return ir::as_bits(sample(texture, channel, at));
}

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
    return Evaluator(stage, BitMachine(environment)).run();
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
