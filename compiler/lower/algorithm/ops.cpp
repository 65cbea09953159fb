// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/ops.h"

#include <bit>
#include <cmath>
#include <limits>

#include "compiler/lower/algorithm/exact_exprs.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using ir::Op;
using ir::Type;

constexpr float kTwo31 = 2147483648.0f;
constexpr float kTwo32 = 4294967296.0f;

Expr trunc_float(const Expr& e) {
    return Halide::trunc(e);
}

Expr float_op(Op op, const Expr& a, const Expr& b) {
    switch (op) {
        case Op::kAdd:
            return a + b;
        case Op::kSub:
            return a - b;
        case Op::kMul:
            return a * b;
        case Op::kDiv:
            return divide(a, b);
        case Op::kMod:
            return a - b * trunc_float(divide(a, b));
        case Op::kNeg:
            return as_float(as_uint(a) ^ u32(kSign));
        case Op::kAbs:
            return as_float(as_uint(a) & u32(kMagnitude));
        case Op::kMin:
            return choose(greater(b, a), a, b);
        case Op::kMax:
            return choose(greater(a, b), a, b);
        case Op::kSqrt:
            return square_root(a);
        case Op::kFloor:
            return Halide::floor(a);
        case Op::kCeil:
            return Halide::ceil(a);
        case Op::kRound:
            return Halide::round(a);
        case Op::kTrunc:
            return trunc_float(a);
        case Op::kIsNan:
            return nan_bit(a);
        case Op::kEq:
            return float_equality(a, b);
        case Op::kNe:
            return invert(float_equality(a, b));
        case Op::kLt:
            return greater(b, a);
        case Op::kGt:
            return greater(a, b);
        case Op::kLe:
            return both(invert(greater(a, b)), ordered(a, b));
        case Op::kGe:
            return both(invert(greater(b, a)), ordered(a, b));
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return Expr();
}

Expr uint_div(const Expr& a, const Expr& b) {
    const Expr zero = b == u32(0);
    return choose(zero, u32(0), a / choose(zero, u32(1), b));
}

/// |e| of an int as uint; correct for INT_MIN, too.
Expr int_magnitude(const Expr& e) {
    return choose(i32(0) > e, u32(0) - as_uint(e), as_uint(e));
}

Expr int_div(const Expr& a, const Expr& b) {
    const Expr q = uint_div(int_magnitude(a), int_magnitude(b));
    const Expr negative = i32(0) > as_int(as_uint(a) ^ as_uint(b));
    return as_int(choose(negative, u32(0) - q, q));
}

/// Halide simplifies a == b through a - b, and reports signed overflow there as an error.
Expr equal_ints(const Expr& a, const Expr& b) {
    return as_uint(a) == as_uint(b);
}

Expr int_mod(const Expr& a, const Expr& b) {
    const Expr rest = as_uint(a) - as_uint(int_div(a, b)) * as_uint(b);
    return choose(equal_ints(b, i32(0)), i32(0), as_int(rest));
}

/// Operations that are defined on bits alone, on uint Exprs.
Expr bits_op(Op op, const Expr& a, const Expr& b) {
    switch (op) {
        case Op::kAdd:
            return a + b;
        case Op::kSub:
            return a - b;
        case Op::kMul:
            return a * b;
        case Op::kNeg:
            return u32(0) - a;
        case Op::kBitAnd:
            return a & b;
        case Op::kBitOr:
            return a | b;
        case Op::kBitXor:
            return a ^ b;
        case Op::kBitNot:
            return a ^ u32(0xffffffffu);
        case Op::kShl:
            return a << (b & u32(31));
        case Op::kDiv:
        case Op::kMod:
        case Op::kShr:
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(COMPARISONS)
            OPENFAB_IR_CASES(EXTREMES)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return Expr();
}

/// Comparisons of ints, uints; they are exact in Halide.
Expr compare_op(Op op, const Expr& a, const Expr& b) {
    switch (op) {
        case Op::kEq:
            return a == b;
        case Op::kNe:
            return invert(a == b);
        case Op::kLt:
            return b > a;
        case Op::kGt:
            return a > b;
        case Op::kLe:
            return invert(a > b);
        case Op::kGe:
            return invert(b > a);
        case Op::kMin:
            return choose(b > a, a, b);
        case Op::kMax:
            return choose(a > b, a, b);
        case Op::kAbs:
            OPENFAB_IR_CASES(ARITHMETIC)
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return Expr();
}

Expr int_op(Op op, const Expr& a, const Expr& b) {
    switch (op) {
        case Op::kAdd:
        case Op::kSub:
        case Op::kMul:
        case Op::kNeg:
        case Op::kBitAnd:
        case Op::kBitOr:
        case Op::kBitXor:
        case Op::kBitNot:
        case Op::kShl:
            return as_int(bits_op(op, as_uint(a), b.defined() ? as_uint(b) : Expr()));
        case Op::kDiv:
            return int_div(a, b);
        case Op::kMod:
            return int_mod(a, b);
        case Op::kAbs:
            return as_int(int_magnitude(a));
        case Op::kShr:
            return a >> as_int(as_uint(b) & u32(31));
        case Op::kEq:
            return equal_ints(a, b);
        case Op::kNe:
            return invert(equal_ints(a, b));
        case Op::kMin:
        case Op::kMax:
            OPENFAB_IR_CASES(ORDERS)
            return compare_op(op, a, b);
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return Expr();
}

Expr uint_op(Op op, const Expr& a, const Expr& b) {
    switch (op) {
        case Op::kAdd:
        case Op::kSub:
        case Op::kMul:
        case Op::kNeg:
        case Op::kBitAnd:
        case Op::kBitOr:
        case Op::kBitXor:
        case Op::kBitNot:
        case Op::kShl:
            return bits_op(op, a, b);
        case Op::kDiv:
            return uint_div(a, b);
        case Op::kMod:
            return choose(b == u32(0), u32(0), a - uint_div(a, b) * b);
        case Op::kAbs:
            return a;
        case Op::kShr:
            return a >> (b & u32(31));
        case Op::kMin:
        case Op::kMax:
            OPENFAB_IR_CASES(COMPARISONS)
            return compare_op(op, a, b);
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return Expr();
}

Expr bool_op(Op op, const Expr& a, const Expr& b) {
    switch (op) {
        case Op::kAnd:
            return both(a, b);
        case Op::kOr:
            return either(a, b);
        case Op::kNot:
            return invert(a);
        case Op::kEq:
            return invert(a ^ b);
        case Op::kNe:
            return a ^ b;
            OPENFAB_IR_CASES(ARITHMETIC)
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(ORDERS)
            OPENFAB_IR_CASES(EXTREMES)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return Expr();
}

/// Only values in range are cast, since targets differ for others.
Expr float_to_int(const Expr& x) {
    const Expr high = either(greater(x, kTwo31), equal_floats(x, kTwo31));
    const Expr low = greater(-kTwo31, x);
    const Expr fits = invert(either(either(high, low), nan_bit(x)));
    const Expr inside = to_int(choose(fits, x, Expr(0.0f)));
    return choose(high, i32(std::numeric_limits<int32_t>::max()),
                  choose(low, i32(std::numeric_limits<int32_t>::min()), inside));
}

Expr float_to_uint(const Expr& x) {
    const Expr positive = greater(x, 0.0f);
    const Expr full = either(greater(x, kTwo32), equal_floats(x, kTwo32));
    const Expr upper_half = either(greater(x, kTwo31), equal_floats(x, kTwo31));
    // Halide 14's vector conversion of float to uint32 differs between targets, so the upper half
    // goes through int32.
    const Expr lower = choose(both(positive, invert(upper_half)), x, Expr(0.0f));
    const Expr upper = choose(both(upper_half, invert(full)), x - kTwo31, Expr(0.0f));
    const Expr low_bits = as_uint(to_int(lower));
    const Expr high_bits = as_uint(to_int(upper)) ^ u32(kSign);
    return choose(full, u32(0xffffffffu), choose(upper_half, high_bits, low_bits));
}

}  // namespace

Halide::Type halide_type(Type type) {
    switch (type) {
        case Type::kBool:
            return Halide::UInt(1);
        case Type::kInt:
            return Halide::Int(32);
        case Type::kUint:
            return Halide::UInt(32);
        case Type::kFloat:
            break;
    }
    return Halide::Float(32);
}

Halide::Type storage_type(Type type) {
    return type == Type::kBool ? Halide::Int(32) : halide_type(type);
}

Value constant_bits(Type type, uint32_t bits) {
    switch (type) {
        case Type::kBool:
            return {type, boolean(bits != 0)};
        case Type::kInt:
            return {type, i32(static_cast<int32_t>(bits))};
        case Type::kUint:
            return {type, u32(bits)};
        case Type::kFloat:
            break;
    }
    const float value = std::bit_cast<float>(bits);
    if (!std::isfinite(value) || bits == kSign) return {type, as_float(u32(bits))};
    return {type, Halide::Internal::FloatImm::make(Halide::Float(32), static_cast<double>(value))};
}

Value constant(float value) {
    return constant_bits(Type::kFloat, std::bit_cast<uint32_t>(value));
}

Value constant(int32_t value) {
    return {Type::kInt, i32(value)};
}

Value from_storage(Type type, const Expr& expr) {
    return {type, type == Type::kBool ? invert(expr == i32(0)) : expr};
}

Expr to_storage(const Value& value) {
    return value.type == Type::kBool ? choose(value.expr, i32(1), i32(0)) : value.expr;
}

Value select(const Value& condition, const Value& if_true, const Value& if_false) {
    if (if_true.type == Type::kBool) {
        return {Type::kBool, either(both(condition.expr, if_true.expr),
                                    both(invert(condition.expr), if_false.expr))};
    }
    return {if_true.type, choose(condition.expr, if_true.expr, if_false.expr)};
}

Value operate(Op op, const std::vector<Value>& args) {
    if (op == Op::kSelect) return select(args[0], args[1], args[2]);
    const Expr a = args[0].expr;
    const Expr b = args.size() > 1 ? args[1].expr : Expr();
    Expr result;
    switch (args[0].type) {
        case Type::kFloat:
            result = float_op(op, a, b);
            break;
        case Type::kInt:
            result = int_op(op, a, b);
            break;
        case Type::kUint:
            result = uint_op(op, a, b);
            break;
        case Type::kBool:
            result = bool_op(op, a, b);
            break;
    }
    return {result.type().is_bool() ? Type::kBool : args[0].type, result};
}

Value convert(const Value& value, Type to) {
    const Type from = value.type;
    const Expr& x = value.expr;
    if (from == to) return value;
    if (to == Type::kBool) return operate(Op::kNe, {value, constant_bits(from, 0)});
    if (from == Type::kBool) {
        return {
            to,
            choose(x,
                   constant_bits(to, to == Type::kFloat ? std::bit_cast<uint32_t>(1.0f) : 1).expr,
                   constant_bits(to, 0).expr)};
    }
    if (from == Type::kFloat) return {to, to == Type::kInt ? float_to_int(x) : float_to_uint(x)};
    if (to == Type::kFloat) return {to, to_float(x)};
    return {to, to == Type::kInt ? as_int(x) : as_uint(x)};
}

Value bit_cast(const Value& value, Type to) {
    if (value.type == to) return value;
    return {to,
            Halide::reinterpret(halide_type(to).with_lanes(value.expr.type().lanes()), value.expr)};
}

Value float_bits(const Value& value) {
    return {Type::kUint, as_uint(value.expr)};
}

Value bits_float(const Value& value) {
    return {Type::kFloat, as_float(value.expr)};
}

}  // namespace openfab::lower
