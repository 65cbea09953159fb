// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of a print in one slab (8 slices): coverage, culling, and the evaluation of its rows of
// blocks into bands. What is made of the bands is the slab's: with effects on neighbours it looks at rows
// of several slabs at once.

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/pool.h"
#include "runtime/dither/band.h"
#include "runtime/dither/support_fill.h"
#include "runtime/pipeline/fraction_sink.h"
#include "runtime/pipeline/overlaps.h"
#include "runtime/pipeline/print_options.h"
#include "runtime/process/effect.h"
#include "runtime/volume/cull.h"
#include "runtime/volume/evaluate.h"
#include "runtime/volume/placed_part.h"

namespace openfab::pipeline {

/// Returns how many of a print's materials fablets can name: support, if it is the last and not one of
/// theirs, is added after the stages.
int32_t model_materials(const std::vector<part::Part>& parts, int32_t materials,
                        int32_t support_code);

/// Settings that are the same for all slabs.
struct SlabSetup {
    const std::vector<std::unique_ptr<volume::PlacedPart>>* parts = nullptr;  ///< in build order
    std::vector<int32_t>
        order;  ///< of parts: higher priority first, ties go to the later in the build list
    int32_t channels = 0;  ///< of fractions, see dither::fraction_channels
    openfab_isa isa = OPENFAB_ISA_AVX2;
    dither::DitherRule dither = dither::kDefaultDither;
    uint64_t seed = 0;
    Vec3i size;  ///< grid size, voxels
    bool culling = true;
    uint8_t solid_code = 0;      ///< see PrintInput
    int32_t rows_in_flight = 2;  ///< rows of blocks of one slab evaluated ahead
    int32_t bits = 4;            ///< per packed voxel
    dither::SupportFill support;
    int32_t materials = 0;              ///< of the model
    FractionSink* fractions = nullptr;  ///< may be null
    const Rates* rates = nullptr;       ///< null: none
    /// Whether mixtures are kept beside what the fablets' rules make of them, for `fractions`.
    bool separate_mixtures = false;
    std::vector<const process::Effect*> spreads;  ///< effects on neighbours, in order
};

/// Scratch of one row of blocks in flight.
struct SlabRow {
    dither::RowBand band;
    dither::RowBand mixtures;  ///< see SlabSetup::separate_mixtures
    bool many = false;         ///< more than one part in the row: claims are tracked
    RowClaims claims;
    volume::RowRates rates;
    Overlaps overlaps;
    std::vector<volume::OwnedBlock> pending;  ///< blocks of one part to evaluate
    segments::PrintfLog log;
    std::vector<uint64_t> notes;  ///< of the next effect on neighbours
};

/// Memory of the parts in one slab, reused by later slabs.
class SlabParts {
  public:
    explicit SlabParts(const SlabSetup& setup) : covered_(setup.parts->size()), setup_(setup) {}

    /// Memory limit for mixtures that fill whole blocks of one slab, over all its parts.
    static constexpr int64_t kUniformBlockBytes = 8 << 20;

    /// Coverage and culling of slices [8 slab, 8 slab + 8). `interrupt`, if not null, stops them, and the
    /// evaluation of rows afterwards, between batches of blocks.
    abi::KernelStatus begin(int32_t slab, Pool<volume::BlockEvaluator>* evaluators,
                            const std::atomic<bool>* interrupt);
    int32_t slab() const { return slab_; }
    /// Returns the number of blocks that culling left: the cost of printing any slices of the slab.
    int64_t blocks_to_evaluate() const { return blocks_to_evaluate_; }
    /// Returns the rows of blocks that have something to print: [x, y).
    Vec2<int32_t> rows() const;
    /// Evaluates a row. Of each column of voxels only those in `slices` are set, by bit.
    abi::KernelStatus evaluate_row(int32_t row, uint8_t slices, SlabRow* scratch,
                                   volume::BlockEvaluator* evaluator) const;
    volume::BlockEvaluator* take_evaluator(Pool<volume::BlockEvaluator>* evaluators) const;

    /// Returns, by part, whether any slab so far holds a voxel of it.
    const std::vector<bool>& covered() const { return covered_; }

    double seconds_coverage = 0;  ///< summed over threads and slabs

  private:
    struct ActivePart {
        const volume::PlacedPart* part;
        voxel::SlabMask mask;
        std::vector<solid::FilledMask> filled;  ///< of a piece, what other materials have of it
        volume::PartCull cull;
        double seconds_coverage = 0;

        bool covers() const { return mask.width > 0 && mask.height > 0; }
    };

    abi::KernelStatus begin_part(ActivePart* active, volume::BlockEvaluator* evaluator,
                                 std::atomic<int64_t>* room) const;
    uint64_t fill_connectors(const ActivePart& active, SlabRow* scratch,
                             volume::OwnedBlock* block) const;
    abi::KernelStatus evaluate_part(const ActivePart& active, uint8_t slices, SlabRow* scratch,
                                    volume::BlockEvaluator* evaluator) const;

    std::vector<bool> covered_;
    const SlabSetup& setup_;
    const std::atomic<bool>* interrupt_ = nullptr;
    int32_t slab_ = 0;
    int64_t blocks_to_evaluate_ = 0;
    /// Parts in this slab; those that are also in the next slab are reused.
    std::vector<std::unique_ptr<ActivePart>> active_;
};

}  // namespace openfab::pipeline
