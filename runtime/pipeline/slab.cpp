// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/slab.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "base/check.h"
#include "base/stage_timer.h"
#include "runtime/pipeline/fraction_rows.h"

namespace openfab::pipeline {

int32_t model_materials(const std::vector<part::Part>& parts, int32_t materials,
                        int32_t support_code) {
    if (support_code != materials) return materials;
    for (const part::Part& part : parts) {
        for (const uint8_t code : part.slot_material) {
            if (code == materials) return materials;
        }
    }
    return materials - 1;
}

SlabRun::SlabRun(const SlabSetup& setup)
    : setup_(setup),
      dither_(setup.channels, setup.isa, setup.dither, setup.seed, setup.size, &setup.support) {}

void SlabRun::set_nozzles(std::shared_ptr<const process::Nozzles> nozzles) {
    nozzles_ = std::move(nozzles);
    // Support comes after the dither.
    dither_.supported = nullptr;
    if (nozzles_ == nullptr || !setup_.support.on()) return;
    dither_.supported = [this](dither::RowBand* band) {
        nozzles_->apply_to_codes(slab_, setup_.size.y, band);
    };
}

/// Returns false where memory ran out.
bool SlabRun::prepare(uint8_t slices) {
    OPENFAB_CHECK_NE(slices, 0);
    slices_ = slices * 0x0101010101010101u;
    const StageTimer timer(Stage::kPack);
    return planes_.reset(setup_.size.x, setup_.size.y, setup_.bits);
}

/// Returns the rows of blocks that have something to print: [x, y).
Vec2<int32_t> SlabRun::rows_in_use() const {
    int32_t first = setup_.size.y, end = 0;
    for (const auto& active : active_) {
        first = std::min(first, active->cull.first_y());
        end = std::max(end, active->cull.end_y());
    }
    const int32_t rows = (setup_.size.y + 7) / 8;
    for (int32_t row = 0; setup_.support.on() && row < rows; ++row) {
        const Vec2<int32_t> blocks = dither::support_blocks(setup_.support, row, 8 * slab_);
        if (blocks.x >= blocks.y) continue;
        first = std::min(first, row);
        end = std::max(end, row + 1);
    }
    return {first, end};
}

abi::KernelStatus SlabRun::run(uint8_t slices, Pool<volume::BlockEvaluator>* evaluators,
                               const StopFlags& stop) {
    if (!prepare(slices)) return abi::KernelStatus::of_code(halide_error_code_out_of_memory);
    abi::KernelStatus status;
    const Vec2<int32_t> rows = rows_in_use();
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
    const Vec2<int32_t> rows = rows_in_use();
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

abi::KernelStatus SlabRun::begin(int32_t slab, Pool<volume::BlockEvaluator>* evaluators,
                                 const std::atomic<bool>* interrupt) {
    interrupt_ = interrupt;
    slab_ = slab;
    blocks_to_evaluate_ = 0;
    // Memory is reused per part: if shared between parts, each buffer would grow to the size of the
    // largest.
    std::map<int32_t, std::unique_ptr<ActivePart>> kept;
    for (auto& active : active_)
        kept[active->part->index] = std::move(active);
    active_.clear();
    for (int32_t index : setup_.order) {
        const volume::PlacedPart& part = *(*setup_.parts)[index];
        if (part.box.lo.z >= 8 * slab + 8 || part.box.hi.z <= 8 * slab) continue;
        std::unique_ptr<ActivePart>& known = kept[index];
        if (known == nullptr) known = std::make_unique<ActivePart>();
        known->part = &part;
        active_.push_back(std::move(known));
    }
    std::atomic<int64_t> room = kUniformBlockBytes;
    std::atomic<abi::KernelStatus> status{abi::KernelStatus{}};
    // Isolated like rows. In parallel over parts, or the first slab would run on one thread.
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(
            tbb::blocked_range<size_t>(0, active_.size(), 1),
            [&](const tbb::blocked_range<size_t>& range) {
                for (size_t i = range.begin(); i < range.end() && status.load().ok(); ++i) {
                    volume::BlockEvaluator* evaluator = take_evaluator(evaluators);
                    const abi::KernelStatus result = begin_part(active_[i].get(), evaluator, &room);
                    evaluators->give(evaluator);
                    if (!result.ok()) status.store(result);
                }
            },
            tbb::simple_partitioner());
    });
    std::erase_if(active_, [](const auto& active) { return !active->covers(); });
    for (const auto& active : active_) {
        times.coverage += active->seconds_coverage;
        blocks_to_evaluate_ += active->cull.blocks_to_evaluate();
    }
    return status.load();
}

abi::KernelStatus SlabRun::begin_part(ActivePart* active, volume::BlockEvaluator* evaluator,
                                      std::atomic<int64_t>* room) const {
    const volume::PlacedPart& part = *active->part;
    active->seconds_coverage = 0;
    {
        const StageTimer timer(Stage::kCoverage);
        part.placed->coverage(slab_, &active->mask, interrupt_, &active->seconds_coverage);
        if (part.cut != nullptr) part.cut->apply(slab_, &active->mask, &active->filled);
    }
    if (interrupt_ != nullptr && interrupt_->load()) return abi::KernelStatus::stopped();
    if (!active->covers()) return {};
    return active->cull.run(part, slab_, active->mask, setup_.culling, evaluator, room);
}

volume::BlockEvaluator* SlabRun::take_evaluator(Pool<volume::BlockEvaluator>* evaluators) const {
    return evaluators->take(
        [&] { return std::make_unique<volume::BlockEvaluator>(setup_.isa, setup_.parts->size()); });
}

abi::KernelStatus SlabRun::run_rows(int32_t first, int32_t end,
                                    Pool<volume::BlockEvaluator>* evaluators,
                                    const StopFlags& stop) {
    std::atomic<abi::KernelStatus> status{abi::KernelStatus{}};
    int32_t next = first;
    dither_.begin(slab_, static_cast<uint8_t>(slices_), &planes_);
    std::vector<Row*>
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
        Row* scratch = rows_.take([] { return std::make_unique<Row>(); });
        volume::BlockEvaluator* evaluator = take_evaluator(evaluators);
        const abi::KernelStatus result = evaluate_row(row, scratch, evaluator);
        evaluators->give(evaluator);
        if (!result.ok()) {
            status.store(result);
        } else if (setup_.fractions != nullptr) {
            write_fractions(setup_.separate_mixtures ? scratch->mixtures : scratch->band, slab_,
                            static_cast<uint8_t>(slices_), setup_.size, setup_.materials,
                            setup_.fractions);
        }
        return scratch;
    };
    const auto dither = [&](Row* scratch) {
        in_order.push_back(scratch);
        if (!scratch->log.empty()) log_.append(&scratch->log);
        if (!scratch->overlaps.empty()) {
            overlaps_.add(scratch->overlaps);
            scratch->overlaps.clear();
        }
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
                tbb::make_filter<int32_t, Row*>(tbb::filter_mode::parallel, evaluate) &
                tbb::make_filter<Row*, void>(tbb::filter_mode::serial_in_order, dither));
    });
    dither::RowBand* released = nullptr;
    const abi::KernelStatus result = dither_.end(&released);
    for (Row* row : in_order)
        rows_.give(row);
    return status.load().ok() ? result : status.load();
}

abi::KernelStatus SlabRun::evaluate_row(int32_t row, Row* scratch,
                                        volume::BlockEvaluator* evaluator) const {
    const int32_t columns = (setup_.size.x + 7) / 8;
    int32_t first = columns, end = 0;
    int32_t parts = 0;
    for (const auto& active : active_) {
        if (row < active->cull.first_y() || row >= active->cull.end_y()) continue;
        first = std::min(first, active->cull.first_x());
        end = std::max(end, active->cull.end_x());
        ++parts;
    }
    int32_t written_first = std::min(first, end), written_end = end;
    if (setup_.support.on()) {
        const Vec2<int32_t> blocks = dither::support_blocks(setup_.support, row, 8 * slab_);
        if (blocks.x < blocks.y) {
            written_first = end > first ? std::min(first, blocks.x) : blocks.x;
            written_end = std::min(std::max(end, blocks.y), columns);
        }
    }
    scratch->band.reset(row, columns, setup_.channels, written_first, written_end);
    if (setup_.separate_mixtures)
        scratch->mixtures.reset(row, columns, setup_.channels, written_first, written_end);
    scratch->many = parts > 1;
    if (scratch->many) scratch->claims.reset(columns, first, end);
    for (const auto& active : active_) {
        if (row < active->cull.first_y() || row >= active->cull.end_y()) continue;
        const abi::KernelStatus status = evaluate_part(*active, scratch, evaluator);
        if (!status.ok()) return status;
    }
    if (nozzles_ != nullptr) {
        nozzles_->apply(slab_, setup_.size.y, &scratch->band);
        if (setup_.separate_mixtures) nozzles_->apply(slab_, setup_.size.y, &scratch->mixtures);
    }
    return {};
}

/// Gives what connectors have of a block to their materials, and returns whether any is left.
uint64_t SlabRun::fill_connectors(const ActivePart& active, Row* scratch,
                                  volume::OwnedBlock* block) const {
    uint64_t left = 0;
    for (const solid::FilledMask& filled : active.filled) {
        const voxel::SlabMask& mask = filled.mask;
        const int32_t x = 8 * block->block - mask.x0, first = 8 * scratch->band.row - mask.y0;
        if (x < 0 || x >= mask.width || first < 0 || first >= mask.height) continue;
        std::array<uint8_t, 64> taken{};
        uint64_t any = 0;
        for (int32_t y = 0; y < 8; ++y) {
            uint64_t of, owned;
            std::memcpy(&of, &mask.mask[static_cast<size_t>(first + y) * mask.width + x], 8);
            std::memcpy(&owned, &block->owned[static_cast<size_t>(y * 8)], 8);
            of &= owned;
            owned &= ~of;
            any |= of;
            std::memcpy(&taken[static_cast<size_t>(y * 8)], &of, 8);
            std::memcpy(&block->owned[static_cast<size_t>(y * 8)], &owned, 8);
        }
        if (any == 0) continue;
        scratch->band.fill(block->block, taken.data(), filled.code);
        if (setup_.separate_mixtures)
            scratch->mixtures.fill(block->block, taken.data(), filled.code);
    }
    for (int32_t y = 0; y < 8; ++y) {
        uint64_t owned;
        std::memcpy(&owned, &block->owned[static_cast<size_t>(y * 8)], 8);
        left |= owned;
    }
    return left;
}

abi::KernelStatus SlabRun::evaluate_part(const ActivePart& active, Row* scratch,
                                         volume::BlockEvaluator* evaluator) const {
    dither::RowBand& band = scratch->band;
    dither::RowBand* const mixtures = setup_.separate_mixtures ? &scratch->mixtures : nullptr;
    std::vector<volume::OwnedBlock>& pending = scratch->pending;
    segments::PrintfLog* log = &scratch->log;
    pending.clear();
    if (scratch->many) scratch->claims.begin_part(*active.part->part, active.part->index);
    const voxel::SlabMask& mask = active.mask;
    const uint8_t* rows = &mask.mask[static_cast<size_t>(8 * band.row - mask.y0) * mask.width];
    for (int32_t b = active.cull.first_x(); b < active.cull.end_x(); ++b) {
        const int32_t constant_index = active.cull.at(b, band.row);
        if (constant_index == volume::PartCull::kNotCovered) continue;
        volume::OwnedBlock block;
        block.block = b;
        uint64_t any = 0;
        for (int32_t y = 0; y < 8; ++y) {
            uint64_t columns;
            std::memcpy(&columns, rows + static_cast<size_t>(y) * mask.width + (8 * b - mask.x0),
                        8);
            columns &= slices_;
            if (scratch->many) columns = scratch->claims.take(b, y, columns);
            std::memcpy(&block.owned[static_cast<size_t>(y * 8)], &columns, 8);
            any |= columns;
        }
        if (scratch->many)
            scratch->claims.end_block(b, {8 * b, 8 * band.row, 8 * slab_}, &scratch->overlaps);
        if (any != 0 && !active.filled.empty()) any = fill_connectors(active, scratch, &block);
        if (any == 0) continue;
        if (constant_index >= 0) {
            const volume::PartCull::Constant& constant = active.cull.constant(constant_index);
            for (dither::RowBand* to : {&band, mixtures}) {
                if (to == nullptr || constant.code == 0) continue;
                if (constant.code == OPENFAB_CODE_MIXED) {
                    constant.merge(b, block.owned.data(), active.part->channels, to);
                } else {
                    to->fill(b, block.owned.data(), constant.code);
                }
            }
            continue;
        }
        pending.push_back(block);
        if (static_cast<int32_t>(pending.size()) < volume::BlockEvaluator::kBatch) continue;
        if (interrupt_ != nullptr && interrupt_->load()) return abi::KernelStatus::stopped();
        const abi::KernelStatus status =
            evaluator->evaluate(*active.part, slab_, pending.data(), volume::BlockEvaluator::kBatch,
                                active.cull.should_cull_pieces(), &band, mixtures, log);
        if (!status.ok()) return status;
        pending.clear();
    }
    if (pending.empty()) return {};
    return evaluator->evaluate(*active.part, slab_, pending.data(),
                               static_cast<int32_t>(pending.size()),
                               active.cull.should_cull_pieces(), &band, mixtures, log);
}

}  // namespace openfab::pipeline
