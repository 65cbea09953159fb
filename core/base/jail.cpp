// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/jail.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <new>
#include <optional>

#include "base/allowance.h"
#include "base/clean_exit.h"
#include "base/input_file.h"
#include "base/jail_walls.h"
#include "base/messages.h"
#include "base/standard_error.h"
#include "base/system_reason.h"
#include "base/units.h"

namespace openfab {

namespace {

namespace fs = std::filesystem;

/// Memory that both share: the name of the file that is read.
char* shared_name = nullptr;
constexpr size_t kNameBytes = 4096;
bool inside = false;

/// How the child ends where it does not answer.
constexpr int kNoMemory = 70;

/// What begins an answer.
enum class Answer : uint8_t { kValue = 1, kError = 2 };

struct Pipe {
    std::array<int, 2> ends{-1, -1};
    Pipe() = default;
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;
    ~Pipe() {
        close(0);
        close(1);
    }
    void close(size_t end) {
        if (ends[end] >= 0) ::close(ends[end]);
        ends[end] = -1;
    }
};

struct SharedName {
    char* text = nullptr;
    SharedName() {
        void* const memory =
            ::mmap(nullptr, kNameBytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (memory != MAP_FAILED) text = static_cast<char*>(memory);
    }
    SharedName(const SharedName&) = delete;
    SharedName& operator=(const SharedName&) = delete;
    ~SharedName() {
        if (text != nullptr) ::munmap(text, kNameBytes);
    }
};

void lower_limit(__rlimit_resource which, rlim_t most, rlim_t hard) {
    rlimit limit{};
    if (::getrlimit(which, &limit) != 0) return;
    limit.rlim_cur = std::min(limit.rlim_cur, most);
    limit.rlim_max = std::min(limit.rlim_max, hard);
    ::setrlimit(which, &limit);
}

#ifndef OPENFAB_SANITIZED  // sanitizers take addresses by the terabyte
/// The addresses that this process has now, in bytes.
int64_t addresses() {
    long long pages = 0;
    if (std::FILE* const file = std::fopen("/proc/self/statm", "re"); file != nullptr) {
        if (std::fscanf(file, "%lld", &pages) != 1) pages = 0;
        (void)std::fclose(file);
    }
    return pages * ::sysconf(_SC_PAGESIZE);
}
#endif

void limit_memory([[maybe_unused]] int64_t memory_bytes) {
#ifndef OPENFAB_SANITIZED
    // For the program itself, what it maps, and the heaps and stacks of threads.
    constexpr int64_t kProgram = 1'000'000'000, kThread = 150'000'000;
    const int64_t most =
        addresses() + 2 * memory_bytes + kProgram + kThread * int64_t{usable_cores()};
    lower_limit(RLIMIT_AS, static_cast<rlim_t>(most), static_cast<rlim_t>(most));
#endif
    std::set_new_handler([] { ::_exit(kNoMemory); });
}

/// A child has the handlers of its parent, which are for the parent's work.
void forget_signals() {
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTERM, SIGPIPE, SIGXCPU,
                             SIGALRM, SIGUSR1, SIGUSR2, SIGCHLD})
        std::signal(signal, SIG_DFL);
    // Ctrl-C reaches both: the parent decides, and ends its child.
    for (const int signal : {SIGINT, SIGHUP, SIGQUIT})
        std::signal(signal, SIG_IGN);
    sigset_t none;
    sigemptyset(&none);
    ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
}

/// Closes all descriptors but `kept`, and makes the first three of the null device.
void close_others(int kept) {
    const int null = ::open("/dev/null", O_RDWR);
    for (int standard = 0; null >= 0 && standard <= STDERR_FILENO; ++standard)
        if (standard != kept) ::dup2(null, standard);
    const auto close_range = [](unsigned from, unsigned to) {
        if (from > to || ::syscall(SYS_close_range, from, to, 0) == 0) return;
        rlimit limit{};
        ::getrlimit(RLIMIT_NOFILE, &limit);
        constexpr rlim_t kMost = 65536;
        const auto most = static_cast<unsigned>(std::min(limit.rlim_cur, kMost));
        for (unsigned d = from; d <= to && d < most; ++d)
            ::close(static_cast<int>(d));
    };
    const auto own = static_cast<unsigned>(kept);
    close_range(STDERR_FILENO + 1, own - 1);
    close_range(std::max<unsigned>(own, STDERR_FILENO) + 1, ~0U);
}

void enter(const JailLimits& limits, int64_t seconds, int line) {
    inside = true;
    forget_signals();
    lower_limit(RLIMIT_CORE, 0, 0);
    lower_limit(RLIMIT_CPU, static_cast<rlim_t>(seconds), static_cast<rlim_t>(seconds + 1));
    limit_memory(limits.memory_bytes);
    if (limits.converts) {
        // Closed to what a library has to say before it gives up.
        static const OwnStandardError kClosed;
    } else {
        close_others(line);
    }
#ifndef OPENFAB_SANITIZED  // sanitizers call the kernel in ways of their own
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    (void)deny_files(limits);
    (void)deny_system_calls(limits.converts);
#endif
}

[[noreturn]] void answer(int descriptor, const std::function<Result<void>()>& read,
                         const std::function<void(JailLine*)>& send) {
    JailLine line(descriptor, true);
    const Result<void> done = read();
    auto what = done ? Answer::kValue : Answer::kError;
    pass(&line, &what);
    if (done) {
        send(&line);
    } else {
        Error error = done.error();
        pass(&line, &error);
    }
    ::_exit(line.fine() ? 0 : 1);
}

/// Seconds of the processor that a process took; negative where that is not known.
double processor_seconds(pid_t process) {
    clockid_t clock{};
    timespec now{};
    if (::clock_getcpuclockid(process, &clock) != 0 || ::clock_gettime(clock, &now) != 0) return -1;
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Waits until the child answers or ends; false where it does neither, nor computes.
bool wait_for_answer(int descriptor, pid_t child) {
    constexpr int kSecond = 1000, kMostStill = 300;
    double before = processor_seconds(child);
    for (int still = 0; still < kMostStill;) {
        pollfd polled{descriptor, POLLIN, 0};
        const int got = ::poll(&polled, 1, kSecond);
        if (got > 0) return true;
        if (got < 0 && errno != EINTR) return true;
        const double now = processor_seconds(child);
        still = now > before + 1e-3 ? 0 : still + (got == 0 ? 1 : 0);
        before = now;
    }
    return false;
}

/// How the child ended; nothing where someone else has waited for it.
std::optional<int> wait_for(pid_t child, RunningProgram* listed) {
    int status = 0;
    if (listed != nullptr) return listed->wait(&status) ? std::optional(status) : std::nullopt;
    pid_t got = 0;
    while ((got = ::waitpid(child, &status, 0)) < 0 && errno == EINTR) {
    }
    return got == child ? std::optional(status) : std::nullopt;
}

/// Why there is no answer.
Error reason_of(const std::string& name, const JailLimits& limits, int64_t seconds, bool still,
                std::optional<int> status) {
    if (still) return user_error(fmt::format(messages::kReaderStandsStill, name));
    if (status && WIFSIGNALED(*status)) {
        const int signal = WTERMSIG(*status);
        if (signal == SIGPIPE) return user_error(fmt::format(messages::kReaderNonsense, name));
        if (signal == SIGXCPU)
            return user_error(fmt::format(messages::kReaderTakesLong, name, seconds),
                              messages::kReaderTakesLongHelp);
        return user_error(fmt::format(messages::kReaderCrashed, name, signal, ::strsignal(signal)),
                          messages::kReaderCrashedHelp);
    }
    if (status && WIFEXITED(*status) && WEXITSTATUS(*status) == kNoMemory)
        return user_error(
            fmt::format(messages::kReaderTakesMemory, name, format_bytes(limits.memory_bytes)),
            messages::kReaderTakesMemoryHelp);
    return outside_error(fmt::format(messages::kReaderEnded, name));
}

}  // namespace

bool inside_jail() {
    return inside;
}

void now_reading(const fs::path& file) {
    if (shared_name == nullptr) return;
    const std::string name = file.filename().string().substr(0, kNameBytes - 1);
    std::memcpy(shared_name, name.c_str(), name.size() + 1);
}

JailLimits limits_of_header(const fs::path& file, int64_t memory_bytes) {
    JailLimits limits;
    limits.memory_bytes = memory_bytes;
    limits.reads = {without_links(file)};
    return limits;
}

int64_t reading_seconds(const fs::path& file) {
    constexpr int64_t kLeast = 60, kPerMegabyte = 2, kMegabyte = 1'000'000;
    std::error_code failed;
    uintmax_t bytes = 0;
    if (fs::is_directory(file, failed)) {
        for (fs::recursive_directory_iterator it(file, failed), end; !failed && it != end;
             it.increment(failed)) {
            std::error_code unknown;
            const uintmax_t own = it->is_regular_file(unknown) ? it->file_size(unknown) : 0;
            if (!unknown) bytes += own;
        }
    } else if (const uintmax_t own = fs::file_size(file, failed); !failed) {
        bytes = own;
    }
    return kLeast + kPerMegabyte * static_cast<int64_t>(bytes / kMegabyte);
}

Result<void> run_in_jail(const fs::path& file, const JailLimits& limits,
                         const std::function<Result<void>()>& read,
                         const std::function<void(JailLine*)>& send,
                         const std::function<bool(JailLine*)>& take) {
    if (inside) return internal_error(fmt::format(messages::kReaderEnded, file.string()));
    Pipe pipe;
    if (::pipe2(pipe.ends.data(), O_CLOEXEC) != 0)
        return outside_error(messages::kCannotMakePipe + system_reason(errno));
    constexpr int kPipeBytes = 1 << 20;
    ::fcntl(pipe.ends[1], F_SETPIPE_SZ, kPipeBytes);
    const SharedName name;
    const int64_t seconds = limits.seconds > 0 ? limits.seconds : reading_seconds(file);
    const pid_t parent = ::getpid();
    const pid_t child = ::fork();
    if (child < 0) return outside_error(messages::kCannotStartProcess + system_reason(errno));
    if (child == 0) {
        // Of the thread that started it, which waits for it as long as there is this process.
        ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
        if (::getppid() != parent) ::_exit(1);
        shared_name = name.text;
        enter(limits, seconds, pipe.ends[1]);
        answer(pipe.ends[1], read, send);
    }
    pipe.close(1);
    // A child that writes files ends before they are removed.
    std::optional<RunningProgram> listed;
    if (limits.converts) listed.emplace(child);
    const bool answers = wait_for_answer(pipe.ends[0], child);
    JailLine line(pipe.ends[0], false, 2 * std::max<int64_t>(limits.memory_bytes, 1 << 24));
    auto what = Answer{};
    Error error;
    bool whole = false;
    if (answers) {
        pass(&line, &what);
        if (line.fine() && what == Answer::kValue) whole = take(&line);
        if (line.fine() && what == Answer::kError) {
            pass(&line, &error);
            whole = line.fine();
        }
    }
    pipe.close(0);
    if (!whole) ::kill(child, answers ? SIGPIPE : SIGKILL);
    const std::optional<int> status = wait_for(child, listed ? &*listed : nullptr);
    if (whole) return what == Answer::kError ? Result<void>(error) : Result<void>();
    std::string place = file.string();
    if (name.text != nullptr && name.text[0] != 0) {
        name.text[kNameBytes - 1] = 0;
        place += fmt::format(messages::kWithinFile, name.text);
    }
    return reason_of(place, limits, seconds, !answers, status);
}

}  // namespace openfab
