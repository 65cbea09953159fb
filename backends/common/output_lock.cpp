// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/common/output_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>

#include "backends/common/messages.h"

namespace openfab::backends {

namespace {

/// Returns the process that has the lock, from the kernel's list of locks; 0 where unknown. On some
/// layered file systems the list has other inode numbers.
int holder_of(const struct stat& file) {
    std::ifstream list("/proc/locks");
    const std::string where =
        fmt::format("{:02x}:{:02x}:{}", major(file.st_dev), minor(file.st_dev), file.st_ino);
    for (std::string line; std::getline(list, line);) {
        char kind[16], lockable[16], id[64];
        int pid = 0;
        // "1: FLOCK  ADVISORY  WRITE 4711 fe:01:1234567 0 EOF"
        const int read =
            std::sscanf(line.c_str(), "%*s %15s %*s %15s %d %63s", kind, lockable, &pid, id);
        if (read == 4 && std::strcmp(kind, "FLOCK") == 0 && where == id) return pid;
    }
    return 0;
}

/// Formats "process 4711 (`card-print`)".
std::string describe(int pid) {
    if (pid <= 0) return messages::kAnotherProcess;
    // The name it was started by; the kernel's own is truncated to 15 bytes.
    std::string name;
    std::ifstream command(fmt::format("/proc/{}/cmdline", pid));
    std::getline(command, name, '\0');
    name.erase(0, name.find_last_of('/') + 1);
    return name.empty() ? fmt::format(messages::kProcessNumber, pid)
                        : fmt::format(messages::kProcessNamed, pid, name);
}

}  // namespace

Result<void> lock_output(int fd, const std::string& name) {
    struct stat status {};
    if (::fstat(fd, &status) != 0 || !(S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)))
        return {};
    while (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
        if (errno == EINTR) continue;
        if (errno != EWOULDBLOCK) return {};
        return outside_error(
            fmt::format(messages::kBeingWritten, name, describe(holder_of(status))));
    }
    return {};
}

bool is_locked(const std::string& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) return false;
    const bool locked = ::flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    ::close(fd);
    return locked;
}

}  // namespace openfab::backends
