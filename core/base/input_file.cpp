// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "base/check.h"
#include "base/large_pages.h"
#include "base/messages.h"
#include "base/system_reason.h"
#include "base/units.h"

namespace openfab {
namespace {

namespace fs = std::filesystem;

Error reason_of(int code) {
    const std::string reason = system_reason(code);
    return code == ENOENT || code == ENOTDIR || code == ELOOP ? user_error(reason)
                                                              : outside_error(reason);
}

const char* kind_of(mode_t mode) {
    if (S_ISDIR(mode)) return messages::kKindFolder;
    if (S_ISFIFO(mode)) return messages::kKindPipe;
    if (S_ISSOCK(mode)) return messages::kKindSocket;
    return messages::kKindDevice;
}

bool is_below_any(const fs::path& path, const std::vector<fs::path>& roots) {
    return roots.empty() || std::any_of(roots.begin(), roots.end(),
                                        [&](const fs::path& root) { return is_below(path, root); });
}

Error not_below(const fs::path& path, const std::vector<fs::path>& roots) {
    return user_error(fmt::format(messages::kNotBelow, path.string(), roots.front().string()));
}

}  // namespace

fs::path without_links(const fs::path& path) {
    std::error_code status;
    const fs::path absolute = fs::absolute(path, status);
    fs::path out = fs::weakly_canonical(absolute, status);
    return status ? absolute.lexically_normal() : out;
}

bool is_below(const fs::path& path, const fs::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first ==
           folder.end();
}

fs::path reading_root(const fs::path& folder) {
    fs::path own = without_links(folder.empty() ? "." : folder);
    std::error_code ignored;
    for (fs::path at = own;; at = at.parent_path()) {
        if (fs::is_regular_file(at / kProjectFile, ignored)) return at;
        if (at == at.parent_path()) return own;
    }
}

std::string as_argument(const fs::path& path) {
    return path.is_absolute() ? path.string() : "./" + path.string();
}

Result<InputFile> InputFile::open(const fs::path& file, const std::vector<fs::path>& roots) {
    // Nonblocking: opening a pipe without a writer would block.
    const int descriptor = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (descriptor < 0) {
        // A socket, or a device without a driver.
        if (errno == ENXIO) return user_error(messages::kNotAFile);
        const int code = errno;
        // In a jail (jail.h) what lies elsewhere cannot be opened at all.
        if (const fs::path place = without_links(file);
            code == EACCES && !is_below_any(place, roots))
            return not_below(place, roots);
        return reason_of(code);
    }
    InputFile opened(descriptor, 0);
    struct stat status {};
    if (::fstat(descriptor, &status) != 0) return reason_of(errno);
    if (!S_ISREG(status.st_mode))
        return user_error(fmt::format(messages::kKindNotAFile, kind_of(status.st_mode)));
    opened.bytes_ = status.st_size;
    if (roots.empty()) return opened;
    std::error_code unknown;
    const fs::path resolved = fs::read_symlink(opened.name(), unknown);
    if (unknown) return outside_error(fmt::format(messages::kPlaceUnknown, unknown.message()));
    if (is_below_any(resolved, roots)) return opened;
    return not_below(resolved, roots);
}

InputFile::~InputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

InputFile::InputFile(InputFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), bytes_(other.bytes_) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    std::swap(bytes_, other.bytes_);
    return *this;
}

std::string InputFile::name() const {
    return fmt::format("/proc/self/fd/{}", descriptor_);
}

Result<size_t> InputFile::read(int64_t at, void* to, size_t bytes) const {
    OPENFAB_CHECK_GE(at, 0);
    size_t done = 0;
    while (done < bytes) {
        const ssize_t got = ::pread(descriptor_, static_cast<char*>(to) + done, bytes - done,
                                    at + static_cast<int64_t>(done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return reason_of(errno);
        if (got == 0) break;
        done += static_cast<size_t>(got);
    }
    return done;
}

Result<std::string> InputFile::read_all(int64_t most) const {
    const auto too_large = [&] {
        return user_error(fmt::format(messages::kLargerThan, format_bytes(most)));
    };
    if (bytes_ > most) return too_large();
    // Some file systems do not know sizes, and files grow: the end is where reading ends.
    std::string text;
    text.reserve(static_cast<size_t>(bytes_) + 1);
    advise_large_pages(text.data(), text.capacity());
    text.resize(static_cast<size_t>(bytes_) + 1);
    size_t used = 0;
    for (;;) {
        const Result<size_t> got =
            read(static_cast<int64_t>(used), text.data() + used, text.size() - used);
        if (!got) return got.error();
        used += *got;
        if (static_cast<int64_t>(used) > most) return too_large();
        if (used < text.size()) break;
        text.resize(std::min(text.size() * 2, static_cast<size_t>(most) + 1));
    }
    text.resize(used);
    return text;
}

}  // namespace openfab
