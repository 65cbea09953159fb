// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Ends work that takes too long, by a flag that the work checks.

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace openfab {

/// A flag that is set once the allowed time has passed, or soon after another flag is set. It stays
/// set.
class Deadline {
  public:
    /// Sets the flag when `interrupt` is set; no time passes yet.
    explicit Deadline(const std::atomic<bool>& interrupt);
    ~Deadline();
    Deadline(const Deadline&) = delete;
    Deadline& operator=(const Deadline&) = delete;

    /// Allows that many seconds from now on, whatever was allowed before. On a machine that has no time
    /// for this process, those are seconds of the processor, up to ten times as many.
    void start(double seconds);
    const std::atomic<bool>& passed() const { return passed_; }

  private:
    void watch();

    const std::atomic<bool>& interrupt_;
    std::atomic<bool> passed_{false};
    std::mutex mutex_;
    std::condition_variable change_;
    bool over_ = false;
    double allowed_ = -1;  ///< seconds; negative: any
    double started_ = 0, started_processor_ = 0;
    std::thread thread_;
};

}  // namespace openfab
