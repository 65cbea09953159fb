// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A slab whose voxels bleed: its rows of blocks are made of those around them, in the slabs below and
// above, too. These are evaluated again for each slab that needs them, so that slabs stay independent:
// their order, `--slices` and what is resumed change nothing.

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <utility>

#include "base/check.h"
#include "base/stage_timer.h"
#include "runtime/pipeline/slab.h"

namespace openfab::pipeline {

/// The rows of one y in all slabs within reach, from the lowest on; null where there is no such row.
/// Gives them back with its last user.
class SlabRun::Around {
  public:
    Around(Pool<SlabRow>* pool, size_t slabs) : rows(slabs), pool_(pool) {}
    ~Around() {
        for (SlabRow* row : rows) {
            if (row == nullptr) continue;
            segments::PrintfLog dropped;  // of rows that are looked at for their neighbours alone
            if (!row->log.empty()) dropped.append(&row->log);
            row->overlaps.clear();
            pool_->give(row);
        }
    }
    Around(const Around&) = delete;
    Around& operator=(const Around&) = delete;

    std::vector<SlabRow*> rows;
    SlabRow* own() const { return rows[rows.size() / 2]; }

  private:
    Pool<SlabRow>* pool_;
};

abi::KernelStatus SlabRun::evaluate_around(int32_t row, Pool<volume::BlockEvaluator>* evaluators,
                                           Around* around) {
    const int32_t below = setup_.bleed->reach_blocks().z;
    abi::KernelStatus status;
    if (row < 0 || row >= (setup_.size.y + 7) / 8) return status;
    for (int32_t i = 0; i < static_cast<int32_t>(around->rows.size()) && status.ok(); ++i) {
        const SlabParts& parts =
            i == below ? own_ : *near_[static_cast<size_t>(i < below ? i : i - 1)];
        const int32_t left = setup_.size.z - 8 * parts.slab();
        if (parts.slab() < 0 || left <= 0) continue;
        // What is not printed matters to what is.
        const auto inside = static_cast<uint8_t>(left >= 8 ? 255 : (1 << left) - 1);
        SlabRow* scratch = rows_.take([] { return std::make_unique<SlabRow>(); });
        around->rows[static_cast<size_t>(i)] = scratch;
        volume::BlockEvaluator* evaluator = own_.take_evaluator(evaluators);
        status = parts.evaluate_row(row, below == 0 ? slices_ : inside, scratch, evaluator);
        evaluators->give(evaluator);
        if (status.ok()) setup_.bleed->find_present(scratch->band, &scratch->present);
    }
    return status;
}

abi::KernelStatus SlabRun::run_rows_with_bleed(int32_t first, int32_t end,
                                               Pool<volume::BlockEvaluator>* evaluators,
                                               const StopFlags& stop) {
    using Window = std::vector<std::shared_ptr<Around>>;
    struct Task {
        int32_t row = -1;
        Window around;
    };
    const int32_t reach = setup_.bleed->reach_blocks().y;
    std::atomic<abi::KernelStatus> status{abi::KernelStatus{}};
    int32_t next = first - reach, gathered = next;
    dither_.begin(own_.slab(), slices_, &planes_);
    std::deque<SlabRow*> in_order;  // rows passed to the dither, which returns them one row later
    std::deque<std::shared_ptr<Around>> window;
    const auto source = [&](tbb::flow_control& control) {
        if (next >= end + reach || !status.load().ok() || stop.requested()) {
            control.stop();
            return int32_t{0};
        }
        return next++;
    };
    const auto evaluate = [&](int32_t row) {
        const StageTimer timer(Stage::kRows);
        auto around = std::make_shared<Around>(&rows_, near_.size() + 1);
        const abi::KernelStatus result = evaluate_around(row, evaluators, around.get());
        if (!result.ok()) status.store(result);
        return around;
    };
    const auto gather = [&](const std::shared_ptr<Around>& around) {
        window.push_back(around);
        if (static_cast<int32_t>(window.size()) > 2 * reach + 1) window.pop_front();
        Task task;
        task.row = gathered++ - reach;
        if (task.row < first || !status.load().ok()) return Task{};
        task.around = {window.begin(), window.end()};
        take_notes(task.around[static_cast<size_t>(reach)]->own());
        return task;
    };
    const auto spread = [&](const Task& task) -> SlabRow* {
        if (task.row < 0) return nullptr;
        const StageTimer timer(Stage::kRows);
        process::NearBands near{{}, own_.slab(), task.row};
        for (size_t slab = 0; slab <= near_.size(); ++slab) {
            for (const std::shared_ptr<Around>& around : task.around) {
                const SlabRow* row = around->rows[slab];
                near.bands.push_back(row == nullptr
                                         ? process::NearBands::One{}
                                         : process::NearBands::One{&row->band, &row->present});
            }
        }
        SlabRow* out = rows_.take([] { return std::make_unique<SlabRow>(); });
        process::BleedScratch* scratch =
            bleeds_.take([] { return std::make_unique<process::BleedScratch>(); });
        setup_.bleed->apply(near, setup_.size, scratch, &out->band);
        bleeds_.give(scratch);
        finish_band(&out->band, nullptr);
        return out;
    };
    const auto dither = [&](SlabRow* row) {
        if (row == nullptr) return;
        in_order.push_back(row);
        if (!status.load().ok()) return;
        dither::RowBand* released = nullptr;
        const abi::KernelStatus result = dither_.add(&row->band, &released);
        if (!result.ok()) status.store(result);
        if (released == nullptr) return;
        OPENFAB_CHECK(released == &in_order.front()->band);
        rows_.give(in_order.front());
        in_order.pop_front();
    };
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_pipeline(
            static_cast<size_t>(setup_.rows_in_flight),
            tbb::make_filter<void, int32_t>(tbb::filter_mode::serial_in_order, source) &
                tbb::make_filter<int32_t, std::shared_ptr<Around>>(tbb::filter_mode::parallel,
                                                                   evaluate) &
                tbb::make_filter<std::shared_ptr<Around>, Task>(tbb::filter_mode::serial_in_order,
                                                                gather) &
                tbb::make_filter<Task, SlabRow*>(tbb::filter_mode::parallel, spread) &
                tbb::make_filter<SlabRow*, void>(tbb::filter_mode::serial_in_order, dither));
    });
    dither::RowBand* released = nullptr;
    const abi::KernelStatus result = dither_.end(&released);
    for (SlabRow* row : in_order)
        rows_.give(row);
    return status.load().ok() ? result : status.load();
}

}  // namespace openfab::pipeline
