// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writing to files, folders and pipes, with messages that name the file and the system's reason.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "base/result.h"

namespace openfab::backends {

/// A file or pipe that is written front to back. Not copyable; closed when it goes.
class OutputFile {
  public:
    /// Creates or empties `path`; `-` is standard output. A folder in the way is a user error, the
    /// rest is the outside's. A file is locked (output_lock.h) before it is emptied.
    static Result<OutputFile> create(const std::string& path);
    /// The same, but keeps what is in a file that is there; writing goes on where continue_at says.
    /// What is no file that can be read back is a usage error.
    static Result<OutputFile> reopen(const std::string& path);
    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&&) = delete;
    ~OutputFile();

    /// All of `bytes` or an error; after an error the file may hold a part of them.
    Result<void> write(std::span<const uint8_t> bytes);
    /// Puts `bytes` in the place of some that were written before; a pipe does not allow it.
    Result<void> overwrite(int64_t offset, std::span<const uint8_t> bytes);
    /// Drops what was written after the first `size` bytes, where the file allows it (a pipe does
    /// not).
    void cut_back_to(int64_t size);
    /// Drops what stands after the first `size` bytes, and goes on writing there.
    Result<void> continue_at(int64_t size);
    /// Waits until a regular file is on the disk.
    Result<void> sync();
    /// Closes; with `sync` a regular file is on the disk then, without it only on its way there.
    Result<void> close(bool sync = true);
    int64_t bytes_written() const { return written_; }
    const std::string& name() const { return name_; }

  private:
    OutputFile(int fd, std::string name) : fd_(fd), name_(std::move(name)) {}
    static Result<OutputFile> open_locked(const std::string& path);
    /// All of it by write(data, size), which is asked again until all is written.
    template <typename Write>
    Result<void> write_with(std::span<const uint8_t> bytes, const Write& write);

    int fd_ = -1;
    int64_t written_ = 0;
    std::string name_;
};

/// Writes a whole file under a temporary name beside `path` and renames it, so that a file that is
/// there is whole. The disk may still be busy with it: sync_file waits. Pipes and devices are
/// written to as they are.
Result<void> write_whole_file(const std::filesystem::path& path, std::span<const uint8_t> bytes);
Result<void> write_whole_file(const std::filesystem::path& path, const std::string& text);
/// Waits until the file or folder is on the disk.
Result<void> sync_file(const std::filesystem::path& path);

}  // namespace openfab::backends
