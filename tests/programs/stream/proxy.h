// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A line between a sender and a receiver that a test cuts and damages.

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "backends/stream/address.h"

namespace openfab::testing {

/// Passes bytes on, both ways, for one sender at a time.
class Proxy {
  public:
    /// Cuts the line once for each of `cuts`, which rise: when so many bytes have gone to the
    /// receiver, over all lines, whatever a byte belongs to. Flips a bit of byte `damaged`, if it
    /// is above 0.
    Proxy(stream::Address receiver, std::vector<int64_t> cuts, int64_t damaged = 0);
    ~Proxy();
    const std::string& address() const { return address_; }
    int cuts_made() const { return cuts_made_; }

  private:
    void run();
    void pass(stream::Socket sender, stream::Socket receiver);

    stream::Address receiver_;
    std::vector<int64_t> cuts_;
    int64_t damaged_;
    stream::Socket listening_;
    std::string address_;
    int64_t passed_ = 0;
    std::atomic<int> cuts_made_{0};
    std::atomic<bool> quit_{false};
    std::thread thread_;
};

}  // namespace openfab::testing
