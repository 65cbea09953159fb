// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print as a grid of some two million cells, for the 3-D view. A cell keeps a few of its voxels'
// codes, so that colours can be chosen afterwards. A thread reads the slices, coarse to fine, from
// the moment that somebody asks. Of the difference of two prints all slices are read, and a cell
// differs as soon as one of its voxels does: a few that differ are what one looks for.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "base/vec.h"
#include "tools/viewer/difference.h"
#include "tools/viewer/slice_store.h"
#include "tools/viewer/tile.h"

namespace openfab::viewer {

/// The number of cells along each axis: about as wide as high, no smaller than voxels.
Vec3i volume_cells(const pipeline::PrintInfo& info);
/// The number of parts of layers that a volume reads, or that of a difference from `other`.
int32_t volume_steps(const pipeline::PrintInfo& info, const pipeline::PrintInfo* other = nullptr);

class Volume {
  public:
    /// Starts the thread; the stores must outlive the volume. With `other`, of a print of the same
    /// size, it is the volume of the difference: codes of the first, or kDifferent.
    explicit Volume(SliceStore* store, SliceStore* other = nullptr);
    ~Volume();
    Volume(const Volume&) = delete;
    Volume& operator=(const Volume&) = delete;

    /// Returns how many steps were read.
    int32_t steps_done() const { return done_; }
    /// Waits until more than `known` steps were read, or a moment has passed.
    void wait_for_more(int32_t known);
    /// Returns RGBA of the cells, x fastest, then y, z; alpha is the mean of the voxels', and colours
    /// are those of what is visible in a cell or, where nothing is, beside it. Layers that were not
    /// read yet are as the one below.
    std::vector<uint8_t> colors(const Palette& palette);
    /// Returns what went wrong, or an empty text.
    std::string trouble();

  private:
    struct Step {
        int32_t layer = 0, part = 0;
        int32_t z = 0;               ///< of the slice that stands for it
        int32_t begin = 0, end = 0;  ///< of all its slices
    };

    void run();
    /// Whether what a step reads is there by now.
    bool is_there(const Step& step) const;
    Result<void> read(const Step& step, std::vector<uint8_t>* codes);
    /// The codes of one slice's samples, kSamples a cell.
    void sample(const uint8_t* rows, std::vector<uint8_t>* codes) const;
    /// Marks the cells in which a slice's voxels differ.
    Result<void> compare(int32_t z, std::vector<uint8_t>* marks);
    size_t layer_cells() const {
        return static_cast<size_t>(cells_.x) * static_cast<size_t>(cells_.y);
    }

    SliceStore* store_;
    SliceStore* other_;  ///< of a difference
    Difference difference_;
    Vec3i cells_;
    int32_t parts_ = 1;  ///< slices a layer
    std::vector<int32_t> xs_, ys_;
    std::vector<int32_t> cell_of_x_, cell_of_y_;  ///< of a difference, by voxel
    std::vector<Step> steps_;
    std::atomic<int32_t> done_{0};
    std::atomic<bool> stop_{false};
    std::mutex mutex_;  ///< of all below
    std::condition_variable changed_;
    std::vector<uint8_t> codes_;     ///< by layer, cell, part and sample
    std::vector<uint8_t> has_part_;  ///< by layer and part
    std::string trouble_;
    std::thread thread_;
};

}  // namespace openfab::viewer
