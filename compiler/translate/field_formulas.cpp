// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Noises and hashes of points.
#include <algorithm>
#include <array>
#include <utility>

#include "compiler/ir/arithmetic.h"
#include "compiler/translate/formulas.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

constexpr uint32_t kSeedStep = 0x9e3779b9u;  // between octaves
constexpr int32_t kMaxOctaves = 16;

}  // namespace

Value Formulas::field(check::Intrinsic id, int32_t size, const std::vector<Value>& args) {
    switch (id) {
        case check::Intrinsic::kFbm:
        case check::Intrinsic::kTurbulence:
            return {octaves(id, args)};
        case check::Intrinsic::kCurl:
            return curl(args);
        case check::Intrinsic::kHash:
        case check::Intrinsic::kHash2:
        case check::Intrinsic::kHash3:
        case check::Intrinsic::kHash4:
        case check::Intrinsic::kHashUint:
            return hash(id, size, args);
        case check::Intrinsic::kNoise:
        case check::Intrinsic::kNoiseGradient:
        case check::Intrinsic::kPnoise:
        case check::Intrinsic::kPnoiseGradient:
        case check::Intrinsic::kSimplex:
        case check::Intrinsic::kSimplexGradient:
        case check::Intrinsic::kCellular:
            OPENFAB_INTRINSIC_CASES(COMPONENT)
            OPENFAB_INTRINSIC_CASES(GEOMETRIC)
            OPENFAB_INTRINSIC_CASES(CHOICE)
            OPENFAB_INTRINSIC_CASES(ELEMENTARY)
            OPENFAB_INTRINSIC_CASES(BITWISE)
            OPENFAB_INTRINSIC_CASES(SEVERAL)
            OPENFAB_INTRINSIC_CASES(BENDING)
            OPENFAB_INTRINSIC_CASES(DERIVATIVE)
            break;
    }
    return noise(id, size, args);
}

ValueId Formulas::noise_value(Op op, int32_t which, const Value& p, ValueId seed) {
    std::vector<ValueId> args(p.begin(), p.end());
    args.push_back(seed);
    return emit_.function(op, which, std::move(args));
}

Value Formulas::noise(check::Intrinsic id, int32_t size, const std::vector<Value>& args) {
    const bool simplex =
        id == check::Intrinsic::kSimplex || id == check::Intrinsic::kSimplexGradient;
    const bool periodic =
        id == check::Intrinsic::kPnoise || id == check::Intrinsic::kPnoiseGradient;
    const bool cellular = id == check::Intrinsic::kCellular;
    const bool gradient = id == check::Intrinsic::kNoiseGradient ||
                          id == check::Intrinsic::kPnoiseGradient ||
                          id == check::Intrinsic::kSimplexGradient;
    Value list = args[0];
    if (periodic) list.insert(list.end(), args[1].begin(), args[1].end());
    const Op op = simplex ? Op::kSimplex : cellular ? Op::kCellular : Op::kNoise;
    Value out;
    for (int32_t k = 0; k < size; ++k) {
        const int32_t which = (gradient ? k + 1 : k) + (periodic ? ir::kPeriodic : 0);
        out.push_back(noise_value(op, which, list, args.back()[0]));
    }
    return out;
}

/// The sum over octaves k of gain^k noise(lacunarity^k p, seed k); turbulence sums the magnitude of
/// the noise. Octaves beyond the requested number add nothing.
ValueId Formulas::octaves(check::Intrinsic id, const std::vector<Value>& args) {
    const ValueId count = args[1][0];
    const bool known = emit_.is_constant(count);
    int32_t most = kMaxOctaves;
    if (known) most = std::min(ir::as_int(emit_.instr(count).bits), kMaxOctaves);
    Value p = args[0];
    ValueId seed = args[4][0];
    ValueId weight = emit_.constant(1.0f);
    ValueId sum = emit_.constant(0.0f);
    for (int32_t k = 0; k < most; ++k) {
        ValueId value = noise_value(Op::kNoise, 0, p, seed);
        if (id == check::Intrinsic::kTurbulence) value = emit_.unary(Op::kAbs, value);
        const ValueId more = emit_.binary(Op::kAdd, sum, emit_.binary(Op::kMul, value, weight));
        const ValueId number = emit_.constant(ir::Type::kInt, static_cast<uint32_t>(k));
        sum = known ? more : emit_.select(emit_.binary(Op::kGt, count, number), more, sum);
        weight = emit_.binary(Op::kMul, weight, args[3][0]);
        for (ValueId& x : p)
            x = emit_.binary(Op::kMul, x, args[2][0]);
        seed = emit_.binary(Op::kAdd, seed, uint_constant(kSeedStep));
    }
    return sum;
}

/// For 2 axes the gradient rotated by 90 degrees; for 3 the curl of three noises. Divergence-free.
Value Formulas::curl(const std::vector<Value>& args) {
    const Value& p = args[0];
    const ValueId seed = args[1][0];
    if (p.size() == 2) {
        const ValueId dx = noise_value(Op::kNoise, 1, p, seed);
        return {noise_value(Op::kNoise, 2, p, seed), emit_.unary(Op::kNeg, dx)};
    }
    Value out;
    std::array<ValueId, 3> seeds{};
    for (uint32_t k = 0; k < 3; ++k)
        seeds[k] = emit_.binary(Op::kAdd, seed, uint_constant(kSeedStep * k));
    for (size_t axis = 0; axis < 3; ++axis) {
        const size_t j = (axis + 1) % 3;
        const size_t k = (axis + 2) % 3;
        out.push_back(emit_.binary(
            Op::kSub, noise_value(Op::kNoise, static_cast<int32_t>(j) + 1, p, seeds[k]),
            noise_value(Op::kNoise, static_cast<int32_t>(k) + 1, p, seeds[j])));
    }
    return out;
}

/// Floats in [0, 1): the upper 24 bits. 0 and -0 are the same argument, and so are all NaNs.
Value Formulas::hash(check::Intrinsic id, int32_t size, const std::vector<Value>& args) {
    std::vector<ValueId> words;
    for (ValueId x : args[0]) {
        if (emit_.type(x) == ir::Type::kFloat) x = emit_.binary(Op::kAdd, x, emit_.constant(0.0f));
        words.push_back(emit_.convert(float_bits(x), ir::Type::kUint));
    }
    words.push_back(args[1][0]);
    if (id == check::Intrinsic::kHashUint) return {emit_.function(Op::kHash, 0, words)};
    Value out;
    for (int32_t k = 0; k < size; ++k) {
        const ValueId bits =
            emit_.binary(Op::kShr, emit_.function(Op::kHash, k, words), uint_constant(8));
        const ValueId number = emit_.convert(emit_.convert(bits, ir::Type::kInt), ir::Type::kFloat);
        out.push_back(emit_.binary(Op::kMul, number, emit_.constant(0x1p-24f)));
    }
    return out;
}

}  // namespace openfab::translate
