// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Passes slices to observers (previews) as well as to a sink, and a sink that discards slices, for
// prints with previews only.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::backends {

/// Observes each slice once, in order of z, from one thread.
class SliceObserver {
  public:
    virtual ~SliceObserver() = default;
    virtual Result<void> begin(const pipeline::PrintInfo& info) = 0;
    virtual void observe(const pipeline::SliceView& slice) = 0;
    /// Called also when the print ended early, so that pictures of the printed part are written;
    /// not where it could not begin.
    virtual Result<void> finish(const pipeline::PrintTotals& totals) = 0;
};

/// Passes every slice to `sink` and to the observers. The bytes between encode and commit are the
/// packed rows, then the result of the sink's encode.
class TeeSink : public pipeline::SliceSink {
  public:
    TeeSink(std::unique_ptr<pipeline::SliceSink> sink,
            std::vector<std::unique_ptr<SliceObserver>> observers)
        : sink_(std::move(sink)), observers_(std::move(observers)) {}

    Result<void> begin(const pipeline::PrintInfo& info) override;
    Result<int32_t> resume(const std::function<bool(const pipeline::SliceView&)>& show) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    std::unique_ptr<pipeline::SliceSink> sink_;
    std::vector<std::unique_ptr<SliceObserver>> observers_;
    bool sink_begun_ = false;
    bool observed_ = false;  ///< begun without an error: there is something to show
    int32_t width_ = 0;
    int32_t height_ = 0;
    size_t row_bytes_ = 0;
};

/// Discards slices, for previews without an output and for timings.
class NullSink : public pipeline::SliceSink {
  public:
    Result<void> begin(const pipeline::PrintInfo&) override { return {}; }
    std::vector<uint8_t> encode(const pipeline::SliceView&) const override { return {}; }
    Result<void> commit(int32_t, std::vector<uint8_t>) override { return {}; }
    Result<void> finish(const pipeline::PrintTotals&) override { return {}; }
};

/// Returns the bytes of a packed row: ceil(width * bits / 8).
inline size_t packed_row_bytes(int32_t width, int32_t bits) {
    return (static_cast<size_t>(width) * static_cast<size_t>(bits) + 7) / 8;
}

/// Unpacks row `y` to one code a byte; `codes` has slice.width elements.
void unpack_row(const pipeline::SliceView& slice, int32_t y, int32_t bits, uint8_t* codes);
/// Returns all codes of a slice, one a byte.
std::vector<uint8_t> unpack_slice(const pipeline::SliceView& slice, int32_t bits);
/// Packs the codes of a row, one a byte, into its packed_row_bytes.
void pack_row(std::span<const uint8_t> codes, int32_t bits, uint8_t* row);

}  // namespace openfab::backends
