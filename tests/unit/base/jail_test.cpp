// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/jail.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "base/input_file.h"
#include "base/jail_walls.h"
#include "base/messages.h"
#include "base/own_threads.h"

namespace openfab {
namespace {

namespace fs = std::filesystem;
using Numbers = std::vector<int64_t>;

JailLimits small() {
    JailLimits limits;
    limits.memory_bytes = 50'000'000;
    return limits;
}

/// What is said of a reader that does this.
std::string said(const std::function<Result<bool>()>& read, const JailLimits& limits = small()) {
    const Result<bool> done = read_in_jail<bool>("a.3mf", limits, read);
    return done ? "no error" : done.error().message;
}

TEST(Jail, HandsOverWhatWasRead) {
    Numbers many(3'000'000);
    std::iota(many.begin(), many.end(), -7);
    const Result<Numbers> got =
        read_in_jail<Numbers>("a.obj", small(), [&]() -> Result<Numbers> { return many; });
    ASSERT_TRUE(got) << got.error().text();
    EXPECT_EQ(*got, many);
    using Texts = std::vector<std::pair<std::string, std::optional<std::string>>>;
    const Texts texts{{"one", {}}, {std::string("t\0o", 3), "three"}, {"", ""}};
    const Result<Texts> same =
        read_in_jail<Texts>("a.obj", small(), [&]() -> Result<Texts> { return texts; });
    ASSERT_TRUE(same) << same.error().text();
    EXPECT_EQ(*same, texts);
}

TEST(Jail, PassesErrorsOnWithTheirPlaces) {
    const Result<bool> done = read_in_jail<bool>("a.obj", small(), []() -> Result<bool> {
        return error_at({"a.obj", 3, 5}, "wrong", "do right");
    });
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().text(), "a.obj:3:5: wrong; do right");
    EXPECT_EQ(done.error().code, ErrorCode::kUserInput);
}

#ifndef OPENFAB_SANITIZED  // sanitizers watch readers in this process

TEST(Jail, IsAnotherProcess) {
    const Result<int64_t> read =
        read_in_jail<int64_t>("a.obj", small(), []() -> Result<int64_t> { return ::getpid(); });
    ASSERT_TRUE(read);
    EXPECT_NE(*read, ::getpid());
    EXPECT_FALSE(inside_jail());
}

TEST(Jail, TellsOfACrashAndWhere) {
    for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL}) {
        EXPECT_EQ(said([&]() -> Result<bool> {
                      ::raise(signal);
                      return true;
                  }),
                  fmt::format(messages::kReaderCrashed, "a.3mf", signal, ::strsignal(signal)));
    }
    EXPECT_EQ(
        said([]() -> Result<bool> {
            now_reading("textures/b.png");
            std::abort();
        }),
        fmt::format(messages::kReaderCrashed, "a.3mf" + fmt::format(messages::kWithinFile, "b.png"),
                    SIGABRT, ::strsignal(SIGABRT)));
    EXPECT_EQ(said([]() -> Result<bool> { ::_exit(0); }),
              fmt::format(messages::kReaderEnded, "a.3mf"));
}

TEST(Jail, EndsWhatComputesForever) {
    JailLimits limits = small();
    limits.seconds = 1;
    EXPECT_EQ(said(
                  []() -> Result<bool> {
                      for (volatile uint64_t i = 0;;)
                          i = i + 1;
                  },
                  limits),
              fmt::format(messages::kReaderTakesLong, "a.3mf", 1));
}

TEST(Jail, EndsWhatTakesFarTooMuchMemory) {
    const std::string message = said([]() -> Result<bool> {
        std::vector<std::vector<char>> parts;
        for (;;)
            parts.emplace_back(size_t{1} << 30);
    });
    EXPECT_EQ(message, fmt::format(messages::kReaderTakesMemory, "a.3mf", "50 MB"));
}

TEST(Jail, ValuesThatCannotBeAreRefused) {
    const auto lie = [](JailLine* line) {
        uint64_t count = uint64_t{1} << 61;
        pass(line, &count);
    };
    Numbers numbers;
    const auto take = [&](JailLine* line) {
        pass(line, &numbers);
        return line->fine();
    };
    const Result<void> done = run_in_jail(
        "a.3mf", small(), [] { return Result<void>(); }, lie, take);
    ASSERT_FALSE(done);
    EXPECT_TRUE(numbers.empty());
}

/// Numbers of the errors of what a stranger's program would do.
Result<Numbers> tries(const fs::path& folder) {
    Numbers out;
    const auto tried = [&](int64_t done) { out.push_back(done >= 0 ? 0 : errno); };
    tried(::open((folder / "new").c_str(), O_WRONLY | O_CREAT, 0600));
    tried(::open((folder / "there").c_str(), O_RDWR));
    tried(::unlink((folder / "there").c_str()));
    tried(::mkdir((folder / "more").c_str(), 0700));
    tried(::socket(AF_INET, SOCK_STREAM, 0));
    tried(::fork());
    tried(::kill(::getppid(), 0));
    char* const nothing[] = {nullptr};
    tried(::execve("/bin/true", nothing, nothing));
    tried(::open("/etc/passwd", O_RDONLY));
    tried(::open((folder / "there").c_str(), O_RDONLY));
    return out;
}

TEST(Jail, HasWalls) {
    std::string name = (fs::temp_directory_path() / "openfab-jail-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    const fs::path folder = without_links(name);
    std::ofstream(folder / "there") << "text";
    JailLimits limits = small();
    limits.reads = {folder};
    const Result<Numbers> got =
        read_in_jail<Numbers>("a.obj", limits, [&] { return tries(folder); });
    const bool calls = has_system_call_filters(), files = has_landlock();
    fmt::print("of this kernel: seccomp {}, Landlock {}\n", calls, files);
    ASSERT_TRUE(got) << got.error().text();
    ASSERT_EQ(got->size(), 10U);
    for (size_t i = 0; i < 8; ++i)
        EXPECT_EQ((*got)[i] != 0, calls || (files && (i < 4 || i == 7))) << i;
    EXPECT_EQ((*got)[8] != 0, files);
    EXPECT_EQ((*got)[9], 0);
    EXPECT_TRUE(fs::exists(folder / "there"));
    fs::remove_all(folder);
}

/// A process, which is gone within five seconds.
bool ends(pid_t process) {
    for (int i = 0; i < 500; ++i) {
        if (::kill(process, 0) != 0 && errno == ESRCH) return true;
        std::ifstream status(fmt::format("/proc/{}/stat", process));
        std::string text((std::istreambuf_iterator<char>(status)), {});
        if (text.empty() || text.find(") Z") != std::string::npos) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

TEST(Jail, EndsWithItsParent) {
    for (const int signal : {SIGKILL, SIGTERM}) {
        auto* const reader = static_cast<std::atomic<pid_t>*>(
            ::mmap(nullptr, sizeof(std::atomic<pid_t>), PROT_READ | PROT_WRITE,
                   MAP_SHARED | MAP_ANONYMOUS, -1, 0));
        ASSERT_NE(static_cast<void*>(reader), MAP_FAILED);
        const pid_t parent = ::fork();
        if (parent == 0) {
            (void)said([&]() -> Result<bool> {
                reader->store(::getpid());
                for (;;)
                    ::pause();
            });
            ::_exit(0);
        }
        while (reader->load() == 0)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ::kill(parent, signal);
        ::waitpid(parent, nullptr, 0);
        EXPECT_TRUE(ends(reader->load())) << signal;
        ::munmap(reader, sizeof(std::atomic<pid_t>));
    }
}

/// Threads of the parent hold the locks of its heap at any moment; readers have threads of their own.
TEST(Jail, WorksBesideThreads) {
    std::atomic<bool> over{false};
    std::vector<std::thread> busy;
    for (int t = 0; t < 4; ++t)
        busy.emplace_back([&] {
            while (!over)
                std::vector<std::string>(64, std::string(100, 'x'))
                    .swap(*std::make_unique<std::vector<std::string>>());
        });
    for (int i = 0; i < 100; ++i) {
        const Result<int64_t> sum =
            read_in_jail<int64_t>("a.obj", small(), []() -> Result<int64_t> {
                std::atomic<int64_t> all{0};
                on_own_threads(50, [&](size_t k) {
                    all += static_cast<int64_t>(std::string(k * 1000, 'y').size());
                });
                return all.load();
            });
        ASSERT_TRUE(sum) << sum.error().text();
        EXPECT_EQ(*sum, 1000 * 49 * 50 / 2);
    }
    over = true;
    for (std::thread& thread : busy)
        thread.join();
}

#endif

}  // namespace
}  // namespace openfab
