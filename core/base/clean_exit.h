// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cleans up when a signal ends the process: removes its temporary files and folders, and terminates
// the programs that it runs. What SIGKILL leaves behind, the next process removes (own_folder.h).

#include <sys/types.h>

#include <filesystem>
#include <functional>

namespace openfab {

/// Name of the environment variable with the number of the process that this one ends with.
constexpr const char* kEndsWith = "OPENFAB_ENDS_WITH";

/// Whether another program of ours started this one: what it advises is not for the command that the user gave.
bool has_starter();

/// Sends SIGTERM to this process once the one that kEndsWith names is gone, also by SIGKILL; does
/// nothing without that variable. clean_up_on_signals calls it.
void end_with_starter();

/// Name of the environment variable that is 1 where the starter tells of an interruption, since both write to the
/// same standard error.
constexpr const char* kStarterTells = "OPENFAB_STARTER_TELLS";

/// Installs handlers of SIGINT, SIGTERM and SIGHUP that tell it (tell_interrupted), terminate child programs, remove
/// what is listed, and then end the process with the exit code of an interruption. An ignored signal stays ignored;
/// a second one ends the process immediately.
void clean_up_on_signals();

/// Writes the one line that says that the process was interrupted, unless it was written before, or a program that
/// shares standard error does that. Async-signal-safe.
void tell_interrupted();
/// What a program that was started has said of it stands for that line; false where it was written before.
bool claim_interrupted();
void unclaim_interrupted();

/// Whether a signal has begun to end the process: nothing more is said. A handler of its own calls the first.
void begin_ending();
bool is_ending();
/// Waits for that end, if it has begun.
void wait_if_ending();

/// Ends the process with `exit_code` after the same clean-up. Async-signal-safe; may return before
/// the process has ended.
void end_cleanly(int exit_code);

/// Lists a file or folder for removal during its own lifetime.
class RemovedAtEnd {
  public:
    /// Calls `make` and lists the path that it returns (empty: failure), with signals held off in
    /// between.
    explicit RemovedAtEnd(const std::function<std::filesystem::path()>& make);
    ~RemovedAtEnd();
    RemovedAtEnd(const RemovedAtEnd&) = delete;
    RemovedAtEnd& operator=(const RemovedAtEnd&) = delete;

  private:
    std::filesystem::path path_;
};

/// A group of processes, which is ended with this one. Its leader is waited for by others.
class RunningGroup {
  public:
    explicit RunningGroup(pid_t leader);
    ~RunningGroup();
    RunningGroup(const RunningGroup&) = delete;
    RunningGroup& operator=(const RunningGroup&) = delete;

  private:
    pid_t leader_;
};

/// A child process, which is terminated with this one until it has been waited for.
class RunningProgram {
  public:
    explicit RunningProgram(pid_t child);
    ~RunningProgram();
    RunningProgram(const RunningProgram&) = delete;
    RunningProgram& operator=(const RunningProgram&) = delete;

    /// Waits for its end and sets `status` as waitpid does; false with errno on failure.
    bool wait(int* status);

  private:
    pid_t child_;
};

}  // namespace openfab
