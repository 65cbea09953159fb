// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Ctrl-C. Before anything is written, a signal ends the process at once, whatever it is at: reading
// a world, building trees, an estimate. While a sink is open, the first signal asks the print to end
// after the slices in flight, and the second ends the process.

#include <atomic>

namespace openfab::print {

/// Sets the handlers of SIGINT and SIGTERM, ignores SIGPIPE and SIGXFSZ (a closed pipe and a file
/// above the limit are then write errors with a message), and returns the flag that a signal sets
/// while a KeepSlices is alive. A signal at any other time ends the process with `exit_code`, after
/// `text`, which must stay, on standard error.
const std::atomic<bool>& install_interrupt(int exit_code, const char* text);

/// While it lives, a first signal only sets the flag. One at a time.
class KeepSlices {
  public:
    KeepSlices();
    ~KeepSlices();
    KeepSlices(const KeepSlices&) = delete;
    KeepSlices& operator=(const KeepSlices&) = delete;
};

}  // namespace openfab::print
