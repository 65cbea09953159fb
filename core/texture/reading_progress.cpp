// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/reading_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "base/say.h"
#include "base/standard_error.h"

namespace openfab::texture {

bool tells_progress() {
    return ::isatty(message_descriptor()) != 0 || std::getenv(kTellProgress) != nullptr;
}

ReadingProgress::ReadingProgress(std::string name, std::chrono::milliseconds pause)
    : name_(std::move(name)),
      pause_(pause),
      tells_(tells_progress()),
      next_(Clock::now() + pause) {}

void ReadingProgress::at(double done) {
    if (!tells_ || done >= 1) return;
    const Clock::time_point now = Clock::now();
    if (now < next_) return;
    next_ = now + pause_;
    say(fmt::format("{}{}: {:.0f} %\n", kReading, name_, 100 * done));
}

}  // namespace openfab::texture
