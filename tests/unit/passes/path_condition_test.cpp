// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/path_condition.h"

#include <gtest/gtest.h>

#include "compiler/interp/evaluate.h"

namespace openfab::passes {

namespace {

using ir::Type;
using ir::ValueId;

TEST(PathConditions, WhatAlwaysHoldsIsFound) {
    PathConditions c;
    EXPECT_EQ(c.either(c.holds(3), c.fails(3)), kAlways);
    EXPECT_EQ(c.both(c.holds(3), c.fails(3)), kNever);
    const Condition a = c.holds(1), b = c.holds(2);
    // a b + a !b + !a
    EXPECT_EQ(c.either(c.either(c.both(a, b), c.both(a, c.fails(2))), c.fails(1)), kAlways);
    EXPECT_EQ(c.both(a, b), c.both(b, a));
    EXPECT_EQ(c.either(a, c.both(a, b)), a);
    EXPECT_EQ(c.both(a, kAlways), a);
    EXPECT_EQ(c.both(a, kNever), kNever);
    EXPECT_EQ(c.tested(c.both(c.holds(7), c.either(b, a))), (std::vector<ValueId>{1, 2, 7}));
}

/// A sum of products of pairs that are far apart doubles its diagram with each.
TEST(PathConditions, WhatGrowsTooBigAlwaysHolds) {
    PathConditions c;
    Condition sum = kNever;
    for (ValueId k = 0; k < 40; ++k)
        sum = c.either(sum, c.both(c.holds(k), c.holds(40 + k)));
    EXPECT_EQ(sum, kAlways);
}

class Inputs : public interp::Environment {
  public:
    uint32_t input(int32_t /*kind*/, int32_t a, int32_t /*b*/) const override {
        return bits >> a & 1u;
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }
    uint32_t bits = 0;
};

TEST(PathConditions, WritesWhatItMeans) {
    PathConditions c;
    const Condition x = c.holds(0), y = c.holds(1), z = c.holds(2);
    const Condition not_x = c.fails(0), not_y = c.fails(1);
    const std::vector<std::pair<Condition, bool (*)(bool, bool, bool)>> cases = {
        {x, [](bool a, bool, bool) { return a; }},
        {not_x, [](bool a, bool, bool) { return !a; }},
        {c.both(x, y), [](bool a, bool b, bool) { return a && b; }},
        {c.both(x, not_y), [](bool a, bool b, bool) { return a && !b; }},
        {c.both(not_x, y), [](bool a, bool b, bool) { return !a && b; }},
        {c.either(not_x, y), [](bool a, bool b, bool) { return !a || b; }},
        {c.either(c.both(x, y), c.both(not_x, z)),
         [](bool a, bool b, bool k) { return a ? b : k; }},
        {c.either(c.both(x, not_y), c.both(y, z)),
         [](bool a, bool b, bool k) { return (a && !b) || (b && k); }},
    };
    for (size_t k = 0; k < cases.size(); ++k) {
        ir::Stage stage;
        ir::Builder b(&stage);
        for (int32_t i = 0; i < 3; ++i)
            b.input(Type::kBool, OPENFAB_ARG_UNIFORM, i, 0);
        const ValueId value = c.write(
            cases[k].first, [](ValueId id) { return id; }, &b);
        stage.outputs = {{"out", OPENFAB_ARG_DEMAND, 0, 0, value}};
        ASSERT_EQ(ir::verify(stage), "");
        Inputs inputs;
        for (inputs.bits = 0; inputs.bits < 8; ++inputs.bits) {
            const bool expected = cases[k].second((inputs.bits & 1u) != 0, (inputs.bits & 2u) != 0,
                                                  (inputs.bits & 4u) != 0);
            EXPECT_EQ(interp::evaluate(stage, inputs)[0] != 0, expected)
                << "case " << k << ", bits " << inputs.bits;
        }
    }
}

}  // namespace

}  // namespace openfab::passes
