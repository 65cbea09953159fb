// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/exact_exprs.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace openfab::lower {

using Halide::Expr;

namespace {

constexpr uint32_t kQuietNan = 0x7fc00000u;

Expr widened(const Expr& e, int lanes) {
    return e.type().lanes() == lanes ? e : Halide::Internal::Broadcast::make(e, lanes);
}

/// The pattern of a constant 0 of either sign.
std::optional<uint32_t> zero_constant(const Expr& e) {
    if (const auto* imm = e.as<Halide::Internal::FloatImm>()) {
        if (imm->value != 0.0) return std::nullopt;
        return std::signbit(imm->value) ? kSign : 0;
    }
#if HALIDE_VERSION_MAJOR >= 15
    const auto* cast = e.as<Halide::Internal::Reinterpret>();
    if (cast == nullptr) return std::nullopt;
    const auto* bits = cast->value.as<Halide::Internal::UIntImm>();
#else
    const auto* cast = e.as<Halide::Internal::Call>();
    if (cast == nullptr || !cast->is_intrinsic(Halide::Internal::Call::reinterpret)) {
        return std::nullopt;
    }
    const auto* bits = cast->args[0].as<Halide::Internal::UIntImm>();
#endif
    if (bits == nullptr || (bits->value & kMagnitude) != 0) return std::nullopt;
    return static_cast<uint32_t>(bits->value);
}

/// x > 0 and 0 > x from the pattern. Beside a constant 0 of either sign LLVM 14 treats the other
/// sign as equal when it makes a minimum of a comparison and a choice, and may return the wrong
/// zero (seen for AVX2).
Expr above_zero(const Expr& x) {
    const Expr bits = as_int(x);
    return both(bits > i32(0), i32(static_cast<int32_t>(kInfinityBits) + 1) > bits);
}
Expr below_zero(const Expr& x) {
    const Expr bits = as_uint(x);
    return both(bits > u32(kSign), u32((kSign | kInfinityBits) + 1) > bits);
}

bool is_ordered_constant(const Expr& e) {
    const auto* imm = e.as<Halide::Internal::FloatImm>();
    return imm != nullptr && !std::isnan(imm->value);
}

/// a / 0 from the pattern: newer versions of Halide reject a division by a constant 0.
Expr divide_by_zero(const Expr& a, uint32_t zero) {
    const Expr nothing = (as_uint(a) & u32(kMagnitude)) == u32(0);
    const Expr infinity = ((as_uint(a) ^ u32(zero)) & u32(kSign)) | u32(kInfinityBits);
    return as_float(choose(either(nothing, nan_bit(a)), u32(kQuietNan), infinity));
}

}  // namespace

Expr u32(uint32_t value) {
    return Halide::Internal::UIntImm::make(Halide::UInt(32), value);
}
Expr i32(int32_t value) {
    return Halide::Internal::IntImm::make(Halide::Int(32), value);
}
Expr boolean(bool value) {
    return Halide::Internal::UIntImm::make(Halide::UInt(1), value ? 1 : 0);
}
Expr as_uint(const Expr& e) {
    return Halide::reinterpret(Halide::UInt(32, e.type().lanes()), e);
}
Expr as_int(const Expr& e) {
    return Halide::reinterpret(Halide::Int(32, e.type().lanes()), e);
}
Expr as_float(const Expr& e) {
    return Halide::reinterpret(Halide::Float(32, e.type().lanes()), e);
}
Expr to_int(const Expr& e) {
    return Halide::cast(Halide::Int(32, e.type().lanes()), e);
}
Expr to_float(const Expr& e) {
    return Halide::cast(Halide::Float(32, e.type().lanes()), e);
}

namespace {

/// Halide from 18 on looks for stages that conditions skip, and takes each variable of a let there for unbounded. If that
/// is a condition, which it has put there since several selects have it, it conjoins it with infinity, a pointer: an
/// internal error. Here such a variable holds a byte. Common subexpressions are no sums with a constant, simplifying
/// does not see through the number of bits, and LLVM sees through all of it.
Expr skippable(const Expr& condition) {
#if HALIDE_VERSION_MAJOR >= 18
    if (Halide::Internal::is_const(condition)) return condition;
    const Expr bits = Halide::popcount(
        Halide::Internal::Cast::make(Halide::UInt(8, condition.type().lanes()), condition));
    return Halide::Internal::Cast::make(
        condition.type(),
        Halide::Internal::Add::make(bits, Halide::Internal::make_zero(bits.type())));
#else
    return condition;
#endif
}

}  // namespace

Expr choose(const Expr& condition, const Expr& a, const Expr& b) {
    const int lanes = std::max({condition.type().lanes(), a.type().lanes(), b.type().lanes()});
    return Halide::select(skippable(condition), widened(a, lanes), widened(b, lanes));
}

Expr both(const Expr& a, const Expr& b) {
    return a & b;
}
Expr either(const Expr& a, const Expr& b) {
    return a | b;
}
Expr invert(const Expr& a) {
    return a ^ boolean(true);
}

/// The target feature marks float results only: without the wrapper LLVM may assume that operands
/// of comparisons are not NaN, and does (seen with `!(a < b)` for AVX2).
Expr greater(const Expr& a, const Expr& b) {
    if (zero_constant(b)) return above_zero(a);
    if (zero_constant(a)) return below_zero(b);
    return Halide::strict_float(a > b);
}
Expr equal_floats(const Expr& a, const Expr& b) {
    return Halide::strict_float(a == b);
}

Expr nan_bit(const Expr& e) {
    if (is_ordered_constant(e)) return boolean(false);
    return (as_uint(e) & u32(kMagnitude)) > u32(kInfinityBits);
}
Expr ordered(const Expr& a, const Expr& b) {
    if (is_ordered_constant(a)) return invert(nan_bit(b));
    if (is_ordered_constant(b)) return invert(nan_bit(a));
    return both(invert(nan_bit(a)), invert(nan_bit(b)));
}

Expr float_equality(const Expr& a, const Expr& b) {
    if (is_ordered_constant(a) || is_ordered_constant(b)) return equal_floats(a, b);
    const Expr zeros = ((as_uint(a) | as_uint(b)) & u32(kMagnitude)) == u32(0);
    return either(both(as_uint(a) == as_uint(b), invert(nan_bit(a))), zeros);
}

/// LLVM 14 ignores that it may be -0: it assumed 1 / sqrt(x) >= 0 and dropped a later lower bound.
/// It does not analyse a select.
Expr square_root(const Expr& a) {
    // Halide::sqrt takes scalars only.
    const Expr root =
        Halide::Internal::Call::make(a.type(), "sqrt_f32", {a}, Halide::Internal::Call::PureExtern);
    return choose((as_uint(a) & u32(kMagnitude)) == u32(0), a, root);
}

Expr divide(const Expr& a, const Expr& b) {
    if (const std::optional<uint32_t> zero = zero_constant(b)) return divide_by_zero(a, *zero);
    return a / b;
}

}  // namespace openfab::lower
