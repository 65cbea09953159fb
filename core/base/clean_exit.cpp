// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/clean_exit.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <system_error>
#include <thread>
#include <vector>

#include "base/result.h"
#include "base/standard_error.h"

namespace openfab {
namespace {

namespace fs = std::filesystem;

/// The exit code with which the process is to end. Signal handlers send it through a pipe to the
/// cleaner thread, since a handler may not remove files.
using Ending = int;

std::atomic<int> pipe_to_cleaner{-1};
std::atomic<bool> ending{false}, interruption_told{false};
static_assert(std::atomic<int>::is_always_lock_free, "a handler must not wait");

struct Listed {
    std::mutex mutex;
    std::vector<fs::path> paths;
    std::vector<pid_t> programs;
    std::vector<pid_t> groups;  ///< by their leaders
    bool has_cleaner = false;
};

/// Never destroyed: the cleaner thread may use it while static objects are destroyed.
Listed& listed() {
    static Listed* const all = new Listed;
    return *all;
}

bool has_ended(pid_t child) {
    siginfo_t info{};
    const int got = ::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT);
    return got != 0 || info.si_pid != 0;
}

constexpr auto kStep = std::chrono::milliseconds(5);
/// A print has a second to end in order (program/interrupt.h), and ends what it runs itself.
constexpr int kStepsOfPrograms = 280;
constexpr int kStepsOfFiles = 40;

/// Other threads still run: one that makes a file in a folder while that is emptied keeps it from
/// being removed, and cannot make any once it is.
void remove_now(const fs::path& path) {
    std::error_code error;
    for (int step = 0; step < kStepsOfFiles; ++step) {
        fs::remove_all(path, error);
        if (!error) return;
        std::this_thread::sleep_for(kStep);
    }
}

/// The caller holds the lock and keeps it: nothing can be added to the list any more.
void remove_all_listed(const Listed& all) {
    for (const pid_t child : all.programs)
        ::kill(child, SIGTERM);
    for (const pid_t leader : all.groups)
        ::kill(-leader, SIGTERM);
    // Programs end first, since their output is removed next; one that ignores SIGTERM is killed.
    const auto ended = [&](int steps) {
        for (int step = 0; step < steps; ++step) {
            if (std::all_of(all.programs.begin(), all.programs.end(), has_ended) &&
                std::all_of(all.groups.begin(), all.groups.end(), has_ended))
                return true;
            std::this_thread::sleep_for(kStep);
        }
        return false;
    };
    if (!ended(kStepsOfPrograms)) {
        for (const pid_t child : all.programs)
            if (!has_ended(child)) ::kill(child, SIGKILL);
        for (const pid_t leader : all.groups)
            ::kill(-leader, SIGKILL);
        ended(kStepsOfFiles);
    }
    // What a leader that has ended has left.
    for (const pid_t leader : all.groups)
        ::kill(-leader, SIGKILL);
    for (const fs::path& path : all.paths)
        remove_now(path);
}

void clean(int pipe) {
    Ending how = 0;
    ssize_t got = 0;
    while ((got = ::read(pipe, &how, sizeof how)) < 0 && errno == EINTR) {
    }
    if (got != sizeof how) return;
    Listed& all = listed();
    const std::lock_guard<std::mutex> lock(all.mutex);
    remove_all_listed(all);
    ::_exit(how);
}

/// Starts the cleaner thread. If that fails, signals end the process immediately, without cleaning.
void start_cleaner(Listed* all) {
    if (all->has_cleaner) return;
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return;
    all->has_cleaner = true;
    std::thread(clean, ends[0]).detach();
    pipe_to_cleaner.store(ends[1]);
}

/// Asks the cleaner thread to end the process; false if there is none.
bool ask_cleaner(Ending how) {
    const int pipe = pipe_to_cleaner.load();
    return pipe >= 0 && ::write(pipe, &how, sizeof how) == sizeof how;
}

void on_signal(int) {
    const int before = errno;
    begin_ending();
    tell_interrupted();
    end_cleanly(exit_code(ErrorCode::kInterrupted));
    errno = before;
}

}  // namespace

bool has_starter() {
    return std::getenv(kEndsWith) != nullptr;
}

void end_with_starter() {
    static std::once_flag once;
    std::call_once(once, [] {
        const char* const text = std::getenv(kEndsWith);
        const pid_t starter = text == nullptr ? 0 : static_cast<pid_t>(std::atol(text));
        if (starter <= 1 || starter == ::getpid()) return;
        // Not PR_SET_PDEATHSIG, which tells of the end of the thread that started this process.
        const int process = static_cast<int>(::syscall(SYS_pidfd_open, starter, 0));
        if (process < 0 && errno != ESRCH) return;  // before Linux 5.3
        std::thread([process] {
            pollfd polled{process, POLLIN, 0};
            while (process >= 0 && ::poll(&polled, 1, -1) < 0 && errno == EINTR) {
            }
            ::kill(::getpid(), SIGTERM);
        }).detach();
    });
}

void tell_interrupted() {
    if (!claim_interrupted()) return;
    constexpr std::string_view kLine = "error: interrupted\n";
    [[maybe_unused]] const ssize_t wrote =
        ::write(message_descriptor(), kLine.data(), kLine.size());
}

bool claim_interrupted() {
    return !interruption_told.exchange(true);
}

void unclaim_interrupted() {
    interruption_told.store(false);
}

void begin_ending() {
    ending.store(true);
}

bool is_ending() {
    return ending.load();
}

void wait_if_ending() {
    while (is_ending())
        ::pause();
}

void clean_up_on_signals() {
    end_with_starter();
    const char* const told = std::getenv(kStarterTells);
    if (told != nullptr && std::string_view(told) == "1") interruption_told.store(true);
    // A file that may not grow is an error of the write, which has a message.
    std::signal(SIGXFSZ, SIG_IGN);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction before {};
        struct sigaction action {};
        if (::sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
        action.sa_handler = on_signal;
        action.sa_flags = static_cast<int>(SA_RESTART | SA_RESETHAND);
        sigemptyset(&action.sa_mask);
        ::sigaction(signal, &action, nullptr);
    }
}

void end_cleanly(int exit_code) {
    if (!ask_cleaner(exit_code)) ::_exit(exit_code);
}

RemovedAtEnd::RemovedAtEnd(const std::function<fs::path()>& make) {
    Listed& all = listed();
    const std::lock_guard<std::mutex> lock(all.mutex);
    start_cleaner(&all);
    path_ = make();
    if (!path_.empty()) all.paths.push_back(path_);
}

RemovedAtEnd::~RemovedAtEnd() {
    Listed& all = listed();
    const std::lock_guard<std::mutex> lock(all.mutex);
    const auto found = std::find(all.paths.begin(), all.paths.end(), path_);
    if (found != all.paths.end()) all.paths.erase(found);
}

RunningGroup::RunningGroup(pid_t leader) : leader_(leader) {
    Listed& all = listed();
    const std::lock_guard<std::mutex> lock(all.mutex);
    start_cleaner(&all);
    all.groups.push_back(leader);
}

RunningGroup::~RunningGroup() {
    Listed& all = listed();
    const std::lock_guard<std::mutex> lock(all.mutex);
    std::erase(all.groups, leader_);
}

RunningProgram::RunningProgram(pid_t child) : child_(child) {
    Listed& all = listed();
    const std::lock_guard<std::mutex> lock(all.mutex);
    start_cleaner(&all);
    all.programs.push_back(child);
}

RunningProgram::~RunningProgram() {
    int status = 0;
    if (child_ > 0) wait(&status);
}

bool RunningProgram::wait(int* status) {
    // Waits without reaping, then reaps and unlists under the lock: its process id cannot be reused
    // while it is listed.
    siginfo_t info{};
    while (::waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOWAIT) != 0 &&
           errno == EINTR) {
    }
    Listed& all = listed();
    const std::lock_guard<std::mutex> lock(all.mutex);
    std::erase(all.programs, child_);
    const bool found = ::waitpid(child_, status, 0) == child_;
    child_ = -1;
    return found;
}

}  // namespace openfab
