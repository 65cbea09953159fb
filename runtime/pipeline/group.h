// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One group of 8 slices, from coverage to packed planes. Rows of blocks are evaluated side by side,
// ahead of the dither, which takes them in order; so one group can use several threads, and the
// first slice comes soon.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "runtime/dither/band.h"
#include "runtime/dither/support_fill.h"
#include "runtime/pipeline/overlaps.h"
#include "runtime/volume/cull.h"
#include "runtime/volume/evaluate.h"
#include "runtime/volume/print_part.h"

namespace openfab::slab {

/// Objects that are used by one task at a time and kept for the next. A task holds what it took
/// until it is done; with thread-local storage, a thread that waits inside a task and takes up
/// another would share it with itself.
template <typename T>
class Pool {
  public:
    template <typename Make>
    T* take(const Make& make) {
        const std::lock_guard lock(mutex_);
        if (free_.empty()) {
            all_.push_back(make());
            return all_.back().get();
        }
        T* object = free_.back();
        free_.pop_back();
        return object;
    }
    void give(T* object) {
        const std::lock_guard lock(mutex_);
        free_.push_back(object);
    }
    /// While nothing is taken.
    const std::vector<std::unique_ptr<T>>& all() const { return all_; }

  private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<T>> all_;
    std::vector<T*> free_;
};

/// Why a print may end before its last slice; rows of blocks look at it.
struct StopFlags {
    const std::atomic<bool>& interrupt;  ///< the caller's
    std::atomic<bool> failed{false};
    bool requested() const {
        return failed.load(std::memory_order_relaxed) || interrupt.load(std::memory_order_relaxed);
    }
};

/// What does not change from group to group.
struct GroupSetup {
    const std::vector<std::unique_ptr<PrintPart>>* parts = nullptr;  ///< in build order
    std::vector<int32_t>
        order;  ///< of parts: higher priority first, of equals the later in the build list
    const openfab_stage_set* stages = nullptr;
    openfab_isa isa = OPENFAB_ISA_AVX2;
    DitherRule dither = kDefaultDither;
    uint64_t seed = 0;
    Vec3i size;  ///< of the grid, voxels
    bool culling = true;
    const std::atomic<bool>* interrupt = nullptr;  ///< as of PrintOptions
    int32_t rows_in_flight = 2;                    ///< rows of blocks of one group evaluated ahead
    int32_t bits = 4;                              ///< a packed voxel
    SupportFill support;
};

/// Phase times, seconds summed over threads.
struct GroupTimes {
    double coverage = 0, dither = 0, support = 0, pack = 0;
};

/// Memory of one group in flight, reused by later groups.
class GroupRun {
  public:
    explicit GroupRun(const GroupSetup& setup);

    /// For the compositions that fill whole blocks of one group, over all its parts.
    static constexpr int64_t kCompositionBytes = 8 << 20;

    /// Coverage and culling of slices [8 group, 8 group + 8).
    abi::KernelStatus begin(int32_t group, Pool<BlockEvaluator>* evaluators);
    /// Blocks that culling left: what printing slices of the group costs, however few.
    int64_t blocks_to_evaluate() const { return blocks_to_evaluate_; }
    /// Prints some slices of the group that was begun into planes(), those of bit z & 7 in
    /// `slices`; what the planes of the others hold then means nothing.
    abi::KernelStatus run(uint8_t slices, Pool<BlockEvaluator>* evaluators, const StopFlags& stop);

    const GroupPlanes& planes() const { return planes_; }
    /// What the group's voxels printed, to be taken.
    PointPrints& prints() { return prints_; }
    /// Of all groups so far.
    const Overlaps& overlaps() const { return overlaps_; }
    GroupTimes times;

  private:
    struct ActivePart {
        const PrintPart* part;
        voxel::GroupMask mask;
        PartCull cull;
        double seconds_coverage = 0;

        bool covers() const { return mask.width > 0 && mask.height > 0; }
    };
    /// Scratch of one row in flight.
    struct Row {
        RowBand band;
        bool many = false;  ///< parts in the row: claims are kept
        RowClaims claims;
        Overlaps overlaps;
        std::vector<OwnedBlock> pending;  ///< blocks to evaluate, of one part
        PointPrints prints;
    };

    abi::KernelStatus begin_part(ActivePart* active, BlockEvaluator* evaluator,
                                 std::atomic<int64_t>* room) const;
    BlockEvaluator* take_evaluator(Pool<BlockEvaluator>* evaluators) const;
    abi::KernelStatus evaluate_row(int32_t row, Row* scratch, BlockEvaluator* evaluator) const;
    abi::KernelStatus evaluate_part(const ActivePart& active, Row* scratch,
                                    BlockEvaluator* evaluator) const;
    abi::KernelStatus run_rows(int32_t first, int32_t end, Pool<BlockEvaluator>* evaluators,
                               const StopFlags& stop);

    const GroupSetup& setup_;
    int32_t group_ = 0;
    uint64_t slices_ = 0;  ///< of a column's voxels those to print, a byte a column
    int64_t blocks_to_evaluate_ = 0;
    /// Of this group; those of parts that the next one meets are kept for it.
    std::vector<std::unique_ptr<ActivePart>> active_;
    Pool<Row> rows_;
    GroupPlanes planes_;
    PointPrints prints_;
    Overlaps overlaps_;
    GroupDither dither_;
};

}  // namespace openfab::slab
