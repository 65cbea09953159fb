// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/start_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>
#include <utility>

#include "base/clean_exit.h"
#include "base/messages.h"

extern char** environ;

namespace openfab {

namespace {

std::string_view name_of(std::string_view variable) {
    return variable.substr(0, variable.find('='));
}

/// Returns the variables of this process, those of `more` in place of the same of ours.
std::vector<char*> variables(std::vector<std::string>* more) {
    std::vector<char*> all;
    for (char** one = environ; *one != nullptr; ++one) {
        const bool replaced =
            std::any_of(more->begin(), more->end(),
                        [&](const std::string& other) { return name_of(other) == name_of(*one); });
        if (!replaced) all.push_back(*one);
    }
    for (std::string& one : *more)
        all.push_back(one.data());
    all.push_back(nullptr);
    return all;
}

}  // namespace

int start_program(const ProgramStart& start, pid_t* process) {
    std::vector<char*> argv;
    for (const std::string& word : start.argv)
        argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    std::vector<std::string> more = start.environment;
    more.push_back(fmt::format("{}={}", kEndsWith, ::getpid()));
    const bool shares = start.err == STDERR_FILENO && !start.tells_interruption;
    more.push_back(fmt::format("{}={}", kStarterTells, shares ? 1 : 0));
    const std::vector<char*> environment = variables(&more);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    if (!start.folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, start.folder.c_str());
    // Standard error last: standard output may become what it is now.
    const std::pair<int, int> streams[] = {
        {start.in, STDIN_FILENO}, {start.out, STDOUT_FILENO}, {start.err, STDERR_FILENO}};
    for (const auto& [ours, its] : streams) {
        if (ours != its) posix_spawn_file_actions_adddup2(&actions, ours, its);
    }
    posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    if (start.own_group) {
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
        posix_spawnattr_setpgroup(&attributes, 0);
    }
    const auto spawn = start.search ? &::posix_spawnp : &::posix_spawn;
    const int failed =
        spawn(process, argv[0], &actions, &attributes, argv.data(), environment.data());
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    return failed;
}

Result<std::filesystem::path> program_folder() {
    std::error_code failed;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", failed);
    if (failed) return outside_error(messages::kNoOwnFolder + failed.message());
    return self.parent_path();
}

int open_null() {
    return ::open("/dev/null", O_RDWR | O_CLOEXEC);
}

GroupWatch::GroupWatch(pid_t group) {
    // Its line ends when the last descriptor of the other end does, and that is ours alone.
    constexpr const char* kWatch =
        "read said && exit; kill -s TERM -- \"-$1\"; sleep 1; kill -s KILL -- \"-$1\"";
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return;
    const int null = open_null();
    ProgramStart start;
    start.argv = {"/bin/sh", "-c", kWatch, "sh", std::to_string(group)};
    start.in = ends[1];
    start.out = start.err = null;
    start.own_group = true;
    const bool started = null >= 0 && start_program(start, &process_) == 0;
    if (null >= 0) ::close(null);
    ::close(ends[1]);
    line_ = ends[0];
    if (!started) process_ = -1;
}

GroupWatch::~GroupWatch() {
    if (process_ > 0) (void)::send(line_, "\n", 1, MSG_NOSIGNAL);
    if (line_ >= 0) ::close(line_);
    while (process_ > 0 && ::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
}

}  // namespace openfab
