// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/compile.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "abi/kernel_call.h"
#include "tests/support/process/process.h"

namespace openfab::lower {

namespace {

ir::Stage distance_stage() {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder b(&stage);
    const ir::ValueId d = b.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    stage.outputs.push_back({"slot", OPENFAB_ARG_WEIGHT, 0, 0, d});
    return stage;
}

// The words of a linker or of the system, and what the user can do.
TEST(Remedies, NameWhatLetsOneGoOn) {
    const testing::ScratchFolder cache;
    ::setenv("OPENFAB_CACHE", cache.path().c_str(), 1);
    const std::string full = "/usr/bin/ld: final link failed: No space left on device";
    const std::string kept = remedy_of(full, cache / "prints");
    EXPECT_NE(kept.find(cache.path().string()), std::string::npos) << kept;
    EXPECT_NE(kept.find("OPENFAB_CACHE"), std::string::npos) << kept;
    const std::string output = remedy_of(full, "/somewhere");
    EXPECT_NE(output.find("`/somewhere`"), std::string::npos) << output;
    EXPECT_EQ(output.find("OPENFAB_CACHE"), std::string::npos) << output;
    EXPECT_NE(remedy_of(full).find("TMPDIR"), std::string::npos);
    EXPECT_NE(remedy_of("File too large").find("ulimit -f"), std::string::npos);
    EXPECT_EQ(remedy_of("undefined reference to `f`"), "");
}

TEST(EmitText, EveryPipelineHasABuiltInSchedule) {
    for (const std::string& name : pipeline_names()) {
        for (const std::string& target : schedule::targets())
            EXPECT_NE(schedule::default_file(name, target), nullptr) << name;
    }
}

// What `--as schedule` prints is a file that gives the same kernel again, for whoever has it.
TEST(EmitText, TheScheduleInForceIsAFile) {
    const ir::Stage stage = distance_stage();
    for (const openfab_isa isa : {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2, OPENFAB_ISA_AVX512}) {
        const KernelRequest usual{&stage, {}, "kernel", isa, nullptr};
        const auto text = emit_text(usual, TextForm::kSchedule);
        ASSERT_TRUE(std::holds_alternative<std::string>(text));
        const auto again = schedule::read({"again.sched", std::get<std::string>(text)});
        ASSERT_TRUE(std::holds_alternative<schedule::Schedule>(again));
        const auto& mine = std::get<schedule::Schedule>(again);
        EXPECT_EQ(schedule::text_of(mine),
                  schedule::text_of(schedule::default_schedule("slab", abi::isa_name(isa))));
        const auto loops = emit_text(usual, TextForm::kLoops);
        ASSERT_TRUE(std::holds_alternative<std::string>(loops));
        EXPECT_EQ(
            std::get<std::string>(emit_text({&stage, {}, "kernel", isa, &mine}, TextForm::kLoops)),
            std::get<std::string>(loops));
    }
}

// What is computed in an unrolled loop is written out with it.
TEST(EmitText, LoopsThatAreWrittenOutAreLimited) {
    const ir::Stage stage = distance_stage();
    const auto loops = [&](int copies) {
        const auto parsed = schedule::read({"slab.sched", fmt::format(R"(
slab.unroll(column, {})
rounded.compute_at(slab, column_unroll)
whole.compute_at(slab, column_unroll)
remainder.compute_at(slab, column_unroll)
sums.compute_at(slab, column_unroll)
)",
                                                                      copies)});
        const auto text = emit_text(
            {&stage, {}, "kernel", OPENFAB_ISA_SSE41, &std::get<schedule::Schedule>(parsed)},
            TextForm::kStmt);
        const auto* fault = std::get_if<Fault>(&text);
        if (fault == nullptr) return std::string("written");
        const schedule::Fault& what = *fault->schedule;
        return fmt::format("{}:{}: {}", what.line, what.column, what.message);
    };
    EXPECT_EQ(loops(4), "written");
    EXPECT_EQ(loops(20),
              "6:6: this schedule writes out 377 loops, most of them for `sums`; the limit is 256");
}

TEST(EmitText, OperationsThatAreWrittenOutAreLimited) {
    ir::Stage stage = distance_stage();
    ir::Builder b(&stage);
    ir::ValueId sum = stage.outputs[0].value;
    for (int k = 0; k < 1000; ++k)
        sum = b.binary(ir::Op::kAdd, b.binary(ir::Op::kMul, sum, sum), sum);
    stage.outputs[0].value = sum;
    const auto written = [&](const std::string& lines) {
        const auto parsed = schedule::read({"slab.sched", lines});
        const auto text = emit_text(
            {&stage, {}, "kernel", OPENFAB_ISA_SSE41, &std::get<schedule::Schedule>(parsed)},
            TextForm::kLoops);
        const auto* fault = std::get_if<Fault>(&text);
        return fault == nullptr ? "written" : fault->schedule->message;
    };
    EXPECT_EQ(written("weights.compute_root().unroll(z, 2)"), "written");
    // Of 64 columns the lowered code is counted; more Halide is not asked to write out.
    for (const std::string lines :
         {"weights.compute_root().unroll(column, 64).unroll(z, 2)",
          "include \"slab.sched\"\nweights.unroll(column)\nslab.unroll(batch, 128)",
          "include \"slab.sched\"\nweights.unroll(column, 16)\nslab.unroll(batch, 99)"}) {
        EXPECT_NE(
            written(lines).find("operations, most of them for `weights`; the limit is 400000"),
            std::string::npos)
            << lines << ": " << written(lines);
    }
}

// Halide 14 drops all stores behind an update whose last vector is masked, and mixes up lanes.
TEST(EmitText, VectorsAreWhole) {
    const ir::Stage stage = distance_stage();
    const auto loops = [&](const std::string& update, const std::string& lanes) {
        const auto parsed = schedule::read({"slab.sched",
                                            "slab.split(column, pair, member, 2)\n"
                                            "remainder.compute_at(slab, pair)\n"
                                            "remainder" +
                                                update + ".vectorize(" + lanes + ")\n"});
        const auto text = emit_text(
            {&stage, {}, "kernel", OPENFAB_ISA_SSE41, &std::get<schedule::Schedule>(parsed)},
            TextForm::kStmt);
        const auto* fault = std::get_if<Fault>(&text);
        return fault == nullptr ? "stored" : fault->schedule->message;
    };
    for (const std::string update : {"", ".update()"}) {
        for (const std::string lanes : {"column, 3", "column, 4", "z, 3", "z, 16"}) {
            EXPECT_EQ(loops(update, lanes),
                      "where `remainder` is computed, it is not certain that vectors of " +
                          lanes.substr(lanes.find(' ') + 1) + " fill all that is needed at a time");
        }
        for (const std::string lanes : {"column, 2", "z, 4", "z, 8", "z"})
            EXPECT_EQ(loops(update, lanes), "stored") << update << lanes;
    }
    EXPECT_NE(loops(".split(z, zo, zi, 3).fuse(zo, column, both)", "zi"), "stored");
}

// Masks of more lanes than a vector has are taken apart and joined again by LLVM, which takes a time
// that grows faster than the interval form is long.
TEST(EmitText, IntervalFormsHaveVectorsOfTheTarget) {
    const auto loops = [](int outputs, openfab_isa isa) {
        ir::Stage stage;
        stage.kind = ir::StageKind::kVolumeBounds;
        ir::Builder b(&stage);
        for (int32_t k = 0; k < outputs; ++k) {
            const ir::ValueId lo = b.input(ir::Type::kFloat, OPENFAB_ARG_UNIFORM, k, 0);
            stage.outputs.push_back({"lo", OPENFAB_ARG_WEIGHT_LO, k / 2, 0, lo});
        }
        return std::get<std::string>(
            emit_text({&stage, {}, "kernel", isa, nullptr}, TextForm::kLoops));
    };
    for (const int outputs : {2, 40}) {
        const std::string narrow = loops(outputs, OPENFAB_ISA_SSE41);
        EXPECT_NE(narrow.find("vectorized quad"), std::string::npos) << narrow;
        EXPECT_EQ(loops(outputs, OPENFAB_ISA_AVX2).find("quad"), std::string::npos);
    }
}

TEST(EmitText, MemoryIsTakenWhereTheScheduleSays) {
    const ir::Stage stage = distance_stage();
    // Returns whether the memory of `weights` is taken before the loop over batches.
    const auto taken_outside = [&](const std::string& stored) {
        std::string text = "slab.split(column, batch, member, 64)\n";
        for (const char* func : {"unusable", "remainder", "rounded", "whole", "sums", "scaled",
                                 "total", "amounts", "weights"})
            text += std::string(func) + ".compute_at(slab, batch)\n";
        const auto parsed =
            schedule::read({"slab.sched", text + "weights" + stored + ".store_in(heap)\n"});
        const auto stmt = emit_text(
            {&stage, {}, "kernel", OPENFAB_ISA_SSE41, &std::get<schedule::Schedule>(parsed)},
            TextForm::kStmt);
        const std::string& code = std::get<std::string>(stmt);
        const size_t memory = code.find("allocate weights");
        const size_t loop = code.find(".s0.column.batch, ");
        EXPECT_NE(memory, std::string::npos);
        EXPECT_NE(loop, std::string::npos);
        return memory < loop;
    };
    EXPECT_FALSE(taken_outside(""));
    EXPECT_TRUE(taken_outside(".store_root()"));
}

}  // namespace

}  // namespace openfab::lower
