// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Folders that nobody else can write: programs and data that are found in one were put there by
// this user. And what is made in them for a while, which goes even if its maker dies.

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "base/clean_exit.h"
#include "base/result.h"

namespace openfab {

/// Makes `folder` where it is missing, for this user alone, and checks it: it is this user's, and
/// neither it nor any folder above can be changed by others than this user and root (folders above
/// may be sticky, as /tmp is). The folder without links; or, without its name, why it is not to be
/// used.
Result<std::filesystem::path> own_folder(const std::filesystem::path& folder);

/// What temporary names end in: this, and six letters.
constexpr std::string_view kTemporaryMark = ".tmp-";

/// A folder for a while, which nobody else can look into. Its maker holds a lock on it, and it goes
/// with the maker (clean_exit.h).
class TemporaryFolder {
  public:
    /// In `place`; empty: in the system's folder for temporary files. Those that were left there by
    /// makers that were killed are removed.
    static Result<std::unique_ptr<TemporaryFolder>> create(const std::filesystem::path& place = {});
    /// Removes it with all that it holds.
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

/// A new file `name`.tmp-XXXXXX, open to be read and written, and locked while it is open. Returns
/// its descriptor and sets `made`; -1 with errno where that fails.
int open_temporary(const std::filesystem::path& name, std::filesystem::path* made);

/// Removes files and folders of temporary names whose makers are gone: those that are not locked.
/// Only below own_folder.
void clear_left_over(const std::filesystem::path& folder);

}  // namespace openfab
