// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/slab.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <utility>

#include "base/check.h"
#include "base/stage_timer.h"
#include "runtime/pipeline/fraction_rows.h"

namespace openfab::pipeline {

namespace {

/// Returns how many voxels of those slices have no material of their own.
int64_t count_mixed(const dither::RowBand& band, uint8_t slices) {
    if (!band.any_mixed) return 0;
    int64_t count = 0;
    for (const uint8_t column : band.mixed)
        count += std::popcount(static_cast<uint8_t>(column & slices));
    return count;
}

}  // namespace

SlabRun::SlabRun(const SlabSetup& setup)
    : setup_(setup),
      own_(setup),
      dither_(setup.channels, setup.isa, setup.dither, setup.seed, setup.size, &setup.support) {
    if (setup.bleed == nullptr) return;
    for (int32_t i = 0; i < 2 * setup.bleed->reach_blocks().z; ++i)
        near_.push_back(std::make_unique<SlabParts>(setup));
}

abi::KernelStatus SlabRun::begin(int32_t slab, Pool<volume::BlockEvaluator>* evaluators,
                                 const std::atomic<bool>* interrupt) {
    abi::KernelStatus status = own_.begin(slab, evaluators, interrupt);
    times.coverage = own_.seconds_coverage;
    const auto below = static_cast<int32_t>(near_.size() / 2);
    for (int32_t i = 0; i < 2 * below && status.ok(); ++i) {
        SlabParts& parts = *near_[static_cast<size_t>(i)];
        status = parts.begin(slab + (i < below ? i - below : i - below + 1), evaluators, interrupt);
    }
    for (const auto& parts : near_)
        times.coverage += parts->seconds_coverage;
    return status;
}

void SlabRun::set_nozzles(std::shared_ptr<const process::Nozzles> nozzles) {
    nozzles_ = std::move(nozzles);
    // Support comes after the dither.
    dither_.supported = nullptr;
    if (nozzles_ == nullptr || !setup_.support.on()) return;
    dither_.supported = [this](dither::RowBand* band) {
        nozzles_->apply_to_codes(own_.slab(), setup_.size.y, band);
    };
}

/// Returns false where memory ran out.
bool SlabRun::prepare(uint8_t slices) {
    OPENFAB_CHECK_NE(slices, 0);
    slices_ = slices;
    const StageTimer timer(Stage::kPack);
    return planes_.reset(setup_.size.x, setup_.size.y, setup_.bits);
}

abi::KernelStatus SlabRun::run(uint8_t slices, Pool<volume::BlockEvaluator>* evaluators,
                               const StopFlags& stop) {
    if (!prepare(slices)) return abi::KernelStatus::of_code(halide_error_code_out_of_memory);
    abi::KernelStatus status;
    const Vec2<int32_t> rows = rows_to_run();
    if (rows.x < rows.y) status = run_rows(rows.x, rows.y, evaluators, stop);
    if (status.ok() && stop.requested()) status = abi::KernelStatus::stopped();
    times.dither = dither_.seconds_dither;
    times.support = dither_.seconds_support;
    times.pack = dither_.seconds_pack;
    return status;
}

abi::KernelStatus SlabRun::try_rows(uint8_t slices, Pool<volume::BlockEvaluator>* evaluators,
                                    const StopFlags& stop, int32_t* pieces) {
    // So many that a few are spread over the slab, and so large that all threads have work in one.
    constexpr uint32_t kOrderBits = 4;
    const int32_t most = std::exchange(*pieces, 0);
    if (!prepare(slices)) return abi::KernelStatus::of_code(halide_error_code_out_of_memory);
    const Vec2<int32_t> rows = rows_to_run();
    const int32_t all = std::max(rows.y - rows.x, 0);
    const int32_t length = std::max((all >> kOrderBits) + 1, 2 * setup_.rows_in_flight);
    abi::KernelStatus status;
    for (uint32_t k = 0; k < 1u << kOrderBits && status.ok() && *pieces < most; ++k) {
        uint32_t place = 0;  // the bits of k in reverse
        for (uint32_t bit = 0; bit < kOrderBits; ++bit)
            place |= (k >> bit & 1) << (kOrderBits - 1 - bit);
        const int32_t first = rows.x + static_cast<int32_t>(place) * length;
        const int32_t end = std::min(first + length, rows.y);
        if (first >= end) continue;
        ++*pieces;
        status = run_rows(first, end, evaluators, stop);
        if (status.ok() && stop.requested()) status = abi::KernelStatus::stopped();
    }
    return status;
}

void SlabRun::take_notes(SlabRow* row) {
    if (!row->log.empty()) log_.append(&row->log);
    if (row->overlaps.empty()) return;
    overlaps_.add(row->overlaps);
    row->overlaps.clear();
}

Vec2<int32_t> SlabRun::rows_to_run() const {
    Vec2<int32_t> rows = own_.rows();
    if (setup_.bleed == nullptr || !setup_.bleed->leaves_parts()) return rows;
    for (const auto& parts : near_) {
        const Vec2<int32_t> more = parts->rows();
        if (more.x >= more.y) continue;
        rows = rows.x < rows.y ? Vec2<int32_t>{std::min(rows.x, more.x), std::max(rows.y, more.y)}
                               : more;
    }
    if (rows.x >= rows.y) return rows;
    const int32_t reach = setup_.bleed->reach_blocks().y;
    return {std::max(rows.x - reach, 0), std::min(rows.y + reach, (setup_.size.y + 7) / 8)};
}

/// Gives the nozzles' substitutes to a band, and its fractions to whom they are for.
void SlabRun::finish_band(dither::RowBand* band, dither::RowBand* mixtures) {
    mixed_ += count_mixed(setup_.separate_mixtures ? *mixtures : *band, slices_);
    if (nozzles_ != nullptr) {
        nozzles_->apply(own_.slab(), setup_.size.y, band);
        if (setup_.separate_mixtures) nozzles_->apply(own_.slab(), setup_.size.y, mixtures);
    }
    if (setup_.fractions == nullptr) return;
    write_fractions(setup_.separate_mixtures ? *mixtures : *band, own_.slab(), slices_, setup_.size,
                    setup_.materials, setup_.fractions);
}

abi::KernelStatus SlabRun::run_rows(int32_t first, int32_t end,
                                    Pool<volume::BlockEvaluator>* evaluators,
                                    const StopFlags& stop) {
    if (setup_.bleed != nullptr) return run_rows_with_bleed(first, end, evaluators, stop);
    std::atomic<abi::KernelStatus> status{abi::KernelStatus{}};
    int32_t next = first;
    dither_.begin(own_.slab(), slices_, &planes_);
    std::vector<SlabRow*>
        in_order;  // rows passed to the dither, in order; it returns their bands one row later
    const auto release = [&](const dither::RowBand* band) {
        if (band == nullptr) return;
        OPENFAB_CHECK(!in_order.empty() && band == &in_order.front()->band);
        rows_.give(in_order.front());
        in_order.erase(in_order.begin());
    };
    const auto source = [&](tbb::flow_control& control) {
        if (next >= end || !status.load().ok() || stop.requested()) {
            control.stop();
            return int32_t{0};
        }
        return next++;
    };
    const auto evaluate = [&](int32_t row) {
        const StageTimer timer(Stage::kRows);
        SlabRow* scratch = rows_.take([] { return std::make_unique<SlabRow>(); });
        volume::BlockEvaluator* evaluator = own_.take_evaluator(evaluators);
        const abi::KernelStatus result = own_.evaluate_row(row, slices_, scratch, evaluator);
        evaluators->give(evaluator);
        if (result.ok())
            finish_band(&scratch->band, &scratch->mixtures);
        else
            status.store(result);
        return scratch;
    };
    const auto dither = [&](SlabRow* scratch) {
        in_order.push_back(scratch);
        take_notes(scratch);
        if (!status.load().ok()) return;
        dither::RowBand* released = nullptr;
        const abi::KernelStatus result = dither_.add(&scratch->band, &released);
        if (!result.ok()) status.store(result);
        release(released);
    };
    // Isolated: a thread that waits here must not begin another slab, which would delay this one.
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_pipeline(
            static_cast<size_t>(setup_.rows_in_flight),
            tbb::make_filter<void, int32_t>(tbb::filter_mode::serial_in_order, source) &
                tbb::make_filter<int32_t, SlabRow*>(tbb::filter_mode::parallel, evaluate) &
                tbb::make_filter<SlabRow*, void>(tbb::filter_mode::serial_in_order, dither));
    });
    dither::RowBand* released = nullptr;
    const abi::KernelStatus result = dither_.end(&released);
    for (SlabRow* row : in_order)
        rows_.give(row);
    return status.load().ok() ? result : status.load();
}

}  // namespace openfab::pipeline
