// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lets observers (previews) see the slices on their way into a sink, and a sink that keeps nothing
// for prints that are only looked at.

#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::backends {

/// Sees each slice once, in order of z, from one thread.
class SliceObserver {
  public:
    virtual ~SliceObserver() = default;
    virtual Result<void> begin(const PrintInfo& info) = 0;
    virtual void observe(const SliceView& slice) = 0;
    /// Called also when the print ended early, so that a picture of what there is gets written.
    virtual Result<void> finish(const PrintTotals& totals) = 0;
};

/// Hands every slice to `sink` and to the observers. The bytes between encode and commit are the
/// packed rows, then what the sink's encode gave.
class TeeSink : public SliceSink {
  public:
    TeeSink(std::unique_ptr<SliceSink> sink, std::vector<std::unique_ptr<SliceObserver>> observers)
        : sink_(std::move(sink)), observers_(std::move(observers)) {}

    Result<void> begin(const PrintInfo& info) override;
    Result<int32_t> take_up(const std::function<bool(const SliceView&)>& show) override;
    std::vector<uint8_t> encode(const SliceView& slice) const override;
    Result<void> commit(int32_t z, const std::vector<uint8_t>& bytes) override;
    Result<void> finish(const PrintTotals& totals) override;

  private:
    std::unique_ptr<SliceSink> sink_;
    std::vector<std::unique_ptr<SliceObserver>> observers_;
    int32_t width_ = 0;
    int32_t height_ = 0;
    size_t row_bytes_ = 0;
};

/// Takes slices and keeps none: previews without an output, timings.
class NullSink : public SliceSink {
  public:
    Result<void> begin(const PrintInfo&) override { return {}; }
    std::vector<uint8_t> encode(const SliceView&) const override { return {}; }
    Result<void> commit(int32_t, const std::vector<uint8_t>&) override { return {}; }
    Result<void> finish(const PrintTotals&) override { return {}; }
};

/// Bytes of a packed row: ceil(width * bits / 8).
inline size_t packed_row_bytes(int32_t width, int32_t bits) {
    return (static_cast<size_t>(width) * static_cast<size_t>(bits) + 7) / 8;
}

/// The code of every voxel of row `y`, one a byte; `codes` has slice.width elements.
void unpack_row(const SliceView& slice, int32_t y, int32_t bits, uint8_t* codes);

}  // namespace openfab::backends
