// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Compare and replace of a world's files as one step: for the threads of a viewer, and for other viewers of the same
// folder.

#include <filesystem>
#include <mutex>

#include "base/result.h"

namespace openfab::viewer {

/// Held while files are read, compared and replaced.
class WorldLock {
  public:
    /// Waits for others, though not for long: they hold it while they replace files.
    static Result<WorldLock> take(std::mutex* mutex, const std::filesystem::path& world);
    WorldLock(WorldLock&& other) noexcept;
    WorldLock& operator=(WorldLock&&) = delete;
    ~WorldLock();

  private:
    WorldLock(std::unique_lock<std::mutex> lock, int fd) : lock_(std::move(lock)), fd_(fd) {}

    std::unique_lock<std::mutex> lock_;
    int fd_;  ///< of the world's folder
};

}  // namespace openfab::viewer
