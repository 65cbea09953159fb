// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/replace_file.h"

#include <fmt/format.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <functional>
#include <vector>

#include "base/input_file.h"
#include "base/messages.h"
#include "base/own_folder.h"
#include "base/system_reason.h"
#include "base/write_all.h"

namespace openfab {

namespace fs = std::filesystem;

namespace {

/// Makes a file under another name, which `fill` writes, and moves it to `file`, so that none is there in part. Both
/// return 0 or an error's number.
int make_at_once(const fs::path& file, mode_t mode, const std::function<int(int)>& fill) {
    fs::path made;
    const int descriptor = open_temporary(file, &made);
    if (descriptor < 0) return errno;
    int failed = fill(descriptor);
    if (failed == 0 && ::fchmod(descriptor, mode) != 0) failed = errno;
    if (failed == 0 && ::fsync(descriptor) != 0) failed = errno;
    if (failed == 0 && ::rename(made.c_str(), file.c_str()) != 0) failed = errno;
    if (failed != 0) ::unlink(made.c_str());
    ::close(descriptor);
    return failed;
}

}  // namespace

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
    const int failed = make_at_once(real, before.st_mode & 07777,
                                    [&](int descriptor) { return write_all(descriptor, text); });
    if (failed != 0) return trouble(failed);
    return {};
}

Result<void> copy_at_once(const fs::path& from, const fs::path& to) {
    const auto trouble = [&](const std::string& why) {
        return outside_error(fmt::format(messages::kCannotCopy, from.string(), to.string(), why));
    };
    const Result<InputFile> source = InputFile::open(from);
    if (!source) return trouble(source.error().text());
    struct stat of_source {};
    if (::fstat(source->descriptor(), &of_source) != 0) return trouble(system_reason(errno));
    std::error_code status;
    const fs::path there = fs::canonical(to, status);
    Result<size_t> got{0};
    const int failed =
        make_at_once(status ? to : there, of_source.st_mode & 0777, [&](int descriptor) {
            // Within the system where it can; the rest by hand.
            constexpr size_t kAtOnce = size_t{1} << 30;
            off_t copied = 0;
            while (::sendfile(descriptor, source->descriptor(), &copied, kAtOnce) > 0)
                continue;
            std::vector<char> buffer(1 << 20);
            int code = 0;
            for (int64_t at = copied; code == 0; at += static_cast<int64_t>(*got)) {
                got = source->read(at, buffer.data(), buffer.size());
                if (!got) return EIO;
                if (*got == 0) break;
                code = write_all(descriptor, {buffer.data(), *got});
            }
            return code;
        });
    if (!got) return trouble(got.error().text());
    if (failed != 0) return trouble(system_reason(failed));
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
