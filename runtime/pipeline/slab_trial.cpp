// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/slab_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "abi/halide_hooks.h"
#include "base/clock.h"
#include "base/deadline.h"
#include "runtime/pipeline/messages.h"

namespace openfab::pipeline {

namespace {

/// Seconds for the coverage of the first slab that is tried.
constexpr double kCoverageSeconds = 3;

}  // namespace

Result<SlabTrial> try_slab(const PrintSetup& setup, SlabLoop* loop, const SlabTry& wanted,
                           const std::atomic<bool>& interrupt, TrialSlices* slices) {
    const auto evaluated = [&] {
        int64_t blocks = 0;
        for (const auto& e : loop->evaluators().all())
            blocks += e->counts.evaluated;
        return blocks;
    };
    const bool first = loop->evaluators().all().empty();
    if (wanted.drop_trees) {
        nearest::set_budget(setup.trees.get(), 0);
        nearest::set_budget(setup.trees.get(), setup.plan.caches.trees);
    }
    const int64_t before = evaluated(), diced = setup.patches_diced();
    const int64_t trees = nearest::built_bytes(*setup.trees);
    const double start = seconds_now(), start_processor = processor_seconds();
    Deadline deadline(interrupt);
    deadline.start(first ? kCoverageSeconds : wanted.seconds);
    SlabRun* run = loop->take_run();
    abi::KernelStatus status = run->begin(wanted.slab, &loop->evaluators(), &deadline.passed());
    SlabTrial trial;
    trial.blocks = status.ok() ? run->blocks_to_evaluate() : -1;
    trial.processor_seconds_begun = processor_seconds() - start_processor;
    trial.patches_begun = setup.patches_diced() - diced;
    if (first) deadline.start(wanted.seconds);
    FinishedSlices finished;
    const SlabSlices of_slab = setup.slices_of(wanted.slab);
    finished.first = of_slab.first;
    finished.end = of_slab.end;
    const StopFlags flags{deadline.passed()};
    trial.pieces = wanted.pieces;
    if (status.ok()) {
        status = run->try_rows(bits_of_slices(of_slab.first, of_slab.end), &loop->evaluators(),
                               flags, &trial.pieces);
    }
    segments::PrintfLog dropped;
    if (!run->log().empty()) dropped.append(&run->log());
    Result<void> taken;
    if (status.ok() && wanted.pieces == kAllPieces && slices->sink != nullptr) {
        loop->encode(*slices->sink, *run, slices->next - of_slab.first, &finished);
        for (FinishedSlices::Slice& slice : finished.slices) {
            // In low prints slabs are tried again.
            if (slices->next == setup.range.y || !taken) break;
            taken = slices->sink->commit(slices->next++, std::move(slice.bytes));
        }
    }
    loop->runs().give(run);
    if (!taken) return taken.error();
    if (!status.ok() && !status.is_stopped()) {
        return internal_error(fmt::format(messages::kTrialFailed, 8 * wanted.slab, status.code(),
                                          abi::take_kernel_error()));
    }
    if (!status.ok() || wanted.pieces != kAllPieces) {
        trial.share = std::min(1.0, static_cast<double>(evaluated() - before) /
                                        static_cast<double>(std::max<int64_t>(trial.blocks, 1)));
    }
    trial.seconds = seconds_now() - start;
    trial.processor_seconds = processor_seconds() - start_processor;
    trial.patches_diced = setup.patches_diced() - diced;
    trial.tree_bytes = nearest::built_bytes(*setup.trees) - trees;
    return trial;
}

}  // namespace openfab::pipeline
