// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The only place where other programs are started: without a shell, without our descriptors but for three, and so that
// they end with us. Our own programs do by kEndsWith (clean_exit.h); what a group of others does is in GroupWatch.

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab {

struct ProgramStart {
    std::vector<std::string> argv;    ///< the first is its path
    bool search = false;              ///< looks for it along the PATH
    std::filesystem::path folder;     ///< where it runs; empty: where we do
    int in = 0, out = 1, err = 2;     ///< our descriptors, which become its first three
    bool own_group = false;           ///< of processes: Ctrl-C does not reach it
    bool tells_interruption = false;  ///< itself, though it writes to our standard error
    /// `NAME=VALUE`, in place of ours.
    std::vector<std::string> environment;
};

/// Starts a program; returns 0, or the error's number.
int start_program(const ProgramStart& start, pid_t* process);

/// Returns the folder of the running program, beside which our others lie.
Result<std::filesystem::path> program_folder();

/// Opens the null device; -1 where that fails.
int open_null();

/// Ends a group of processes once this process is gone, also by SIGKILL: SIGTERM, and a second later SIGKILL. A process
/// of its own watches for that. Where it cannot be started, nobody does.
class GroupWatch {
  public:
    explicit GroupWatch(pid_t group);
    /// Ends the watch, not the group.
    ~GroupWatch();
    GroupWatch(const GroupWatch&) = delete;
    GroupWatch& operator=(const GroupWatch&) = delete;

  private:
    pid_t process_ = -1;
    int line_ = -1;  ///< its other end closes with this process
};

}  // namespace openfab
