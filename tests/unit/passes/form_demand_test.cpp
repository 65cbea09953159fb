// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_demand.h"

#include <gtest/gtest.h>

#include "compiler/passes/pipeline.h"

namespace openfab::passes {

namespace {

using ir::Op;
using ir::Type;
using ir::ValueId;

/// A stage under construction; x and y are what a voxel's place says, d is what it must ask for.
class FormDemand : public ::testing::Test {
  protected:
    FormDemand() { stage.kind = ir::StageKind::kVolume; }

    ValueId less(ValueId a, float limit) { return b.emit(Op::kLt, {a, b.constant(limit)}); }
    void output(ValueId value) {
        const auto slot = static_cast<int32_t>(stage.outputs.size());
        stage.outputs.push_back({"w", OPENFAB_ARG_WEIGHT, slot, 0, value});
    }
    /// The demand stage's text without the output's name, or "" where there is none.
    std::string demand() const {
        const ir::Stage out = form_demand(stage);
        EXPECT_EQ(ir::verify(out), "");
        return out.outputs.empty() ? "" : ir::print(out);
    }

    ir::Stage stage;
    ir::Builder b{&stage};
    ValueId x = b.input(Type::kFloat, ir::kVoxelCoord, 0, 0);
    ValueId y = b.input(Type::kFloat, ir::kVoxelCoord, 1, 0);
    ValueId d = b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    ValueId zero = b.constant(0.0f);
};

constexpr const char* kXBelow1 =
    "  stage volume_demand\n"
    "    %0 = input float voxel_coord 0 0\n"
    "    %1 = const float 1\n"
    "    %2 = lt bool %0 %1\n"
    "    output demand demand 0 0 %2\n";

TEST_F(FormDemand, FollowsTheTakenSideOfASelect) {
    output(b.select(less(x, 1), d, zero));
    EXPECT_EQ(demand(), kXBelow1);
}

TEST_F(FormDemand, NegatesForTheOtherSide) {
    output(b.select(less(x, 1), zero, d));
    EXPECT_EQ(demand(),
              "  stage volume_demand\n"
              "    %0 = input float voxel_coord 0 0\n"
              "    %1 = const float 1\n"
              "    %2 = lt bool %0 %1\n"
              "    %3 = not bool %2\n"
              "    output demand demand 0 0 %3\n");
}

TEST_F(FormDemand, AddsUpOverOutputsAndInputs) {
    const ValueId n = b.input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, 0);
    const ValueId a = less(x, 1), c = less(y, 1);
    output(b.select(a, d, zero));
    output(b.select(c, n, zero));
    const ir::Stage out = form_demand(stage);
    ASSERT_EQ(out.outputs.size(), 1u);
    EXPECT_EQ(out.instrs[out.outputs[0].value].op, Op::kOr);
    output(b.select(a, zero, n));
    EXPECT_EQ(demand(), "") << "a or not a";
}

TEST_F(FormDemand, IsEmptyWhereAllAskOrNoneCan) {
    output(b.select(less(x, 1), y, zero));
    EXPECT_EQ(demand(), "") << "nothing to ask for";
    output(d);
    EXPECT_EQ(demand(), "") << "all ask";
}

TEST_F(FormDemand, AConditionThatAsksIsNotFollowed) {
    output(b.select(less(d, 1), d, zero));
    EXPECT_EQ(demand(), "");
}

TEST_F(FormDemand, AndAndOrStopWhereTheOtherSideDecides) {
    const ValueId one = b.constant(1.0f);
    output(b.select(b.emit(Op::kAnd, {less(x, 1), less(d, -1)}), one, zero));
    EXPECT_EQ(demand(), kXBelow1);
    stage.outputs.clear();
    const ValueId far = b.emit(Op::kNot, {less(x, 1)});
    output(b.select(b.emit(Op::kOr, {less(d, -1), far}), one, zero));
    EXPECT_EQ(demand(), kXBelow1);
}

TEST_F(FormDemand, AConditionThatAsksInPartIsFollowedAsFarAsItIsKnown) {
    const ValueId gate = b.emit(Op::kAnd, {less(x, 1), less(d, -1)});
    output(b.select(gate, d, zero));
    EXPECT_EQ(demand(), kXBelow1);
    // Where the gate is shut for another reason than x, the other side is taken.
    output(b.select(gate, zero, d));
    EXPECT_EQ(demand(), "");
}

TEST_F(FormDemand, ALookUpsGuardCounts) {
    ir::Instr sample;
    sample.op = Op::kSample;
    sample.args = {less(x, 1), d, d, zero};
    output(b.append(std::move(sample)));
    EXPECT_EQ(demand(), kXBelow1);
}

TEST_F(FormDemand, ALookUpIsNoCondition) {
    ir::Instr sample;
    sample.op = Op::kSample;
    sample.args = {b.constant(true), x, y, zero};
    output(b.select(less(b.append(std::move(sample)), 0.5f), d, zero));
    EXPECT_EQ(demand(), "");
}

TEST_F(FormDemand, LoopsQueriesAndPrintsAskWhereTheirGuardHolds) {
    ir::Instr print;
    print.op = Op::kPrint;
    print.type = Type::kBool;
    print.args = {less(x, 1), d};
    stage.prints = {{"%f", false, {}, "", 0, 0}};
    b.append(std::move(print));
    output(zero);
    EXPECT_EQ(demand(), kXBelow1);

    stage.instrs.pop_back();
    stage.prints.clear();
    const ValueId query = b.query(-1, less(x, 1), {d, x, y});
    stage.outputs.clear();
    output(b.query_result(query, Type::kFloat, OPENFAB_QUERY_DISTANCE, 0, 0));
    EXPECT_EQ(demand(), kXBelow1);
}

/// The value that no trip has changed is seen where the guard is shut.
TEST_F(FormDemand, ALoopsFirstValueIsNeededWithItsResult) {
    const ValueId loop = b.loop(less(x, 1));
    const ValueId variable = b.loop_var(loop, 0, zero);
    const ValueId next = b.emit(Op::kAdd, {variable, d});
    const ValueId end = b.loop_end(loop, less(next, -5), {next});
    output(b.loop_result(end, 0));
    EXPECT_EQ(demand(), kXBelow1);
    stage.instrs[variable].args[1] = d;
    EXPECT_EQ(demand(), "");
}

TEST_F(FormDemand, APassThatCanBeSwitchedOff) {
    ir::Fablet fablet;
    output(b.select(less(x, 1), d, zero));
    fablet.volume = stage;
    EXPECT_EQ(run_pipeline(fablet).stages.volume_demand.outputs.size(), 1u);
    PipelineOptions options;
    options.disabled = {"form_demand"};
    EXPECT_TRUE(run_pipeline(fablet, options).stages.volume_demand.outputs.empty());
}

}  // namespace

}  // namespace openfab::passes
