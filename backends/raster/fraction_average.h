// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Averages the fractions of a fine print over the voxels of a coarse one, so many along each axis: what a
// fine texture amounts to in an element of a simulation, which the middle of the element does not
// tell.
//
// Fractions are whole numbers of 65535ths, and are added up as such, so that the means are the same
// in any order. Sums of a layer of coarse voxels are kept until the fine print has passed it.

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "runtime/pipeline/fraction_sink.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

class FractionAverage : public pipeline::FractionSink {
  public:
    /// Sums of so many fit 32 bits.
    static constexpr int32_t kMostParts = 65536;

    /// Passes the means to `to`. The fine print's grid is that of `coarse`, from its first slice to
    /// its last, with `times` voxels for one along the axes, at most kMostParts together.
    FractionAverage(const pipeline::PrintInfo& coarse, const Vec3i& times,
                    pipeline::FractionSink* to)
        : coarse_(coarse), times_(times), to_(*to) {}

    Result<void> begin(const pipeline::PrintInfo& fine, int32_t materials) override;
    void write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) override;
    Result<void> status() const override { return to_.status(); }
    /// Does not finish `to`: it ends with the totals of the coarse print.
    Result<void> finish(const pipeline::PrintTotals& totals) override;
    /// Must be called after each slice of the fine print, in order. Returns the coarse slice that is complete
    /// by that, or -1.
    int32_t passed(int32_t z);

    /// Returns whether the fine print was complete.
    bool complete() const { return complete_; }
    /// Returns the memory that sums take, for each column of the fine print and each material, with
    /// so many slabs of 8 slices in flight.
    static int64_t bytes_per_fraction(const Vec3i& times, int32_t slabs);

  private:
    uint32_t* layer(int32_t z);

    const pipeline::PrintInfo coarse_;
    const Vec3i times_;
    pipeline::FractionSink& to_;
    int32_t materials_ = 0;
    bool complete_ = false;
    std::mutex mutex_;                                 ///< for which layers there are
    std::map<int32_t, std::vector<uint32_t>> layers_;  ///< [y][x][material], by coarse slice
};

/// The sink of the fine print's slices, which nobody wants.
class AveragedSlices : public pipeline::SliceSink {
  public:
    /// `layer`, if any, is called for each coarse slice whose means have been passed on, in order.
    explicit AveragedSlices(FractionAverage* average,
                            std::function<Result<void>(int32_t z)> layer = {})
        : average_(*average), layer_(std::move(layer)) {}
    Result<void> begin(const pipeline::PrintInfo&) override { return {}; }
    std::vector<uint8_t> encode(const pipeline::SliceView&) const override { return {}; }
    Result<void> commit(int32_t z, std::vector<uint8_t>) override {
        const int32_t coarse = average_.passed(z);
        return layer_ && coarse >= 0 ? layer_(coarse) : Result<void>();
    }
    Result<void> finish(const pipeline::PrintTotals&) override { return {}; }

  private:
    FractionAverage& average_;
    std::function<Result<void>(int32_t z)> layer_;
};

}  // namespace openfab::raster
