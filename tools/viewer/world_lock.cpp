// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/world_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <thread>
#include <utility>

#include "tools/viewer/messages.h"

namespace openfab::viewer {

Result<WorldLock> WorldLock::take(std::mutex* mutex, const std::filesystem::path& world) {
    std::unique_lock lock(*mutex);
    const std::filesystem::path folder = std::filesystem::absolute(world).parent_path();
    const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    // A file system without locks has the threads' alone.
    constexpr int kTries = 1000;
    for (int i = 0; fd >= 0 && ::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK; ++i) {
        if (i == kTries) {
            ::close(fd);
            return user_error(fmt::format(messages::kFolderIsTaken, folder.string()));
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return WorldLock(std::move(lock), fd);
}

WorldLock::WorldLock(WorldLock&& other) noexcept
    : lock_(std::move(other.lock_)), fd_(std::exchange(other.fd_, -1)) {}

WorldLock::~WorldLock() {
    if (fd_ >= 0) ::close(fd_);
}

}  // namespace openfab::viewer
