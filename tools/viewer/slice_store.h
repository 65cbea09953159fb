// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Slices of a print, unpacked: the last few are kept. At most two are being unpacked at a time, so
// that memory is bounded whatever is asked for at once.

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

#include "backends/read/print_file.h"
#include "base/lru_cache.h"
#include "base/result.h"

namespace openfab::viewer {

struct Slice {
    int32_t z = 0;
    std::vector<uint8_t> rows;  ///< packed, lowest y first
    size_t bytes() const { return rows.size(); }
};

/// All functions are thread-safe.
class SliceStore {
  public:
    explicit SliceStore(prints::PrintFile* file);

    const prints::PrintFile& file() const { return *file_; }
    /// Returns a slice, which is kept.
    Result<std::shared_ptr<const Slice>> slice(int32_t z);
    /// Shows the packed rows of a slice to `look`; the slice is not kept.
    Result<void> visit(int32_t z, const std::function<void(const uint8_t* rows)>& look);

  private:
    class Turn;

    prints::PrintFile* file_;
    LruCache<int32_t, Slice> kept_;
    std::mutex mutex_;  ///< of all below
    std::condition_variable changed_;
    std::vector<std::unique_ptr<prints::SliceBuffers>> free_;
    std::set<int32_t> being_read_;  ///< by slice(), so that one slice is not unpacked twice at once
};

}  // namespace openfab::viewer
