// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Temporary folders are removed with the processes that created them, however these end.

#include "base/own_folder.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <thread>

#include "tests/support/process/process.h"

namespace openfab {
namespace {

namespace fs = std::filesystem;

class TemporaryFolders : public ::testing::Test {
  protected:
    /// Starts a process that makes a folder with a file in it and a file beside it, and runs a
    /// program that does not end; ends it by `signal` and returns how it ended.
    int end_one(int signal, const std::function<void()>& prepare = clean_up_on_signals) {
        int ready[2];
        if (::pipe(ready) != 0) return -1;
        const pid_t child = ::fork();
        if (child == 0) {
            prepare();
            const auto folder = TemporaryFolder::create(place_.path());
            int made = -1;
            const RemovedAtEnd listed([&] {
                fs::path file;
                made = open_temporary(place_ / "file", &file);
                return file;
            });
            std::ofstream((*folder)->path() / "inside") << "text";
            // Detached from this test's output, whose reader would wait for it.
            posix_spawn_file_actions_t actions;
            posix_spawn_file_actions_init(&actions);
            for (const int end : {STDOUT_FILENO, STDERR_FILENO})
                posix_spawn_file_actions_addclose(&actions, end);
            pid_t program = 0;
            char name[] = "sleep", seconds[] = "100";
            char* argv[] = {name, seconds, nullptr};
            if (::posix_spawn(&program, "/bin/sleep", &actions, nullptr, argv, environ) != 0)
                ::_exit(1);
            RunningProgram running(program);
            (void)!::write(ready[1], &program, sizeof program);
            int status = 0;
            running.wait(&status);
            for (;;)
                ::pause();
            ::close(made);
        }
        (void)!::read(ready[0], &program_, sizeof program_);
        ::kill(child, signal);
        int status = 0;
        ::waitpid(child, &status, 0);
        ::close(ready[0]);
        ::close(ready[1]);
        return WIFSIGNALED(status) ? WTERMSIG(status) : 1000 + WEXITSTATUS(status);
    }
    size_t left() const {
        return static_cast<size_t>(
            std::distance(fs::directory_iterator(place_.path()), fs::directory_iterator()));
    }
    /// Whether or not somebody has waited for it.
    bool program_has_ended() const {
        const std::string state = testing::read_file("/proc/" + std::to_string(program_) + "/stat");
        return state.empty() || state.find(") Z") != std::string::npos;
    }

    testing::ScratchFolder place_;
    pid_t program_ = 0;
};

TEST_F(TemporaryFolders, GoWhenASignalEndsTheirMaker) {
    for (const int signal : {SIGINT, SIGTERM}) {
        EXPECT_EQ(end_one(signal), 1130);
        EXPECT_EQ(left(), 0u) << signal;
        EXPECT_TRUE(program_has_ended());
    }
}

TEST_F(TemporaryFolders, GoBeforeAHandlerEndsTheirMakerInItsOwnWay) {
    EXPECT_EQ(end_one(SIGTERM, [] { ::signal(SIGTERM, [](int) { end_cleanly(7); }); }), 1007);
    EXPECT_EQ(left(), 0u);
}

TEST_F(TemporaryFolders, OfKilledMakersGoWhenTheNextIsMade) {
    EXPECT_EQ(end_one(SIGKILL), SIGKILL);
    EXPECT_EQ(left(), 2u);
    ::kill(program_, SIGKILL);
    // It holds what its maker had locked until it is gone.
    while (!program_has_ended())
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    // Names that look similar but are not temporary.
    place_.write("openfab.tmp-abcdef", "a file");
    fs::create_directory(place_ / "other.tmp-abcdef");
    fs::create_directory(place_ / "openfab.tmp-abc");
    const auto alive = TemporaryFolder::create(place_.path());
    ASSERT_TRUE(alive);
    EXPECT_EQ(left(), 5u) << "the file is left to clear_left_over, which is for folders of ours";
    const auto next = TemporaryFolder::create(place_.path());
    EXPECT_TRUE(fs::exists((*alive)->path()));
    clear_left_over(place_.path());
    EXPECT_EQ(left(), 3u) << "these two, and what has another name";
}

}  // namespace
}  // namespace openfab
