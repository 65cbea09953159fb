// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A program that runs beside this one, with its output in files. It sees none of this one's
// connections, and ends with it.

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/result.h"

namespace openfab::client {

class Child {
  public:
    /// Starts `argv[0]`, a path, without a shell; `out` and `err` are replaced.
    static Result<std::unique_ptr<Child>> start(const std::vector<std::string>& argv,
                                                const std::filesystem::path& out,
                                                const std::filesystem::path& err);
    /// Asks it to end, and waits for that.
    ~Child();
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Returns its exit code, 128 + the signal that ended it, or nothing while it runs.
    std::optional<int> exit_code() const;
    /// Waits for its end.
    int wait();

  private:
    explicit Child(pid_t process);

    pid_t process_;
    mutable std::mutex mutex_;  ///< of the code; the process is not waited for while it is held
    std::optional<int> code_;
    std::thread thread_;
};

/// Bounds what programs that are started here take that have a budget; 0, the default: they choose.
void set_memory_of_programs(int64_t bytes);
/// Returns the word of a command line with what is left of that for one that starts now; none without a bound.
std::vector<std::string> memory_words();

/// Runs a program of ours to its end; `out` and `err` are replaced. Relays why it failed.
Result<void> run(const std::vector<std::string>& argv, const std::filesystem::path& out,
                 const std::filesystem::path& err);

/// Says what a program of ours that ended with `code` said last, and returns an error of that kind that has nothing to
/// add: what it said has the form of our messages, with its place in a file.
Error relayed_error(const std::string& said, int code);

/// Returns up to `most` bytes of the end of a file; empty where it cannot be read.
std::string end_of_file(const std::filesystem::path& file, int64_t most);

}  // namespace openfab::client
