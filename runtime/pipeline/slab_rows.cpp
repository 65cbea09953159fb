// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The rows of blocks of a slab, from evaluation to dither. Where effects change neighbours, rows are made of
// those around them, in the slabs below and above, too. These are evaluated again for each slab that needs
// them, so that slabs stay independent: their order, `--slices` and what is resumed change nothing.

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <utility>

#include "base/at.h"
#include "base/check.h"
#include "base/count_bits.h"
#include "base/stage_timer.h"
#include "runtime/pipeline/fraction_rows.h"
#include "runtime/pipeline/slab.h"

namespace openfab::pipeline {

namespace {

/// Returns how many voxels of those slices have no material of their own.
int64_t count_mixed(const dither::RowBand& band, uint8_t slices) {
    int64_t count = 0;
    for (int32_t block = band.first_block; band.any_mixed && block < band.end_block; ++block)
        for (int32_t y = 0; at(band.mixed_blocks, block) != 0 && y < 8; ++y)
            count += count_bits({band.mixed_row(y) + 8 * block, 8}, slices);
    return count;
}

}  // namespace

/// The rows of one y in all slabs within reach, from the lowest on; null where there is no such row.
/// Gives them back with its last user.
class SlabRun::Around {
  public:
    Around(Pool<SlabRow>* pool, int32_t slabs) : rows(static_cast<size_t>(slabs)), pool_(pool) {}
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
    SlabRow*& own() { return rows[rows.size() / 2]; }

  private:
    Pool<SlabRow>* pool_;
};

/// A row that an effect on neighbours makes of those around it.
struct SlabRun::Task {
    int32_t row = 0;
    std::vector<std::shared_ptr<Around>> around;  ///< empty: none
};

/// Returns the reach of the effects on neighbours from a number on, one after the other.
Vec3i SlabRun::reach_blocks(size_t first_spread) const {
    Vec3i reach;
    for (size_t k = first_spread; k < setup_.spreads.size(); ++k)
        reach = reach + setup_.spreads[k]->reach_blocks();
    return reach;
}

void SlabRun::take_log(SlabRow* row) {
    if (!row->log.empty()) log_.append(&row->log);
    if (row->overlaps.empty()) return;
    overlaps_.add(row->overlaps);
    row->overlaps.clear();
}

/// Applies the effects on single voxels, and gives fractions to whom they are for.
void SlabRun::finish_row(SlabRow* row) {
    const bool separate = setup_.separate_mixtures;
    mixed_ += count_mixed(separate ? row->mixtures : row->band, slices_);
    for (const auto& effect : effects_) {
        effect->before_dither(own_.slab(), setup_.size.y, &row->band);
        if (separate) effect->before_dither(own_.slab(), setup_.size.y, &row->mixtures);
    }
    if (setup_.fractions == nullptr) return;
    write_fractions(separate ? row->mixtures : row->band, own_.slab(), slices_, setup_.size,
                    setup_.materials, setup_.fractions);
    if (setup_.rates != nullptr && row->rates.any)
        write_rates(row->rates, own_.slab(), row->band.row, slices_, setup_.size, setup_.fractions);
}

abi::KernelStatus SlabRun::evaluate_around(int32_t row, Pool<volume::BlockEvaluator>* evaluators,
                                           Around* around) {
    const auto below = static_cast<int32_t>(near_.size() / 2);
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
        at(around->rows, i) = scratch;
        volume::BlockEvaluator* evaluator = own_.take_evaluator(evaluators);
        status = parts.evaluate_row(row, below == 0 ? slices_ : inside, scratch, evaluator);
        evaluators->give(evaluator);
        if (status.ok() && !setup_.spreads.empty())
            setup_.spreads.front()->note(scratch->band, &scratch->notes);
    }
    if (status.ok() && setup_.spreads.empty()) finish_row(around->own());
    return status;
}

/// Makes the rows of a task by an effect on neighbours.
std::shared_ptr<SlabRun::Around> SlabRun::spread(size_t number, const Task& task) {
    if (task.around.empty()) return nullptr;
    const StageTimer timer(Stage::kRows);
    const process::Effect& effect = *setup_.spreads[number];
    const Vec3i reach = effect.reach_blocks();
    const int32_t below = reach_blocks(number + 1).z;  // slabs that later ones ask for
    auto out = std::make_shared<Around>(&rows_, 2 * below + 1);
    for (int32_t i = 0; i <= 2 * below; ++i) {
        process::NearBands near{{}, own_.slab() - below + i, task.row};
        for (int32_t slab = i; slab <= i + 2 * reach.z; ++slab) {
            for (const std::shared_ptr<Around>& around : task.around) {
                const SlabRow* row = around->rows[static_cast<size_t>(slab)];
                near.bands.push_back(row == nullptr
                                         ? process::NearBands::One{}
                                         : process::NearBands::One{&row->band, &row->notes});
            }
        }
        if (near.bands[near.bands.size() / 2].band == nullptr) continue;
        SlabRow* row = rows_.take([] { return std::make_unique<SlabRow>(); });
        at(out->rows, i) = row;
        effect.spread(near, setup_.size, &row->band);
        if (number + 1 < setup_.spreads.size())
            setup_.spreads[number + 1]->note(row->band, &row->notes);
        else
            finish_row(row);
    }
    return out;
}

abi::KernelStatus SlabRun::run_rows(int32_t first, int32_t end,
                                    Pool<volume::BlockEvaluator>* evaluators,
                                    const StopFlags& stop) {
    using Rows = std::shared_ptr<Around>;
    using tbb::filter_mode;
    const size_t spreads = setup_.spreads.size();
    const Vec3i reach = reach_blocks(0);
    std::atomic<abi::KernelStatus> status{abi::KernelStatus{}};
    int32_t next = first - reach.y;
    dither_.begin(own_.slab(), slices_, &planes_);
    // Rows passed to the dither, in order; it returns their bands one row later.
    std::deque<SlabRow*> in_order;
    const auto source = [&](tbb::flow_control& control) {
        if (next >= end + reach.y || !status.load().ok() || stop.requested()) {
            control.stop();
            return int32_t{0};
        }
        return next++;
    };
    const auto evaluate = [&](int32_t row) {
        const StageTimer timer(Stage::kRows);
        auto around = std::make_shared<Around>(&rows_, 2 * reach.z + 1);
        const abi::KernelStatus result = evaluate_around(row, evaluators, around.get());
        if (!result.ok()) status.store(result);
        return around;
    };
    const auto dither = [&](const Rows& around) {
        if (around == nullptr || around->own() == nullptr) return;
        in_order.push_back(std::exchange(around->own(), nullptr));
        if (spreads == 0) take_log(in_order.back());
        if (!status.load().ok()) return;
        dither::RowBand* released = nullptr;
        const abi::KernelStatus result = dither_.add(&in_order.back()->band, &released);
        if (!result.ok()) status.store(result);
        if (released == nullptr) return;
        OPENFAB_CHECK(released == &in_order.front()->band);
        rows_.give(in_order.front());
        in_order.pop_front();
    };
    tbb::filter<void, Rows> rows =
        tbb::make_filter<void, int32_t>(filter_mode::serial_in_order, source) &
        tbb::make_filter<int32_t, Rows>(filter_mode::parallel, evaluate);
    struct Window {
        std::deque<Rows> rows;  // that wait for those around them
        int32_t next = 0;       // row in the middle
    };
    std::vector<Window> windows(spreads);
    for (size_t k = 0; k < spreads; ++k) {
        const int32_t around = setup_.spreads[k]->reach_blocks().y;
        windows[k].next = first - reach_blocks(k).y - around;
        const auto gather = [&, k, around](const Rows& last) {
            Task task;
            if (last == nullptr) return task;
            auto& [window, middle] = windows[k];
            window.push_back(last);
            if (static_cast<int32_t>(window.size()) > 2 * around + 1) window.pop_front();
            task.row = middle++;
            if (static_cast<int32_t>(window.size()) <= 2 * around || !status.load().ok())
                return task;
            task.around = {window.begin(), window.end()};
            if (k == 0 && task.row >= first && task.row < end)
                take_log(window[static_cast<size_t>(around)]->own());
            return task;
        };
        rows = rows & tbb::make_filter<Rows, Task>(filter_mode::serial_in_order, gather) &
               tbb::make_filter<Task, Rows>(filter_mode::parallel,
                                            [&, k](const Task& task) { return spread(k, task); });
    }
    // Isolated: a thread that waits here must not begin another slab, which would delay this one.
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_pipeline(
            static_cast<size_t>(setup_.rows_in_flight),
            rows & tbb::make_filter<Rows, void>(filter_mode::serial_in_order, dither));
    });
    dither::RowBand* released = nullptr;
    const abi::KernelStatus result = dither_.end(&released);
    for (SlabRow* row : in_order)
        rows_.give(row);
    return status.load().ok() ? result : status.load();
}

}  // namespace openfab::pipeline
