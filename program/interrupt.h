// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Handles Ctrl-C. Before anything is written, a signal ends the process at once, even while a world
// is read or trees are built. While a sink is open, the first signal asks the print to end between two
// batches of blocks, or steps of a loop. A second signal ends the process, and so does a second of time:
// nobody waits for a kernel, a cut surface or a slow disk. What a sink has written is whole either way.

#include <atomic>
#include <cstdint>
#include <string>

namespace openfab::program {

/// The last signal that asked the process to end.
struct StopSignal {
    int number = 0;
    int64_t sender = 0;  ///< a process; 0 where the kernel sent it, as for Ctrl-C
};
StopSignal last_stop_signal();

/// Sets the handlers of SIGINT, SIGTERM and SIGALRM, ignores SIGPIPE and SIGXFSZ (a closed pipe and a
/// file above the limit are then write errors with a message), and returns the flag that a signal sets
/// while a DeferredInterrupt is alive. A signal at any other time ends the process with
/// `exit_code`, after `text`, which must outlive the process, on standard error.
const std::atomic<bool>& install_interrupt(int exit_code, const char* text);

/// During its lifetime a first signal only sets the flag, unless this lives on for a second. At most one
/// may exist. Its functions are for one thread at a time.
class DeferredInterrupt {
  public:
    DeferredInterrupt();
    ~DeferredInterrupt();
    DeferredInterrupt(const DeferredInterrupt&) = delete;
    DeferredInterrupt& operator=(const DeferredInterrupt&) = delete;

    /// Sets what is said instead of the text of install_interrupt if the process is ended after all: the
    /// first two `{}` become the numbers that `count` was last called with.
    void say(std::string text);
    void count(int64_t done, int64_t total);

  private:
    const char* text_before_;
};

}  // namespace openfab::program
