// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Edge values of the operations, against rule 2 and C.

#include "compiler/ir/arithmetic.h"
#include "base/infinity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace openfab::ir {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr int32_t kIntMin = std::numeric_limits<int32_t>::min();
constexpr int32_t kIntMax = std::numeric_limits<int32_t>::max();

float f(Op op, float a, float b = 0) {
    return as_float(eval(op, Type::kFloat, as_bits(a), as_bits(b), 0));
}
bool cmp(Op op, float a, float b) {
    return eval(op, Type::kFloat, as_bits(a), as_bits(b), 0) != 0;
}
int32_t i(Op op, int32_t a, int32_t b = 0) {
    return as_int(eval(op, Type::kInt, as_bits(a), as_bits(b), 0));
}
uint32_t u(Op op, uint32_t a, uint32_t b = 0) {
    return eval(op, Type::kUint, a, b, 0);
}

TEST(Arithmetic, IntegersWrap) {
    EXPECT_EQ(i(Op::kAdd, kIntMax, 1), kIntMin);
    EXPECT_EQ(i(Op::kSub, kIntMin, 1), kIntMax);
    EXPECT_EQ(i(Op::kMul, 65536, 65536), 0);
    EXPECT_EQ(i(Op::kNeg, kIntMin), kIntMin);
    EXPECT_EQ(i(Op::kAbs, kIntMin), kIntMin);
    EXPECT_EQ(u(Op::kSub, 0, 1), 0xffffffffu);
}

TEST(Arithmetic, DivisionTruncatesAndIsTotal) {
    EXPECT_EQ(i(Op::kDiv, -7, 2), -3);
    EXPECT_EQ(i(Op::kMod, -7, 2), -1);
    EXPECT_EQ(i(Op::kMod, 7, -2), 1);
    EXPECT_EQ(i(Op::kDiv, 5, 0), 0);
    EXPECT_EQ(i(Op::kMod, 5, 0), 0);
    EXPECT_EQ(i(Op::kDiv, kIntMin, -1), kIntMin);
    EXPECT_EQ(i(Op::kMod, kIntMin, -1), 0);
    EXPECT_EQ(u(Op::kDiv, 7, 0), 0u);
    EXPECT_EQ(u(Op::kMod, 7, 0), 0u);
    EXPECT_EQ(u(Op::kDiv, 0xfffffffeu, 2), 0x7fffffffu);
}

TEST(Arithmetic, ShiftsTakeFiveBits) {
    EXPECT_EQ(i(Op::kShl, 1, 33), 2);
    EXPECT_EQ(i(Op::kShr, -8, 1), -4);
    EXPECT_EQ(u(Op::kShr, 0x80000000u, 31), 1u);
    EXPECT_EQ(i(Op::kShr, -1, -1), -1);
}

TEST(Arithmetic, FloatComparisonsAreIeee) {
    for (Op op : {Op::kEq, Op::kLt, Op::kLe, Op::kGt, Op::kGe})
        EXPECT_FALSE(cmp(op, kNan, 1));
    EXPECT_TRUE(cmp(Op::kNe, kNan, kNan));
    EXPECT_TRUE(cmp(Op::kEq, 0.0f, -0.0f));
    EXPECT_TRUE(cmp(Op::kGe, 2, 2));
}

TEST(Arithmetic, MinAndMaxGiveTheSecondOnNanAndOnEqual) {
    EXPECT_EQ(f(Op::kMin, kNan, 1), 1);
    EXPECT_TRUE(std::isnan(f(Op::kMin, 1, kNan)));
    EXPECT_EQ(f(Op::kMax, kNan, 1), 1);
    EXPECT_TRUE(std::signbit(f(Op::kMin, 0.0f, -0.0f)));
    EXPECT_FALSE(std::signbit(f(Op::kMin, -0.0f, 0.0f)));
}

TEST(Arithmetic, NegAndAbsAreOnTheSignBit) {
    EXPECT_TRUE(std::signbit(f(Op::kNeg, 0.0f)));
    EXPECT_FALSE(std::signbit(f(Op::kAbs, -0.0f)));
    EXPECT_EQ(eval(Op::kNeg, Type::kFloat, 0x7fc00001u, 0, 0), 0xffc00001u);
}

TEST(Arithmetic, RoundingOfHalves) {
    EXPECT_EQ(f(Op::kRound, 0.5f), 0);
    EXPECT_EQ(f(Op::kRound, 1.5f), 2);
    EXPECT_EQ(f(Op::kRound, 2.5f), 2);
    EXPECT_TRUE(std::signbit(f(Op::kRound, -0.4f)));
    EXPECT_EQ(f(Op::kTrunc, -1.9f), -1);
    EXPECT_EQ(f(Op::kFloor, -1.1f), -2);
    EXPECT_EQ(f(Op::kCeil, 1.1f), 2);
}

TEST(Arithmetic, FloatModTruncates) {
    EXPECT_EQ(f(Op::kMod, -5.5f, 2), -1.5f);
    EXPECT_EQ(f(Op::kMod, 5.5f, -2), 1.5f);
    EXPECT_TRUE(std::isnan(f(Op::kMod, 1, 0)));
}

TEST(Arithmetic, ConversionsSaturate) {
    const auto to = [](Type type, float x) { return eval_convert(Type::kFloat, type, as_bits(x)); };
    EXPECT_EQ(as_int(to(Type::kInt, kNan)), 0);
    EXPECT_EQ(as_int(to(Type::kInt, 3e9f)), kIntMax);
    EXPECT_EQ(as_int(to(Type::kInt, -3e9f)), kIntMin);
    EXPECT_EQ(as_int(to(Type::kInt, -kInfinity)), kIntMin);
    EXPECT_EQ(as_int(to(Type::kInt, -2.9f)), -2);
    EXPECT_EQ(to(Type::kUint, -1.0f), 0u);
    EXPECT_EQ(to(Type::kUint, kNan), 0u);
    EXPECT_EQ(to(Type::kUint, 5e9f), 0xffffffffu);
    EXPECT_EQ(to(Type::kUint, 3e9f), 3000000000u);
    EXPECT_EQ(to(Type::kBool, kNan), 1u);
    EXPECT_EQ(to(Type::kBool, -0.0f), 0u);
    EXPECT_EQ(as_float(eval_convert(Type::kUint, Type::kFloat, 0xffffffffu)), 4294967296.0f);
    EXPECT_EQ(as_float(eval_convert(Type::kInt, Type::kFloat, 0xffffffffu)), -1.0f);
    EXPECT_EQ(as_float(eval_convert(Type::kBool, Type::kFloat, 1)), 1.0f);
}

}  // namespace
}  // namespace openfab::ir
