// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "client/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <future>

#include "base/clean_exit.h"
#include "base/clock.h"
#include "base/exit_kind.h"
#include "base/input_file.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/system_reason.h"
#include "client/messages.h"

namespace openfab::client {

namespace {

std::atomic<int64_t> memory_of_programs{0};

int code_of(int status) {
    return WIFEXITED(status) ? WEXITSTATUS(status) : kExitBySignal + WTERMSIG(status);
}

}  // namespace

Result<std::unique_ptr<Child>> Child::start(const std::vector<std::string>& argv,
                                            const std::filesystem::path& out,
                                            const std::filesystem::path& err) {
    constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
    constexpr mode_t kMine = 0600;
    ProgramStart start;
    start.argv = argv;
    start.in = open_null();
    start.out = ::open(out.c_str(), kWrite, kMine);
    start.err = ::open(err.c_str(), kWrite, kMine);
    pid_t process = 0;
    int failed = errno;
    // On a full disk what it says would be lost, and above all that the disk is full.
    constexpr off_t kWordBytes = 16 << 10;
    const bool no_room = start.err >= 0 &&
                         ::fallocate(start.err, FALLOC_FL_KEEP_SIZE, 0, kWordBytes) != 0 &&
                         (errno == ENOSPC || errno == EDQUOT);
    if (no_room) failed = errno;
    if (!no_room && start.in >= 0 && start.out >= 0 && start.err >= 0)
        failed = start_program(start, &process);
    for (const int end : {start.in, start.out, start.err}) {
        if (end >= 0) ::close(end);
    }
    if (no_room) {
        return outside_error(
            fmt::format(messages::kNoRoomForWords, err.string(), system_reason(failed)));
    }
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

void set_memory_of_programs(int64_t bytes) {
    memory_of_programs.store(bytes);
}

std::vector<std::string> memory_words() {
    const int64_t all = memory_of_programs.load();
    if (all == 0) return {};
    // Not less than the least that is an amount of memory: what needs more says so.
    constexpr int64_t kLeast = 1'000'000;
    return {fmt::format("--memory={}B", std::max(all - resident_bytes(), kLeast))};
}

Result<void> run(const std::vector<std::string>& argv, const std::filesystem::path& out,
                 const std::filesystem::path& err) {
    const Result<std::unique_ptr<Child>> child = Child::start(argv, out, err);
    if (!child) return child.error();
    const int code = (*child)->wait();
    if (code == 0) return {};
    constexpr int64_t kMostSaid = 64 << 10;
    return relayed_error(end_of_file(err, kMostSaid), code);
}

Error relayed_error(const std::string& said, int code) {
    // From the line that has the error on; what was said before are notes of its own.
    const size_t at = said.rfind("error: ");
    const size_t begin = at == std::string::npos ? 0 : said.rfind('\n', at) + 1;
    const ErrorCode kind = kind_of_exit(code);
    const bool interrupted = kind == ErrorCode::kInterrupted;
    const bool tells = begin < said.size();
    if (tells && (!interrupted || claim_interrupted())) say(said.substr(begin));
    const bool told = tells || interrupted;
    return Error{kind, told ? "" : fmt::format(messages::kProgramEndedWith, code), "", {}};
}

std::string end_of_file(const std::filesystem::path& file, int64_t most) {
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return {};
    const int64_t bytes = std::min(most, opened->bytes());
    std::string text(static_cast<size_t>(bytes), '\0');
    const Result<size_t> length = opened->read(opened->bytes() - bytes, text.data(), text.size());
    text.resize(length ? *length : 0);
    return text;
}

}  // namespace openfab::client
