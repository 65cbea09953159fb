// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reports progress of a print to people and programs, on stderr.

#include <cstdint>
#include <cstdio>
#include <mutex>
#include <string>
#include <string_view>

#include "base/result.h"
#include "runtime/pipeline/print_job.h"

namespace openfab::program {

enum class ProgressMode {
    kAuto,   ///< a bar where stderr is a terminal, else plain lines
    kPlain,  ///< a line now and then
    kJson,   ///< a JSON object a line
    kNone,
};

class Progress {
  public:
    Progress(ProgressMode mode, std::FILE* stream);
    /// Must be called after each slice; shows progress when due. Times come from the event, so that
    /// tests need no clock.
    void update(const pipeline::ProgressEvent& event);
    /// Shows a line of a fablet's printf, in every mode: as a JSON object `{"event": "print",
    /// "line": …}` in JSON mode, else as text.
    void print_line(const std::string& line);
    /// Show a message, in JSON mode as `{"event": "warning", "text": …}` or `"note"`. A warning is shown
    /// in every mode, a note not where nothing is to be said of the print's progress.
    void warn(const std::string& message);
    void note(const std::string& message);
    /// Tells that slices take long; from any thread, as all of these. JSON: `{"event": "slow", "first": …, "last": …,
    /// "seconds": …}`.
    void slow(int32_t first, int32_t last, double seconds);
    /// Shows the error that ended the print, in every mode: as JSON `{"event": "error", "text": …, "help": …}`, with
    /// "file", "line" and "column" if it has a location, or with "setting" if it is about a `--set`.
    void fail(const Error& error, std::string_view setting);
    /// Returns what `fail` writes, with what clears a bar.
    std::string error_text(const Error& error, std::string_view setting) const;
    /// Returns whether a line about the finished print, as people read it, is wanted.
    bool sums_up() const { return style_ == Style::kBar || style_ == Style::kPlain; }
    /// Clears the bar, so that later output starts on a line of its own.
    void end();

    /// Formats "slice 12 of 150  8 %  31.2 M voxels/s  2 min 10 s left"; rate and time left count
    /// from `start`, the first event, since set-up came before it.
    static std::string describe(const pipeline::ProgressEvent& event,
                                const pipeline::ProgressEvent& start = {});

  private:
    enum class Style { kBar, kPlain, kJson, kNone };
    void show_bar(const pipeline::ProgressEvent& event);
    void show_json(const pipeline::ProgressEvent& event);

    Style style_;
    std::FILE* stream_;
    std::recursive_mutex mutex_;
    pipeline::ProgressEvent start_;  ///< the first event; slices_done is 0 before it
    double due_seconds_ = 0;
    bool bar_shown_ = false;
};

}  // namespace openfab::program
