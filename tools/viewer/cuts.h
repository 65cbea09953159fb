// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cuts through a print across x or y. Each of their rows comes from another slice, which has to be
// unpacked for it, so rows are fetched as they are asked for, and kept for the next, finer picture.

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "base/result.h"
#include "tools/viewer/slice_store.h"

namespace openfab::viewer {

/// One cut. Rows are packed as a slice's: along y of a cut across x, along x of one across y.
/// Functions are thread-safe.
class Cut {
  public:
    /// `axis` 0 or 1; `at` a voxel along it.
    Cut(SliceStore* store, int axis, int32_t at);

    int axis() const { return axis_; }
    int32_t at() const { return at_; }
    int32_t width() const { return width_; }
    /// Fetches the rows `first`, `first + stride`, … below `end` that are not there yet; slices that
    /// the print does not have yet are left out.
    Result<void> fetch(int32_t first, int32_t end, int32_t stride);
    /// Returns row z, which stays where it is; null where it was not fetched.
    const uint8_t* row(int32_t z) const;
    int64_t bytes() const;

  private:
    enum class State : uint8_t { kNone, kBeingRead, kThere };
    struct Row {
        State state = State::kNone;
        std::unique_ptr<uint8_t[]> data;
    };

    Result<void> read(int32_t z);
    void take(const uint8_t* rows, uint8_t* to) const;

    SliceStore* store_;
    int axis_;
    int32_t at_, width_;
    size_t row_bytes_;
    mutable std::mutex mutex_;  ///< of all below
    std::condition_variable changed_;
    std::vector<Row> rows_;
    int64_t there_ = 0;
};

/// The last cuts.
class Cuts {
  public:
    explicit Cuts(SliceStore* store) : store_(store) {}
    std::shared_ptr<Cut> cut(int axis, int32_t at);

  private:
    SliceStore* store_;
    std::mutex mutex_;
    std::vector<std::shared_ptr<Cut>> kept_;  ///< most recent last
};

}  // namespace openfab::viewer
