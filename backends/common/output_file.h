// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes files and pipes, with errors that name the file and the system's reason.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "base/result.h"

namespace openfab::backends {

/// A file or pipe that is written front to back. Not copyable; closed by the destructor.
class OutputFile {
  public:
    /// Creates `path`, or replaces it: what it holds goes with the first write, or where it is
    /// closed; `-` is standard output. Fails with a user error where it is a folder, else with
    /// kOutside. A file is locked (output_lock.h) from here on.
    static Result<OutputFile> create(const std::string& path);
    /// Same, but keeps the contents of an existing file; writing continues where continue_at sets
    /// it. Fails with a usage error for anything but a regular file.
    static Result<OutputFile> reopen(const std::string& path);
    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&&) = delete;
    ~OutputFile();

    /// Writes all of `bytes`; after an error the file may hold a part of them.
    Result<void> write(std::span<const uint8_t> bytes);
    /// Overwrites earlier bytes at `offset`; fails on a pipe.
    Result<void> overwrite(int64_t offset, std::span<const uint8_t> bytes);
    /// Truncates a regular file to `size` bytes; does nothing for others.
    void cut_back_to(int64_t size);
    /// Truncates the file to `size` bytes and continues writing there.
    Result<void> continue_at(int64_t size);
    /// Syncs a regular file to the disk.
    Result<void> sync();
    /// Closes the file; with `sync` a regular file is synced to the disk first.
    Result<void> close(bool sync = true);
    int64_t bytes_written() const { return written_; }
    const std::string& name() const { return name_; }

  private:
    OutputFile(int fd, std::string name) : fd_(fd), name_(std::move(name)) {}
    static Result<OutputFile> open_locked(const std::string& path);
    /// Calls write(data, size) until all is written.
    template <typename Write>
    Result<void> write_with(std::span<const uint8_t> bytes, const Write& write);
    Result<void> drop_contents();

    int fd_ = -1;
    bool holds_earlier_ = false;  ///< contents that this print replaces
    int64_t written_ = 0;
    std::string name_;
};

/// Syncs the names in a folder to the disk, as far as its file system can; empty: the current one.
void sync_folder(const std::filesystem::path& folder);

/// Writes a whole file under a temporary name beside `path` and renames it, so that the file is
/// never partial. It is not synced. Pipes and devices are written directly.
Result<void> write_whole_file(const std::filesystem::path& path, std::span<const uint8_t> bytes);
Result<void> write_whole_file(const std::filesystem::path& path, const std::string& text);

}  // namespace openfab::backends
