// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A file that is there only when it is whole: a mesh cannot be closed before its last slice.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "backends/common/output_file.h"

namespace openfab::boundary {

/// Written beside `path` as `path.part`, which is gone when this is, unless it was kept.
class PartFile {
  public:
    static Result<std::unique_ptr<PartFile>> create(const std::filesystem::path& path);
    ~PartFile();
    PartFile(const PartFile&) = delete;

    /// Bytes wait in a buffer until there are many.
    Result<void> write(std::span<const uint8_t> bytes);
    /// The file with all that was written until now.
    Result<backends::OutputFile*> flushed();
    /// Gives the file its name once it is on the disk; an earlier one is replaced.
    Result<void> keep();
    const std::filesystem::path& path() const { return path_; }

  private:
    PartFile(backends::OutputFile file, std::filesystem::path path);

    backends::OutputFile file_;
    std::filesystem::path path_;
    std::vector<uint8_t> waiting_;
    bool kept_ = false;
};

}  // namespace openfab::boundary
