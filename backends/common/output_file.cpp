// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/common/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "backends/common/messages.h"
#include "backends/common/output_lock.h"
#include "base/system_reason.h"

namespace openfab::backends {

namespace {

Error system_error(const char* what, const std::string& name, int code) {
    return outside_error(fmt::format("{} `{}`: {}", what, name, system_reason(code)));
}

}  // namespace

Result<OutputFile> OutputFile::create(const std::string& path) {
    if (path == "-") {
        const int fd = ::dup(STDOUT_FILENO);
        if (fd < 0) return system_error(messages::kCannotWriteTo, messages::kStandardOutput, errno);
        return OutputFile(fd, messages::kStandardOutput);
    }
    Result<OutputFile> file = open_locked(path);
    if (file) file->holds_earlier_ = true;
    return file;
}

Result<OutputFile> OutputFile::reopen(const std::string& path) {
    struct stat status {};
    if (path == "-" || (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) &&
                        !S_ISDIR(status.st_mode))) {
        return usage_error(fmt::format(messages::kResumeNeedsFile,
                                       path == "-" ? messages::kStandardOutput : "`" + path + "`"));
    }
    return open_locked(path);
}

Result<OutputFile> OutputFile::open_locked(const std::string& path) {
    // More than one attempt is needed only if other processes replace the file concurrently.
    constexpr int kTries = 100;
    for (int tries = 1;; ++tries) {
        struct stat named {};
        if (::stat(path.c_str(), &named) == 0 && S_ISDIR(named.st_mode)) {
            return user_error(fmt::format(messages::kOutputIsFolder, path));
        }
        // Nonblocking: opening a pipe that nobody reads would wait. Writing to one blocks again.
        const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_NONBLOCK | O_CLOEXEC, 0666);
        if (fd < 0 && errno == ENXIO) return user_error(fmt::format(messages::kPipeUnread, path));
        if (fd < 0) return system_error(messages::kCannotCreate, path, errno);
        ::fcntl(fd, F_SETFL, 0);
        OutputFile file(fd, path);
        if (Result<void> locked = lock_output(fd, path); !locked) return locked.error();
        // The previous holder of the lock may have renamed the file before releasing it.
        struct stat opened {};
        if (::fstat(fd, &opened) != 0) return system_error(messages::kCannotWriteTo, path, errno);
        const bool same = ::stat(path.c_str(), &named) == 0 && named.st_dev == opened.st_dev &&
                          named.st_ino == opened.st_ino;
        if (same || tries == kTries) return file;
    }
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      holds_earlier_(other.holds_earlier_),
      written_(other.written_),
      name_(std::move(other.name_)) {}

OutputFile::~OutputFile() {
    if (fd_ >= 0) ::close(fd_);
}

template <typename Write>
Result<void> OutputFile::write_with(std::span<const uint8_t> bytes, const Write& write) {
    while (!bytes.empty()) {
        // Linux writes at most 2 GiB at once.
        const ssize_t n = write(bytes.data(), std::min<size_t>(bytes.size(), 1U << 30));
        if (n < 0) {
            if (errno == EINTR) continue;
            return system_error(messages::kCannotWriteTo, name_, errno);
        }
        bytes = bytes.subspan(static_cast<size_t>(n));
    }
    return {};
}

Result<void> OutputFile::drop_contents() {
    if (!std::exchange(holds_earlier_, false)) return {};
    if (::ftruncate(fd_, 0) != 0 && errno != EINVAL)  // EINVAL: a pipe or a device
        return system_error(messages::kCannotWriteTo, name_, errno);
    return {};
}

Result<void> OutputFile::write(std::span<const uint8_t> bytes) {
    if (Result<void> dropped = drop_contents(); !dropped) return dropped;
    return write_with(bytes, [&](const uint8_t* data, size_t size) {
        const ssize_t n = ::write(fd_, data, size);
        written_ += std::max<ssize_t>(n, 0);
        return n;
    });
}

Result<void> OutputFile::overwrite(int64_t offset, std::span<const uint8_t> bytes) {
    return write_with(bytes, [&](const uint8_t* data, size_t size) {
        const ssize_t n = ::pwrite(fd_, data, size, offset);
        offset += std::max<ssize_t>(n, 0);
        return n;
    });
}

void OutputFile::cut_back_to(int64_t size) {
    struct stat status {};
    if (::fstat(fd_, &status) != 0 || !S_ISREG(status.st_mode)) return;
    if (::ftruncate(fd_, size) == 0 && ::lseek(fd_, size, SEEK_SET) == size) written_ = size;
}

Result<void> OutputFile::continue_at(int64_t size) {
    if (::ftruncate(fd_, size) != 0 || ::lseek(fd_, size, SEEK_SET) != size)
        return system_error(messages::kCannotWriteTo, name_, errno);
    written_ = size;
    return {};
}

Result<void> OutputFile::sync() {
    struct stat status {};
    if (::fstat(fd_, &status) != 0 || !S_ISREG(status.st_mode)) return {};
    if (::fsync(fd_) != 0) return system_error(messages::kCannotWriteTo, name_, errno);
    return {};
}

Result<void> OutputFile::close(bool sync) {
    if (fd_ < 0) return {};
    Result<void> done = drop_contents();
    if (done && sync) done = this->sync();
    const int close_error = ::close(std::exchange(fd_, -1)) != 0 ? errno : 0;
    if (!done) return done;
    if (close_error != 0) return system_error(messages::kCannotWriteTo, name_, close_error);
    return {};
}

void sync_folder(const std::filesystem::path& folder) {
    const int fd =
        ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return;
    (void)::fsync(fd);
    ::close(fd);
}

Result<void> write_whole_file(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
    struct stat there {};
    const bool special =
        ::stat(path.c_str(), &there) == 0 && !S_ISREG(there.st_mode) && !S_ISDIR(there.st_mode);
    // Pipes and devices are written directly; a rename would replace them by a file.
    const std::string temporary = path.string() + (special ? "" : ".part");
    Result<OutputFile> file = OutputFile::create(temporary);
    if (!file) return file.error();
    Result<void> written = file->write(bytes);
    if (written) written = file->close(false);
    if (!written && !special) ::unlink(temporary.c_str());
    if (!written || special) return written;
    if (::rename(temporary.c_str(), path.c_str()) != 0) {
        const int code = errno;
        ::unlink(temporary.c_str());
        return system_error(messages::kCannotCreate, path.string(), code);
    }
    return {};
}

Result<void> write_whole_file(const std::filesystem::path& path, const std::string& text) {
    return write_whole_file(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace openfab::backends
