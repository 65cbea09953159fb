// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/print_job.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/clock.h"
#include "base/messages.h"
#include "runtime/pipeline/gather_statistics.h"
#include "runtime/pipeline/messages.h"
#include "runtime/pipeline/part_sizes.h"
#include "runtime/pipeline/print_setup.h"
#include "runtime/pipeline/slab_loop.h"
#include "runtime/pipeline/slab_trial.h"
#include "runtime/pipeline/slice_committer.h"

namespace openfab::pipeline {

namespace {

class PrintJobImpl final : public PrintJob {
  public:
    explicit PrintJobImpl(std::unique_ptr<PrintSetup> setup)
        : setup_(std::move(setup)), loop_(*setup_) {}

    const PrintInfo& info() const override { return setup_->info; }
    PrintEstimate estimate() const override;
    const std::vector<std::string>& warnings() const override { return setup_->warnings; }
    std::string part_sizes() const override {
        return pipeline::part_sizes(setup_->input.parts, setup_->solids, setup_->input.pitch_mm);
    }
    Result<TimeSample> sample_time(double seconds, SliceSink* sink,
                                   const std::atomic<bool>& interrupt) override;
    Result<void> run(SliceSink& sink, const std::function<void(const ProgressEvent&)>& progress,
                     const std::atomic<bool>& interrupt, PrintStatistics* statistics) override;
    int32_t threads() const override { return setup_->threads; }
    Vec2<int32_t> slabs() const override {
        return {setup_->range.x / 8, (setup_->range.y + 7) / 8};
    }
    Result<SlabsRun> run_slabs(std::span<const int32_t> slabs, SliceSink& sink,
                               const std::atomic<bool>& interrupt,
                               PrintStatistics* statistics) override;
    bool set_uniforms(size_t part, std::span<const uint32_t> values) override;

  private:
    void stop_solids_by(const std::atomic<bool>* stop) const;
    Result<void> resume(SliceSink& sink, SliceCommitter* committer);
    void show_surface_logs(SliceCommitter* committer);

    /// Only set_uniforms changes it.
    const std::unique_ptr<PrintSetup> setup_;
    SlabLoop loop_;
};

PrintEstimate PrintJobImpl::estimate() const {
    // Voxels of the grid per second and thread, typical of one evaluated layer around a culled
    // core.
    constexpr double kTypicalRate = 15e6;
    PrintEstimate estimate;
    estimate.size = setup_->grid.size;
    estimate.voxels_total =
        int64_t{setup_->grid.size.x} * setup_->grid.size.y * (setup_->range.y - setup_->range.x);
    estimate.memory_bytes = setup_->plan.total_bytes;
    estimate.seconds =
        static_cast<double>(estimate.voxels_total) / (kTypicalRate * setup_->threads);
    return estimate;
}

Result<TimeSample> PrintJobImpl::sample_time(double seconds, SliceSink* sink,
                                             const std::atomic<bool>& interrupt) {
    const double began = process_age_seconds() - setup_->options.began_seconds;
    const double began_processor = processor_seconds();
    if (sink != nullptr) {
        if (const Result<void> begun = sink->begin(setup_->info); !begun) return begun.error();
    }
    PatchNeeds needs;
    needs.tree_room = static_cast<int64_t>(setup_->plan.caches.trees);
    for (size_t i = 0; i < setup_->solids.size(); ++i) {
        const solid::Dicing* dicing = setup_->own_dicing(i);
        needs.patches += dicing != nullptr ? dicing->patches() : 0;
    }
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<size_t>(setup_->threads));
    tbb::task_arena arena(setup_->threads);
    TrialSlices slices{sink, setup_->range.x};
    Result<TimeSample> sample = arena.execute([&] {
        return pipeline::sample_time(slabs(), seconds, needs, [&](const SlabTry& wanted) {
            return try_slab(*setup_, &loop_, wanted, interrupt, &slices);
        });
    });
    if (sink != nullptr) {
        // It is told that the print ended early, and may say so.
        const Result<void> ended = sink->finish(PrintTotals());
        (void)ended;
    }
    if (interrupt.load()) return Error{ErrorCode::kInterrupted, openfab::messages::kInterrupted};
    if (sample) {
        sample->seconds += began;
        sample->processor_seconds += began_processor;
    }
    return sample;
}

Result<void> PrintJobImpl::run(SliceSink& sink,
                               const std::function<void(const ProgressEvent&)>& progress,
                               const std::atomic<bool>& interrupt, PrintStatistics* statistics) {
    SliceCommitter committer(sink, progress, interrupt, setup_->info, setup_->options.print_line,
                             setup_->options.began_seconds);
    if (const Result<void> begun = resume(sink, &committer); !begun) {
        committer.fail(begun.error());
    } else {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<size_t>(setup_->threads));
        tbb::task_arena arena(setup_->threads);
        arena.execute([&] {
            show_surface_logs(&committer);
            if (!committer.failed())
                loop_.print_rest({sink, &committer, setup_->options.interrupt});
        });
    }
    committer.end_log();
    const bool complete =
        !committer.failed() && committer.slices() == setup_->range.y - setup_->range.x;

    PrintTotals totals = print_totals(committer.totals(), setup_->input.materials.size());
    totals.complete = complete;
    for (const process::Effect* effect : setup_->options.effects)
        std::ranges::move(effect->changes(), std::back_inserter(totals.changes));
    const double finish_start = seconds_now();
    Result<void> finished = sink.finish(totals);
    if (setup_->options.fractions != nullptr) {
        const Result<void> fractions = setup_->options.fractions->finish(totals);
        if (finished) finished = fractions;
    }
    const double seconds_finish = seconds_now() - finish_start;
    if (!finished && !committer.failed()) committer.fail(finished.error());

    gather_statistics(*setup_, loop_, committer, seconds_finish, statistics);
    statistics->complete = complete && !committer.failed();
    fill_voxels(totals, setup_->input.support_code, statistics);
    if (committer.failed()) return committer.error();
    if (!complete) {
        return Error{ErrorCode::kInterrupted,
                     fmt::format(messages::kInterruptedAfter, committer.slices(),
                                 setup_->range.y - setup_->range.x)};
    }
    return {};
}

Result<SlabsRun> PrintJobImpl::run_slabs(std::span<const int32_t> slabs, SliceSink& sink,
                                         const std::atomic<bool>& interrupt,
                                         PrintStatistics* statistics) {
    std::vector<SlabSlices> all;
    PrintInfo info = setup_->info;
    if (!slabs.empty()) info.slice_begin = setup_->slices_of(slabs.front()).first;
    info.slice_end = info.slice_begin;
    for (const int32_t slab : slabs) {
        SlabSlices& slices = all.emplace_back(setup_->slices_of(slab));
        slices.shift = info.slice_end - slices.first;
        info.slice_end += slices.end - slices.first;
    }
    const std::function<void(const ProgressEvent&)> no_progress;
    const std::function<void(const std::string&)> no_lines;
    SliceCommitter committer(sink, no_progress, interrupt, info, no_lines,
                             setup_->options.began_seconds);
    SlabsRun run;
    if (const Result<void> begun = sink.begin(info); !begun) return begun.error();
    FractionSink* fractions = setup_->options.fractions;
    if (fractions != nullptr) {
        const Result<void> begun = fractions->begin(info, setup_->slabs.materials);
        if (!begun) return begun.error();
    }
    // Else every second run of the same slabs would find crossings that the one before has left.
    for (const auto& part : setup_->parts)
        part->placed->forget_slabs();
    const double processor = processor_seconds();
    run.begin = seconds_now();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<size_t>(setup_->threads));
    tbb::task_arena arena(setup_->threads);
    size_t next = 0;
    // Its own interrupt is looked at between batches of blocks; patches are always whole, since what
    // is made of them stays in caches for the next run.
    stop_solids_by(nullptr);
    arena.execute([&] {
        loop_.print_all([&] { return next < all.size() ? all[next++] : SlabSlices{}; },
                        {sink, &committer, &interrupt});
    });
    stop_solids_by(setup_->options.interrupt);
    run.end = seconds_now();
    run.processor_seconds = processor_seconds() - processor;
    run.hash = committer.totals().hash;
    const bool complete =
        !committer.failed() && committer.slices() == info.slice_end - info.slice_begin;
    PrintTotals totals = print_totals(committer.totals(), setup_->input.materials.size());
    totals.complete = complete;
    Result<void> finished = sink.finish(totals);
    if (fractions != nullptr) {
        const Result<void> mixed = fractions->finish(totals);
        if (finished) finished = mixed;
    }
    if (committer.failed()) return committer.error();
    if (!complete) return Error{ErrorCode::kInterrupted, openfab::messages::kInterrupted};
    if (!finished) return finished.error();
    if (statistics != nullptr) {
        gather_statistics(*setup_, loop_, committer, 0, statistics);
        statistics->complete = true;
        fill_voxels(totals, setup_->input.support_code, statistics);
    }
    return run;
}

bool PrintJobImpl::set_uniforms(size_t part, std::span<const uint32_t> values) {
    std::vector<uint32_t>& now = setup_->input.parts[part].uniform_values;
    if (std::ranges::equal(now, values)) return true;
    const auto depends = [](const part::Part& of) {
        return of.fablet->has_surface != 0 ||
               !(part::is_mesh(of) || std::holds_alternative<part::BeamGeometry>(of.geometry));
    };
    if (values.size() != now.size() || depends(setup_->input.parts[part])) return false;
    // In place: kernels of evaluators have their addresses.
    std::ranges::copy(values, now.begin());
    return true;
}

void PrintJobImpl::stop_solids_by(const std::atomic<bool>* stop) const {
    for (size_t i = 0; i < setup_->solids.size(); ++i) {
        if (setup_->owns_solid(i)) setup_->solids[i]->set_stop(stop);
    }
}

/// Begins the sink, and counts slices that an earlier print has written.
Result<void> PrintJobImpl::resume(SliceSink& sink, SliceCommitter* committer) {
    if (const Result<void> begun = sink.begin(setup_->info); !begun) return begun;
    if (setup_->options.fractions != nullptr) {
        const Result<void> begun =
            setup_->options.fractions->begin(setup_->info, setup_->slabs.materials);
        if (!begun) return begun;
    }
    const Result<int32_t> resumed =
        sink.resume([&](const SliceView& slice) { return committer->count_resumed(slice); });
    if (!resumed) return resumed.error();
    committer->end_resumed();
    return {};
}

/// Shows what surface stages print, before the voxels: of surfaces of their own on which nothing is
/// inferred, since those that are printed are evaluated where, and as often as, they are needed.
void PrintJobImpl::show_surface_logs(SliceCommitter* committer) {
    surface::SurfaceOptions options = setup_->surface_options;
    options.infer_identity = false;
    for (size_t i = 0; i < setup_->input.parts.size(); ++i) {
        const part::Part& part = setup_->input.parts[i];
        if (!setup_->owns_solid(i) || part.fablet->surface_segments.printf_count == 0) continue;
        if (committer->stopped()) return;
        const auto surface = surface::Surface::create(part, options);
        if (!surface) return committer->fail(surface.error());
        segments::PrintfLog log;
        (*surface)->log(&log);
        if (const Result<void> status = (*surface)->status(); !status)
            return committer->fail(status.error());
        if (!committer->show_log(log)) return;
    }
}

}  // namespace

Result<std::unique_ptr<PrintJob>> PrintJob::create(PrintInput input, PrintOptions options) {
    Result<std::unique_ptr<PrintSetup>> setup = set_up_print(std::move(input), std::move(options));
    if (!setup) return setup.error();
    return std::unique_ptr<PrintJob>(std::make_unique<PrintJobImpl>(std::move(*setup)));
}

}  // namespace openfab::pipeline
