// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A program of the user's that answers lines: it runs beside us, without a shell, and is ended with us. What it
// writes to its standard error is the user's to see.

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/clean_exit.h"
#include "base/result.h"
#include "base/start_program.h"

namespace openfab {

/// The option without which no program of a world runs. It stands among the folders of `--allow`, where both are
/// handed on.
constexpr const char* kProgramsWord = "--allow-programs";
constexpr const char* kProgramsHelp =
    "run the programs that a world names: never those of a stranger";
/// Returns the word of a command line that allows a folder, or programs.
inline std::string allow_argument(const std::string& allow) {
    return allow == kProgramsWord ? allow : "--allow=" + allow;
}

class TalkingProgram {
  public:
    struct Limits {
        int32_t answer_ms = 60'000;            ///< for one answer
        size_t most_bytes = size_t{64} << 20;  ///< of one answer
    };

    /// `command`: the program, which is looked for along the PATH, and its arguments; it runs in `folder`.
    TalkingProgram(std::vector<std::string> command, std::filesystem::path folder,
                   const Limits& limits);
    ~TalkingProgram();
    TalkingProgram(const TalkingProgram&) = delete;
    TalkingProgram& operator=(const TalkingProgram&) = delete;

    /// Sends a line and returns the lines up to one that is `done`, which is left out. Starts the program where it is
    /// not running. After an error it is not started again. Ends early, with an error, once `stop` is set, which may
    /// be null. One thread at a time.
    Result<std::string> ask(const std::string& line, const std::atomic<bool>* stop);

    /// Returns the program as messages call it.
    const std::string& name() const { return name_; }

  private:
    Result<void> start();
    Result<void> send(const std::string& line);
    Result<std::string> receive(const std::string& asked, const std::atomic<bool>* stop);
    Error ended(const std::string& asked);
    void end();
    /// Returns whether its process has ended within so long; it is still there.
    bool has_ended(int32_t ms) const;
    /// Kills what is left of its group, and forgets the process; returns its status, as waitpid does.
    int end_group();

    const std::vector<std::string> command_;
    const std::filesystem::path folder_;
    const Limits limits_;
    std::string name_;
    pid_t process_ = 0;
    std::unique_ptr<RunningGroup> running_;
    std::unique_ptr<GroupWatch> watch_;
    int line_ = -1;
    bool failed_ = false;
    std::string received_;
};

/// The first word of a command that is answered by the process itself; the second is for who answers.
constexpr const char* kThisProcess = "(this process)";
/// Sets what opens a line to it: a socket, which is then ours, or -1. For Python, whose functions may answer.
void set_line_opener(std::function<int(const std::string&)> open);

}  // namespace openfab
