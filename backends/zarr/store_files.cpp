// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/store_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>
#include <vector>

#include "backends/common/output_lock.h"
#include "backends/zarr/messages.h"
#include "base/input_file.h"
#include "base/system_reason.h"
#include "base/write_all.h"

namespace openfab::zarr {

namespace fs = std::filesystem;

namespace {

Error write_error(const fs::path& file, int code) {
    return outside_error(fmt::format(messages::kCannotWrite, file.string(), system_reason(code)));
}

bool has_bytes(const fs::path& file, std::span<const uint8_t> bytes) {
    std::error_code none;
    if (fs::file_size(file, none) != bytes.size() || none) return false;
    const Result<InputFile> there = InputFile::open(file);
    if (!there) return false;
    std::vector<uint8_t> read(bytes.size());
    const Result<size_t> got = there->read(0, read.data(), read.size());
    return got && *got == bytes.size() && std::equal(bytes.begin(), bytes.end(), read.begin());
}

/// Writes a file of this process's own beside `file`; returns its name.
Result<fs::path> write_beside(const fs::path& file, std::string_view bytes) {
    std::error_code status;
    fs::create_directories(file.parent_path(), status);
    if (status)
        return outside_error(
            fmt::format(messages::kCannotCreate, file.parent_path().string(), status.message()));
    fs::path part = file;
    part += fmt::format(".{}.part", ::getpid());
    const int fd =
        ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (fd < 0)
        return outside_error(
            fmt::format(messages::kCannotCreate, part.string(), system_reason(errno)));
    int code = write_all(fd, bytes);
    if (::close(fd) != 0 && code == 0) code = errno;
    if (code == 0) return part;
    ::unlink(part.c_str());
    return write_error(file, code);
}

}  // namespace

Result<void> write_store_file(const fs::path& file, std::span<const uint8_t> bytes) {
    if (has_bytes(file, bytes)) return {};
    const Result<fs::path> part =
        write_beside(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (!part) return part.error();
    if (::rename(part->c_str(), file.c_str()) == 0) return {};
    const int code = errno;
    ::unlink(part->c_str());
    return write_error(file, code);
}

Result<void> write_store_file(const fs::path& file, std::string_view text) {
    return write_store_file(file,
                            std::span(reinterpret_cast<const uint8_t*>(text.data()), text.size()));
}

Result<bool> claim_store_file(const fs::path& file, std::string_view text) {
    const Result<fs::path> part = write_beside(file, text);
    if (!part) return part.error();
    int code = ::link(part->c_str(), file.c_str()) == 0 ? 0 : errno;
    // A file system without links: whoever comes later finds it before it gets here.
    std::error_code ignored;
    if (code != 0 && code != EEXIST && !fs::exists(file, ignored))
        code = ::rename(part->c_str(), file.c_str()) == 0 ? 0 : errno;
    ::unlink(part->c_str());
    if (code == 0 || code == EEXIST) return code == 0;
    return write_error(file, code);
}

Result<void> remove_store_file(const fs::path& file) {
    if (::unlink(file.c_str()) == 0 || errno == ENOENT || errno == ENOTDIR) return {};
    return write_error(file, errno);
}

Result<ListFile> ListFile::open(const fs::path& file) {
    std::error_code status;
    fs::create_directories(file.parent_path(), status);
    const int fd =
        ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (fd < 0)
        return outside_error(
            fmt::format(messages::kCannotCreate, file.string(), system_reason(errno)));
    ListFile list(fd, file);
    if (Result<void> locked = backends::lock_output(fd, file.string()); !locked)
        return locked.error();
    return list;
}

ListFile::ListFile(ListFile&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), path_(std::move(other.path_)) {}

ListFile::~ListFile() {
    if (fd_ >= 0) ::close(fd_);
}

Result<void> ListFile::cut(size_t bytes) const {
    if (::ftruncate(fd_, static_cast<off_t>(bytes)) == 0) return {};
    return write_error(path_, errno);
}

Result<void> ListFile::add(std::string_view text) const {
    const int code = write_all(fd_, text);
    return code == 0 ? Result<void>() : write_error(path_, code);
}

Result<void> ListFile::sync() const {
    if (::syncfs(fd_) == 0) return {};
    return write_error(path_, errno);
}

}  // namespace openfab::zarr
