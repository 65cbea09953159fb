// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Halide Exprs as a machine of compiler/functions, with Halide's own operators: the same arithmetic
// as one would write by hand.

#include <Halide.h>

#include "compiler/functions/machine.h"

namespace openfab::bench {

enum class Kind { kF, kI, kU, kB };

template <Kind kKind>
struct Hand {
    Halide::Expr e;
};

template <Kind kKind>
struct HandScalar;
template <>
struct HandScalar<Kind::kF> {
    using T = float;
};
template <>
struct HandScalar<Kind::kI> {
    using T = int32_t;
};
template <>
struct HandScalar<Kind::kU> {
    using T = uint32_t;
};
template <>
struct HandScalar<Kind::kB> {
    using T = bool;
};

inline Halide::Expr literal(float x) {
    return Halide::Expr(x);
}
inline Halide::Expr literal(int32_t x) {
    return Halide::Expr(x);
}
inline Halide::Expr literal(uint32_t x) {
    return Halide::cast(Halide::UInt(32), Halide::Expr(x));
}

#define OPENFAB_HAND_OPERATOR(sign, result)                                             \
    template <Kind kKind>                                                               \
    Hand<result> operator sign(const Hand<kKind>& a, const Hand<kKind>& b) {            \
        return {a.e sign b.e};                                                          \
    }                                                                                   \
    template <Kind kKind>                                                               \
    Hand<result> operator sign(const Hand<kKind>& a, typename HandScalar<kKind>::T b) { \
        return {a.e sign literal(b)};                                                   \
    }                                                                                   \
    template <Kind kKind>                                                               \
    Hand<result> operator sign(typename HandScalar<kKind>::T a, const Hand<kKind>& b) { \
        return {literal(a) sign b.e};                                                   \
    }
OPENFAB_HAND_OPERATOR(+, kKind)
OPENFAB_HAND_OPERATOR(-, kKind)
OPENFAB_HAND_OPERATOR(*, kKind)
OPENFAB_HAND_OPERATOR(/, kKind)
OPENFAB_HAND_OPERATOR(<, Kind::kB)
OPENFAB_HAND_OPERATOR(>, Kind::kB)
OPENFAB_HAND_OPERATOR(==, Kind::kB)
OPENFAB_HAND_OPERATOR(^, kKind)
OPENFAB_HAND_OPERATOR(<<, kKind)
OPENFAB_HAND_OPERATOR(>>, kKind)
OPENFAB_HAND_OPERATOR(&, kKind)
OPENFAB_HAND_OPERATOR(|, kKind)
#undef OPENFAB_HAND_OPERATOR

struct ByHand {
    using F = Hand<Kind::kF>;
    using I = Hand<Kind::kI>;
    using U = Hand<Kind::kU>;
    using B = Hand<Kind::kB>;

    template <Kind kKind>
    static Hand<kKind> select(const B& c, const Hand<kKind>& a, const Hand<kKind>& b) {
        return {Halide::select(c.e, a.e, b.e)};
    }
    template <Kind kKind>
    static Hand<kKind> select(const B& c, const Hand<kKind>& a, typename HandScalar<kKind>::T b) {
        return {Halide::select(c.e, a.e, literal(b))};
    }
    template <Kind kKind>
    static Hand<kKind> select(const B& c, typename HandScalar<kKind>::T a, const Hand<kKind>& b) {
        return {Halide::select(c.e, literal(a), b.e)};
    }
    static F constant(const F&, float x) { return {literal(x)}; }
    static F floor(const F& x) { return {Halide::floor(x.e)}; }
    static F trunc(const F& x) { return {Halide::trunc(x.e)}; }
    static F sqrt(const F& x) { return {Halide::sqrt(x.e)}; }
    static F abs(const F& x) { return {Halide::abs(x.e)}; }
    static U bits(const F& x) { return {Halide::reinterpret(Halide::UInt(32), x.e)}; }
    static F from_bits(const U& x) { return {Halide::reinterpret(Halide::Float(32), x.e)}; }
    static I as_int(const U& x) { return {Halide::reinterpret(Halide::Int(32), x.e)}; }
    static U as_uint(const I& x) { return {Halide::reinterpret(Halide::UInt(32), x.e)}; }
    static F to_float(const I& x) { return {Halide::cast(Halide::Float(32), x.e)}; }
    static U shift_down(const U& x, uint32_t count) {
        return as_uint({as_int(x).e >> static_cast<int32_t>(count)});
    }
};

}  // namespace openfab::bench
