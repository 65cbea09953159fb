// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Folders that only this user can write, so that programs and data found in one were put there by
// this user, and temporary files and folders in them, which are cleaned up even after a crash.

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "base/clean_exit.h"
#include "base/result.h"

namespace openfab {

/// Creates `folder` where it is missing, for this user alone, and checks that it belongs to this
/// user and that only this user and root can change it and the folders above (which may be sticky,
/// like /tmp). Returns the folder without links; errors say why it must not be used, without its
/// name.
Result<std::filesystem::path> own_folder(const std::filesystem::path& folder);

/// Fails where this process cannot make files in the folder; the error says why, without its name.
Result<void> check_writable(const std::filesystem::path& folder);

/// Temporary names end in this and six letters.
constexpr std::string_view kTemporaryMark = ".tmp-";

/// A temporary folder, readable by this user only. The process that created it holds a lock on it
/// and removes it when it ends (clean_exit.h).
class TemporaryFolder {
  public:
    /// Creates one in `base_folder`; empty: in the system's folder for temporary files. Removes
    /// those that killed processes left there.
    static Result<std::unique_ptr<TemporaryFolder>> create(
        const std::filesystem::path& base_folder = {});
    /// Removes the folder and its contents.
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

  private:
    TemporaryFolder() = default;

    std::filesystem::path path_;
    std::optional<RemovedAtEnd> at_end_;
    int lock_ = -1;
};

/// Creates and locks a file `name`.tmp-XXXXXX, open for reading and writing. Returns its descriptor
/// and sets `made`; returns -1 and sets errno on failure.
int open_temporary(const std::filesystem::path& name, std::filesystem::path* made);

/// Removes temporary files and folders that no process holds locked any more. For use below
/// own_folder only.
void clear_left_over(const std::filesystem::path& folder);

}  // namespace openfab
