// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Steps that move elements of arrays: what kernels come to, beside what the interpreter finds for random
// fablets (tests/exec/array_elements_test.cpp).

#include "compiler/passes/cut_elements.h"

#include <gtest/gtest.h>

#include <functional>

namespace openfab::passes {
namespace {

using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr int32_t kCount = 20;
constexpr int32_t kOther = 100, kIndex = 200, kValue = 201, kRuns = 202;

/// A kernel that reads two arrays, from state 0 and from kOther on, and an index, a value and a condition.
struct Arrays {
    ir::Stage stage;
    ir::Builder b{&stage};
    std::vector<ValueId> first, second;
    ValueId index, value, runs;
    std::vector<Type> states = std::vector<Type>(300, Type::kFloat);

    Arrays() {
        stage.kind = ir::StageKind::kVolumeSegment;
        for (int32_t k = 0; k < kCount; ++k) {
            first.push_back(b.input(Type::kFloat, OPENFAB_ARG_STATE, k, 0));
            second.push_back(b.input(Type::kFloat, OPENFAB_ARG_STATE, kOther + k, 0));
        }
        index = b.input(Type::kInt, OPENFAB_ARG_STATE, kIndex, 0);
        value = b.input(Type::kFloat, OPENFAB_ARG_STATE, kValue, 0);
        runs = b.input(Type::kBool, OPENFAB_ARG_STATE, kRuns, 0);
    }
    ValueId is(int32_t k) {
        const Op op = k == 0 ? Op::kLe : k == kCount - 1 ? Op::kGe : Op::kEq;
        return b.binary(op, index, b.constant(k));
    }
    void write(int32_t from, const std::function<ValueId(int32_t k)>& element) {
        for (int32_t k = 0; k < kCount; ++k)
            stage.outputs.push_back({"out", OPENFAB_ARG_STATE_OUT, from + k, 0, element(k)});
    }
    std::vector<ElementPart> cut() {
        EXPECT_EQ(ir::verify(stage), "");
        std::vector<ElementPart> parts = cut_elements(stage, &states);
        for (const ElementPart& part : parts)
            EXPECT_EQ(ir::verify(part.kernel), "") << ir::dump(part.kernel);
        return parts;
    }
};

size_t at(int32_t k) {
    return static_cast<size_t>(k);
}

TEST(CutElements, AnElementThatGetsAValueIsAStoreUnderItsCondition) {
    Arrays a;
    a.write(0, [&](int32_t k) {
        const ValueId next = a.b.select(a.is(k), a.value, a.first[at(k)]);
        return a.b.select(a.runs, next, a.first[at(k)]);
    });
    const std::vector<ElementPart> parts = a.cut();
    ASSERT_EQ(parts.size(), 1u);
    ASSERT_EQ(parts[0].steps.size(), 1u);
    const openfab_elements& step = parts[0].steps[0];
    EXPECT_EQ(step.kind, OPENFAB_ELEMENTS_STORE);
    EXPECT_EQ(step.first, 0);
    EXPECT_EQ(step.apart, 1);
    EXPECT_EQ(step.count, kCount);
    EXPECT_EQ(a.states[at(step.index)], Type::kInt);
    EXPECT_EQ(a.states[at(step.guard)], Type::kBool);
    EXPECT_EQ(parts[0].kernel.outputs.size(), 3u);  // the index, the value, the condition
}

TEST(CutElements, AnElementThatIsReadIsALoadBeforeWhatNeedsIt) {
    Arrays a;
    ValueId chosen = a.first.back();
    for (int32_t k = kCount - 1; k-- > 0;) {
        const Op op = k == 0 ? Op::kLe : Op::kEq;
        chosen = a.b.select(a.b.binary(op, a.index, a.b.constant(k)), a.first[at(k)], chosen);
    }
    a.stage.outputs.push_back({"out", OPENFAB_ARG_WEIGHT, 0, 0, a.b.unary(Op::kNeg, chosen)});
    const std::vector<ElementPart> parts = a.cut();
    ASSERT_EQ(parts.size(), 2u);
    ASSERT_EQ(parts[0].steps.size(), 1u);
    EXPECT_EQ(parts[0].steps[0].kind, OPENFAB_ELEMENTS_LOAD);
    EXPECT_EQ(parts[0].steps[0].guard, -1);
    EXPECT_EQ(parts[1].kernel.instrs.size(), 2u);  // what was loaded, its negative
    EXPECT_EQ(parts[1].kernel.outputs[0].kind, OPENFAB_ARG_WEIGHT);
}

/// What was stored in the same trip is not in the array yet.
TEST(CutElements, AnElementThatIsReadAfterAStoreIsTheStoredOneOrTheArrays) {
    Arrays a;
    std::vector<ValueId> next;
    for (int32_t k = 0; k < kCount; ++k)
        next.push_back(a.b.select(a.is(k), a.value, a.first[at(k)]));
    ValueId chosen = next.back();
    const ValueId other = a.b.binary(Op::kAdd, a.index, a.b.constant(3));
    for (int32_t k = kCount - 1; k-- > 0;) {
        const Op op = k == 0 ? Op::kLe : Op::kEq;
        chosen = a.b.select(a.b.binary(op, other, a.b.constant(k)), next[at(k)], chosen);
    }
    a.write(0, [&](int32_t k) { return next[at(k)]; });
    a.stage.outputs.push_back({"out", OPENFAB_ARG_STATE_OUT, kValue, 0, chosen});
    const std::vector<ElementPart> parts = a.cut();
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_EQ(parts[0].steps[0].kind, OPENFAB_ELEMENTS_LOAD);
    ASSERT_EQ(parts[1].steps.size(), 1u);
    EXPECT_EQ(parts[1].steps[0].kind, OPENFAB_ELEMENTS_STORE);
    EXPECT_LT(parts[1].kernel.instrs.size(), 20u);
}

TEST(CutElements, WhoCopiesAnArrayComesBeforeWhoWritesIt) {
    Arrays a;
    a.write(0, [&](int32_t k) { return a.b.select(a.is(k), a.value, a.first[at(k)]); });
    a.write(kOther, [&](int32_t k) { return a.b.select(a.runs, a.first[at(k)], a.second[at(k)]); });
    const std::vector<ElementPart> parts = a.cut();
    ASSERT_EQ(parts.size(), 1u);
    ASSERT_EQ(parts[0].steps.size(), 2u);
    EXPECT_EQ(parts[0].steps[0].kind, OPENFAB_ELEMENTS_COPY);
    EXPECT_EQ(parts[0].steps[0].first, kOther);
    EXPECT_EQ(parts[0].steps[0].value, 0);
    EXPECT_EQ(parts[0].steps[1].kind, OPENFAB_ELEMENTS_STORE);
}

TEST(CutElements, ArraysThatChangePlacesStayInTheKernel) {
    Arrays a;
    a.write(0, [&](int32_t k) { return a.second[at(k)]; });
    a.write(kOther, [&](int32_t k) { return a.first[at(k)]; });
    const std::vector<ElementPart> parts = a.cut();
    ASSERT_EQ(parts.size(), 1u);
    // One of them: then it has read the other, which may be copied.
    EXPECT_EQ(parts[0].kernel.outputs.size() + at(kCount) * parts[0].steps.size(), 2 * at(kCount));
    EXPECT_GE(parts[0].kernel.outputs.size(), at(kCount));
}

TEST(CutElements, ComponentsOfStructsAreArraysApart) {
    Arrays a;
    for (int32_t k = 0; k < kCount / 2; ++k) {
        // Elements of two floats each.
        const ValueId here = a.b.binary(Op::kEq, a.index, a.b.constant(k));
        a.stage.outputs.push_back(
            {"x", OPENFAB_ARG_STATE_OUT, 2 * k, 0, a.b.select(here, a.value, a.first[at(2 * k)])});
        a.stage.outputs.push_back(
            {"y", OPENFAB_ARG_STATE_OUT, 2 * k + 1, 0, a.first[at(2 * k + 1)]});
    }
    // Ten elements are chosen one by one.
    EXPECT_TRUE(a.cut()[0].steps.empty());
    Arrays many;
    std::vector<ValueId> more;
    for (int32_t k = 0; k < 4 * kCount; ++k)
        more.push_back(many.b.input(Type::kFloat, OPENFAB_ARG_STATE, k, 0));
    for (int32_t k = 0; k < 2 * kCount; ++k) {
        const ValueId here = many.b.binary(Op::kEq, many.index, many.b.constant(k));
        many.stage.outputs.push_back({"x", OPENFAB_ARG_STATE_OUT, 2 * k, 0,
                                      many.b.select(here, many.value, more[at(2 * k)])});
        many.stage.outputs.push_back(
            {"y", OPENFAB_ARG_STATE_OUT, 2 * k + 1, 0, many.b.constant(0.0f)});
    }
    const std::vector<ElementPart> parts = many.cut();
    ASSERT_EQ(parts[0].steps.size(), 2u);
    EXPECT_EQ(parts[0].steps[0].apart, 2);
    EXPECT_EQ(parts[0].steps[0].kind, OPENFAB_ELEMENTS_STORE);
    EXPECT_GE(parts[0].steps[0].guard, 0);  // an index beyond names none here
    EXPECT_EQ(parts[0].steps[1].kind, OPENFAB_ELEMENTS_FILL);
    EXPECT_EQ(parts[0].steps[1].first, 1);
}

}  // namespace
}  // namespace openfab::passes
