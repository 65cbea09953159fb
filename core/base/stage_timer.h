// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Times what the threads of a print do: sums for its statistics, and, for who wants to know more, a
// trace of when each thread worked at what.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <utility>
#include <vector>

namespace openfab {

/// The work of a print between set-up and the end.
enum class Stage : uint8_t {
    kCoverage,  ///< which voxels belong to which part
    kCulling,   ///< bounds of blocks
    kRows,      ///< what a row of blocks needs beside the stages that are timed in it
    kNearest,   ///< nearest surface points
    kSlab,      ///< the slab kernel, and merging its results
    kDither,
    kSupport,
    kPack,
    kCount,   ///< totals and hashes of slices
    kEncode,  ///< the sink's work on single slices
    kCommit,  ///< the sink's work in order
};
inline constexpr size_t kStages = 11;

class StageTimer;

/// While it lives, every StageTimer of the process adds to it. At most one lives at a time, and no
/// timer may run when it begins or ends.
class Trace {
  public:
    /// What one thread did.
    struct Thread {
        /// Of the processor, which a busy machine gives to others, too; without the stages that
        /// were timed inside.
        std::array<double, kStages> seconds{};
        /// Begin and end of the times it worked at any stage, in order (seconds_now).
        std::vector<std::pair<double, double>> busy;

      private:
        friend class StageTimer;
        StageTimer* current = nullptr;
    };

    Trace();
    ~Trace();
    Trace(const Trace&) = delete;
    Trace& operator=(const Trace&) = delete;

    /// Returns the threads that worked so far, in the order in which they began.
    const std::deque<Thread>& threads() const { return threads_; }

  private:
    friend class StageTimer;
    /// Returns the calling thread's record, null where no trace lives.
    static Thread* mine();

    std::mutex mutex_;
    std::deque<Thread> threads_;
};

/// Times a stage from its construction to its end, on one thread. Timers of a thread nest.
class StageTimer {
  public:
    /// `sum`: to which the whole time is added at the end; may be null.
    explicit StageTimer(Stage stage, double* sum = nullptr);
    ~StageTimer();
    StageTimer(const StageTimer&) = delete;
    StageTimer& operator=(const StageTimer&) = delete;

  private:
    Stage stage_;
    double* sum_;
    Trace::Thread* thread_;
    StageTimer* outer_ = nullptr;
    double start_;
    double processor_start_ = 0, inner_ = 0;  ///< inner_: of the timers inside
};

/// Returns for how many seconds between `begin` and `end` so many threads worked at once: [0] none,
/// [1] one alone, and so on.
std::vector<double> seconds_by_busy_threads(const std::deque<Trace::Thread>& threads, double begin,
                                            double end);

}  // namespace openfab
