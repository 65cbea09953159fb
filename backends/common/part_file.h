// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// An output file that appears only when it is complete: a mesh is not closed before its last slice.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "backends/common/output_file.h"
#include "base/clean_exit.h"

namespace openfab::backends {

/// Writes to `path.part`, which is removed by the destructor unless `keep` was called.
class PartFile {
  public:
    static Result<std::unique_ptr<PartFile>> create(const std::filesystem::path& path);
    ~PartFile();
    PartFile(const PartFile&) = delete;

    /// Appends bytes, buffered.
    Result<void> write(std::span<const uint8_t> bytes);
    /// Flushes the buffer and returns the file.
    Result<OutputFile*> flushed();
    /// Flushes the buffer, and syncs the file to the disk.
    Result<void> sync();
    /// Syncs the file and renames it to `path`, replacing an earlier one.
    Result<void> keep();
    const std::filesystem::path& path() const { return path_; }
    /// Returns where the bytes lie until `keep`, for libraries that write to a file by its name.
    std::filesystem::path temporary_path() const { return path_.string() + ".part"; }

  private:
    PartFile(OutputFile file, std::filesystem::path path);

    OutputFile file_;
    std::filesystem::path path_;
    const RemovedAtEnd listed_;  ///< as a print may be ended at once
    std::vector<uint8_t> waiting_;
    bool kept_ = false;
};

}  // namespace openfab::backends
