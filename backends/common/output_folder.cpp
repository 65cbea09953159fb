// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/common/output_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <utility>

#include "backends/common/messages.h"
#include "backends/common/output_lock.h"
#include "base/system_reason.h"
#include "base/write_all.h"

namespace openfab::backends {

namespace {

Error folder_error(const char* what, const std::filesystem::path& path, int code) {
    return outside_error(fmt::format("{} `{}`: {}", what, path.string(), system_reason(code)));
}

/// Makes `bytes` the contents of a file; returns 0 or the error's number.
int fill(int fd, std::span<const uint8_t> bytes) {
    // Not O_TRUNC: a file that becomes empty is written to the disk when it is closed, by itself.
    struct stat before {};
    if (::fstat(fd, &before) != 0) return errno;
    const auto size = static_cast<off_t>(bytes.size());
    if (before.st_size > size && ::ftruncate(fd, size) != 0) return errno;
    return write_all(fd, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

GrowingFile::GrowingFile(GrowingFile&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), path_(std::move(other.path_)) {}

GrowingFile::~GrowingFile() {
    if (fd_ >= 0) ::close(fd_);
}

Result<void> GrowingFile::add(std::string_view text) const {
    const int code = write_all(fd_, text);
    return code == 0 ? Result<void>() : folder_error(messages::kCannotWriteTo, path_, code);
}

Result<OutputFolder> OutputFolder::open(const std::filesystem::path& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return folder_error(messages::kCannotOpenFolder, path, errno);
    OutputFolder folder(fd, path);
    if (Result<void> locked = lock_output(fd, path.string()); !locked) return locked.error();
    return folder;
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), path_(std::move(other.path_)) {}

OutputFolder::~OutputFolder() {
    if (fd_ >= 0) ::close(fd_);
}

Result<void> OutputFolder::write(const std::string& name, std::span<const uint8_t> bytes) const {
    const std::string temporary = name + ".part";
    const auto open = [&] {
        return ::openat(fd_, temporary.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    };
    int file = open();
    if (file < 0) {
        const int why = errno;
        // One that is there and may not be written to may still be replaced.
        if (::unlinkat(fd_, temporary.c_str(), 0) == 0) file = open();
        if (file < 0) return folder_error(messages::kCannotCreate, path_ / temporary, why);
    }
    int code = fill(file, bytes);
    if (::close(file) != 0 && code == 0) code = errno;
    if (code == 0 && ::renameat(fd_, temporary.c_str(), fd_, name.c_str()) == 0) return {};
    const char* const what = code != 0 ? messages::kCannotWriteTo : messages::kCannotCreate;
    const Error error =
        folder_error(what, path_ / (code != 0 ? temporary : name), code != 0 ? code : errno);
    ::unlinkat(fd_, temporary.c_str(), 0);
    return error;
}

Result<GrowingFile> OutputFolder::grow(const std::string& name) const {
    const int file =
        ::openat(fd_, name.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file < 0) return folder_error(messages::kCannotCreate, path_ / name, errno);
    return GrowingFile(file, path_ / name);
}

Result<void> OutputFolder::set_aside(const std::string& name) const {
    struct stat there {};
    if (::fstatat(fd_, name.c_str(), &there, AT_SYMLINK_NOFOLLOW) != 0)
        return folder_error(messages::kCannotRead, path_ / name, errno);
    if (!S_ISREG(there.st_mode) || there.st_nlink != 1) return remove(name);
    if (::renameat(fd_, name.c_str(), fd_, (name + ".part").c_str()) == 0) return {};
    return folder_error(messages::kCannotRename, path_ / name, errno);
}

Result<void> OutputFolder::remove(const std::string& name) const {
    if (::unlinkat(fd_, name.c_str(), 0) == 0 || errno == ENOENT ||
        (errno == EISDIR && ::unlinkat(fd_, name.c_str(), AT_REMOVEDIR) == 0))
        return {};
    return folder_error(messages::kCannotRemove, path_ / name, errno);
}

Result<void> OutputFolder::sync() const {
    if (::syncfs(fd_) != 0) return folder_error(messages::kCannotWriteTo, path_, errno);
    return {};
}

}  // namespace openfab::backends
