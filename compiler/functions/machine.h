// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Machines that run one formula: Plain computes on 32-bit scalars, Emit appends the operations
// to an IR stage, and Wide computes noises in double, for the oracle of derivatives. A formula is a template over the machine, so that the interpreter, the constant
// folder and generated code cannot differ. A machine has types F, I, U, B (float, int, uint, bool)
// with C++ operators, and the static functions below. Formulas use operations that all targets
// compute alike: + - * / on floats, sqrt, floor, comparisons, selects and integer operations.
//
// All of it is cheap in vector code except U -> float beyond int's range (so there is only
// `to_float(I)`), float -> int (formulas add 1.5 * 2^23 and read the low bits instead), == and >=
// on floats, and comparisons with 0, whose sign has to be looked at.

#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "compiler/ir/arithmetic.h"
#include "compiler/ir/ir.h"

namespace openfab::functions {

struct Plain {
    using F = float;
    using I = int32_t;
    using U = uint32_t;
    using B = bool;

    template <typename T>
    static T select(bool condition, T a, T b) {
        return condition ? a : b;
    }
    template <typename T>
    static T constant(F /*beside*/, T value) {
        return value;
    }
    static F floor(F x) { return std::floor(x); }
    static F trunc(F x) { return std::trunc(x); }
    static F sqrt(F x) { return std::sqrt(x); }
    static F abs(F x) { return ir::as_float(ir::as_bits(x) & 0x7fffffffu); }
    static B is_nan(F x) { return std::isnan(x); }
    static U bits(F x) { return ir::as_bits(x); }
    static F from_bits(U x) { return ir::as_float(x); }
    static I as_int(U x) { return static_cast<I>(x); }
    static U as_uint(I x) { return static_cast<U>(x); }
    static F to_float(I x) { return static_cast<F>(x); }
    /// Fills with the sign bit.
    static U shift_down(U x, U count) { return static_cast<U>(static_cast<I>(x) >> count); }
};

/// Plain with floats in double, for formulas whose `bits` are those of whole numbers below 2^23 or of a float whose
/// sign alone changes (flip). Elementary functions are none of these: they have polynomials for float.
struct Wide : Plain {
    using F = double;

    template <typename A, typename B>
    static std::common_type_t<A, B> select(bool condition, A a, B b) {
        return condition ? a : b;
    }
    template <typename T>
    static T constant(F /*beside*/, T value) {
        return value;
    }
    static F floor(F x) { return std::floor(x); }
    static F sqrt(F x) { return std::sqrt(x); }
    static U bits(F x) { return ir::as_bits(static_cast<float>(x)); }
    static F to_float(I x) { return static_cast<F>(x); }
};

/// A value of the stage under construction.
template <ir::Type kType>
struct Node {
    ir::Builder* builder = nullptr;
    ir::ValueId id = ir::kNoValue;
};

template <typename T>
constexpr ir::Type kTypeOf = ir::Type::kFloat;
template <>
inline constexpr ir::Type kTypeOf<bool> = ir::Type::kBool;
template <>
inline constexpr ir::Type kTypeOf<int32_t> = ir::Type::kInt;
template <>
inline constexpr ir::Type kTypeOf<uint32_t> = ir::Type::kUint;

template <ir::Type kType>
struct ScalarOf;
template <>
struct ScalarOf<ir::Type::kBool> {
    using T = bool;
};
template <>
struct ScalarOf<ir::Type::kInt> {
    using T = int32_t;
};
template <>
struct ScalarOf<ir::Type::kUint> {
    using T = uint32_t;
};
template <>
struct ScalarOf<ir::Type::kFloat> {
    using T = float;
};

// Operands are two nodes, or a node and a C++ scalar of the same type.
#define OPENFAB_NODE_OPERATOR(sign, op, result)                                \
    template <ir::Type kType>                                                  \
    Node<result> operator sign(Node<kType> a, Node<kType> b) {                 \
        return {a.builder, a.builder->emit(ir::Op::op, {a.id, b.id})};         \
    }                                                                          \
    template <ir::Type kType>                                                  \
    Node<result> operator sign(Node<kType> a, typename ScalarOf<kType>::T b) { \
        return a sign Node<kType>{a.builder, a.builder->constant(b)};          \
    }                                                                          \
    template <ir::Type kType>                                                  \
    Node<result> operator sign(typename ScalarOf<kType>::T a, Node<kType> b) { \
        return Node<kType>{b.builder, b.builder->constant(a)} sign b;          \
    }
OPENFAB_NODE_OPERATOR(+, kAdd, kType)
OPENFAB_NODE_OPERATOR(-, kSub, kType)
OPENFAB_NODE_OPERATOR(*, kMul, kType)
OPENFAB_NODE_OPERATOR(/, kDiv, kType)
OPENFAB_NODE_OPERATOR(<, kLt, ir::Type::kBool)
OPENFAB_NODE_OPERATOR(>, kGt, ir::Type::kBool)
OPENFAB_NODE_OPERATOR(==, kEq, ir::Type::kBool)
OPENFAB_NODE_OPERATOR(^, kBitXor, kType)
OPENFAB_NODE_OPERATOR(<<, kShl, kType)
OPENFAB_NODE_OPERATOR(>>, kShr, kType)
#undef OPENFAB_NODE_OPERATOR

template <ir::Type kType>
Node<kType> operator&(Node<kType> a, Node<kType> b) {
    constexpr ir::Op kOp = kType == ir::Type::kBool ? ir::Op::kAnd : ir::Op::kBitAnd;
    return {a.builder, a.builder->emit(kOp, {a.id, b.id})};
}
template <ir::Type kType>
Node<kType> operator&(Node<kType> a, typename ScalarOf<kType>::T b) {
    return a & Node<kType>{a.builder, a.builder->constant(b)};
}
template <ir::Type kType>
Node<kType> operator|(Node<kType> a, Node<kType> b) {
    constexpr ir::Op kOp = kType == ir::Type::kBool ? ir::Op::kOr : ir::Op::kBitOr;
    return {a.builder, a.builder->emit(kOp, {a.id, b.id})};
}
template <ir::Type kType>
Node<kType> operator|(Node<kType> a, typename ScalarOf<kType>::T b) {
    return a | Node<kType>{a.builder, a.builder->constant(b)};
}
inline Node<ir::Type::kBool> operator!(Node<ir::Type::kBool> a) {
    return {a.builder, a.builder->emit(ir::Op::kNot, {a.id})};
}
inline Node<ir::Type::kFloat> operator-(Node<ir::Type::kFloat> a) {
    return {a.builder, a.builder->emit(ir::Op::kNeg, {a.id})};
}

struct Emit {
    using F = Node<ir::Type::kFloat>;
    using I = Node<ir::Type::kInt>;
    using U = Node<ir::Type::kUint>;
    using B = Node<ir::Type::kBool>;

    template <ir::Type kType>
    static Node<kType> select(B condition, Node<kType> a, Node<kType> b) {
        return {a.builder, a.builder->select(condition.id, a.id, b.id)};
    }
    template <ir::Type kType>
    static Node<kType> select(B condition, Node<kType> a, typename ScalarOf<kType>::T b) {
        return select(condition, a, Node<kType>{a.builder, a.builder->constant(b)});
    }
    template <ir::Type kType>
    static Node<kType> select(B condition, typename ScalarOf<kType>::T a, Node<kType> b) {
        return select(condition, Node<kType>{b.builder, b.builder->constant(a)}, b);
    }
    template <typename T>
    static Node<kTypeOf<T>> select(B condition, T a, T b) {
        ir::Builder* to = condition.builder;
        const ir::ValueId first = to->constant(a);
        return {to, to->select(condition.id, first, to->constant(b))};
    }
    template <typename T>
    static Node<kTypeOf<T>> constant(F beside, T value) {
        return {beside.builder, beside.builder->constant(value)};
    }
    static F floor(F x) { return {x.builder, x.builder->emit(ir::Op::kFloor, {x.id})}; }
    static F trunc(F x) { return {x.builder, x.builder->emit(ir::Op::kTrunc, {x.id})}; }
    static F sqrt(F x) { return {x.builder, x.builder->emit(ir::Op::kSqrt, {x.id})}; }
    static F abs(F x) { return {x.builder, x.builder->emit(ir::Op::kAbs, {x.id})}; }
    static B is_nan(F x) { return {x.builder, x.builder->emit(ir::Op::kIsNan, {x.id})}; }
    static U bits(F x) { return {x.builder, x.builder->bit_cast(x.id, ir::Type::kUint)}; }
    static F from_bits(U x) { return {x.builder, x.builder->bit_cast(x.id, ir::Type::kFloat)}; }
    static I as_int(U x) { return {x.builder, x.builder->convert(x.id, ir::Type::kInt)}; }
    static U as_uint(I x) { return {x.builder, x.builder->convert(x.id, ir::Type::kUint)}; }
    static F to_float(I x) { return {x.builder, x.builder->convert(x.id, ir::Type::kFloat)}; }
    static U shift_down(U x, U count) {
        const I places = as_int(count);
        return as_uint(as_int(x) >> places);
    }
    static U shift_down(U x, uint32_t count) {
        return as_uint(as_int(x) >> static_cast<int32_t>(count));
    }
};

}  // namespace openfab::functions
