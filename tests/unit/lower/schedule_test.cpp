// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Schedule files: what is accepted, and the locations and messages of errors ([schedule-illegal]).

#include "compiler/lower/schedule.h"

#include <gtest/gtest.h>

#include "compiler/lower/compile.h"

namespace openfab::lower {

namespace {

ScheduleFault parse_fault(const char* text) {
    auto parsed = parse_schedule("slab.sched", text);
    if (auto* fault = std::get_if<ScheduleFault>(&parsed)) return *fault;
    ADD_FAILURE() << "accepted: " << text;
    return {};
}

/// A volume stage of one slot: the distance.
ir::Stage distance_stage() {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder b(&stage);
    const ir::ValueId d = b.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    stage.outputs.push_back({"slot", OPENFAB_ARG_WEIGHT, 0, 0, d});
    return stage;
}

ScheduleFault apply_fault(const char* text) {
    auto parsed = parse_schedule("slab.sched", text);
    if (auto* fault = std::get_if<ScheduleFault>(&parsed)) return *fault;
    const ir::Stage stage = distance_stage();
    const KernelRequest request{&stage, nullptr, "kernel", OPENFAB_ISA_SSE41,
                                &std::get<Schedule>(parsed)};
    auto emitted = emit_text(request, TextForm::kStmt);
    if (auto* fault = std::get_if<Fault>(&emitted)) {
        EXPECT_EQ(fault->internal, "");
        if (fault->schedule) return *fault->schedule;
    }
    ADD_FAILURE() << "accepted: " << text;
    return {};
}

TEST(Schedule, ParsesChainsCommentsAndBlankLines) {
    const std::string text =
        "# comment\n\n  weights.vectorize( z ) . parallel(n)  # more\na_*.compute_root()";
    auto parsed = parse_schedule("s", text);
    ASSERT_TRUE(std::holds_alternative<Schedule>(parsed));
    const Schedule& schedule = std::get<Schedule>(parsed);
    ASSERT_EQ(schedule.lines.size(), 2u);
    EXPECT_EQ(schedule.lines[0].line, 3);
    ASSERT_EQ(schedule.lines[0].directives.size(), 2u);
    EXPECT_EQ(schedule.lines[0].directives[1].name.text, "parallel");
    EXPECT_EQ(schedule.lines[1].func.text, "a_*");
}

TEST(Schedule, NamesTheDirectiveThatWasMeant) {
    const ScheduleFault fault = parse_fault("weights.vectorize(z)\nweights.vektorize(x)\n");
    EXPECT_EQ(fault.line, 2);
    EXPECT_EQ(fault.column, 9);
    EXPECT_EQ(fault.length, 9);
    EXPECT_EQ(fault.offset, 29u);
    EXPECT_EQ(fault.id, "schedule-illegal");
    EXPECT_EQ(fault.help, "did you mean `vectorize`?");
}

TEST(Schedule, RefusesWhatCouldChangeResults) {
    for (const char* text : {"weights.atomic()", "weights.rfactor(z)", "weights.memoize()",
                             "weights.allow_race_conditions()"}) {
        EXPECT_NE(parse_fault(text).message.find("is not allowed"), std::string::npos) << text;
    }
}

TEST(Schedule, ReportsFormMistakesAtTheirPlace) {
    EXPECT_EQ(parse_fault("weights.split(z, zo, zi)").column, 9);
    EXPECT_EQ(parse_fault("weights.vectorize z").column, 19);
    EXPECT_EQ(parse_fault("weights.vectorize(z").column, 20);
    EXPECT_EQ(parse_fault("weights").column, 1);
    EXPECT_EQ(parse_fault("weights.").column, 9);
    EXPECT_EQ(parse_fault("\n\n.vectorize(z)").line, 3);
}

TEST(Schedule, ReportsNamesThatTheKernelLacks) {
    EXPECT_EQ(apply_fault("weigths.vectorize(z)").help, "did you mean `weights`?");
    const ScheduleFault fault = apply_fault("weights.vectorize(w)");
    EXPECT_EQ(fault.column, 19);
    EXPECT_EQ(fault.message, "`weights` has no var `w`");
    EXPECT_EQ(apply_fault("weights.split(column, z, ci, 2)").column, 23);
    EXPECT_EQ(apply_fault("weights.vectorize(z, 0)").column, 22);
    EXPECT_EQ(apply_fault("slab.compute_root()").column, 6);
}

TEST(Schedule, MapsWhatHalideRefusesToTheLine) {
    const ScheduleFault fault =
        apply_fault("weights.vectorize(z)\n\nslab.unroll(z).vectorize(column)\n");
    EXPECT_EQ(fault.line, 3);
    // In our terms, without Halide's own names and text.
    EXPECT_EQ(fault.help.find("Error"), std::string::npos);
    EXPECT_EQ(fault.help.find('$'), std::string::npos);
}

TEST(Schedule, EveryBuiltInScheduleApplies) {
    const ir::Stage stage = distance_stage();
    for (const openfab_isa isa : {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2}) {
        const KernelRequest request{&stage, nullptr, "kernel", isa, nullptr};
        EXPECT_TRUE(std::holds_alternative<std::string>(emit_text(request, TextForm::kStmt)));
    }
}

}  // namespace

}  // namespace openfab::lower
