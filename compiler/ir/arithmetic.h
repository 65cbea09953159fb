// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Defines each arithmetic operation of the IR on 32-bit patterns (rule 2). The interpreter
// and constant folding both call this; generated code must give the same bits. A NaN result may be
// any NaN: which payload comes out depends on operand order in the machine's instructions.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "compiler/ir/ir.h"

namespace openfab::ir {

inline float as_float(uint32_t bits) {
    return std::bit_cast<float>(bits);
}
inline int32_t as_int(uint32_t bits) {
    return static_cast<int32_t>(bits);
}
inline uint32_t as_bits(float value) {
    return std::bit_cast<uint32_t>(value);
}
inline uint32_t as_bits(int32_t value) {
    return static_cast<uint32_t>(value);
}
inline uint32_t as_bits(bool value) {
    return value ? 1 : 0;
}

/// Truncates; x / 0 = 0, and INT_MIN / -1 = INT_MIN.
inline int32_t divide(int32_t a, int32_t b) {
    if (b == 0) return 0;
    if (b == -1) return as_int(0u - as_bits(a));
    return a / b;
}
/// Has the sign of the dividend; x % 0 = 0.
inline int32_t modulo(int32_t a, int32_t b) {
    return b == 0 || b == -1 ? 0 : a % b;
}

/// Truncates and saturates; NaN gives 0.
inline int32_t float_to_int(float x) {
    if (std::isnan(x)) return 0;
    if (x >= 2147483648.0f) return std::numeric_limits<int32_t>::max();
    if (x < -2147483648.0f) return std::numeric_limits<int32_t>::min();
    return static_cast<int32_t>(x);
}
inline uint32_t float_to_uint(float x) {
    if (!(x > 0.0f)) return 0;
    if (x >= 4294967296.0f) return std::numeric_limits<uint32_t>::max();
    return static_cast<uint32_t>(x);
}

inline uint32_t eval_convert(Type from, Type to, uint32_t x) {
    if (from == to) return x;
    if (to == Type::kBool) return as_bits(from == Type::kFloat ? as_float(x) != 0.0f : x != 0);
    if (from == Type::kFloat) {
        return to == Type::kInt ? as_bits(float_to_int(as_float(x))) : float_to_uint(as_float(x));
    }
    if (to != Type::kFloat) return x;
    return as_bits(from == Type::kInt ? static_cast<float>(as_int(x)) : static_cast<float>(x));
}

inline uint32_t eval_float(Op op, float a, float b) {
    switch (op) {
        case Op::kAdd:
            return as_bits(a + b);
        case Op::kSub:
            return as_bits(a - b);
        case Op::kMul:
            return as_bits(a * b);
        case Op::kDiv:
            return as_bits(a / b);
        case Op::kMod:
            return as_bits(a - b * std::trunc(a / b));
        case Op::kNeg:
            return as_bits(a) ^ 0x80000000u;
        case Op::kAbs:
            return as_bits(a) & 0x7fffffffu;
        case Op::kMin:
            return as_bits(a < b ? a : b);
        case Op::kMax:
            return as_bits(a > b ? a : b);
        case Op::kSqrt:
            return as_bits(std::sqrt(a));
        case Op::kFloor:
            return as_bits(std::floor(a));
        case Op::kCeil:
            return as_bits(std::ceil(a));
        case Op::kRound:
            return as_bits(std::nearbyint(a));  // halves to even
        case Op::kTrunc:
            return as_bits(std::trunc(a));
        case Op::kIsNan:
            return as_bits(std::isnan(a));
        case Op::kEq:
            return as_bits(a == b);
        case Op::kNe:
            return as_bits(a != b);
        case Op::kLt:
            return as_bits(a < b);
        case Op::kLe:
            return as_bits(a <= b);
        case Op::kGt:
            return as_bits(a > b);
        case Op::kGe:
            return as_bits(a >= b);
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return 0;
}

/// Computes operations that have the same bits for int and uint.
inline uint32_t eval_integer(Op op, uint32_t a, uint32_t b) {
    switch (op) {
        case Op::kAdd:
            return a + b;
        case Op::kSub:
            return a - b;
        case Op::kMul:
            return a * b;
        case Op::kNeg:
            return 0u - a;
        case Op::kBitAnd:
            return a & b;
        case Op::kBitOr:
            return a | b;
        case Op::kBitXor:
            return a ^ b;
        case Op::kBitNot:
            return ~a;
        case Op::kShl:
            return a << (b & 31u);
        case Op::kEq:
            return as_bits(a == b);
        case Op::kNe:
            return as_bits(a != b);
        case Op::kDiv:
        case Op::kMod:
        case Op::kShr:
            OPENFAB_IR_CASES(ORDERS)
            OPENFAB_IR_CASES(EXTREMES)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return 0;
}

inline uint32_t eval_int(Op op, uint32_t x, uint32_t y) {
    const int32_t a = as_int(x);
    const int32_t b = as_int(y);
    switch (op) {
        case Op::kDiv:
            return as_bits(divide(a, b));
        case Op::kMod:
            return as_bits(modulo(a, b));
        case Op::kAbs:
            return a < 0 ? 0u - x : x;
        case Op::kMin:
            return a < b ? x : y;
        case Op::kMax:
            return a > b ? x : y;
        case Op::kShr:
            return as_bits(a >> (y & 31u));
        case Op::kLt:
            return as_bits(a < b);
        case Op::kLe:
            return as_bits(a <= b);
        case Op::kGt:
            return as_bits(a > b);
        case Op::kGe:
            return as_bits(a >= b);
        case Op::kAdd:
        case Op::kSub:
        case Op::kMul:
        case Op::kNeg:
        case Op::kBitAnd:
        case Op::kBitOr:
        case Op::kBitXor:
        case Op::kBitNot:
        case Op::kShl:
        case Op::kEq:
        case Op::kNe:
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return eval_integer(op, x, y);
}

inline uint32_t eval_uint(Op op, uint32_t a, uint32_t b) {
    switch (op) {
        case Op::kDiv:
            return b == 0 ? 0 : a / b;
        case Op::kMod:
            return b == 0 ? 0 : a % b;
        case Op::kAbs:
            return a;
        case Op::kMin:
            return a < b ? a : b;
        case Op::kMax:
            return a > b ? a : b;
        case Op::kShr:
            return a >> (b & 31u);
        case Op::kLt:
            return as_bits(a < b);
        case Op::kLe:
            return as_bits(a <= b);
        case Op::kGt:
            return as_bits(a > b);
        case Op::kGe:
            return as_bits(a >= b);
        case Op::kAdd:
        case Op::kSub:
        case Op::kMul:
        case Op::kNeg:
        case Op::kBitAnd:
        case Op::kBitOr:
        case Op::kBitXor:
        case Op::kBitNot:
        case Op::kShl:
        case Op::kEq:
        case Op::kNe:
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return eval_integer(op, a, b);
}

inline uint32_t eval_bool(Op op, uint32_t a, uint32_t b) {
    switch (op) {
        case Op::kAnd:
            return a & b;
        case Op::kOr:
            return a | b;
        case Op::kNot:
            return a ^ 1u;
        case Op::kEq:
            return as_bits(a == b);
        case Op::kNe:
            return as_bits(a != b);
            OPENFAB_IR_CASES(ARITHMETIC)
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(ORDERS)
            OPENFAB_IR_CASES(EXTREMES)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return 0;
}

/// Returns the result bits of an instruction whose arguments have type `type` (of a select: its two
/// values) and bits a, b, c; unused ones are 0. Select takes its condition in `a`. Not for Const,
/// Input, Sample, SampleBound, functions (compiler/functions); Convert is eval_convert.
inline uint32_t eval(Op op, Type type, uint32_t a, uint32_t b, uint32_t c) {
    if (op == Op::kSelect) return a != 0 ? b : c;
    if (op == Op::kBitCast) return a;
    switch (type) {
        case Type::kFloat:
            return eval_float(op, as_float(a), as_float(b));
        case Type::kInt:
            return eval_int(op, a, b);
        case Type::kUint:
            return eval_uint(op, a, b);
        case Type::kBool:
            return eval_bool(op, a, b);
    }
    return 0;
}

/// Returns which of `count` elements an index of this type names: the nearest where it names none.
inline size_t picked_element(Type type, uint32_t index, size_t count) {
    const bool below = type == Type::kInt && as_int(index) < 0;
    return below ? 0 : std::min(static_cast<size_t>(index), count - 1);
}

}  // namespace openfab::ir
