// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <future>
#include <string_view>

#include "base/clean_exit.h"
#include "base/input_file.h"
#include "tools/viewer/messages.h"

extern char** environ;

namespace openfab::viewer {

namespace {

int code_of(int status) {
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Result<std::unique_ptr<Child>> Child::start(const std::vector<std::string>& argv,
                                            const std::filesystem::path& out,
                                            const std::filesystem::path& err) {
    std::vector<char*> words;
    for (const std::string& word : argv)
        words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC;
    constexpr mode_t kMine = 0600;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), kWrite, kMine);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), kWrite, kMine);
    posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
    std::string ends_with = fmt::format("{}={}", kEndsWith, ::getpid());
    std::vector<char*> environment;
    for (char** one = environ; *one != nullptr; ++one) {
        if (!std::string_view(*one).starts_with(fmt::format("{}=", kEndsWith)))
            environment.push_back(*one);
    }
    environment.push_back(ends_with.data());
    environment.push_back(nullptr);
    pid_t process = 0;
    const int failed =
        posix_spawn(&process, words[0], &actions, nullptr, words.data(), environment.data());
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0)
        return outside_error(fmt::format(messages::kCannotStart, argv[0], std::strerror(failed)));
    return std::unique_ptr<Child>(new Child(process));
}

Child::Child(pid_t process) : process_(process) {
    std::promise<void> listed;
    thread_ = std::thread([this, &listed] {
        RunningProgram running(process_);
        listed.set_value();
        // Ended, but still there: its number is nobody else's until the code is set.
        siginfo_t info{};
        while (::waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOWAIT) != 0 &&
               errno == EINTR) {
        }
        const std::lock_guard lock(mutex_);
        int status = 0;
        code_ = running.wait(&status) ? code_of(status) : openfab::exit_code(ErrorCode::kOutside);
    });
    listed.get_future().wait();
}

Child::~Child() {
    {
        const std::lock_guard lock(mutex_);
        if (!code_) ::kill(process_, SIGTERM);
    }
    if (thread_.joinable()) thread_.join();
}

std::optional<int> Child::exit_code() const {
    const std::lock_guard lock(mutex_);
    return code_;
}

int Child::wait() {
    if (thread_.joinable()) thread_.join();
    return *exit_code();
}

std::string end_of_file(const std::filesystem::path& file, int64_t most) {
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return {};
    const int64_t bytes = std::min(most, opened->bytes());
    std::string text(static_cast<size_t>(bytes), '\0');
    const Result<size_t> got = opened->read(opened->bytes() - bytes, text.data(), text.size());
    text.resize(got ? *got : 0);
    return text;
}

}  // namespace openfab::viewer
