// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Progress of a print for people and programs, on stderr.

#include <cstdint>
#include <cstdio>
#include <string>

#include "runtime/pipeline/print.h"

namespace openfab::report {

enum class ProgressMode {
    kAuto,   ///< a bar where stderr is a terminal, else plain lines
    kPlain,  ///< a line now and then
    kJson,   ///< a JSON object a line
    kNone,
};

class Progress {
  public:
    Progress(ProgressMode mode, std::FILE* stream);
    /// Called after each slice; shows what is due. Times come from the event, so that tests need no
    /// clock.
    void update(const slab::ProgressEvent& event);
    /// Shows a line that a fablet prints, in every mode, since it was asked for: a JSON object
    /// `{"event": "print", "line": …}` among others of its kind, else the text.
    void print_line(const std::string& line);
    /// Clears the bar, so that what follows starts on a line of its own.
    void end();

    /// "slice 12 of 150  8 %  31.2 M voxels/s  2 min 10 s left"; rate and time left are those since
    /// `start`, the first event, since what came before it was set-up.
    static std::string describe(const slab::ProgressEvent& event,
                                const slab::ProgressEvent& start = {});

  private:
    enum class Style { kBar, kPlain, kJson, kNone };
    void show_bar(const slab::ProgressEvent& event);
    void show_json(const slab::ProgressEvent& event);

    Style style_;
    std::FILE* stream_;
    slab::ProgressEvent start_;  ///< the first event; slices_done is 0 before it
    double due_seconds_ = 0;
    bool bar_shown_ = false;
};

}  // namespace openfab::report
