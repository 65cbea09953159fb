// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/guarded.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>

#include "base/clean_exit.h"
#include "base/say.h"
#include "base/standard_error.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

/// The name of the file that the child reads, in memory that both share; nothing outside of `guarded`.
char* shared_name = nullptr;
constexpr size_t kSharedBytes = 4096;

/// The child's end of the pipe, into which it writes its error, if there is one, behind its code.
int to_parent = -1;

/// Libraries make room for what a file claims. Beyond the budget, the pyramid's mapping and the
/// program itself they get none.
void prepare_child([[maybe_unused]] int64_t memory_bytes) {
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    // Closed to what a library has to say before it gives up.
    static const OwnStandardError kClosed;
#ifndef OPENFAB_SANITIZED  // sanitizers take addresses by the terabyte
    constexpr int64_t kProgram = 1'000'000'000;
    rlimit limit{};
    const auto most = static_cast<rlim_t>(2 * memory_bytes + kProgram);
    if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur < most) return;
    limit.rlim_cur = most;
    ::setrlimit(RLIMIT_AS, &limit);
#endif
}

void pass_on(const std::string& text) {
    for (size_t at = 0; at < text.size();) {
        const ssize_t wrote = ::write(to_parent, text.data() + at, text.size() - at);
        if (wrote <= 0) return;
        at += static_cast<size_t>(wrote);
    }
}

/// Writes an error's code, message and help.
void pass_on(const Error& error) {
    pass_on(static_cast<char>(error.code) + error.message + '\0' + error.help);
}

bool is_crash(int signal) {
    return signal == SIGSEGV || signal == SIGABRT || signal == SIGBUS || signal == SIGFPE ||
           signal == SIGILL;
}

}  // namespace

Result<void> guarded(int64_t memory_bytes, const std::filesystem::path& file,
                     const std::function<Result<void>()>& make) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
        return outside_error(std::string(messages::kCannotMakePipe) + std::strerror(errno));
    void* const shared =
        ::mmap(nullptr, kSharedBytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED)
        return outside_error(std::string(messages::kCannotMapMemory) + std::strerror(errno));
    shared_name = static_cast<char*>(shared);
    const pid_t child = ::fork();
    if (child < 0)
        return outside_error(std::string(messages::kCannotStartProcess) + std::strerror(errno));
    if (child == 0) {
        prepare_child(memory_bytes);
        to_parent = ends[1];
        const Result<void> done = make();
        if (!done) pass_on(done.error());
        ::_exit(done ? 0 : 1);
    }
    ::close(ends[1]);
    RunningProgram running(child);
    std::string text;
    std::array<char, 4096> buffer{};
    for (;;) {
        const ssize_t got = ::read(ends[0], buffer.data(), buffer.size());
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        text.append(buffer.data(), static_cast<size_t>(got));
    }
    ::close(ends[0]);
    const std::string within = shared_name[0] == 0 ? "" : std::string(shared_name) + ": ";
    ::munmap(shared, kSharedBytes);
    shared_name = nullptr;
    int status = 0;
    if (!running.wait(&status))
        return outside_error(std::string(messages::kCannotWaitForProcess) + std::strerror(errno));
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    if (WIFSIGNALED(status) && is_crash(WTERMSIG(status))) {
        return user_error(fmt::format(messages::kReaderCrashed, file.string(), within));
    }
    if (text.empty()) {
        return outside_error(
            fmt::format(messages::kReaderEnded, file.string(),
                        WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status)) : messages::kNoReason));
    }
    const size_t end = text.find('\0', 1);
    return Error{
        static_cast<ErrorCode>(text[0]), text.substr(1, end - 1), text.substr(end + 1), {}};
}

void now_reading(const std::filesystem::path& file) {
    if (shared_name == nullptr) return;
    const std::string name = file.filename().string().substr(0, kSharedBytes - 1);
    std::memcpy(shared_name, name.c_str(), name.size() + 1);
}

void tell(const std::string& message) {
    note(message);
}

}  // namespace openfab::tools
