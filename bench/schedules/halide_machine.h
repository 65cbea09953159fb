// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A machine (compiler/functions/machine.h) whose numbers are Halide expressions, with Halide's own
// operators: what somebody who writes a kernel in Halide by hand takes noise and sines from.

#include <Halide.h>

#include <cstdint>
#include <type_traits>
#include <utility>

namespace openfab::by_hand {

/// An expression that knows its C++ type, so that scalars beside it take that.
template <typename T>
struct Number {
    Halide::Expr expr;

    Number() = default;
    Number(T value) : expr(Halide::Internal::make_const(Halide::type_of<T>(), value)) {}
    explicit Number(Halide::Expr value) : expr(std::move(value)) {}

#define OPENFAB_NUMBER_OPERATOR(sign, Result)                    \
    friend Number<Result> operator sign(Number a, Number b) {    \
        return Number<Result>(Halide::Expr(a.expr sign b.expr)); \
    }
    OPENFAB_NUMBER_OPERATOR(+, T)
    OPENFAB_NUMBER_OPERATOR(-, T)
    OPENFAB_NUMBER_OPERATOR(*, T)
    OPENFAB_NUMBER_OPERATOR(/, T)
    OPENFAB_NUMBER_OPERATOR(^, T)
    OPENFAB_NUMBER_OPERATOR(<<, T)
    OPENFAB_NUMBER_OPERATOR(>>, T)
    OPENFAB_NUMBER_OPERATOR(<, bool)
    OPENFAB_NUMBER_OPERATOR(>, bool)
    OPENFAB_NUMBER_OPERATOR(==, bool)
#undef OPENFAB_NUMBER_OPERATOR
    friend Number operator&(Number a, Number b) {
        if constexpr (std::is_same_v<T, bool>) return Number(a.expr && b.expr);
        return Number(a.expr & b.expr);
    }
    friend Number operator|(Number a, Number b) {
        if constexpr (std::is_same_v<T, bool>) return Number(a.expr || b.expr);
        return Number(a.expr | b.expr);
    }
};

using Real = Number<float>;

struct Machine {
    using F = Real;
    using I = Number<int32_t>;
    using U = Number<uint32_t>;
    using B = Number<bool>;

    template <typename T>
    static Number<T> select(B condition, Number<T> a, Number<T> b) {
        return Number<T>(Halide::select(condition.expr, a.expr, b.expr));
    }
    static F select(B condition, F a, float b) { return select(condition, a, F(b)); }
    static F select(B condition, float a, F b) { return select(condition, F(a), b); }
    static F constant(F /*beside*/, float value) { return F(value); }
    static F floor(F x) { return F(Halide::floor(x.expr)); }
    static F trunc(F x) { return F(Halide::trunc(x.expr)); }
    static F sqrt(F x) { return F(Halide::sqrt(x.expr)); }
    static F abs(F x) { return F(Halide::abs(x.expr)); }
    static F min(F a, F b) { return F(Halide::min(a.expr, b.expr)); }
    static F max(F a, F b) { return F(Halide::max(a.expr, b.expr)); }
    static U bits(F x) { return U(Halide::reinterpret<uint32_t>(x.expr)); }
    static F from_bits(U x) { return F(Halide::reinterpret<float>(x.expr)); }
    static I as_int(U x) { return I(Halide::reinterpret<int32_t>(x.expr)); }
    static F to_float(I x) { return F(Halide::cast<float>(x.expr)); }
};

}  // namespace openfab::by_hand
