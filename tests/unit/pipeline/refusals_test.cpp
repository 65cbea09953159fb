// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Errors before a print starts, and how a print ends early.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/units.h"
#include "runtime/pipeline/messages.h"
#include "tests/support/prints/box_print.h"
#include "tests/support/prints/test_fablets.h"
#include "tests/support/says/says.h"

namespace openfab {
namespace {

using testing::BoxPart;
using ::testing::HasSubstr;
using testing::MemorySink;
using testing::Printed;

std::vector<BoxPart> box() {
    return {{{0.013, 0.021, 0.019}, {3.03, 2.11, 2.37}, &testing::skin_fablet()}};
}

void expect_refused(const pipeline::PrintInput& input, const pipeline::PrintOptions& options,
                    ErrorCode code, const ::testing::Matcher<std::string>& text) {
    const auto print = pipeline::PrintJob::create(input, options);
    ASSERT_FALSE(print.has_value());
    EXPECT_EQ(print.error().code, code);
    EXPECT_THAT(print.error().text(), text);
}

TEST(PrintRefuses, AnUnknownDitherAndListsWhatThereIs) {
    pipeline::PrintOptions options;
    options.dither = "ordered";
    expect_refused(testing::make_input(box()), options, ErrorCode::kUsage,
                   testing::Says(pipeline::messages::kNoSuchDither, "ordered",
                                 "own, floyd_steinberg, decorrelated, blue_noise, majority"));
}

TEST(PrintRefuses, MoreMaterialsThanCodes) {
    pipeline::PrintInput input = testing::make_input(box());
    input.materials.resize(255);
    input.materials[254].name = "gold";
    expect_refused(input, {}, ErrorCode::kUserInput,
                   testing::Says(pipeline::messages::kTooManyMaterials, 255, 254));
    expect_refused(input, {}, ErrorCode::kUserInput, HasSubstr("gold"));
    input.materials.resize(254);
    EXPECT_TRUE(pipeline::PrintJob::create(input, {}).has_value());
}

TEST(PrintRefuses, TooSmallABudgetAndNamesTheLeast) {
    pipeline::PrintOptions options;
    options.memory_bytes = 1'000'000;
    expect_refused(testing::make_input(box()), options, ErrorCode::kUserInput,
                   testing::Says(pipeline::messages::kPrintNeeds));
}

/// Returns the memory that an error asks for; 0 if the print is possible.
int64_t least_budget(const pipeline::PrintInput& input, const pipeline::PrintOptions& options) {
    const auto print = pipeline::PrintJob::create(input, options);
    if (print) return 0;
    const std::string& text = print.error().text();
    const std::string needs = pipeline::messages::kPrintNeeds;
    const size_t first = needs.find("{}"), second = needs.find("{}", first + 2);
    const size_t begin = text.find(needs.substr(0, first)) + first;
    const size_t end = text.find(needs.substr(first + 2, second - first - 2), begin);
    const Result<int64_t> bytes = parse_bytes(text.substr(begin, end - begin));
    EXPECT_TRUE(bytes.has_value()) << text;
    return bytes ? *bytes : 0;
}

TEST(PrintRefuses, TheBudgetThatItNamesWillDo) {
#ifdef OPENFAB_SANITIZED
    GTEST_SKIP() << "a sanitizer's memory counts in the budget, and grows from print to print";
#endif
    // A tray of 120 parts in four layers.
    std::vector<testing::BoxPart> tray;
    for (int32_t i = 0; i < 120; ++i) {
        tray.push_back(
            {{i % 6 * 20.0, i / 6 % 5 * 20.0, i / 30 * 5.0}, {19, 19, 4}, &testing::skin_fablet()});
    }
    for (const std::vector<testing::BoxPart>& boxes : {box(), tray}) {
        const pipeline::PrintInput input = testing::make_input(boxes);
        for (int32_t threads : {1, 8}) {
            pipeline::PrintOptions options;
            options.threads = threads;
            options.memory_bytes = 1'000'000;
            const int64_t least = least_budget(input, options);
            ASSERT_GT(least, options.memory_bytes);
            options.memory_bytes = least;
            EXPECT_EQ(least_budget(input, options), 0) << least << " bytes";
            options.memory_bytes = least - least / 4;
            EXPECT_GT(least_budget(input, options), 0) << "far less would have done, too";
        }
    }
}

// Parts that are never in one slab together do not add up.
TEST(PrintRefuses, LayersOfPartsNeedWhatOneNeeds) {
    const auto least = [](int32_t layers) {
        std::vector<testing::BoxPart> boxes;
        for (int32_t i = 0; i < layers; ++i)
            boxes.push_back({{0, 0, i * 5.0}, {150, 150, 4}, &testing::solid_fablet()});
        pipeline::PrintOptions options;
        options.memory_bytes = 1'000'000;
        return least_budget(testing::make_input(boxes), options);
    };
    const int64_t one = least(1);
    EXPECT_LT(least(20), one + one / 10);
}

TEST(PrintRefuses, SlicesOutsideThePrint) {
    pipeline::PrintOptions options;
    options.slices = Vec2<int32_t>{48, 500};
    expect_refused(testing::make_input(box()), options, ErrorCode::kUserInput,
                   testing::Says(pipeline::messages::kSlicesOutside, 48, 500, 48));
    options.slices = Vec2<int32_t>{5, 5};
    expect_refused(testing::make_input(box()), options, ErrorCode::kUserInput,
                   testing::Says(pipeline::messages::kSlicesOutside, 5, 5));
    options.slices.reset();
    options.z_range_mm = Vec2<double>{3, 5};
    expect_refused(testing::make_input(box()), options, ErrorCode::kUserInput,
                   testing::Says(pipeline::messages::kNoSliceInRange, "*", "*", "2.4"));
}

TEST(PrintRefuses, NothingToPrint) {
    expect_refused(testing::make_input({}), {}, ErrorCode::kUserInput,
                   testing::Says(pipeline::messages::kNothingToPrint));
}

TEST(PrintRefuses, AGridBeyondAllLimits) {
    expect_refused(testing::make_input(box(), {1e-7, 0.1, 0.1}), {}, ErrorCode::kUserInput,
                   HasSubstr("1e-07 mm"));
    expect_refused(testing::make_input(box(), {0, 0.1, 0.1}), {}, ErrorCode::kUserInput,
                   testing::Says(pipeline::messages::kVoxelOutside));
}

TEST(PrintJob, ChoosesSlicesByHeight) {
    pipeline::PrintOptions options;
    options.z_range_mm = Vec2<double>{0.49, 1.01};
    const auto print = pipeline::PrintJob::create(testing::make_input(box()), options);
    ASSERT_TRUE(print.has_value());
    EXPECT_EQ((*print)->info().slice_begin, 9);  // 0.45 to 0.5 mm
    EXPECT_EQ((*print)->info().slice_end, 21);   // 1.0 to 1.05 mm
}

TEST(PrintJob, GridStandsOnWholePitches) {
    const auto print = pipeline::PrintJob::create(testing::make_input(box()), {});
    ASSERT_TRUE(print.has_value());
    const pipeline::PrintInfo& info = (*print)->info();
    EXPECT_EQ(info.size, (Vec3i{31, 27, 48}));
    EXPECT_EQ(info.origin_mm, (Vec3d{0, 0, 0}));
    // A box of whole pitches gets no empty layer.
    const auto whole = pipeline::PrintJob::create(
        testing::make_input({{{0.3, 0.3, 0.3}, {0.6, 0.3, 0.9}, &testing::solid_fablet()}},
                            {0.1, 0.1, 0.1}),
        {});
    ASSERT_TRUE(whole.has_value());
    EXPECT_EQ((*whole)->info().size, (Vec3i{6, 3, 9}));
}

TEST(PrintJob, StatisticsOfASolidBox) {
    const Printed printed = testing::print_boxes(
        {{{0.3, 0.3, 0.3}, {0.6, 0.3, 0.9}, &testing::solid_fablet()}}, {}, {0.1, 0.1, 0.1});
    ASSERT_TRUE(printed.ok) << printed.error.text();
    const pipeline::PrintStatistics& s = printed.statistics;
    EXPECT_EQ(s.voxels_total, 6 * 3 * 9);
    EXPECT_EQ(s.voxels_solid, 6 * 3 * 9);
    EXPECT_EQ(s.voxels_by_code, (std::vector<int64_t>{0, 6 * 3 * 9, 0}));
    EXPECT_EQ(s.tight, (Box3i{{0, 0, 0}, {6, 3, 9}}));
    EXPECT_EQ(s.slices, 9);
    EXPECT_EQ(s.blocks_total, 2);
    EXPECT_EQ(s.blocks_filled, 2);
    EXPECT_EQ(s.blocks_evaluated, 0);
    EXPECT_TRUE(s.complete);
    EXPECT_GT(s.seconds_first_slice, 0);
    EXPECT_GE(s.seconds_total, s.seconds_first_slice);
    EXPECT_EQ(printed.sink.totals.hash, s.hash);
    EXPECT_EQ(printed.sink.totals.tight, s.tight);
    EXPECT_TRUE(printed.sink.totals.complete);
}

TEST(PrintJob, AFailingSinkEndsItWithWholeSlicesKept) {
    for (int32_t threads : {1, 2}) {
        auto print = pipeline::PrintJob::create(testing::make_input(box()), {.threads = threads});
        ASSERT_TRUE(print.has_value());
        MemorySink sink;
        sink.fail_at = 19;
        pipeline::PrintStatistics statistics;
        const Result<void> run = (*print)->run(sink, {}, false, &statistics);
        ASSERT_FALSE(run.has_value());
        EXPECT_EQ(run.error().code, ErrorCode::kOutside);
        EXPECT_EQ(run.error().text(), "the disk is full");
        EXPECT_EQ(sink.slices.size(), 19u);
        EXPECT_EQ(sink.finished, 1);
        EXPECT_FALSE(sink.totals.complete);
        EXPECT_EQ(statistics.slices, 19);
        EXPECT_FALSE(statistics.complete);
    }
}

TEST(PrintJob, AnInterruptKeepsWholeSlices) {
    auto print = pipeline::PrintJob::create(testing::make_input(box()), {.threads = 2});
    ASSERT_TRUE(print.has_value());
    MemorySink sink;
    pipeline::PrintStatistics statistics;
    std::atomic<bool> interrupt{false};
    const auto progress = [&](const pipeline::ProgressEvent& event) {
        EXPECT_EQ(event.slices_total, 48);
        if (event.slices_done == 9) interrupt.store(true);
    };
    const Result<void> run = (*print)->run(sink, progress, interrupt, &statistics);
    ASSERT_FALSE(run.has_value());
    EXPECT_EQ(run.error().code, ErrorCode::kInterrupted);
    EXPECT_GE(sink.slices.size(), 9u);
    EXPECT_LT(sink.slices.size(), 48u);
    EXPECT_EQ(sink.finished, 1);
    EXPECT_FALSE(sink.totals.complete);
}

TEST(PrintJob, AnInterruptDuringSetUpEndsIt) {
    const std::atomic<bool> interrupt{true};
    pipeline::PrintOptions options;
    options.interrupt = &interrupt;
    expect_refused(testing::make_input(box()), options, ErrorCode::kInterrupted,
                   testing::Says(pipeline::messages::kInterruptedBefore));
}

TEST(PrintJob, AFailingKernelNamesTheSlices) {
    const Printed printed =
        testing::print_boxes({{{0.013, 0.021, 0.019}, {1, 1, 1}, &testing::broken_fablet()}});
    EXPECT_FALSE(printed.ok);
    EXPECT_EQ(printed.error.code, ErrorCode::kInternal);
    EXPECT_THAT(printed.error.text(),
                testing::Says(pipeline::messages::kKernelFailed, "0", "7", "-7"));
    EXPECT_EQ(printed.sink.finished, 1);
}

}  // namespace
}  // namespace openfab
