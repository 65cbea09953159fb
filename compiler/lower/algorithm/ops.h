// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// With exact_exprs.h, the only code that makes arithmetic Halide Exprs. Each gives the bits of
// compiler/ir/arithmetic.h, which Halide's own operators do not: they fold `x + 1 > x` on ints,
// call `a >= b` true on NaN, lose the sign of -0, round integer division down. All kernels are
// compiled with the target feature strict_float; what that leaves open is closed here by going
// through uint32, which Halide neither reorders nor assumes anything about. Exprs may be vectors;
// a scalar beside one stands for each of its lanes.
//
// Ways that Halide 14 folds floats wrongly even then, and the form used instead:
//   !(a < b)      becomes b <= a        Not is xor with true
//   a == a, a<=a  becomes true          equality and order with NaN are taken from the bit patterns
//   a < c || b    is merged by range    And, Or are bitwise
//   a < b         tells LLVM that       wrapped one by one in strict_float: the target feature
//                 neither is a NaN      marks float results only
//   constants     NaN equals any number, NaN and -0 are made from their bits
//                 -0 equals 0, when
//                 equal Exprs are merged

#include <Halide.h>

#include <cstdint>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::lower {

/// A Halide Expr with its IR type; bools are UInt(1).
struct Value {
    ir::Type type = ir::Type::kFloat;
    Halide::Expr expr;
};

Halide::Type halide_type(ir::Type type);
/// Returns the type in buffers and scalar arguments: halide_type, but int32 for a bool.
Halide::Type storage_type(ir::Type type);
Value constant_bits(ir::Type type, uint32_t bits);
Value constant(float value);
Value constant(int32_t value);
/// Returns a value loaded from a buffer or scalar of storage_type.
Value from_storage(ir::Type type, const Halide::Expr& expr);
Halide::Expr to_storage(const Value& value);

/// Applies a primitive operation, except Const, Input, Convert, BitCast, Sample and SampleBound.
Value operate(ir::Op op, const std::vector<Value>& args);
Value convert(const Value& value, ir::Type to);
Value bit_cast(const Value& value, ir::Type to);
Value select(const Value& condition, const Value& if_true, const Value& if_false);
/// Converts a float to its bits as uint, and back.
Value float_bits(const Value& value);
Value bits_float(const Value& value);

inline Value operator+(const Value& a, const Value& b) {
    return operate(ir::Op::kAdd, {a, b});
}
inline Value operator-(const Value& a, const Value& b) {
    return operate(ir::Op::kSub, {a, b});
}
inline Value operator*(const Value& a, const Value& b) {
    return operate(ir::Op::kMul, {a, b});
}
inline Value operator/(const Value& a, const Value& b) {
    return operate(ir::Op::kDiv, {a, b});
}
inline Value operator<(const Value& a, const Value& b) {
    return operate(ir::Op::kLt, {a, b});
}
inline Value operator>(const Value& a, const Value& b) {
    return operate(ir::Op::kGt, {a, b});
}
inline Value operator>=(const Value& a, const Value& b) {
    return operate(ir::Op::kGe, {a, b});
}
inline Value operator==(const Value& a, const Value& b) {
    return operate(ir::Op::kEq, {a, b});
}
inline Value operator&(const Value& a, const Value& b) {
    return operate(a.type == ir::Type::kBool ? ir::Op::kAnd : ir::Op::kBitAnd, {a, b});
}
inline Value operator|(const Value& a, const Value& b) {
    return operate(a.type == ir::Type::kBool ? ir::Op::kOr : ir::Op::kBitOr, {a, b});
}
inline Value sqrt(const Value& a) {
    return operate(ir::Op::kSqrt, {a});
}
inline Value floor(const Value& a) {
    return operate(ir::Op::kFloor, {a});
}
inline Value ceil(const Value& a) {
    return operate(ir::Op::kCeil, {a});
}

}  // namespace openfab::lower
