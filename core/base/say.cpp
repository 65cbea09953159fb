// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/say.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>

#include "base/caret.h"
#include "base/messages.h"
#include "base/text.h"

namespace openfab {

void prepare_streams() {
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd) {
        if (::fcntl(fd, F_GETFD) >= 0 || errno != EBADF) continue;
        // open() takes the lowest free descriptor, which is this one. Opened in the wrong
        // direction, so that a result does not count as written. Standard error is opened for
        // writing: its messages have no reader anyway, and programs that are started may fail where
        // they cannot write theirs.
        const int mode = fd == STDIN_FILENO ? O_WRONLY : fd == STDOUT_FILENO ? O_RDONLY : O_RDWR;
        (void)::open("/dev/null", mode);
    }
    (void)std::signal(SIGPIPE, SIG_IGN);
}

void say(std::string_view text) {
    const std::string safe = printable_lines(text);
    (void)std::fwrite(safe.data(), 1, safe.size(), stderr);
    (void)std::fflush(stderr);
}

void note(std::string_view message) {
    say(fmt::format("note: {}\n", printable(message)));
}

void warn(std::string_view message) {
    say(fmt::format("warning: {}\n", printable(message)));
}

int say_error(const Error& error) {
    say(render_error(error));
    return exit_code(error.code);
}

void show(std::string_view text) {
    write_out(printable_lines(text));
}

void write_out(std::string_view data) {
    // Stops at the first failure, to keep its errno.
    if (std::ferror(stdout) == 0) (void)std::fwrite(data.data(), 1, data.size(), stdout);
}

Result<void> written_out() {
    errno = 0;
    const bool flushed = std::fflush(stdout) == 0;
    if (flushed && std::ferror(stdout) == 0) return {};
    return outside_error(flushed || errno == 0
                             ? std::string(messages::kCannotWriteOut)
                             : fmt::format(messages::kCannotWriteOutBecause, std::strerror(errno)));
}

}  // namespace openfab
