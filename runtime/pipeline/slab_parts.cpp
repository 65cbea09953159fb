// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/slab_parts.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <utility>

#include "base/count_bits.h"
#include "base/stage_timer.h"

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

Vec2<int32_t> SlabParts::rows() const {
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

abi::KernelStatus SlabParts::begin(int32_t slab, Pool<volume::BlockEvaluator>* evaluators,
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
        seconds_coverage += active->seconds_coverage;
        blocks_to_evaluate_ += active->cull.blocks_to_evaluate();
        const auto index = static_cast<size_t>(active->part->index);
        if (!covered_[index])
            covered_[index] =
                std::ranges::any_of(active->mask.mask, [](uint8_t column) { return column != 0; });
    }
    return status.load();
}

abi::KernelStatus SlabParts::begin_part(ActivePart* active, volume::BlockEvaluator* evaluator,
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

volume::BlockEvaluator* SlabParts::take_evaluator(Pool<volume::BlockEvaluator>* evaluators) const {
    volume::BlockEvaluator* evaluator = evaluators->take(
        [&] { return std::make_unique<volume::BlockEvaluator>(setup_.isa, setup_.parts->size()); });
    evaluator->stop = interrupt_;
    return evaluator;
}

abi::KernelStatus SlabParts::evaluate_row(int32_t row, uint8_t slices, SlabRow* scratch,
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
    if (setup_.rates != nullptr)
        scratch->rates.reset(8 * columns, setup_.materials, setup_.rates->columns);
    scratch->many = parts > 1;
    if (scratch->many) scratch->claims.reset(columns, first, end);
    for (const auto& active : active_) {
        if (row < active->cull.first_y() || row >= active->cull.end_y()) continue;
        const abi::KernelStatus status = evaluate_part(*active, slices, scratch, evaluator);
        if (!status.ok()) return status;
    }
    return {};
}

/// Gives what connectors have of a block to their materials, and returns whether any is left.
uint64_t SlabParts::fill_connectors(const ActivePart& active, SlabRow* scratch,
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

abi::KernelStatus SlabParts::evaluate_part(const ActivePart& active, uint8_t slices,
                                           SlabRow* scratch,
                                           volume::BlockEvaluator* evaluator) const {
    dither::RowBand& band = scratch->band;
    dither::RowBand* const mixtures = setup_.separate_mixtures ? &scratch->mixtures : nullptr;
    std::vector<volume::OwnedBlock>& pending = scratch->pending;
    segments::PrintfLog* log = &scratch->log;
    volume::PartVoxels& voxels = evaluator->counts.by_part[static_cast<size_t>(active.part->index)];
    pending.clear();
    evaluator->rates = setup_.rates != nullptr ? &scratch->rates : nullptr;
    if (setup_.rates != nullptr)
        evaluator->rate_columns = setup_.rates->of_parts[static_cast<size_t>(active.part->index)];
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
            columns &= slices * 0x0101010101010101u;
            if (scratch->many) columns = scratch->claims.take(b, y, columns);
            std::memcpy(&block.owned[static_cast<size_t>(y * 8)], &columns, 8);
            any |= columns;
        }
        if (scratch->many)
            scratch->claims.end_block(b, {8 * b, 8 * band.row, 8 * slab_}, &scratch->overlaps);
        if (any != 0 && !active.filled.empty()) any = fill_connectors(active, scratch, &block);
        if (any == 0) continue;
        const int64_t own = count_bits(block.owned);
        voxels.own += own;
        if (setup_.solid_code != 0) {
            for (dither::RowBand* to : {&band, mixtures})
                if (to != nullptr) to->fill(b, block.owned.data(), setup_.solid_code);
            continue;
        }
        if (constant_index >= 0) {
            const volume::PartCull::Constant& constant = active.cull.constant(constant_index);
            if (constant.code == 0) voxels.empty += own;
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
        block.blind_distance = active.cull.blind_distance(b, band.row);
        block.attributes = active.cull.attributes(b, band.row);
        pending.push_back(block);
        if (static_cast<int32_t>(pending.size()) < volume::BlockEvaluator::kBatch) continue;
        if (interrupt_ != nullptr && interrupt_->load()) return abi::KernelStatus::stopped();
        const abi::KernelStatus status =
            evaluator->evaluate(*active.part, slab_, pending.data(), volume::BlockEvaluator::kBatch,
                                active.cull.tries(), &band, mixtures, log);
        if (!status.ok()) return status;
        pending.clear();
    }
    if (pending.empty()) return {};
    return evaluator->evaluate(*active.part, slab_, pending.data(),
                               static_cast<int32_t>(pending.size()), active.cull.tries(), &band,
                               mixtures, log);
}

}  // namespace openfab::pipeline
