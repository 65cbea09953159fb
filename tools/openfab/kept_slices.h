// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads back the slices that a sink has kept of an interrupted print, in a thread of its own: the
// receiver's poll goes on meanwhile, so that neither a large file nor a slow reader delays others.

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::tools {

class KeptSlices {
  public:
    /// Begins to read; the sink is this thread's until it is done or this is destroyed. With
    /// `sends`, each slice is framed and waits until it is taken: one at a time.
    KeptSlices(pipeline::SliceSink* sink, bool sends);
    /// Ends the reading: the sink is as if it had not begun.
    ~KeptSlices();
    KeptSlices(const KeptSlices&) = delete;
    KeptSlices& operator=(const KeptSlices&) = delete;

    /// A descriptor that can be read from where something happened.
    int fd() const { return event_; }
    /// The next framed slice, if there is one by now.
    std::optional<std::vector<uint8_t>> take();

    struct End {
        Result<int32_t> kept;  ///< slices
        uint64_t hash = 0;     ///< of them
    };
    /// The result, once all frames were taken.
    std::optional<End> end();

  private:
    void read(bool sends);
    void wake() const;

    pipeline::SliceSink& sink_;
    int event_;
    std::mutex mutex_;
    std::condition_variable taken_;
    std::vector<uint8_t> frame_;  ///< empty: taken
    std::optional<End> end_;
    bool cancelled_ = false;
    std::thread thread_;
};

}  // namespace openfab::tools
