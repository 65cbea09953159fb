// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far a converter is with a large file: lines on standard error, `reading scan.vtu: 40 %`, where a
// person looks at it. A print that waits for a converter passes them on.

#include <chrono>
#include <string>

namespace openfab::texture {

/// What such lines begin with.
constexpr const char* kReading = "reading ";
/// The variable by which a program tells the converter that it passes lines on.
constexpr const char* kTellProgress = "OPENFAB_TELL_PROGRESS";

/// Returns whether standard error is a terminal, or a program that passes lines on.
bool tells_progress();

class ReadingProgress {
  public:
    /// Tells at most once in `pause`, and nothing before the first one is over.
    explicit ReadingProgress(std::string name,
                             std::chrono::milliseconds pause = std::chrono::seconds(2));
    /// `done` is a share of the work, 0 to 1.
    void at(double done);

  private:
    using Clock = std::chrono::steady_clock;
    std::string name_;
    std::chrono::milliseconds pause_;
    bool tells_ = false;
    Clock::time_point next_;
};

}  // namespace openfab::texture
