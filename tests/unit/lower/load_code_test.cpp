// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The loader of kernels: what it loads runs, and what is damaged is refused, not run.

#include "compiler/lower/code/load_code.h"

#include <HalideRuntime.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "compiler/lower/code/compile.h"

namespace openfab::lower {
namespace {

const std::string kFunction = "openfab_test";

/// derived(0) = input uniform 0 * 3: small, and it reads a constant.
std::string object_of_triple() {
    ir::Stage stage;
    stage.kind = ir::StageKind::kDerived;
    ir::Builder builder(&stage);
    const ir::ValueId in = builder.input(ir::Type::kFloat, OPENFAB_ARG_UNIFORM, 0, 0);
    const ir::ValueId triple = builder.binary(ir::Op::kMul, in, builder.constant(3.0f));
    stage.outputs.push_back({"derived", OPENFAB_ARG_DERIVED, 0, 0, triple});
    auto made = compile_object({&stage, {}, kFunction, OPENFAB_ISA_SSE41, nullptr});
    const auto* fault = std::get_if<Fault>(&made);
    EXPECT_EQ(fault, nullptr) << fault->trouble;
    return fault == nullptr ? std::get<CompiledKernel>(made).code : "";
}

float call(openfab_kernel_fn function, float in) {
    float out = 0;
    halide_dimension_t dimension(0, 1, 1);
    halide_buffer_t buffer{};
    buffer.host = reinterpret_cast<uint8_t*>(&out);
    buffer.type = {halide_type_float, 32, 1};
    buffer.dimensions = 1;
    buffer.dim = &dimension;
    void* args[] = {&in, &buffer};
    EXPECT_EQ(function(args), 0);
    return out;
}

TEST(LoadCode, RunsWhatItLoads) {
    const auto loaded = load_code(object_of_triple(), kFunction + "_argv");
    ASSERT_TRUE(std::holds_alternative<LoadedKernel>(loaded)) << std::get<std::string>(loaded);
    EXPECT_EQ(call(std::get<LoadedKernel>(loaded).function, 14), 42);
}

/// A parallel loop's body is a function of the object whose address is loaded.
TEST(LoadCode, LoadsParallelLoops) {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder builder(&stage);
    const ir::ValueId in = builder.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    stage.outputs.push_back({"weight", OPENFAB_ARG_WEIGHT, 0, 0, in});
    const auto parsed = schedule::read({"slab.sched", "slab.parallel(column)\n"});
    for (const openfab_isa isa : {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2}) {
        const auto made =
            compile_object({&stage, {}, kFunction, isa, &std::get<schedule::Schedule>(parsed)});
        ASSERT_TRUE(std::holds_alternative<CompiledKernel>(made));
        const auto loaded = load_code(std::get<CompiledKernel>(made).code, kFunction + "_argv");
        EXPECT_TRUE(std::holds_alternative<LoadedKernel>(loaded)) << std::get<std::string>(loaded);
    }
}

TEST(LoadCode, WantsTheFunction) {
    const auto loaded = load_code(object_of_triple(), "another_argv");
    ASSERT_TRUE(std::holds_alternative<std::string>(loaded));
    EXPECT_EQ(std::get<std::string>(loaded), "it has no function `another_argv`");
}

/// Prefixes, and bytes outside the code that are changed: an error, or code that loads, but never a
/// step outside the object. (Sanitizers see it.) What loads is not called.
TEST(LoadCode, StandsDamage) {
    const std::string object = object_of_triple();
    ASSERT_FALSE(object.empty());
    for (size_t length = 0; length < object.size(); ++length)
        EXPECT_TRUE(std::holds_alternative<std::string>(
            load_code(object.substr(0, length), kFunction + "_argv")))
            << length;
    std::mt19937 random(1);
    size_t refused = 0;
    for (int trial = 0; trial < 20'000; ++trial) {
        std::string damaged = object;
        const size_t at = random() % damaged.size();
        damaged[at] = static_cast<char>(random());
        refused += std::holds_alternative<std::string>(load_code(damaged, kFunction + "_argv"));
    }
    EXPECT_GT(refused, 100u);
}

TEST(LoadCode, KnowsNoFunctionButThoseOfKernels) {
    EXPECT_EQ(kernel_symbol("system"), nullptr);
    EXPECT_EQ(kernel_symbol(""), nullptr);
    EXPECT_NE(kernel_symbol("halide_error_bad_type"), nullptr);
    EXPECT_NE(kernel_symbol("openfab_sample_avx2"), nullptr);
}

}  // namespace
}  // namespace openfab::lower
