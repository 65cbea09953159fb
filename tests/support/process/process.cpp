// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/process/process.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <poll.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

namespace openfab::testing {

namespace {

constexpr int kLongestRunMs = 600'000;

struct Pipe {
    int read = -1, write = -1;
    Pipe() {
        std::array<int, 2> ends{};
        if (pipe2(ends.data(), O_CLOEXEC) != 0) std::abort();
        read = ends[0];
        write = ends[1];
    }
};

[[noreturn]] void become(const std::vector<std::string>& argv, const RunOptions& options, int out,
                         int err) {
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    for (const auto& [name, value] : options.environment)
        setenv(name.c_str(), value.c_str(), 1);
    if (options.largest_file_bytes >= 0) {
        const auto bytes = static_cast<rlim_t>(options.largest_file_bytes);
        const rlimit limit{bytes, bytes};
        if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(126);
    }
    // Where this fails it is not root.
    if (options.obeys_permissions) {
        for (const int capability : {CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH})
            (void)prctl(PR_CAPBSET_DROP, capability);
    }
    if (!options.folder.empty() && chdir(options.folder.c_str()) != 0) _exit(126);
    std::vector<char*> args;
    for (const std::string& arg : argv)
        args.push_back(const_cast<char*>(arg.c_str()));
    args.push_back(nullptr);
    execv(args[0], args.data());
    _exit(127);
}

/// Collects both streams until they close; sends the signals that are due meanwhile.
void collect(pid_t child, const Pipe& out, const Pipe& err, const RunOptions& options,
             Outcome* outcome) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    bool interrupted = options.interrupt_when == nullptr;
    std::array<pollfd, 2> polled{{{out.read, POLLIN, 0}, {err.read, POLLIN, 0}}};
    while (polled[0].fd >= 0 || polled[1].fd >= 0) {
        const auto elapsed = static_cast<int>(
            std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start).count());
        if (!interrupted && options.interrupt_when(elapsed, *outcome)) {
            kill(child, options.signal);
            interrupted = true;
        }
        if (elapsed > kLongestRunMs) kill(child, SIGKILL);
        if (poll(polled.data(), polled.size(), 5) < 0) break;
        for (size_t k = 0; k < polled.size(); ++k) {
            if (polled[k].fd < 0 || polled[k].revents == 0) continue;
            if (k == 0 && options.before_read) options.before_read(*outcome);
            std::array<char, 65536> buffer{};
            const ssize_t got = read(polled[k].fd, buffer.data(), buffer.size());
            if (got > 0) {
                (k == 0 ? outcome->out : outcome->err)
                    .append(buffer.data(), static_cast<size_t>(got));
            } else {
                polled[k].fd = -1;
            }
        }
    }
}

#ifdef OPENFAB_SANITIZED
/// Removes messages of the address sanitizer about itself: it warns about the stacks on which
/// Halide compiles.
std::string without_sanitizer_notes(const std::string& text) {
    std::istringstream lines(text);
    std::string out;
    for (std::string line; std::getline(lines, line);) {
        const bool note = line.find("==WARNING: ASan ") != std::string::npos ||
                          line.starts_with("False positive error reports may follow") ||
                          line.starts_with("For details see ");
        if (!note) out += line + "\n";
    }
    return out;
}
#endif

}  // namespace

Outcome run(const std::vector<std::string>& argv, const RunOptions& options) {
    Outcome outcome;
    Pipe out, err;
    const pid_t child = fork();
    if (child < 0) return outcome;
    if (child == 0) become(argv, options, out.write, err.write);
    close(out.write);
    close(err.write);
    collect(child, out, err, options, &outcome);
    close(out.read);
    close(err.read);
    int status = 0;
    rusage used{};
    wait4(child, &status, 0, &used);
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    outcome.peak_rss_bytes = int64_t{used.ru_maxrss} * 1024;
    outcome.processor_seconds = seconds(used.ru_utime) + seconds(used.ru_stime);
#ifdef OPENFAB_SANITIZED
    outcome.err = without_sanitizer_notes(outcome.err);
#endif
    outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return outcome;
}

ScratchFolder::ScratchFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "openfab-test-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) std::abort();
    path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

void ScratchFolder::write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
}

std::unique_ptr<SmallDisk> SmallDisk::create(int64_t bytes, std::string* why_not) {
    std::unique_ptr<SmallDisk> disk(new SmallDisk());
    const std::string folder = disk->folder_.path().string();
    const std::string size = "size=" + std::to_string(bytes);
    if (mount("none", folder.c_str(), "tmpfs", 0, size.c_str()) != 0) {
        *why_not = std::string("cannot mount a small disk: ") + std::strerror(errno);
        return nullptr;
    }
    disk->mounted_ = true;
    return disk;
}

SmallDisk::~SmallDisk() {
    if (mounted_) umount2(folder_.path().c_str(), MNT_DETACH);
}

void SmallDisk::fill(const std::string& name, int64_t but_for) const {
    const auto free = static_cast<int64_t>(std::filesystem::space(folder_.path()).available);
    folder_.write(name,
                  std::string(static_cast<size_t>(std::max<int64_t>(free - but_for, 0)), 'x'));
}

std::string read_file(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

}  // namespace openfab::testing
