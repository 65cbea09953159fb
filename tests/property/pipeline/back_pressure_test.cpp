// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Back-pressure: a slow sink stalls the pipeline; the queued work is bounded, and work continues
// until that bound is reached.

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "tests/support/prints/box_print.h"
#include "tests/support/prints/test_fablets.h"

namespace openfab::pipeline {
namespace {

using namespace std::chrono_literals;
using testing::BoxPart;

/// Counts slices that have been encoded and not yet committed.
class CountingSink : public pipeline::SliceSink {
  public:
    Result<void> begin(const pipeline::PrintInfo&) override { return {}; }
    std::vector<uint8_t> encode(const pipeline::SliceView&) const override {
        std::unique_lock lock(mutex_);
        most_encoding_ = std::max(most_encoding_, ++encoding_);
        changed_.notify_all();
        changed_.wait_for(lock, alone_for_, [&] { return most_encoding_ > 1; });
        --encoding_;
        ++encoded_;
        most_waiting_ = std::max(most_waiting_, encoded_ - committed_);
        changed_.notify_all();
        return {1};
    }
    Result<void> commit(int32_t z, std::vector<uint8_t>) override {
        std::unique_lock lock(mutex_);
        if (z == slow_z_) {
            // A slow sink: waits until the pipeline has run as far ahead as it may, and longer.
            reached_ = changed_.wait_for(lock, 300s, [&] { return encoded_ >= expected_; });
            lock.unlock();
            std::this_thread::sleep_for(200ms);
            lock.lock();
            encoded_then_ = encoded_;
        }
        ++committed_;
        return {};
    }
    Result<void> finish(const pipeline::PrintTotals&) override { return {}; }

    int32_t slow_z_ = -1;
    int32_t expected_ = 0;
    bool reached_ = false;
    int32_t encoded_then_ = 0;
    mutable int32_t encoded_ = 0, most_waiting_ = 0;
    mutable int32_t encoding_ = 0, most_encoding_ = 0;
    int32_t committed_ = 0;
    std::chrono::milliseconds alone_for_{0};  ///< how long an encoder waits for a second one

  private:
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
};

PrintOptions with_slabs(int32_t slabs) {
    PrintOptions options;
    options.threads = 3;
    options.slabs_in_flight = slabs;
    options.memory_bytes += testing::kSanitizerBytes;
    return options;
}

Result<PrintStatistics> print_into(CountingSink* sink, const PrintOptions& options) {
    const std::vector<BoxPart> boxes{{{0, 0, 0}, {2, 2, 6}, &testing::skin_fablet()}};
    Result<std::unique_ptr<PrintJob>> print = PrintJob::create(testing::make_input(boxes), options);
    if (!print) return print.error();
    PrintStatistics statistics;
    const std::atomic<bool> interrupt{false};
    const Result<void> done = (*print)->run(*sink, {}, interrupt, &statistics);
    if (!done) return done.error();
    return statistics;
}

TEST(BackPressure, ASlowSinkIsWaitedForWithABoundAndNoSooner) {
    for (const int32_t slabs : {2, 3, 5}) {
        CountingSink sink;
        // A slice of the second slab: the first goes alone. While it is written, its slab and as
        // many others as are allowed are in flight.
        sink.slow_z_ = 8;
        sink.expected_ = 8 + 8 * slabs;
        const Result<PrintStatistics> printed = print_into(&sink, with_slabs(slabs));
        ASSERT_TRUE(printed) << printed.error().text();
        EXPECT_TRUE(sink.reached_) << slabs << ": the pipeline stalled behind a slow sink";
        EXPECT_EQ(sink.encoded_then_, sink.expected_) << slabs << ": more waits than may";
        EXPECT_LE(sink.most_waiting_, 8 * slabs);
        EXPECT_EQ(sink.committed_, printed->slices);
        EXPECT_GT(printed->slices, 16 + 8 * slabs);
    }
}

TEST(BackPressure, SlicesAreEncodedSideBySide) {
    CountingSink sink;
    sink.alone_for_ = 300s;
    ASSERT_TRUE(print_into(&sink, with_slabs(0)));
    EXPECT_GT(sink.most_encoding_, 1);
}

TEST(BackPressure, UnlessToldOneSlabMoreWaitsThanThereAreThreads) {
    CountingSink sink;
    sink.slow_z_ = 8;
    sink.expected_ = 8 + 8 * 4;
    const Result<PrintStatistics> printed = print_into(&sink, with_slabs(0));
    ASSERT_TRUE(printed) << printed.error().text();
    EXPECT_EQ(sink.encoded_then_, sink.expected_);
}

// One thread, so that nothing depends on timing: before it continues with the next slab, all
// finished slices are in the sink.
TEST(BackPressure, AFastSinkIsNotKeptWaitingForSlicesThatAreMade) {
    CountingSink sink;
    PrintOptions options = with_slabs(3);
    options.threads = 1;
    const Result<PrintStatistics> printed = print_into(&sink, options);
    ASSERT_TRUE(printed) << printed.error().text();
    EXPECT_GT(printed->slices, 64);
    EXPECT_LE(sink.most_waiting_, 8);
}

}  // namespace
}  // namespace openfab::pipeline
