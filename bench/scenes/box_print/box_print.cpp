// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The slab loop on a card of 100 x 70 x 2.7 mm at 600 x 300 dpi and 27 um with the hand-written
// fablet of the tests: a skin on the front is evaluated, the rest is filled. Slices are dropped.
// Prints the statistics as JSON.
//   bench_box_print [THREADS [MEMORY_MB]]

#include <cstdio>
#include <cstdlib>

#include "program/statistics.h"
#include "tests/support/prints/box_print.h"
#include "tests/support/prints/test_fablets.h"

namespace {

class NullSink final : public openfab::pipeline::SliceSink {
  public:
    openfab::Result<void> begin(const openfab::pipeline::PrintInfo&) override { return {}; }
    std::vector<uint8_t> encode(const openfab::pipeline::SliceView&) const override { return {}; }
    openfab::Result<void> commit(int32_t, std::vector<uint8_t>) override { return {}; }
    openfab::Result<void> finish(const openfab::pipeline::PrintTotals&) override { return {}; }
};

}  // namespace

int main(int argc, char** argv) {
    using namespace openfab;
    pipeline::PrintOptions options;
    if (argc > 1) options.threads = std::atoi(argv[1]);
    if (argc > 2) options.memory_bytes = std::atoll(argv[2]) * 1'000'000;
    const std::vector<testing::BoxPart> card{
        {{0.013, 0.021, 0.009}, {100, 70, 2.7}, &testing::picture_fablet()}};
    auto print = pipeline::PrintJob::create(
        testing::make_input(card, {25.4 / 600, 25.4 / 300, 0.027}), options);
    if (!print) {
        std::fprintf(stderr, "%s\n", print.error().text().c_str());
        return exit_code(print.error().code);
    }
    NullSink sink;
    const std::atomic<bool> interrupt{false};
    pipeline::PrintStatistics statistics;
    const Result<void> run = (*print)->run(sink, {}, interrupt, &statistics);
    if (!run) std::fprintf(stderr, "%s\n", run.error().text().c_str());
    std::fputs(program::statistics_json(statistics, (*print)->info()).c_str(), stdout);
    return run ? 0 : exit_code(run.error().code);
}
