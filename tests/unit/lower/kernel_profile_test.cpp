// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What is known of a kernel's Funcs: which are at work, what they cost, where else they could be.

#include "compiler/lower/code/kernel_profile.h"

#include <gmock/gmock.h>

#include <deque>
#include <set>

#include "abi/kernel_call.h"
#include "base/clock.h"
#include "compiler/lower/code/fablet_data.h"
#include "compiler/lower/code/jit.h"
#include "compiler/lower/schedule/func_costs.h"
#include "compiler/lower/schedule/list_sites.h"

namespace openfab::lower {
namespace {

using ::testing::ElementsAre;

constexpr int32_t kProfiledBlocks = 4096;

/// weight 0 is a polynomial of the distance, which takes a while, in both bounds.
passes::KernelStages slow_bounds() {
    passes::KernelStages stages;
    ir::Stage& stage = stages.volume_bounds;
    stage.kind = ir::StageKind::kVolumeBounds;
    ir::Builder builder(&stage);
    for (const auto& [from, to] : {std::pair(OPENFAB_ARG_DISTANCE_LO, OPENFAB_ARG_WEIGHT_LO),
                                   std::pair(OPENFAB_ARG_DISTANCE_HI, OPENFAB_ARG_WEIGHT_HI)}) {
        const ir::ValueId x = builder.input(ir::Type::kFloat, from, 0, 0);
        ir::ValueId sum = x;
        for (int k = 0; k < 20; ++k)
            sum = builder.binary(ir::Op::kAdd, builder.binary(ir::Op::kMul, sum, x), x);
        stage.outputs.push_back({"weight", to, 0, 0, sum});
    }
    return stages;
}

KernelUnit unit_of(const FabletUnit& fablet, bool profiled) {
    ProgramOptions options;
    options.isas = {OPENFAB_ISA_SSE41};
    options.profiled = profiled;
    const std::vector<KernelUnit> units = list_kernels({fablet}, options);
    EXPECT_EQ(units.size(), 1u);
    return units.at(0);
}

/// Calls a kernel for some seconds and returns what it writes.
std::vector<float> call(const KernelUnit& unit, const openfab_kernel& entry, double seconds) {
    auto compiled = compile_object(unit.request);
    if (std::holds_alternative<Fault>(compiled)) return {};
    const KernelObject object{unit.key, std::get<CompiledKernel>(compiled).code, 0};
    auto loaded = load_kernel(unit, object);
    if (const auto* fault = std::get_if<Fault>(&loaded)) {
        ADD_FAILURE() << fault->trouble;
        return {};
    }
    std::deque<abi::KernelBuffer> buffers;
    std::deque<std::vector<float>> values;
    std::vector<void*> args;
    for (int32_t k = 0; k < entry.arg_count; ++k) {
        std::vector<float>& data = values.emplace_back(kProfiledBlocks);
        for (int32_t n = 0; n < kProfiledBlocks; ++n)
            data[static_cast<size_t>(n)] = static_cast<float>(n) / kProfiledBlocks;
        buffers.emplace_back().set_dense(abi::halide_type(OPENFAB_FLOAT), data.data(),
                                         {kProfiledBlocks});
        args.push_back(buffers.back().raw());
    }
    const double end = thread_processor_seconds() + seconds;
    do {
        EXPECT_EQ(std::get<LoadedKernel>(loaded).function(args.data()), 0);
    } while (thread_processor_seconds() < end);
    std::vector<float> out;
    for (const std::vector<float>& data : values)
        out.insert(out.end(), data.begin(), data.end());
    return out;
}

TEST(KernelProfile, SeesTheFuncsAtWorkAndChangesNoBit) {
    const passes::KernelStages stages = slow_bounds();
    const ir::Fablet fablet;
    const FabletUnit unit{&fablet, &stages, "test.fl", 1};
    const FabletData data(unit);
    const KernelUnit plain = unit_of(unit, false), profiled = unit_of(unit, true);
    EXPECT_NE(plain.key.text(), profiled.key.text());
    const std::vector<float> expected = call(plain, data.kernel(plain.slot), 0);
    ASSERT_FALSE(expected.empty());
    KernelProfile profile;
    EXPECT_EQ(call(profiled, data.kernel(profiled.slot), 0.3), expected);
    const std::vector<FuncSamples> seen = profile.finish();
    int64_t samples = 0;
    std::set<std::string> funcs;
    for (const FuncSamples& func : seen) {
        EXPECT_EQ(func.function, profiled.request.function);
        funcs.insert(func.func.substr(0, func.func.find('$')));
        samples += func.samples;
    }
    // Of 600 looks, on a machine that does other things first.
    EXPECT_GE(samples, 1);
    EXPECT_TRUE(funcs.contains("bounds") || funcs.contains("store"));
    // Nothing is at work any more.
    KernelProfile later;
    EXPECT_TRUE(later.finish().empty());
}

TEST(FuncCosts, AreThoseOfTheDefinitions) {
    const passes::KernelStages stages = slow_bounds();
    const ir::Fablet fablet;
    const KernelUnit unit = unit_of({&fablet, &stages, "test.fl", 1}, false);
    const std::vector<FuncCost> costs = func_costs(unit.request);
    ASSERT_EQ(costs.size(), 2u);
    EXPECT_EQ(costs[0].func, "store");
    EXPECT_EQ(costs[0].operations, 0);
    EXPECT_EQ(costs[0].bytes_read, 8);
    EXPECT_EQ(costs[0].bytes_written, 8);
    EXPECT_EQ(costs[1].func, "bounds");
    EXPECT_EQ(costs[1].operations, 2 * 2 * 20);
    EXPECT_EQ(costs[1].bytes_read, 8);
    EXPECT_EQ(costs[1].bytes_written, 8);
}

TEST(ListSites, AreTheLoopsAroundWhatReadsAFunc) {
    const passes::KernelStages stages = slow_bounds();
    const ir::Fablet fablet;
    const KernelUnit unit = unit_of({&fablet, &stages, "test.fl", 1}, false);
    const auto listed = list_sites(unit.request);
    ASSERT_TRUE(std::holds_alternative<std::vector<FuncSites>>(listed));
    const auto& funcs = std::get<std::vector<FuncSites>>(listed);
    ASSERT_EQ(funcs.size(), 2u);
    // store.split(n, group, lane, 8).vectorize(lane); bounds.compute_at(store, group)
    EXPECT_TRUE(funcs[0].is_result);
    EXPECT_TRUE(funcs[0].sites.empty());
    EXPECT_THAT(funcs[0].serial_loops, ElementsAre("group"));
    EXPECT_EQ(funcs[1].func, "bounds");
    EXPECT_THAT(funcs[1].sites, ElementsAre("compute_root()", "compute_at(store, group)"));
    EXPECT_EQ(funcs[1].current, 1u);
}

}  // namespace
}  // namespace openfab::lower
