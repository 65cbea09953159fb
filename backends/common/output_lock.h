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

/// Returns whether a process has this lock of a file or folder.
bool is_locked(const std::string& path);

}  // namespace openfab::backends
