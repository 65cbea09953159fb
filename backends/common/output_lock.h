// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Exclusive locks of outputs. A lock ends with its process, even if that is killed, so locks are
// never stale.

#include <string>

#include "base/result.h"

namespace openfab::backends {

/// Locks the file or folder behind `fd` until it is closed. Fails where another process has it; the
/// error names `name` and, where known, the process. Does nothing for pipes, devices and file
/// systems without locks.
Result<void> lock_output(int fd, const std::string& name);

/// An exclusive lock of an output folder.
class FolderLock {
  public:
    static Result<FolderLock> take(const std::string& folder);
    FolderLock(FolderLock&& other) noexcept;
    FolderLock& operator=(FolderLock&&) = delete;
    ~FolderLock();

  private:
    explicit FolderLock(int fd) : fd_(fd) {}
    int fd_ = -1;
};

}  // namespace openfab::backends
