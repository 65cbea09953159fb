// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Kernels that are compiled while a program runs: nothing is known, then what the kernel says.

#include "compiler/lower/code/later_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <vector>

#include "abi/kernel_call.h"
#include "compiler/lower/code/fablet_data.h"

namespace openfab::lower {
namespace {

constexpr int32_t kBlocks = 11;

/// weight 0 is the distance, both in bounds.
passes::KernelStages distance_bounds() {
    passes::KernelStages stages;
    ir::Stage& stage = stages.volume_bounds;
    stage.kind = ir::StageKind::kVolumeBounds;
    ir::Builder builder(&stage);
    const ir::ValueId low = builder.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE_LO, 0, 0);
    const ir::ValueId high = builder.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE_HI, 0, 0);
    stage.outputs.push_back({"weight", OPENFAB_ARG_WEIGHT_LO, 0, 0, low});
    stage.outputs.push_back({"weight", OPENFAB_ARG_WEIGHT_HI, 0, 0, high});
    return stages;
}

struct Bounds {
    std::vector<float> low, high;
};

Bounds call(openfab_kernel_fn function, const openfab_kernel& entry) {
    std::deque<abi::KernelBuffer> buffers;
    std::deque<std::vector<float>> values;
    std::vector<void*> args;
    std::vector<float>* out[2] = {};
    for (int32_t k = 0; k < entry.arg_count; ++k) {
        const openfab_arg& arg = entry.args[k];
        std::vector<float>& data = values.emplace_back(kBlocks, -7.0f);
        for (int32_t n = 0; n < kBlocks; ++n) {
            if (arg.kind == OPENFAB_ARG_DISTANCE_LO) data[n] = static_cast<float>(n);
            if (arg.kind == OPENFAB_ARG_DISTANCE_HI) data[n] = static_cast<float>(n) + 0.5f;
        }
        if (arg.kind == OPENFAB_ARG_WEIGHT_LO) out[0] = &data;
        if (arg.kind == OPENFAB_ARG_WEIGHT_HI) out[1] = &data;
        buffers.emplace_back().set_dense(abi::halide_type(OPENFAB_FLOAT), data.data(), {kBlocks});
        args.push_back(buffers.back().raw());
    }
    EXPECT_EQ(function(args.data()), 0);
    return {*out[0], *out[1]};
}

TEST(LaterKernels, KnowNothingUntilTheyAreThere) {
    const passes::KernelStages stages = distance_bounds();
    const ir::Fablet fablet;
    const FabletUnit unit{&fablet, &stages, "test.fl", 1};
    const FabletData data(unit);
    ProgramOptions options;
    options.isas = {OPENFAB_ISA_SSE41};
    const std::vector<KernelUnit> kernels = list_kernels({unit}, options);
    ASSERT_EQ(kernels.size(), 1u);
    ASSERT_TRUE(can_come_later(kernels[0]));
    const openfab_kernel& entry = data.kernel(kernels[0].slot);
    KernelCache cache;
    LaterKernels later(&cache);
    const auto added = later.add(kernels[0], entry);
    ASSERT_TRUE(std::holds_alternative<openfab_kernel_fn>(added)) << std::get<std::string>(added);
    const auto function = std::get<openfab_kernel_fn>(added);
    const Bounds before = call(function, entry);
    later.start();
    const auto finished = later.finish();
    ASSERT_TRUE(std::holds_alternative<std::vector<KernelTime>>(finished));
    ASSERT_EQ(std::get<std::vector<KernelTime>>(finished).size(), 1u);
    EXPECT_TRUE(later.done());
    const Bounds after = call(function, entry);
    for (int32_t n = 0; n < kBlocks; ++n) {
        EXPECT_TRUE(std::isnan(before.low[n]) && std::isnan(before.high[n])) << n;
        EXPECT_EQ(after.low[n], static_cast<float>(n));
        EXPECT_EQ(after.high[n], static_cast<float>(n) + 0.5f);
    }
    EXPECT_NE(cache.find(kernels[0].key), nullptr) << "it is kept";
}

TEST(LaterKernels, AScheduleOfTheUsersIsTriedAtOnce) {
    const passes::KernelStages stages = distance_bounds();
    const ir::Fablet fablet;
    const auto parsed = schedule::read({"volume_bounds.sched", "bounds.vectorize(lane)\n"});
    ProgramOptions options;
    for (const openfab_isa isa : options.isas)
        options.schedules[{"volume_bounds", isa}] = std::get<schedule::Schedule>(parsed);
    for (const KernelUnit& kernel : list_kernels({{&fablet, &stages, "test.fl", 1}}, options))
        EXPECT_FALSE(can_come_later(kernel));
}

TEST(LaterKernels, WhatHasNotBegunIsGivenUp) {
    const passes::KernelStages stages = distance_bounds();
    const ir::Fablet fablet;
    const FabletUnit unit{&fablet, &stages, "test.fl", 1};
    const FabletData data(unit);
    LaterKernels later(nullptr);
    EXPECT_TRUE(later.done()) << "of nothing";
    for (const KernelUnit& kernel : list_kernels({unit}, {}))
        ASSERT_TRUE(
            std::holds_alternative<openfab_kernel_fn>(later.add(kernel, data.kernel(kernel.slot))));
    later.give_up();
    later.start();
    const auto finished = later.finish();
    ASSERT_TRUE(std::holds_alternative<std::vector<KernelTime>>(finished));
    EXPECT_TRUE(std::get<std::vector<KernelTime>>(finished).empty());
}

}  // namespace
}  // namespace openfab::lower
