// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One writer for one output: a lock that goes with the process, however it ends, so that what a
// killed print leaves blocks nobody.

#include <string>

#include "base/result.h"

namespace openfab::backends {

/// Locks the file or folder behind `fd` until it is closed. Where another print has it, an error
/// that names `name` and, where the system tells, the process. File systems that know no locks have
/// none; so have pipes and devices, which are passed over.
Result<void> lock_output(int fd, const std::string& name);

/// A folder that no other print writes to while this lives.
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
