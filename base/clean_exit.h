// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Removes what a process would leave behind when a signal ends it: its temporary files and folders,
// and the programs that it runs. What SIGKILL leaves, the next process removes (own_folder.h).

#include <sys/types.h>

#include <filesystem>
#include <functional>

namespace openfab {

/// From now on SIGINT and SIGTERM end the programs that run for this process, remove what is
/// listed, and then end the process as they would have. A signal that was ignored stays so; the
/// second of a kind ends the process at once.
void clean_up_on_signals();

/// For handlers of signals: ends the process with `exit_code`, after the same; it returns where
/// that takes a moment.
void end_cleanly(int exit_code);

/// Lists a file, or a folder with all that it holds, as long as it lives.
class RemovedAtEnd {
  public:
    /// Lists the path that `make` makes and returns, empty where that fails: no signal comes
    /// between.
    explicit RemovedAtEnd(const std::function<std::filesystem::path()>& make);
    ~RemovedAtEnd();
    RemovedAtEnd(const RemovedAtEnd&) = delete;
    RemovedAtEnd& operator=(const RemovedAtEnd&) = delete;

  private:
    std::filesystem::path path_;
};

/// A child process, which is ended with this one until somebody has waited for it.
class RunningProgram {
  public:
    explicit RunningProgram(pid_t child);
    ~RunningProgram();
    RunningProgram(const RunningProgram&) = delete;
    RunningProgram& operator=(const RunningProgram&) = delete;

    /// Waits for its end; false with errno where it is lost, else `status` is as from waitpid.
    bool wait(int* status);

  private:
    pid_t child_;
};

}  // namespace openfab
