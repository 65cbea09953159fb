// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files of a store that several processes fill at once: each is written under a name of its own and renamed, so that
// it is whole or not there.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab::zarr {

/// Writes a file, and folders above it. One that has these bytes already stays as it is.
Result<void> write_store_file(const std::filesystem::path& file, std::span<const uint8_t> bytes);
Result<void> write_store_file(const std::filesystem::path& file, std::string_view text);

/// As write_store_file, but never replaces a file: returns whether there was none.
Result<bool> claim_store_file(const std::filesystem::path& file, std::string_view text);

Result<void> remove_store_file(const std::filesystem::path& file);

/// A file to which lines are added while its range of slices is locked for this process.
class ListFile {
  public:
    static Result<ListFile> open(const std::filesystem::path& file);
    ListFile(ListFile&& other) noexcept;
    ListFile& operator=(ListFile&&) = delete;
    ~ListFile();

    /// Cuts the file to its first bytes.
    Result<void> cut(size_t bytes) const;
    Result<void> add(std::string_view text) const;
    /// Syncs the file system of the store.
    Result<void> sync() const;

  private:
    ListFile(int fd, std::filesystem::path path) : fd_(fd), path_(std::move(path)) {}

    int fd_ = -1;
    std::filesystem::path path_;
};

}  // namespace openfab::zarr
