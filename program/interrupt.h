// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Handles Ctrl-C. Before anything is written, a signal ends the process at once, even while a world
// is read or trees are built. While a sink is open, the first signal asks the print to end after
// the slices in flight, and the second ends the process.

#include <atomic>

namespace openfab::program {

/// Sets the handlers of SIGINT and SIGTERM, ignores SIGPIPE and SIGXFSZ (a closed pipe and a file
/// above the limit are then write errors with a message), and returns the flag that a signal sets
/// while a DeferredInterrupt is alive. A signal at any other time ends the process with
/// `exit_code`, after `text`, which must outlive the process, on standard error.
const std::atomic<bool>& install_interrupt(int exit_code, const char* text);

/// During its lifetime a first signal only sets the flag. At most one may exist.
class DeferredInterrupt {
  public:
    DeferredInterrupt();
    ~DeferredInterrupt();
    DeferredInterrupt(const DeferredInterrupt&) = delete;
    DeferredInterrupt& operator=(const DeferredInterrupt&) = delete;
};

}  // namespace openfab::program
