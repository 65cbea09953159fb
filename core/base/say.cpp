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
#include "base/clean_exit.h"
#include "base/messages.h"
#include "base/standard_error.h"
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

namespace {

/// To which messages go.
int messages_to = STDERR_FILENO;

}  // namespace

OwnStandardError::OwnStandardError() : before_(messages_to), kept_(-1) {
#ifndef OPENFAB_SANITIZED
    kept_ = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere >= 0) {
        if (messages_to == STDERR_FILENO && kept_ >= 0) messages_to = kept_;
        ::dup2(nowhere, STDERR_FILENO);
        ::close(nowhere);
    }
#endif
}

OwnStandardError::~OwnStandardError() {
    messages_to = before_;
    if (kept_ < 0) return;
    ::dup2(kept_, STDERR_FILENO);
    ::close(kept_);
}

int message_descriptor() {
    return messages_to;
}

void say(std::string_view text) {
    if (is_ending()) return;  // what ends with it has its own troubles
    const std::string safe = printable_lines(text);
    if (messages_to == STDERR_FILENO) {
        (void)std::fwrite(safe.data(), 1, safe.size(), stderr);
        (void)std::fflush(stderr);
        return;
    }
    for (std::string_view left = safe; !left.empty();) {
        const ssize_t wrote = ::write(messages_to, left.data(), left.size());
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote <= 0) return;
        left.remove_prefix(static_cast<size_t>(wrote));
    }
}

void note(std::string_view message) {
    say(fmt::format("note: {}\n", printable(message)));
}

void warn(std::string_view message) {
    say(fmt::format("warning: {}\n", printable(message)));
}

int say_error(const Error& error) {
    const bool interrupted = error.code == ErrorCode::kInterrupted;
    if (interrupted && error.message.empty()) {
        tell_interrupted();
    } else if (!error.message.empty() && (!interrupted || claim_interrupted())) {
        say(render_error(error));
    }
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
