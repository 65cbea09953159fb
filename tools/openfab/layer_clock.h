// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A printer as far as time goes: it takes one slice each layer time out of a buffer.

#include <cstdint>

namespace openfab::tools {

class LayerClock {
  public:
    /// `layer_seconds` 0: takes every slice at once. Printing starts when the buffer is full, or
    /// with the last slice.
    LayerClock(double layer_seconds, int32_t buffer)
        : layer_seconds_(layer_seconds), buffer_(buffer) {}

    /// Begins with `slices` of which `kept` are there and printed already.
    void begin(int32_t slices, int32_t kept);
    /// A slice has arrived.
    void add(double now);
    /// Takes the slices that are due.
    void advance(double now);
    /// Returns how many slices may have arrived by now: those printed and a full buffer.
    int32_t room() const;
    /// Returns when advance has something to do; infinite where nothing is due.
    double due() const;
    bool finished() const { return printed_ == slices_; }
    int32_t starved() const { return starved_; }
    double starved_seconds() const { return starved_seconds_; }

  private:
    void start_if_full(double now);

    double layer_seconds_;
    int32_t buffer_;
    int32_t slices_ = 0, arrived_ = 0, printed_ = 0;
    bool running_ = false;
    bool waiting_ = false;  ///< a slice is due and not there
    double due_ = 0;        ///< when the next slice is taken, or was to be
    int32_t starved_ = 0;
    double starved_seconds_ = 0;
};

}  // namespace openfab::tools
