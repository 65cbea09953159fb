// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/replace_file.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "base/messages.h"
#include "base/own_folder.h"
#include "base/system_reason.h"

namespace openfab {

namespace fs = std::filesystem;

Result<void> replace_file(const fs::path& file, const std::string& text) {
    const auto trouble = [&](int error) {
        return outside_error(
            fmt::format(messages::kCannotWrite, file.string(), system_reason(error)));
    };
    // A link stays one: what it leads to is replaced.
    std::error_code status;
    const fs::path real = fs::canonical(file, status);
    struct stat before {};
    if (status || ::stat(real.c_str(), &before) != 0) return trouble(ENOENT);
    fs::path made;
    const int descriptor = open_temporary(real, &made);
    if (descriptor < 0) return trouble(errno);
    size_t done = 0;
    int failed = 0;
    while (done < text.size() && failed == 0) {
        const ssize_t wrote = ::write(descriptor, text.data() + done, text.size() - done);
        if (wrote > 0) done += static_cast<size_t>(wrote);
        if (wrote < 0 && errno != EINTR) failed = errno;
    }
    if (failed == 0 && ::fchmod(descriptor, before.st_mode & 07777) != 0) failed = errno;
    if (failed == 0 && ::fsync(descriptor) != 0) failed = errno;
    if (failed == 0 && ::rename(made.c_str(), real.c_str()) != 0) failed = errno;
    if (failed != 0) ::unlink(made.c_str());
    ::close(descriptor);
    if (failed != 0) return trouble(failed);
    return {};
}

Result<void> check_replaceable(const fs::path& file) {
    struct stat there {};
    if (::stat(file.c_str(), &there) != 0 || S_ISREG(there.st_mode)) return {};
    const char* what = S_ISDIR(there.st_mode)    ? messages::kKindFolder
                       : S_ISFIFO(there.st_mode) ? messages::kKindPipe
                                                 : messages::kKindDevice;
    return user_error(fmt::format(messages::kOutputIsNoFile, file.string(), what));
}

}  // namespace openfab
