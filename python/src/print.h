// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print in a thread of its own, which its reader waits for in steps, so that Python can look for
// signals in between.

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/result.h"
#include "program/options.h"
#include "program/prepare.h"
#include "program/rates.h"
#include "python/src/program.h"
#include "python/src/slice_queue.h"
#include "runtime/pipeline/print_job.h"

namespace openfab::python {

/// What becomes of a print's slices.
enum class Target {
    kSlices,    ///< they are handed out
    kOutput,    ///< they go where the options say
    kPictures,  ///< they are drawn, as the options' previews say
    kNothing,   ///< set-up alone, for its figures
    kEstimate,  ///< none: the statistics are those of `--estimate`
};

/// RGBA of 8 bits each, sRGB, top row first.
struct Picture8 {
    int32_t width = 0, height = 0;
    std::vector<uint8_t> rgba;
};

class Print {
  public:
    /// Starts the thread. Slices have derivatives by the uniforms `derivatives`, OBJECT.UNIFORM, for which the program
    /// was compiled. With `output`, slices are written there in place of the options' own, which is
    /// what messages name. With a window the grid is that.
    Print(std::shared_ptr<const Program> program, program::Options options, Target target,
          bool fractions, std::string output, std::optional<Box3d> window_mm,
          std::vector<std::string> derivatives = {});
    /// Cancels and waits.
    ~Print();
    Print(const Print&) = delete;
    Print& operator=(const Print&) = delete;

    enum class State { kSettingUp, kPrinting, kEnded };
    State state() const;
    /// Waits for another state than `state`, at most so many seconds; returns the state.
    State wait_while(State state, double seconds) const;
    /// Returns the next slice; nothing where there is none yet, or no more.
    std::optional<Slice> next(double seconds) { return queue_.take(seconds); }
    /// Asks for the end; slices that were handed out stay valid.
    void cancel();
    /// Waits for the end. Idempotent.
    void join();

    /// What is known from the state kPrinting on.
    const pipeline::PrintInfo& info() const { return info_; }
    bool wants_fractions() const { return wants_fractions_; }
    int32_t fraction_materials() const { return planes_.materials(); }
    const std::vector<program::RateColumns>& rate_columns() const { return rate_columns_; }
    int32_t rate_count() const { return planes_.rate_columns(); }
    const pipeline::PrintEstimate& estimate() const { return estimate_; }
    /// What is known from the state kEnded on: an error, or the JSON of `--stats`, and pictures.
    const std::optional<Error>& error() const { return error_; }
    const std::string& statistics() const { return statistics_; }
    const std::vector<Picture8>& pictures() const { return pictures_; }
    /// At any time.
    pipeline::ProgressEvent progress() const;
    /// Returns notes, warnings and lines of printf since the last call.
    std::vector<std::string> take_notes();
    std::vector<std::string> take_warnings();
    std::vector<std::string> take_lines();

  private:
    void run();
    Result<void> print();
    /// Sets the statistics to those of `--estimate`.
    Result<void> make_estimate(program::PreparedPrint ready);
    /// Hands out means over so many parts of each voxel of info_, and no codes.
    Result<void> print_means(const Vec3i& parts);
    Result<std::unique_ptr<pipeline::SliceSink>> open_sink(const world::Printer& printer,
                                                           backends::MixtureInlet* mixtures);
    void set_state(State state);

    const std::shared_ptr<const Program> program_;
    const Target target_;
    const bool wants_fractions_;
    const std::string output_;
    const std::optional<Box3d> window_mm_;
    const std::vector<std::string> derivatives_;
    std::vector<program::RateColumns> rate_columns_;
    program::Options options_;
    FractionPlanes planes_;
    SliceQueue queue_;
    std::atomic<bool> interrupt_{false};

    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    State state_ = State::kSettingUp;
    pipeline::ProgressEvent progress_;
    std::vector<std::string> notes_, warnings_, lines_;

    pipeline::PrintInfo info_;
    pipeline::PrintEstimate estimate_;
    std::optional<Error> error_;
    std::string statistics_;
    std::vector<Picture8> pictures_;
    std::thread thread_;  ///< last: it uses the others
};

}  // namespace openfab::python
