// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What ops.cpp makes operations of: Halide Exprs whose bits are the same on every target, most of them
// through uint32. ops.h says which of Halide's own are not.

#include <Halide.h>

#include <cstdint>

namespace openfab::lower {

// The bits of a float.
constexpr uint32_t kSign = 0x80000000u;
constexpr uint32_t kMagnitude = 0x7fffffffu;
constexpr uint32_t kInfinityBits = 0x7f800000u;

Halide::Expr u32(uint32_t value);
Halide::Expr i32(int32_t value);
Halide::Expr boolean(bool value);

// The bits of a value as another type, and its number.
Halide::Expr as_uint(const Halide::Expr& e);
Halide::Expr as_int(const Halide::Expr& e);
Halide::Expr as_float(const Halide::Expr& e);
Halide::Expr to_int(const Halide::Expr& e);
Halide::Expr to_float(const Halide::Expr& e);

/// Selects; a scalar beside vectors stands for each lane.
Halide::Expr choose(const Halide::Expr& condition, const Halide::Expr& a, const Halide::Expr& b);

// Bitwise on one-bit values: nothing here is an And, Or or Not node that the simplifier knows.
Halide::Expr both(const Halide::Expr& a, const Halide::Expr& b);
Halide::Expr either(const Halide::Expr& a, const Halide::Expr& b);
Halide::Expr invert(const Halide::Expr& a);

// Comparisons of floats, as one bit.
Halide::Expr greater(const Halide::Expr& a, const Halide::Expr& b);
Halide::Expr float_equality(const Halide::Expr& a, const Halide::Expr& b);
/// The same where one of them is a constant other than NaN.
Halide::Expr equal_floats(const Halide::Expr& a, const Halide::Expr& b);
/// Whether e is a NaN.
Halide::Expr nan_bit(const Halide::Expr& e);
/// Whether neither is a NaN.
Halide::Expr ordered(const Halide::Expr& a, const Halide::Expr& b);

Halide::Expr divide(const Halide::Expr& a, const Halide::Expr& b);
/// The square root of a zero is that zero.
Halide::Expr square_root(const Halide::Expr& a);

}  // namespace openfab::lower
