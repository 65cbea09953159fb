// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/slab_loop.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "abi/halide_hooks.h"
#include "base/stage_timer.h"
#include "runtime/nearest/cache_period.h"
#include "runtime/pipeline/slice_totals.h"

namespace openfab::pipeline {

SlabSlices SlabLoop::with_effects(SlabSlices slices) const {
    slices.effects.clear();
    for (process::Effect* effect : setup_.options.effects) {
        if (slices.slab < 0) break;
        if (auto here = effect->at_slice(slices.first)) slices.effects.push_back(std::move(here));
    }
    return slices;
}

SlabRun* SlabLoop::take_run() {
    return runs_.take([&] { return std::make_unique<SlabRun>(setup_.slabs); });
}

void SlabLoop::print_rest(const SlabTarget& target) {
    const Vec2<int32_t>& range = setup_.range;
    if (target.committer->slices() == range.y - range.x) return;
    // Start with the slab of the last resumed slice.
    int32_t next = (range.x + std::max(target.committer->resumed() - 1, 0)) / 8;
    const int32_t end = (range.y + 7) / 8;
    if (next < end) print_first(next++, target);
    print_all([&] { return next < end ? setup_.slices_of(next++) : SlabSlices{}; }, target);
}

void SlabLoop::print_all(const std::function<SlabSlices()>& next, const SlabTarget& target) {
    const auto source = [&](tbb::flow_control& control) {
        SlabSlices slices;
        if (!target.committer->stopped()) slices = with_effects(next());
        if (slices.slab < 0) control.stop();
        return slices;
    };
    const auto print = [&](const SlabSlices& slab) {
        return std::make_shared<FinishedSlices>(print_slab(slab, target));
    };
    const auto commit = [&](const std::shared_ptr<FinishedSlices>& finished) {
        target.committer->commit(std::move(*finished));
    };
    // A slab's token is released when its slices are written, which throttles the others if the
    // sink is slow.
    using Finished = std::shared_ptr<FinishedSlices>;
    tbb::parallel_pipeline(
        static_cast<size_t>(setup_.plan.slabs_in_flight),
        tbb::make_filter<void, SlabSlices>(tbb::filter_mode::serial_in_order, source) &
            tbb::make_filter<SlabSlices, Finished>(tbb::filter_mode::parallel, print) &
            tbb::make_filter<Finished, void>(tbb::filter_mode::serial_in_order, commit));
}

// Trees that no slab in flight and none of the two before these used lie behind the print.
void SlabLoop::begin_period() const {
    nearest::begin_period(setup_.trees.get(), setup_.plan.slabs_in_flight + 1);
}

void SlabLoop::print_first(int32_t slab, const SlabTarget& target) {
    begin_period();
    SlabRun* run = take_run();
    SlabSlices slices = with_effects(setup_.slices_of(slab));
    const SlabClock::Running running(setup_.options.clock, slices.first, slices.end);
    const abi::KernelStatus begun = run->begin(slab, &evaluators_, target.interrupt);
    // printf lines are ordered by column of a slab, which printing a single slice would break.
    const bool has_printf = std::any_of(
        setup_.parts.begin(), setup_.parts.end(),
        [](const auto& p) { return p->part->fablet->volume_segments.printf_count > 0; });
    if (slices.first + 1 < slices.end &&
        run->blocks_to_evaluate() > setup_.options.most_blocks_at_first && !has_printf) {
        SlabSlices alone = slices;
        alone.end = alone.first + 1;
        target.committer->commit(print_slices(alone, begun, run, target));
        ++slices.first;
        slices = with_effects(std::move(slices));
    }
    target.committer->commit(print_slices(slices, begun, run, target));
    runs_.give(run);
}

FinishedSlices SlabLoop::print_slab(const SlabSlices& slab, const SlabTarget& target) {
    begin_period();
    SlabRun* run = take_run();
    const SlabClock::Running running(setup_.options.clock, slab.first, slab.end);
    const abi::KernelStatus begun = run->begin(slab.slab, &evaluators_, target.interrupt);
    FinishedSlices finished = print_slices(slab, begun, run, target);
    runs_.give(run);
    return finished;
}

// Prints slices of the slab that `run` has begun with the status `begun`.
FinishedSlices SlabLoop::print_slices(const SlabSlices& slices, abi::KernelStatus begun,
                                      SlabRun* run, const SlabTarget& target) {
    FinishedSlices finished;
    finished.first = slices.first;
    finished.end = slices.end;
    const uint8_t bits = bits_of_slices(slices.first, slices.end);
    run->set_effects(slices.effects);
    finished.status =
        begun.ok() ? run->run(bits, &evaluators_, target.committer->stop_flags()) : begun;
    if (!run->log().empty()) finished.log.append(&run->log());
    if (!finished.status.ok()) {
        finished.kernel_error = abi::take_kernel_error();
    } else if (finished.outcome = outcome(); !finished.outcome) {
        // Slices printed with an empty patch, or without their fractions, must not be committed.
    } else if (target.committer->stopped()) {
        finished.status = abi::KernelStatus::stopped();
    } else {
        encode(target.sink, *run, slices.shift, &finished);
    }
    return finished;
}

Result<void> SlabLoop::outcome() const {
    Result<void> outcome = setup_.solid_status();
    if (outcome && setup_.options.fractions != nullptr)
        outcome = setup_.options.fractions->status();
    return outcome;
}

void SlabLoop::encode(const SliceSink& sink, const SlabRun& run, int32_t shift,
                      FinishedSlices* finished) {
    const dither::SlabPlanes& planes = run.planes();
    const int32_t first = finished->first, end = finished->end;
    finished->slices.resize(static_cast<size_t>(end - first));
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(first, end, [&](int32_t z) {
            FinishedSlices::Slice& slice = finished->slices[static_cast<size_t>(z - first)];
            SliceView view;
            view.z = z + shift;
            view.data = planes.data.get() + (z & 7) * planes.plane_bytes;
            view.row_bytes = static_cast<size_t>(planes.row_bytes);
            view.width = planes.width;
            view.height = planes.height;
            slice.z = view.z;
            double counting = 0, encoding = 0;
            {
                const StageTimer timer(Stage::kCount, &counting);
                slice.totals = count_slice(view, setup_.info.bits);
            }
            {
                const StageTimer timer(Stage::kEncode, &encoding);
                slice.bytes = sink.encode(view);
            }
            const std::lock_guard lock(encode_mutex_);
            seconds_count_ += counting;
            seconds_encode_ += encoding;
        });
    });
}

}  // namespace openfab::pipeline
