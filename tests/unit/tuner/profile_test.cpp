// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What a profile says of its figures.

#include "tools/tuner/profile.h"

#include <gmock/gmock.h>

namespace openfab::tuner {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// 10 GB/s and 100 G operations/s for each of two threads.
Machine machine() {
    return {2, 15e9, 20e9, 150e9, 200e9};
}

StageCost stage(const std::string& name, double seconds, int64_t bytes) {
    StageCost cost;
    cost.name = name;
    cost.seconds = seconds;
    cost.by_thread = {seconds, 0};
    cost.bytes_read = bytes;
    return cost;
}

TEST(Profile, NamesWhatBoundsAStage) {
    EXPECT_EQ(bound_of(stage("pack", 1, 6'000'000'000), machine()), "memory");
    EXPECT_EQ(bound_of(stage("pack", 1, 4'000'000'000), machine()), "arithmetic");
    EXPECT_EQ(bound_of(stage("commit", 1, 6'000'000'000), machine()), "sink");
    EXPECT_EQ(bound_of(stage("waiting", 1, 0), machine()), "waiting");
    EXPECT_EQ(bound_of(stage("slab", 0, 0), machine()), "arithmetic");
}

TEST(Profile, TableHasAllStagesAndTheirSum) {
    Profile profile;
    profile.title = "card";
    profile.machine = machine();
    profile.slabs = 3;
    profile.slabs_total = 9;
    profile.seconds = 2;
    profile.voxels = 8'000'000;
    profile.stages = {stage("slab", 2.5, 0), stage("pack", 1, 0), stage("support", 0, 0),
                      stage("waiting", 0.5, 0)};
    profile.funcs = {stage("values_*", 2.5, 0)};
    profile.alone_seconds = 0.5;
    profile.print_seconds = 4;
    const std::string table = profile_table(profile);
    EXPECT_THAT(table,
                HasSubstr("card: 3 of 9 slabs, 8.0 M voxels in 2.00 s with 2 threads: 4.0 M"));
    EXPECT_THAT(table, HasSubstr("slab                2.500 s   62.5 %"));
    EXPECT_THAT(table, HasSubstr("sum                 4.000 s  100.0 %"));
    EXPECT_THAT(table, HasSubstr("values_*            2.500 s  100.0 %"));
    EXPECT_THAT(table,
                HasSubstr("one thread alone: 0.50 s of 4.00 s, 12.5 % of the print, scaled"));
    // What took no time has no row; the file has it all the same.
    EXPECT_THAT(table, Not(HasSubstr("support")));
    EXPECT_THAT(profile_json(profile), HasSubstr("\"support\""));
}

TEST(Machine, CanDoSomething) {
    const Machine measured = measure_machine(2, OPENFAB_ISA_SSE41);
    EXPECT_EQ(measured.threads, 2);
    // No machine of the last twenty years is slower, and none of the next few faster.
    EXPECT_GT(measured.bandwidth_one, 1e8);
    EXPECT_LT(measured.bandwidth_one, 1e12);
    EXPECT_GT(measured.operations_one, 1e8);
    EXPECT_LT(measured.operations_one, 1e12);
    EXPECT_GT(measured.bandwidth_all, 1e8);
    EXPECT_GT(measured.operations_all, measured.operations_one / 2);
}

}  // namespace
}  // namespace openfab::tuner
