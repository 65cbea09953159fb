// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/slab.h"

#include <algorithm>
#include <utility>

#include "base/at.h"
#include "base/check.h"
#include "base/stage_timer.h"

namespace openfab::pipeline {

SlabRun::SlabRun(const SlabSetup& setup)
    : setup_(setup),
      own_(setup),
      dither_(setup.channels, setup.isa, setup.dither, setup.seed, setup.size, &setup.support) {
    for (int32_t i = 0; i < 2 * reach_blocks(0).z; ++i)
        near_.push_back(std::make_unique<SlabParts>(setup));
}

abi::KernelStatus SlabRun::begin(int32_t slab, Pool<volume::BlockEvaluator>* evaluators,
                                 const std::atomic<bool>* interrupt) {
    abi::KernelStatus status = own_.begin(slab, evaluators, interrupt);
    times.coverage = own_.seconds_coverage;
    const auto below = static_cast<int32_t>(near_.size() / 2);
    for (int32_t i = 0; i < 2 * below && status.ok(); ++i) {
        SlabParts& parts = *at(near_, i);
        status = parts.begin(slab + (i < below ? i - below : i - below + 1), evaluators, interrupt);
    }
    for (const auto& parts : near_)
        times.coverage += parts->seconds_coverage;
    return status;
}

void SlabRun::set_effects(process::SliceEffects effects) {
    effects_ = std::move(effects);
    // Support comes after the dither.
    dither_.supported = nullptr;
    if (effects_.empty() || !setup_.support.on()) return;
    dither_.supported = [this](dither::RowBand* band) {
        for (const auto& effect : effects_)
            effect->after_dither(own_.slab(), setup_.size.y, band);
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

Vec2<int32_t> SlabRun::rows_to_run() const {
    Vec2<int32_t> rows = own_.rows();
    if (std::ranges::none_of(setup_.spreads, [](const auto* e) { return e->leaves_parts(); }))
        return rows;
    for (const auto& parts : near_) {
        const Vec2<int32_t> more = parts->rows();
        if (more.x >= more.y) continue;
        rows = rows.x < rows.y ? Vec2<int32_t>{std::min(rows.x, more.x), std::max(rows.y, more.y)}
                               : more;
    }
    if (rows.x >= rows.y) return rows;
    const int32_t reach = reach_blocks(0).y;
    return {std::max(rows.x - reach, 0), std::min(rows.y + reach, (setup_.size.y + 7) / 8)};
}

}  // namespace openfab::pipeline
