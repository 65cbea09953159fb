// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Calls of transcendental functions, noises, hashes, derivatives and of what looks at bits. Names,
// types and defaults: check_functions.cpp. Formulas that are not said here: compiler/functions.

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "compiler/ir/arithmetic.h"
#include "compiler/translate/translate_state.h"

namespace openfab::sema {

using ir::Op;
using ir::ValueId;

namespace {

constexpr uint32_t kQuietNan = 0x7fc00000u;
constexpr uint32_t kSeedStep = 0x9e3779b9u;  // between octaves
constexpr int32_t kMaxOctaves = 16;

std::optional<Op> elementary(Intrinsic id) {
    switch (id) {
        case Intrinsic::kSin:
            return Op::kSin;
        case Intrinsic::kCos:
            return Op::kCos;
        case Intrinsic::kTan:
            return Op::kTan;
        case Intrinsic::kAsin:
            return Op::kAsin;
        case Intrinsic::kAcos:
            return Op::kAcos;
        case Intrinsic::kAtan:
            return Op::kAtan;
        case Intrinsic::kAtan2:
            return Op::kAtan2;
        case Intrinsic::kSinh:
            return Op::kSinh;
        case Intrinsic::kCosh:
            return Op::kCosh;
        case Intrinsic::kTanh:
            return Op::kTanh;
        case Intrinsic::kExp:
            return Op::kExp;
        case Intrinsic::kExp2:
            return Op::kExp2;
        case Intrinsic::kLog:
            return Op::kLog;
        case Intrinsic::kLog2:
            return Op::kLog2;
        case Intrinsic::kLog10:
            return Op::kLog10;
        case Intrinsic::kPow:
            return Op::kPow;
        case Intrinsic::kCbrt:
            return Op::kCbrt;
        default:
            return std::nullopt;
    }
}

}  // namespace

bool StageTranslator::is_function_intrinsic(Intrinsic id) {
    switch (id) {
        case Intrinsic::kLdexp:
        case Intrinsic::kAsFloat:
        case Intrinsic::kAsInt:
        case Intrinsic::kAsUint:
        case Intrinsic::kCountBits:
        case Intrinsic::kReverseBits:
        case Intrinsic::kFirstBitHigh:
        case Intrinsic::kFirstBitLow:
            return true;
        default:
            return elementary(id).has_value() ||
                   (id >= Intrinsic::kSincos && id <= Intrinsic::kHashUint);
    }
}

Value StageTranslator::function_call(const Expr& expr) {
    switch (expr.intrinsic) {
        case Intrinsic::kSincos:
        case Intrinsic::kModf:
        case Intrinsic::kFrexp:
            return several_results(expr);
        default:
            break;
    }
    std::vector<Value> args;
    for (const ExprPtr& arg : expr.args)
        args.push_back(expression(*arg));
    if (gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    switch (expr.intrinsic) {
        case Intrinsic::kRefract:
            return refract(args);
        case Intrinsic::kDdx:
        case Intrinsic::kDdy:
        case Intrinsic::kFwidth:
            return derivatives(expr, args[0]);
        case Intrinsic::kFbm:
        case Intrinsic::kTurbulence:
            return {octaves(expr, args)};
        case Intrinsic::kCurl:
            return curl(args);
        case Intrinsic::kHash:
        case Intrinsic::kHash2:
        case Intrinsic::kHash3:
        case Intrinsic::kHash4:
        case Intrinsic::kHashUint:
            return hash(expr, args);
        default:
            break;
    }
    if (expr.intrinsic >= Intrinsic::kNoise && expr.intrinsic <= Intrinsic::kCellular) {
        return noise(expr, args);
    }
    Value out;
    for (size_t i = 0; i < args[0].size(); ++i) {
        const ValueId second = args.size() > 1 ? args[1][args[1].size() == 1 ? 0 : i] : args[0][i];
        out.push_back(function_of_component(expr.intrinsic, args[0][i], second));
    }
    return out;
}

ValueId StageTranslator::function_of_component(Intrinsic id, ValueId x, ValueId y) {
    if (const std::optional<Op> op = elementary(id)) {
        const bool two = ir::arity(*op) == 2;
        return emit_.function(*op, 0, two ? std::vector<ValueId>{x, y} : std::vector<ValueId>{x});
    }
    const ir::Type type = emit_.type(x);
    const ValueId none = uint_constant(~0u);
    switch (id) {
        case Intrinsic::kLdexp:
            return emit_.binary(Op::kMul, x, emit_.function(Op::kExp2, 0, {y}));
        case Intrinsic::kAsFloat:
            return emit_.bit_cast(x, ir::Type::kFloat);
        case Intrinsic::kAsInt:
            return emit_.convert(float_bits(x), ir::Type::kInt);
        case Intrinsic::kAsUint:
            return emit_.convert(float_bits(x), ir::Type::kUint);
        case Intrinsic::kReverseBits:
            return reverse_bits(emit_.convert(x, ir::Type::kUint));
        case Intrinsic::kCountBits:
            return count_bits(emit_.convert(x, ir::Type::kUint));
        case Intrinsic::kFirstBitLow: {
            const ValueId u = emit_.convert(x, ir::Type::kUint);
            const ValueId lowest = emit_.binary(Op::kBitAnd, u, emit_.unary(Op::kNeg, u));
            const ValueId below = emit_.binary(Op::kSub, lowest, uint_constant(1));
            const ValueId empty = emit_.binary(Op::kEq, u, uint_constant(0));
            return emit_.select(empty, none, count_bits(below));
        }
        default:
            break;
    }
    // kFirstBitHigh: of a negative int the highest 0.
    ValueId u = emit_.convert(x, ir::Type::kUint);
    if (type == ir::Type::kInt) {
        const ValueId sign = emit_.binary(Op::kShr, x, emit_.constant(ir::Type::kInt, 31));
        u = emit_.binary(Op::kBitXor, u, emit_.convert(sign, ir::Type::kUint));
    }
    const ValueId empty = emit_.binary(Op::kEq, u, uint_constant(0));
    for (uint32_t shift = 1; shift < 32; shift *= 2) {
        u = emit_.binary(Op::kBitOr, u, emit_.binary(Op::kShr, u, uint_constant(shift)));
    }
    const ValueId place = emit_.binary(Op::kSub, count_bits(u), uint_constant(1));
    return emit_.select(empty, none, place);
}

ValueId StageTranslator::uint_constant(uint32_t value) {
    return emit_.constant(ir::Type::kUint, value);
}

/// Any NaN has the bits of the plain one: which NaN an operation gives is not said.
ValueId StageTranslator::float_bits(ValueId x) {
    if (emit_.type(x) != ir::Type::kFloat) return x;
    return emit_.select(emit_.unary(Op::kIsNan, x), uint_constant(kQuietNan),
                        emit_.bit_cast(x, ir::Type::kUint));
}

/// x with every second group of `width` bits, those of `mask`, and the others combined.
ValueId StageTranslator::exchange_bits(ValueId x, uint32_t mask, uint32_t width) {
    const ValueId even = emit_.binary(Op::kBitAnd, x, uint_constant(mask));
    const ValueId shifted = emit_.binary(Op::kShr, x, uint_constant(width));
    const ValueId odd = emit_.binary(Op::kBitAnd, shifted, uint_constant(mask));
    return emit_.binary(Op::kBitOr, emit_.binary(Op::kShl, even, uint_constant(width)), odd);
}

ValueId StageTranslator::reverse_bits(ValueId x) {
    x = exchange_bits(x, 0x55555555u, 1);
    x = exchange_bits(x, 0x33333333u, 2);
    x = exchange_bits(x, 0x0f0f0f0fu, 4);
    x = exchange_bits(x, 0x00ff00ffu, 8);
    return exchange_bits(x, 0x0000ffffu, 16);
}

ValueId StageTranslator::count_bits(ValueId x) {
    const auto both = [&](ValueId v, uint32_t mask, uint32_t shift) {
        const ValueId high = emit_.binary(Op::kShr, v, uint_constant(shift));
        return emit_.binary(Op::kAdd, emit_.binary(Op::kBitAnd, v, uint_constant(mask)),
                            emit_.binary(Op::kBitAnd, high, uint_constant(mask)));
    };
    x = both(x, 0x55555555u, 1);
    x = both(x, 0x33333333u, 2);
    x = both(x, 0x0f0f0f0fu, 4);
    const ValueId sum = emit_.binary(Op::kMul, x, uint_constant(0x01010101u));
    return emit_.binary(Op::kShr, sum, uint_constant(24));
}

/// sincos(x, s, c); modf(x, whole) gives the rest; frexp(x, exponent) a mantissa in [0.5, 1).
Value StageTranslator::several_results(const Expr& expr) {
    const Value x = expression(*expr.args[0]);
    std::vector<Target> targets;
    for (size_t i = 1; i < expr.args.size(); ++i)
        targets.push_back(target(*expr.args[i]));
    if (gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    std::array<Value, 2> out;
    for (const ValueId v : x) {
        if (expr.intrinsic == Intrinsic::kSincos) {
            out[0].push_back(emit_.function(Op::kSin, 0, {v}));
            out[1].push_back(emit_.function(Op::kCos, 0, {v}));
        } else if (expr.intrinsic == Intrinsic::kModf) {
            out[0].push_back(emit_.unary(Op::kTrunc, v));
            out[1].push_back(emit_.binary(Op::kSub, v, out[0].back()));
        } else {
            const std::array<ValueId, 2> parts = mantissa_and_exponent(v);
            out[0].push_back(parts[1]);
            out[1].push_back(parts[0]);
        }
    }
    store(targets[0], out[0]);
    if (targets.size() > 1) store(targets[1], out[1]);
    return targets.size() > 1 ? Value{} : out[1];
}

/// Of 0, infinities and NaN the number itself and 0.
std::array<ValueId, 2> StageTranslator::mantissa_and_exponent(ValueId x) {
    const ValueId magnitude = emit_.unary(Op::kAbs, x);
    const ValueId tiny = emit_.binary(Op::kLt, magnitude, emit_.constant(0x1p-126f));
    const ValueId scaled = emit_.binary(Op::kMul, x, emit_.constant(0x1p24f));
    const ValueId bits = emit_.bit_cast(emit_.select(tiny, scaled, x), ir::Type::kUint);
    const ValueId field = emit_.binary(Op::kBitAnd, emit_.binary(Op::kShr, bits, uint_constant(23)),
                                       uint_constant(255));
    const ValueId bias = emit_.select(tiny, uint_constant(126 + 24), uint_constant(126));
    const ValueId exponent = emit_.binary(Op::kSub, field, bias);
    const ValueId kept = emit_.binary(Op::kBitAnd, bits, uint_constant(0x807fffffu));
    const ValueId mantissa = emit_.bit_cast(
        emit_.binary(Op::kBitOr, kept, uint_constant(0x3f000000u)), ir::Type::kFloat);
    const ValueId above = emit_.binary(Op::kGt, magnitude, emit_.constant(0.0f));
    const ValueId below =
        emit_.binary(Op::kLt, magnitude, emit_.constant(std::numeric_limits<float>::infinity()));
    const ValueId plain = emit_.binary(Op::kAnd, above, below);
    const ValueId number = emit_.convert(emit_.convert(exponent, ir::Type::kInt), ir::Type::kFloat);
    return {emit_.select(plain, mantissa, x), emit_.select(plain, number, emit_.constant(0.0f))};
}

/// HLSL's: 0 where all is reflected.
Value StageTranslator::refract(const std::vector<Value>& args) {
    const Value& incident = args[0];
    const Value& normal = args[1];
    const ValueId eta = args[2][0];
    const ValueId zero = emit_.constant(0.0f);
    const ValueId one = emit_.constant(1.0f);
    const auto mul = [&](ValueId a, ValueId b) { return emit_.binary(Op::kMul, a, b); };
    const ValueId cosine = dot(normal, incident);
    const ValueId sine2 = emit_.binary(Op::kSub, one, mul(cosine, cosine));
    const ValueId k = emit_.binary(Op::kSub, one, mul(mul(eta, eta), sine2));
    const ValueId none = emit_.binary(Op::kLt, k, zero);
    const ValueId root = emit_.unary(Op::kSqrt, emit_.binary(Op::kMax, k, zero));
    const ValueId along = emit_.binary(Op::kAdd, mul(eta, cosine), root);
    Value out;
    for (size_t i = 0; i < incident.size(); ++i) {
        const ValueId bent = emit_.binary(Op::kSub, mul(eta, incident[i]), mul(along, normal[i]));
        out.push_back(emit_.select(none, zero, bent));
    }
    return out;
}

Value StageTranslator::derivatives(const Expr& expr, const Value& x) {
    if (alone_) {
        Value unknown;
        for (const ValueId v : x) {
            const auto which = static_cast<int32_t>(expr.intrinsic);
            unknown.push_back(emit_.unknown(ir::Type::kFloat, kChange, which, 0, {v}));
        }
        return unknown;
    }
    if (kind_ != ir::StageKind::kSurface) {
        sink_->report(expr.span, diag::kStageMismatch, "ddx", "called in a volume stage")
            .note(fablet_.volume.span, "stage declared `@Volume` here, which calls this function");
        return zero(expr.type);
    }
    Value out;
    for (const ValueId v : x) {
        const ValueId along_x = emit_.function(Op::kDerivative, 0, {v});
        const ValueId along_y = emit_.function(Op::kDerivative, 1, {v});
        if (expr.intrinsic == Intrinsic::kFwidth) {
            out.push_back(emit_.binary(Op::kAdd, emit_.unary(Op::kAbs, along_x),
                                       emit_.unary(Op::kAbs, along_y)));
        } else {
            out.push_back(expr.intrinsic == Intrinsic::kDdx ? along_x : along_y);
        }
    }
    return out;
}

ValueId StageTranslator::noise_value(Op op, int32_t which, const Value& p, ValueId seed) {
    std::vector<ValueId> args(p.begin(), p.end());
    args.push_back(seed);
    return emit_.function(op, which, std::move(args));
}

Value StageTranslator::noise(const Expr& expr, const std::vector<Value>& args) {
    const bool simplex =
        expr.intrinsic == Intrinsic::kSimplex || expr.intrinsic == Intrinsic::kSimplexGradient;
    const bool periodic =
        expr.intrinsic == Intrinsic::kPnoise || expr.intrinsic == Intrinsic::kPnoiseGradient;
    const bool cellular = expr.intrinsic == Intrinsic::kCellular;
    const bool gradient = expr.intrinsic == Intrinsic::kNoiseGradient ||
                          expr.intrinsic == Intrinsic::kPnoiseGradient ||
                          expr.intrinsic == Intrinsic::kSimplexGradient;
    Value list = args[0];
    if (periodic) list.insert(list.end(), args[1].begin(), args[1].end());
    const Op op = simplex ? Op::kSimplex : cellular ? Op::kCellular : Op::kNoise;
    Value out;
    const auto count = static_cast<int32_t>(expr.type.size);
    for (int32_t k = 0; k < count; ++k) {
        const int32_t which = (gradient ? k + 1 : k) + (periodic ? ir::kPeriodic : 0);
        out.push_back(noise_value(op, which, list, args.back()[0]));
    }
    return out;
}

/// Sum over octaves k of gain^k noise(lacunarity^k p, a seed of its own); of turbulence of the
/// noise's magnitude. Octaves beyond what is asked for add nothing.
ValueId StageTranslator::octaves(const Expr& expr, const std::vector<Value>& args) {
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
        if (expr.intrinsic == Intrinsic::kTurbulence) value = emit_.unary(Op::kAbs, value);
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

/// Of 2 axes the gradient turned by a right angle; of 3 the curl of three noises. Without
/// divergence.
Value StageTranslator::curl(const std::vector<Value>& args) {
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

/// Floats in [0, 1): the upper 24 bits. 0 and -0 are one argument, so are all NaNs.
Value StageTranslator::hash(const Expr& expr, const std::vector<Value>& args) {
    std::vector<ValueId> words;
    for (ValueId x : args[0]) {
        if (emit_.type(x) == ir::Type::kFloat) x = emit_.binary(Op::kAdd, x, emit_.constant(0.0f));
        words.push_back(emit_.convert(float_bits(x), ir::Type::kUint));
    }
    words.push_back(args[1][0]);
    if (expr.intrinsic == Intrinsic::kHashUint) return {emit_.function(Op::kHash, 0, words)};
    Value out;
    for (int32_t k = 0; k < expr.type.size; ++k) {
        const ValueId bits =
            emit_.binary(Op::kShr, emit_.function(Op::kHash, k, words), uint_constant(8));
        const ValueId number = emit_.convert(emit_.convert(bits, ir::Type::kInt), ir::Type::kFloat);
        out.push_back(emit_.binary(Op::kMul, number, emit_.constant(0x1p-24f)));
    }
    return out;
}

}  // namespace openfab::sema
