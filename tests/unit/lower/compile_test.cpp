// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/compile.h"

#include <gtest/gtest.h>

namespace openfab::lower {

namespace {

/// A volume stage whose only amount is an input.
ir::Stage stage_of(int32_t input) {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder b(&stage);
    const ir::ValueId d = b.input(ir::Type::kFloat, input, 0, 0);
    stage.outputs.push_back({"slot", OPENFAB_ARG_WEIGHT, 0, 0, d});
    return stage;
}

TEST(EmitText, EveryPipelineHasABuiltInSchedule) {
    for (const std::string& name : pipeline_names()) {
        for (const std::string& target : schedule::targets())
            EXPECT_NE(schedule::default_file(name, target), nullptr) << name;
    }
}

// What `--as schedule` prints is a file that gives the same kernel again, for whoever has it.
TEST(EmitText, TheScheduleInForceIsAFile) {
    const ir::Stage stage = stage_of(OPENFAB_ARG_DISTANCE);
    for (const openfab_isa isa : {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2, OPENFAB_ISA_AVX512}) {
        const KernelRequest usual{&stage, {}, "kernel", isa, nullptr};
        const auto text = emit_text(usual, TextForm::kSchedule);
        ASSERT_TRUE(std::holds_alternative<std::string>(text));
        const auto again = schedule::read({"again.sched", std::get<std::string>(text)});
        ASSERT_TRUE(std::holds_alternative<schedule::Schedule>(again));
        const auto& mine = std::get<schedule::Schedule>(again);
        EXPECT_EQ(schedule::text_of(mine),
                  schedule::text_of(schedule::default_schedule("slab", isa_name(isa))));
        const auto loops = emit_text(usual, TextForm::kLoops);
        ASSERT_TRUE(std::holds_alternative<std::string>(loops));
        EXPECT_EQ(
            std::get<std::string>(emit_text({&stage, {}, "kernel", isa, &mine}, TextForm::kLoops)),
            std::get<std::string>(loops));
    }
}

std::string fault_of(const ir::Stage& stage, const std::string& text) {
    const auto parsed = schedule::read({"slab.sched", text});
    if (const auto* fault = std::get_if<schedule::Fault>(&parsed)) return fault->message;
    const auto made = compile_object({&stage,
                                      {},
                                      "kernel",
                                      OPENFAB_ISA_SSE41,
                                      &std::get<schedule::Schedule>(parsed)});
    const auto* fault = std::get_if<Fault>(&made);
    if (fault == nullptr) return "none";
    return fault->schedule ? fault->schedule->message : fault->internal;
}

// Halide would begin such loops before the first column, or the first voxel of one.
TEST(CompileObject, RefusesLoopsWhoseStepsOverlap) {
    // It reads the list of columns.
    const ir::Stage stage = stage_of(ir::kVoxelCoord);
    const auto overlap = [](const std::string& func) {
        return "a loop between where `" + func +
               "` is stored and where it is computed has steps that overlap in what they need of it";
    };
    const auto by_columns = [&](const std::string& inner, const std::string& outer,
                                const std::string& stored) {
        return fault_of(stage, "slab.split(z, zo, zi, 8).split(column, co, ci, 2)\n"
                               "slab.reorder(" + inner + ", zo, zi, " + outer + ")\n"
                               "unusable.compute_at(slab, " + outer + ")\n"
                               "remainder.compute_at(slab, zo)" + stored + "\n"
                               "rounded.compute_at(slab, " + outer + ")\n"
                               "whole.compute_at(rounded, channel)\n"
                               "sums.compute_at(rounded, channel)\n"
                               "scaled.compute_at(rounded, column)\n"
                               "total.compute_at(scaled, slot)\n"
                               "amounts.compute_at(slab, " + outer + ")\n"
                               "weights.compute_at(amounts, column)\n");
    };
    EXPECT_EQ(by_columns("co", "ci", ".store_root()"), overlap("remainder"));
    EXPECT_EQ(by_columns("co", "ci", ""), "none");
    // The parts of a split in their order do not.
    EXPECT_EQ(by_columns("ci", "co", ".store_root()"), "none");
    const auto by_voxels = [&](const std::string& order, const std::string& at,
                               const std::string& stored) {
        std::string text = "slab.split(z, zo, zi, 4).reorder(column, " + order + ")\n";
        for (const char* func :
             {"unusable", "remainder", "rounded", "whole", "sums", "scaled", "total", "amounts"})
            text += std::string(func) + ".compute_at(slab, " + at + ")\n";
        return fault_of(stage, text + stored);
    };
    EXPECT_EQ(by_voxels("zo, zi", "zi", "rounded.store_root()\n"), overlap("rounded"));
    EXPECT_EQ(by_voxels("zo, zi", "zi", ""), "none");
    EXPECT_EQ(by_voxels("zi, zo", "zo", "rounded.store_root()\n"), "none");
}

}  // namespace

}  // namespace openfab::lower
