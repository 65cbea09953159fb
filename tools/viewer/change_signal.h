// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts what changes of a world and its prints, and wakes who waits for it: pages, and the loop that prints.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace openfab::viewer {

/// Thread-safe. What changes is changed first, and told then; who tells a page of it reads the counts first, and the rest
/// then: a page may see more than the counts say, never less.
class ChangeSignal {
  public:
    struct Counts {
        int64_t change = 0;   ///< of the state, which a page waits for
        int64_t details = 0;  ///< of what a page reads again where it is another
        bool asked = false;   ///< the loop has not begun with what was asked for
    };
    Counts counts() const;

    void tell();
    void tell_of_details();
    /// Asks the loop for another print, of something that is among the details. Returns the count of changes.
    int64_t ask();
    /// Waits until the loop is asked or stopped, or for `longest`.
    void wait_until_asked(std::chrono::milliseconds longest);
    /// The loop begins with all that it was asked for.
    void begin_what_was_asked();
    /// Waits for another count of changes; returns at once where several wait already.
    void wait_for_change(int64_t known, std::chrono::milliseconds longest) const;
    /// Ends all waits, for good.
    void stop();
    bool stopped() const;

  private:
    void count_change();

    mutable std::mutex mutex_;
    std::condition_variable loop_;
    mutable std::condition_variable pages_;
    mutable int32_t waiting_ = 0;
    Counts counts_;
    bool stopped_ = false;
};

}  // namespace openfab::viewer
