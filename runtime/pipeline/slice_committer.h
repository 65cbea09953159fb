// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The end of the slab loop: finished slices go to the sink in order, and are counted.

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "abi/kernel_status.h"
#include "base/result.h"
#include "runtime/pipeline/print_statistics.h"
#include "runtime/pipeline/slab.h"
#include "runtime/pipeline/slice_sink.h"
#include "runtime/pipeline/slice_totals.h"
#include "runtime/segments/printf_log.h"

namespace openfab::pipeline {

/// Encoded slices of one slab, waiting to be committed in order.
struct FinishedSlices {
    int32_t first = 0, end = 0;
    abi::KernelStatus status;
    std::string kernel_error;
    Result<void> outcome;  ///< an error where a surface kernel, or writing fractions, has failed
    struct Slice {
        int32_t z = 0;
        SliceTotals totals;
        std::vector<uint8_t> bytes;
    };
    std::vector<Slice> slices;
    segments::PrintfLog log;
};

/// Returns the voxels with a material.
int64_t solid_of(const SliceTotals& totals);

/// Returns the totals as sinks are told them, of so many materials.
PrintTotals print_totals(const SliceTotals& counted, size_t materials);

/// Takes finished slabs in order, from one thread at a time, and commits their slices to the sink.
class SliceCommitter {
  public:
    /// The references must outlive the committer. `began_seconds`: see PrintOptions.
    SliceCommitter(SliceSink& sink, const std::function<void(const ProgressEvent&)>& progress,
                   const std::atomic<bool>& interrupt, const PrintInfo& info,
                   const std::function<void(const std::string&)>& print_line, double began_seconds)
        : sink_(sink),
          progress_(progress),
          info_(info),
          print_line_(print_line),
          began_(began_seconds),
          stop_{interrupt} {}

    /// Returns whether to stop printing: interrupted, or something failed.
    bool stopped() const { return stop_.requested(); }
    const StopFlags& stop_flags() const { return stop_; }

    void commit(FinishedSlices slab);

    /// Counts a slice that an earlier print has written; returns false to stop.
    bool count_resumed(const SliceView& slice);
    int32_t resumed() const { return resumed_; }
    void end_resumed();
    int64_t solid_resumed() const { return solid_resumed_; }

    void fail(Error error);
    bool failed() const { return failed_; }
    const Error& error() const { return error_; }
    int32_t slices() const { return slices_; }
    const SliceTotals& totals() const { return totals_; }
    /// Return the time of the first slice since the print began, the seconds in the sink's
    /// commit, and the bytes that it took.
    double first_slice() const { return first_slice_; }
    double seconds_commit() const { return seconds_commit_; }
    int64_t bytes() const { return bytes_; }

    /// Prints a log and empties it; returns false, and fails, at a failed assertion.
    bool show_log(segments::PrintfLog& log);
    /// Logs how many lines of each printf were suppressed.
    void end_log();

  private:
    bool matches_resumed_slice(const FinishedSlices::Slice& slice);
    void report();

    SliceSink& sink_;
    const std::function<void(const ProgressEvent&)>& progress_;
    const PrintInfo& info_;
    const std::function<void(const std::string&)>& print_line_;
    const double began_;
    segments::PrintfLog log_;
    StopFlags stop_;
    bool failed_ = false, ended_ = false;
    Error error_;
    int32_t slices_ = 0;  ///< including resumed ones
    int32_t resumed_ = 0;
    std::array<uint64_t, 8> last_resumed_{};  ///< hashes, by z modulo 8
    int64_t solid_resumed_ = 0;
    SliceTotals totals_;
    double first_slice_ = 0, seconds_commit_ = 0;
    int64_t bytes_ = 0;
};

}  // namespace openfab::pipeline
