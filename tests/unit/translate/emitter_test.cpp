// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/emitter.h"

#include <gtest/gtest.h>

#include <random>

#include "compiler/interp/evaluate.h"

namespace openfab::check {
namespace {

using ir::Op;
using ir::ValueId;

/// Input a is bit a of `bits`.
class Bits : public interp::Environment {
  public:
    uint32_t bits = 0;
    uint32_t input(int32_t, int32_t a, int32_t) const override { return bits >> a & 1u; }
    interp::TextureView texture(int32_t) const override { return {}; }
};

TEST(Emitter, FoldingKeepsEveryTruthTable) {
    constexpr int kInputs = 3;
    std::mt19937 random(11);
    for (int round = 0; round < 200; ++round) {
        ir::Stage stage;
        translate::Emitter emit(&stage);
        std::vector<ValueId> values = {emit.constant(false), emit.constant(true)};
        std::vector<uint32_t> tables = {0x00, 0xff};  // bit k: the value under assignment k
        for (int a = 0; a < kInputs; ++a) {
            values.push_back(emit.input(ir::Type::kBool, OPENFAB_ARG_UNIFORM, a, 0));
            uint32_t table = 0;
            for (uint32_t k = 0; k < 8; ++k)
                table |= (k >> a & 1u) << k;
            tables.push_back(table);
        }
        for (int i = 0; i < 40; ++i) {
            const size_t x = random() % values.size();
            const size_t y = random() % values.size();
            const size_t z = random() % values.size();
            switch (random() % 4) {
                case 0:
                    values.push_back(emit.logical_and(values[x], values[y]));
                    tables.push_back(tables[x] & tables[y]);
                    break;
                case 1:
                    values.push_back(emit.logical_or(values[x], values[y]));
                    tables.push_back(tables[x] | tables[y]);
                    break;
                case 2:
                    values.push_back(emit.logical_not(values[x]));
                    tables.push_back(~tables[x] & 0xffu);
                    break;
                default:
                    values.push_back(emit.select(values[x], values[y], values[z]));
                    tables.push_back((tables[x] & tables[y]) | (~tables[x] & tables[z] & 0xffu));
            }
        }
        ASSERT_EQ(ir::verify(stage), "");
        for (uint32_t k = 0; k < 8; ++k) {
            Bits environment;
            environment.bits = k;
            const std::vector<uint32_t> bits = interp::evaluate_all(stage, environment);
            for (size_t i = 0; i < values.size(); ++i) {
                ASSERT_EQ(bits[values[i]], tables[i] >> k & 1u)
                    << "round " << round << " value " << i;
            }
        }
    }
}

TEST(Emitter, ConstantsFoldAsTheInterpreterEvaluates) {
    ir::Stage stage;
    translate::Emitter emit(&stage);
    const auto folded = [&](ValueId value) {
        EXPECT_TRUE(emit.is_constant(value));
        return emit.instr(value).bits;
    };
    const ValueId seven = emit.constant(ir::Type::kInt, 7);
    const ValueId zero = emit.constant(ir::Type::kInt, 0);
    EXPECT_EQ(folded(emit.binary(Op::kDiv, seven, zero)), 0u);
    EXPECT_EQ(folded(emit.binary(Op::kGt, seven, zero)), 1u);
    EXPECT_EQ(folded(emit.unary(Op::kNeg, emit.constant(0.0f))), 0x80000000u);
    EXPECT_EQ(folded(emit.convert(seven, ir::Type::kFloat)), 0x40e00000u);
    EXPECT_EQ(folded(emit.select(emit.constant(false), seven, zero)), 0u);
}

TEST(Emitter, FloatsThatLookAlikeStayApart) {
    ir::Stage stage;
    translate::Emitter emit(&stage);
    const ValueId x = emit.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    EXPECT_NE(emit.constant(0.0f), emit.constant(-0.0f));
    // x + 0 and x * 1 are not x for -0 and NaN; x == x is not true.
    EXPECT_NE(emit.binary(Op::kAdd, x, emit.constant(0.0f)), x);
    EXPECT_FALSE(emit.is_constant(emit.binary(Op::kEq, x, x)));
    EXPECT_FALSE(emit.is_constant(emit.binary(Op::kSub, x, x)));
}

TEST(Emitter, TheSameInstructionIsMadeOnce) {
    ir::Stage stage;
    translate::Emitter emit(&stage);
    const ValueId x = emit.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    EXPECT_EQ(emit.binary(Op::kMul, x, x), emit.binary(Op::kMul, x, x));
    EXPECT_EQ(emit.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0), x);
    const ValueId yes = emit.constant(true);
    const ValueId no = emit.binary(Op::kLt, x, x);
    // Lookups with different guards are different.
    EXPECT_NE(emit.sample(0, 0, {yes, x, x, x}), emit.sample(0, 0, {no, x, x, x}));
    EXPECT_NE(emit.sample(0, 0, {yes, x, x, x}), emit.sample(0, 1, {yes, x, x, x}));
}

TEST(Emitter, ImpliesSeesThroughConjunctions) {
    ir::Stage stage;
    translate::Emitter emit(&stage);
    const ValueId a = emit.input(ir::Type::kBool, OPENFAB_ARG_UNIFORM, 0, 0);
    const ValueId b = emit.input(ir::Type::kBool, OPENFAB_ARG_UNIFORM, 1, 0);
    const ValueId both = emit.logical_and(a, b);
    EXPECT_TRUE(emit.implies(both, a));
    EXPECT_TRUE(emit.implies(emit.logical_and(both, emit.logical_not(a)), b));
    EXPECT_FALSE(emit.implies(a, both));
    EXPECT_FALSE(emit.implies(emit.logical_or(a, b), a));
}

}  // namespace
}  // namespace openfab::check
