// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs the project's own programs from tests, without a shell, and gives each test a folder that is
// removed with it.

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace openfab::testing {

struct Outcome {
    int exit_code = -1;  ///< 128 + signal if a signal ended it
    std::string out;
    std::string err;
    int64_t peak_rss_bytes = 0;    ///< of the process, across exec
    double processor_seconds = 0;  ///< user and system, including children
};

struct RunOptions {
    std::vector<std::pair<std::string, std::string>> environment;  ///< added to the test's own
    std::filesystem::path folder;  ///< working folder, empty: the test's
    /// Polled with the milliseconds since the start and the output so far; `signal` is sent when it
    /// first returns true.
    std::function<bool(int elapsed_ms, const Outcome& so_far)> interrupt_when;
    int signal = SIGINT;
    /// Permissions of files hold for the program and all that it starts even if this is root.
    bool obeys_permissions = false;
    int64_t largest_file_bytes = -1;  ///< RLIMIT_FSIZE, like a full disk; -1: none
    /// Called before each read of the program's standard output, of at most 64 KB, with the output
    /// so far. A test of a slow reader waits here.
    std::function<void(const Outcome& so_far)> before_read;
};

/// Runs a program; `argv[0]` is a path. Kills a program that runs longer than ten minutes.
Outcome run(const std::vector<std::string>& argv, const RunOptions& options = {});

/// A fresh folder below the system's temporary one, removed with everything in it.
class ScratchFolder {
  public:
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    void write(const std::string& name, const std::string& text) const;

  private:
    std::filesystem::path path_;
};

/// A small in-memory file system, mounted over a fresh folder until destruction. Needs privileges.
class SmallDisk {
  public:
    /// Mounts one; returns null, and the reason in `why_not`, if the system refuses.
    static std::unique_ptr<SmallDisk> create(int64_t bytes, std::string* why_not);
    ~SmallDisk();
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;

    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    /// Fills the free space with a file of this name, except `but_for` bytes.
    void fill(const std::string& name, int64_t but_for) const;

  private:
    SmallDisk() = default;
    ScratchFolder folder_;
    bool mounted_ = false;
};

std::string read_file(const std::filesystem::path& file);

}  // namespace openfab::testing
