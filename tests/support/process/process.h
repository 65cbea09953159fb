// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs the project's own programs from tests, without a shell, and gives each test a folder that
// goes away with it.

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace openfab::testing {

struct Outcome {
    int exit_code = -1;  ///< 128 + signal where one ended it
    std::string out;
    std::string err;
    int64_t peak_rss_bytes = 0;    ///< of the program, and of what it became
    double processor_seconds = 0;  ///< user and system, with those of programs that it waited for
};

struct RunOptions {
    std::vector<std::pair<std::string, std::string>> environment;  ///< added to the test's own
    std::filesystem::path folder;  ///< working folder, empty: the test's
    /// Asked again and again with the milliseconds since the start and what was said so far;
    /// `signal` is sent when it is true for the first time.
    std::function<bool(int elapsed_ms, const Outcome& so_far)> interrupt_when;
    int signal = SIGINT;
    int64_t largest_file_bytes = -1;  ///< a limit of the system's, as a full disk; -1: none
    /// Called before each time that the program's standard output is read, at most 64 KB of it,
    /// with what was read so far. A reader that is slow takes its time here.
    std::function<void(const Outcome& so_far)> before_read;
};

/// `argv[0]` is a path. Ends a program that runs longer than ten minutes.
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

/// A disk of its own, in memory, mounted over a fresh folder until the end. Needs rights that not
/// everybody has.
class SmallDisk {
  public:
    /// Null, and why in `why_not`, where the system refuses.
    static std::unique_ptr<SmallDisk> create(int64_t bytes, std::string* why_not);
    ~SmallDisk();
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;

    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    /// Fills what is free with a file of this name, but for `but_for` bytes.
    void fill(const std::string& name, int64_t but_for) const;

  private:
    SmallDisk() = default;
    ScratchFolder folder_;
    bool mounted_ = false;
};

std::string read_file(const std::filesystem::path& file);

}  // namespace openfab::testing
