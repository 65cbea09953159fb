// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/formulas.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/infinity.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

constexpr float kPi = 3.14159265f;
constexpr float kRadiansPerDegree = 0.0174532925f;
constexpr float kDegreesPerRadian = 180.0f / kPi;
constexpr uint32_t kQuietNan = 0x7fc00000u;

/// Returns the IR function of an intrinsic.
std::optional<Op> operation(check::Intrinsic id) {
    switch (id) {
#define OPENFAB_IR_FUNCTION(name, ...) \
    case check::Intrinsic::k##name:    \
        return Op::k##name;
        OPENFAB_ELEMENTARY_INTRINSICS(OPENFAB_IR_FUNCTION)
#undef OPENFAB_IR_FUNCTION
        OPENFAB_INTRINSIC_CASES(COMPONENT)
        OPENFAB_INTRINSIC_CASES(GEOMETRIC)
        OPENFAB_INTRINSIC_CASES(CHOICE)
        OPENFAB_INTRINSIC_CASES(BITWISE)
        OPENFAB_INTRINSIC_CASES(SEVERAL)
        OPENFAB_INTRINSIC_CASES(BENDING)
        OPENFAB_INTRINSIC_CASES(DERIVATIVE)
        OPENFAB_INTRINSIC_CASES(FIELD)
        break;
    }
    return std::nullopt;
}

/// Returns an n by n matrix without row `r` and column `c`.
Value minor_of(const Value& m, size_t n, size_t r, size_t c) {
    Value out;
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; j < n; ++j) {
            if (i != r && j != c) out.push_back(m[i * n + j]);
        }
    }
    return out;
}

}  // namespace

/// Component-wise; a scalar `b` is broadcast.
Value Formulas::binary(Op op, const Value& a, const Value& b) {
    Value out;
    for (size_t i = 0; i < a.size(); ++i) {
        const ValueId right = b[b.size() == 1 ? 0 : i];
        out.push_back(emit_.binary(op, a[i], right));
    }
    return out;
}

ValueId Formulas::clamp(ValueId x, ValueId lo, ValueId hi) {
    return emit_.binary(Op::kMin, emit_.binary(Op::kMax, x, lo), hi);
}

ValueId Formulas::dot(const Value& a, const Value& b) {
    ValueId sum = emit_.binary(Op::kMul, a[0], b[0]);
    for (size_t i = 1; i < a.size(); ++i) {
        sum = emit_.binary(Op::kAdd, sum, emit_.binary(Op::kMul, a[i], b[i]));
    }
    return sum;
}

ValueId Formulas::sum(const Value& amounts) {
    if (amounts.empty()) return emit_.constant(0.0f);
    ValueId out = amounts[0];
    for (size_t i = 1; i < amounts.size(); ++i)
        out = emit_.binary(Op::kAdd, out, amounts[i]);
    return out;
}

bool Formulas::is_geometric(check::Intrinsic id) {
    return check::family(id) == check::Family::kGeometric;
}

bool Formulas::is_elementary(check::Intrinsic id) {
    const check::Family of = check::family(id);
    return of == check::Family::kElementary || of == check::Family::kBitwise;
}

ValueId Formulas::component(check::Intrinsic id, const std::vector<ValueId>& x) {
    const auto bin = [&](Op op, ValueId a, ValueId b) { return emit_.binary(op, a, b); };
    const ir::Type type = emit_.type(x[0]);
    const ValueId zero = emit_.constant(type, 0);
    const ValueId one = emit_.convert(emit_.constant(ir::Type::kInt, 1), type);
    switch (id) {
        case check::Intrinsic::kAbs:
            return emit_.unary(Op::kAbs, x[0]);
        case check::Intrinsic::kSign: {
            const ValueId above = emit_.convert(bin(Op::kGt, x[0], zero), ir::Type::kInt);
            const ValueId below = emit_.convert(bin(Op::kLt, x[0], zero), ir::Type::kInt);
            return bin(Op::kSub, above, below);
        }
        case check::Intrinsic::kMin:
            return bin(Op::kMin, x[0], x[1]);
        case check::Intrinsic::kMax:
            return bin(Op::kMax, x[0], x[1]);
        case check::Intrinsic::kClamp:
            return clamp(x[0], x[1], x[2]);
        case check::Intrinsic::kMad:
            return bin(Op::kAdd, bin(Op::kMul, x[0], x[1]), x[2]);
        case check::Intrinsic::kSaturate:
            return clamp(x[0], zero, one);
        case check::Intrinsic::kFloor:
            return emit_.unary(Op::kFloor, x[0]);
        case check::Intrinsic::kCeil:
            return emit_.unary(Op::kCeil, x[0]);
        case check::Intrinsic::kRound:
            return emit_.unary(Op::kRound, x[0]);
        case check::Intrinsic::kTrunc:
            return emit_.unary(Op::kTrunc, x[0]);
        case check::Intrinsic::kFrac:
            return bin(Op::kSub, x[0], emit_.unary(Op::kFloor, x[0]));
        case check::Intrinsic::kFmod:
            return bin(Op::kMod, x[0], x[1]);
        case check::Intrinsic::kSqrt:
            return emit_.unary(Op::kSqrt, x[0]);
        case check::Intrinsic::kRsqrt:
            return bin(Op::kDiv, one, emit_.unary(Op::kSqrt, x[0]));
        case check::Intrinsic::kRcp:
            return bin(Op::kDiv, one, x[0]);
        case check::Intrinsic::kStep:
            return emit_.select(bin(Op::kGe, x[1], x[0]), one, zero);
        case check::Intrinsic::kSmoothstep: {
            const ValueId ratio =
                bin(Op::kDiv, bin(Op::kSub, x[2], x[0]), bin(Op::kSub, x[1], x[0]));
            const ValueId t = clamp(ratio, zero, one);
            const ValueId ramp =
                bin(Op::kSub, emit_.constant(3.0f), bin(Op::kMul, emit_.constant(2.0f), t));
            return bin(Op::kMul, bin(Op::kMul, t, t), ramp);
        }
        case check::Intrinsic::kLerp:
            return bin(Op::kAdd, x[0], bin(Op::kMul, x[2], bin(Op::kSub, x[1], x[0])));
        case check::Intrinsic::kSelect:
            return emit_.select(x[0], x[1], x[2]);
        case check::Intrinsic::kAnd:
            return emit_.logical_and(x[0], x[1]);
        case check::Intrinsic::kOr:
            return emit_.logical_or(x[0], x[1]);
        case check::Intrinsic::kRadians:
            return bin(Op::kMul, x[0], emit_.constant(kRadiansPerDegree));
        case check::Intrinsic::kDegrees:
            return bin(Op::kMul, x[0], emit_.constant(kDegreesPerRadian));
        case check::Intrinsic::kIsNan:
            return emit_.unary(Op::kIsNan, x[0]);
        case check::Intrinsic::kIsInf:
        case check::Intrinsic::kIsFinite: {
            const ValueId inf = emit_.constant(kInfinity);
            const Op op = id == check::Intrinsic::kIsInf ? Op::kEq : Op::kLt;
            return bin(op, emit_.unary(Op::kAbs, x[0]), inf);
        }
            OPENFAB_INTRINSIC_CASES(GEOMETRIC)
            OPENFAB_INTRINSIC_CASES(ELEMENTARY)
            OPENFAB_INTRINSIC_CASES(BITWISE)
            OPENFAB_INTRINSIC_CASES(SEVERAL)
            OPENFAB_INTRINSIC_CASES(BENDING)
            OPENFAB_INTRINSIC_CASES(DERIVATIVE)
            OPENFAB_INTRINSIC_CASES(FIELD)
            break;
    }
    return x[0];
}

Value Formulas::geometric(check::Intrinsic id, const std::vector<Value>& args) {
    const Value& a = args[0];
    const Value& b = args.size() > 1 ? args[1] : args[0];
    switch (id) {
        case check::Intrinsic::kAny:
        case check::Intrinsic::kAll: {
            ValueId out = emit_.convert(a[0], ir::Type::kBool);
            for (size_t i = 1; i < a.size(); ++i) {
                const ValueId next = emit_.convert(a[i], ir::Type::kBool);
                out = id == check::Intrinsic::kAny ? emit_.logical_or(out, next)
                                                   : emit_.logical_and(out, next);
            }
            return {out};
        }
        case check::Intrinsic::kDot:
            return {dot(a, b)};
        case check::Intrinsic::kLength:
            return {emit_.unary(Op::kSqrt, dot(a, a))};
        case check::Intrinsic::kDistance: {
            const Value d = binary(Op::kSub, a, b);
            return {emit_.unary(Op::kSqrt, dot(d, d))};
        }
        case check::Intrinsic::kNormalize:
            return binary(Op::kDiv, a, {emit_.unary(Op::kSqrt, dot(a, a))});
        case check::Intrinsic::kReflect: {
            const ValueId twice = emit_.binary(Op::kMul, emit_.constant(2.0f), dot(a, b));
            return binary(Op::kSub, a, binary(Op::kMul, b, {twice}));
        }
        case check::Intrinsic::kFaceforward: {
            const ValueId away = emit_.binary(Op::kLt, dot(args[1], args[2]), emit_.constant(0.0f));
            Value out;
            for (ValueId n : a)
                out.push_back(emit_.select(away, n, emit_.unary(Op::kNeg, n)));
            return out;
        }
        case check::Intrinsic::kCross: {
            Value out;
            for (size_t i = 0; i < 3; ++i) {
                const size_t j = (i + 1) % 3;
                const size_t k = (i + 2) % 3;
                out.push_back(emit_.binary(Op::kSub, emit_.binary(Op::kMul, a[j], b[k]),
                                           emit_.binary(Op::kMul, a[k], b[j])));
            }
            return out;
        }
        case check::Intrinsic::kRefract:
            return refract(args);
            OPENFAB_INTRINSIC_CASES(COMPONENT)
            OPENFAB_INTRINSIC_CASES(CHOICE)
            OPENFAB_INTRINSIC_CASES(ELEMENTARY)
            OPENFAB_INTRINSIC_CASES(BITWISE)
            OPENFAB_INTRINSIC_CASES(SEVERAL)
            OPENFAB_INTRINSIC_CASES(DERIVATIVE)
            OPENFAB_INTRINSIC_CASES(FIELD)
            break;
    }
    return a;
}

/// As in HLSL: 0 on total internal reflection.
Value Formulas::refract(const std::vector<Value>& args) {
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

ValueId Formulas::elementary(check::Intrinsic id, ValueId x, ValueId y) {
    if (const std::optional<Op> op = operation(id)) {
        const bool two = ir::arity(*op) == 2;
        return emit_.function(*op, 0, two ? std::vector<ValueId>{x, y} : std::vector<ValueId>{x});
    }
    const ir::Type type = emit_.type(x);
    const ValueId none = uint_constant(~0u);
    switch (id) {
        case check::Intrinsic::kLdexp:
            return emit_.binary(Op::kMul, x, emit_.function(Op::kExp2, 0, {y}));
        case check::Intrinsic::kAsFloat:
            return emit_.bit_cast(x, ir::Type::kFloat);
        case check::Intrinsic::kAsInt:
            return emit_.convert(float_bits(x), ir::Type::kInt);
        case check::Intrinsic::kAsUint:
            return emit_.convert(float_bits(x), ir::Type::kUint);
        case check::Intrinsic::kReverseBits:
            return reverse_bits(emit_.convert(x, ir::Type::kUint));
        case check::Intrinsic::kCountBits:
            return count_bits(emit_.convert(x, ir::Type::kUint));
        case check::Intrinsic::kFirstBitLow: {
            const ValueId u = emit_.convert(x, ir::Type::kUint);
            const ValueId lowest = emit_.binary(Op::kBitAnd, u, emit_.unary(Op::kNeg, u));
            const ValueId below = emit_.binary(Op::kSub, lowest, uint_constant(1));
            const ValueId empty = emit_.binary(Op::kEq, u, uint_constant(0));
            return emit_.select(empty, none, count_bits(below));
        }
        case check::Intrinsic::kFirstBitHigh:
            OPENFAB_INTRINSIC_CASES(COMPONENT)
            OPENFAB_INTRINSIC_CASES(GEOMETRIC)
            OPENFAB_INTRINSIC_CASES(CHOICE)
            OPENFAB_INTRINSIC_CASES(ELEMENTARY)
            OPENFAB_INTRINSIC_CASES(SEVERAL)
            OPENFAB_INTRINSIC_CASES(BENDING)
            OPENFAB_INTRINSIC_CASES(DERIVATIVE)
            OPENFAB_INTRINSIC_CASES(FIELD)
            break;
    }
    // kFirstBitHigh: for a negative int the highest 0 bit.
    ValueId u = emit_.convert(x, ir::Type::kUint);
    if (type == ir::Type::kInt) {
        const ValueId sign = emit_.binary(Op::kShr, x, emit_.constant(ir::Type::kInt, 31));
        u = emit_.binary(Op::kBitXor, u, emit_.convert(sign, ir::Type::kUint));
    }
    const ValueId empty = emit_.binary(Op::kEq, u, uint_constant(0));
    for (uint32_t shift = 1; shift < 32; shift *= 2) {
        u = emit_.binary(Op::kBitOr, u, emit_.binary(Op::kShr, u, uint_constant(shift)));
    }
    const ValueId highest = emit_.binary(Op::kSub, count_bits(u), uint_constant(1));
    return emit_.select(empty, none, highest);
}

ValueId Formulas::uint_constant(uint32_t value) {
    return emit_.constant(ir::Type::kUint, value);
}

/// All NaNs map to the canonical one: which NaN an operation gives is unspecified.
ValueId Formulas::float_bits(ValueId x) {
    if (emit_.type(x) != ir::Type::kFloat) return x;
    return emit_.select(emit_.unary(Op::kIsNan, x), uint_constant(kQuietNan),
                        emit_.bit_cast(x, ir::Type::kUint));
}

/// x with every second group of `width` bits, those of `mask`, and the others combined.
ValueId Formulas::exchange_bits(ValueId x, uint32_t mask, uint32_t width) {
    const ValueId even = emit_.binary(Op::kBitAnd, x, uint_constant(mask));
    const ValueId shifted = emit_.binary(Op::kShr, x, uint_constant(width));
    const ValueId odd = emit_.binary(Op::kBitAnd, shifted, uint_constant(mask));
    return emit_.binary(Op::kBitOr, emit_.binary(Op::kShl, even, uint_constant(width)), odd);
}

ValueId Formulas::reverse_bits(ValueId x) {
    x = exchange_bits(x, 0x55555555u, 1);
    x = exchange_bits(x, 0x33333333u, 2);
    x = exchange_bits(x, 0x0f0f0f0fu, 4);
    x = exchange_bits(x, 0x00ff00ffu, 8);
    return exchange_bits(x, 0x0000ffffu, 16);
}

ValueId Formulas::count_bits(ValueId x) {
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

/// 0, infinities and NaN give the number itself and 0.
std::array<ValueId, 2> Formulas::mantissa_and_exponent(ValueId x) {
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
    const ValueId below = emit_.binary(Op::kLt, magnitude, emit_.constant(kInfinity));
    const ValueId plain = emit_.binary(Op::kAnd, above, below);
    const ValueId number = emit_.convert(emit_.convert(exponent, ir::Type::kInt), ir::Type::kFloat);
    return {emit_.select(plain, mantissa, x), emit_.select(plain, number, emit_.constant(0.0f))};
}

// Matrices are row-major. Sums run from the first term to the last, each product rounded.

/// Row-major; sums of `inner` terms.
Value Formulas::product(const Value& a, const Value& b, size_t inner) {
    const size_t rows = a.size() / inner;
    const size_t columns = b.size() / inner;
    Value out;
    for (size_t i = 0; i < rows; ++i) {
        for (size_t j = 0; j < columns; ++j) {
            Value row;
            Value column;
            for (size_t k = 0; k < inner; ++k) {
                row.push_back(a[i * inner + k]);
                column.push_back(b[k * columns + j]);
            }
            out.push_back(dot(row, column));
        }
    }
    return out;
}

/// Expands along the first row: m00 * |minor| - m01 * |minor| + …
ValueId Formulas::determinant(const Value& m, size_t n) {
    if (n == 1) return m[0];
    ValueId sum = 0;
    for (size_t c = 0; c < n; ++c) {
        const ValueId term = emit_.binary(Op::kMul, m[c], determinant(minor_of(m, n, 0, c), n - 1));
        sum = c == 0 ? term : emit_.binary(c % 2 == 0 ? Op::kAdd : Op::kSub, sum, term);
    }
    return sum;
}

/// The transposed cofactors, each divided by the determinant; not finite for a singular matrix.
Value Formulas::inverse(const Value& m, size_t n) {
    const ValueId whole = determinant(m, n);
    Value out;
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; j < n; ++j) {
            ValueId cofactor = determinant(minor_of(m, n, j, i), n - 1);
            if ((i + j) % 2 != 0) cofactor = emit_.unary(Op::kNeg, cofactor);
            out.push_back(emit_.binary(Op::kDiv, cofactor, whole));
        }
    }
    return out;
}

}  // namespace openfab::translate
