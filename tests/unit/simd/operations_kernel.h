// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Computes what operations.h declares; compiled for each instruction set.

#include "simd/fixed.h"
#include "simd/vectors.h"
#include "tests/unit/simd/operations.h"

namespace openfab::testing::OPENFAB_SIMD_ISA {

void compute(const Operands& in, Results* out) {
    using V = simd::WidestFloats;
    const V a = V::load(in.a), b = V::load(in.b), c = V::load(in.c);
    out->lanes = V::kLanes;
    store(out->sum, a + b);
    store(out->difference, a - b);
    store(out->product, a * b);
    store(out->quotient, a / b);
    store(out->least, min(a, b));
    store(out->most, max(a, b));
    store(out->root, sqrt(a));
    store(out->magnitude, absolute(a));
    store(out->about_sum, about_mul_add(a, b, c));
    store(out->about_difference, about_mul_sub(a, b, c));
    const auto less = a < b, equal = a == b, odd = V::Mask::from_bits(0xaaaa);
    store(out->selected, select(less, a, c));
    store(out->selected_ints, select(less, V::Ints::load(in.i), typename V::Ints(7)));
    out->less = bits(less);
    out->less_equal = bits(a <= b);
    out->equal = bits(equal);
    out->both = bits(less & odd);
    out->either = bits(less | odd);
    out->only_second = bits(andnot(less, odd));
    out->from_bits = bits(odd);
    out->some = any(odd);
    out->none = any(andnot(odd, odd));
}

void compute(const Operands& in, FixedResults* out) {
    using simd::Fixed16;
    const auto store = [](int16_t* to, Fixed16 a) { __builtin_memcpy(to, &a, sizeof(a)); };
    const Fixed16 s = Fixed16::load_unaligned(in.s), t = Fixed16::load_unaligned(in.t);
    store(out->sum, s + t - Fixed16(1));
    store(out->product, times(s, t));
    store(out->capped, add_capped(s, t));
    store(out->magnitude, absolute(s));
    store(out->selected, select(s > t, simd::fixed_lane_numbers(), t));
    out->greater = bits(s > t);
}

void compute(const Operands& in, RegisterResults* out) {
    using simd::Floats;
    using simd::Ints;
    using simd::Uints;
    const Floats a = Floats::load_unaligned(in.a), b = Floats::load(in.b);
    const Ints i = Ints::load(in.i), j = Ints::load(in.j);
    out->lanes = simd::kLanes;
    store(out->down, floor(a));
    store(out->up, ceil(a));
    store(out->of_ints, to_floats(i));
    store_unaligned(out->kept, masked(a > b, a));
    store(out->dropped, andnot(a >= b, a));
    store(out->truncated, to_ints(a));
    store(out->rounded, round_to_ints(a));
    Ints sum = i;
    sum += j;
    Ints difference = i;
    difference -= j;
    store(out->sum, sum);
    store(out->difference, difference);
    store(out->product, i * j);
    store(out->least, min(i, j));
    store(out->most, max(i, j));
    store(out->shifted, (i >> 3) & 0xff);
    store(out->hash, as_ints((Uints(i) ^ (Uints(i) >> Uints(16u))) * Uints(0x7feb352du)));
    store(out->words, Ints::load_unaligned(in.words));
    store(out->bytes, Ints::load_unaligned(in.bytes));
    store(out->mask, as_ints(i > j));
    store_low_bytes(out->low_bytes, i);
    out->greater = bits(i > j);
    out->equal = bits(i == j);
}

}  // namespace openfab::testing::OPENFAB_SIMD_ISA
