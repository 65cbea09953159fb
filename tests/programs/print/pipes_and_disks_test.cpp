// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Outputs that are slow, or full, like real pipes and disks.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <chrono>
#include <map>
#include <thread>

#include "backends/common/messages.h"
#include "program/messages.h"
#include "tests/programs/print/simple_world.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

#ifdef OPENFAB_SANITIZED
constexpr const char* kBlock = "[20, 20, 10]";
#else
constexpr const char* kBlock = "[50, 50, 120]";  ///< 300 million voxels, 41 MB of them packed
#endif

class PipesAndDisks : public ::testing::Test {
  protected:
    PipesAndDisks() {
        scratch_.write("f.fl", "fablet Tint {}\n");
        write_world("block.fab.json", fmt::format(R"({{"box": {}}})", kBlock));
        write_world("ball.fab.json", R"({"sphere": 16})");
    }
    void write_world(const std::string& name, const std::string& mesh) {
        scratch_.write(name, SimpleWorld{"Tint", mesh}.text());
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(const std::string& world, std::vector<std::string> arguments,
                  const RunOptions& options = {}) {
        std::vector<std::string> argv{test_program("openfab_test_print_4"), path(world)};
        argv.insert(argv.end(), arguments.begin(), arguments.end());
        return run(argv, options);
    }
    int64_t number(const std::string& file, const char* key) {
        rapidjson::Document d;
        d.Parse(read_file(scratch_ / file).c_str());
        EXPECT_TRUE(!d.HasParseError() && d.HasMember(key)) << file << " " << key;
        return d.HasParseError() || !d.HasMember(key) ? -1 : d[key].GetInt64();
    }

    ScratchFolder scratch_;
};

// A reader that stalls for longer than the whole print takes, and then continues.
TEST_F(PipesAndDisks, ASlowReaderOfAPipeHoldsThePrintBackInTheMemoryThatWasPlanned) {
    // Error diffusion compresses badly, so that much would be queued.
    const auto print_block = [&](std::vector<std::string> arguments, const RunOptions& options) {
        arguments.insert(arguments.end(), {"--dither", "decorrelated"});
        return print("block.fab.json", arguments, options);
    };
    ASSERT_EQ(print_block({"-o", path("whole.ofr"), "--stats", path("free.json")}, {}).exit_code,
              0);
    const std::string whole = read_file(path("whole.ofr"));
    RunOptions slow;
    bool stood = false;
    slow.before_read = [&](const Outcome& so_far) {
        if (stood || so_far.out.size() < whole.size() / 20) return;
        stood = true;
        std::this_thread::sleep_for(3s);
    };
    const Outcome held = print_block({"-o", "-", "--stats", path("slow.json")}, slow);
    ASSERT_EQ(held.exit_code, 0) << held.err;
    EXPECT_TRUE(stood);
    EXPECT_TRUE(held.out == whole);
    ASSERT_EQ(print_block({"-o", "-", "--estimate", "--stats", path("plan.json")}, {}).exit_code,
              0);
#ifndef OPENFAB_SANITIZED  // sanitizers keep their own memory
    const int64_t peak = number("slow.json", "peak_rss_bytes");
    EXPECT_LE(peak, number("plan.json", "memory_bytes"));
    // An unbounded queue for the reader would take twice this and more.
    EXPECT_GT(static_cast<int64_t>(whole.size()), 36'000'000);
    EXPECT_LE(peak, number("free.json", "peak_rss_bytes") + 15'000'000);
#endif
}

#ifndef OPENFAB_SANITIZED  // what may wait in memory is more than its block
// Slices are written as soon as they are made: a reader that has got some can end the print long before its last one. No more
// than 15 MB of its 36 wait in memory, as above.
TEST_F(PipesAndDisks, AReaderOfAPipeIsNotKeptWaiting) {
    RunOptions watched;
    watched.interrupt_when = [](int, const Outcome& so_far) { return so_far.out.size() > 100'000; };
    const Outcome outcome =
        print("block.fab.json", {"-o", "-", "--dither", "decorrelated"}, watched);
    EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
    EXPECT_GT(outcome.out.size(), 100'000u);
    EXPECT_LT(outcome.out.size(), 24'000'000u);
}
#endif

// Error diffusion compresses badly: 36 MB are far more than the reader takes and the pipe holds.
TEST_F(PipesAndDisks, AReaderThatGoesAwayEndsThePrint) {
    const std::string command = fmt::format(
        "{} {} -o - --dither decorrelated | head -c 200000 > /dev/null; exit "
        "${{PIPESTATUS[0]}}",
        test_program("openfab_test_print_4").string(), path("block.fab.json"));
    const Outcome outcome = run({"/bin/bash", "-c", command});
    EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
    EXPECT_THAT(outcome.err,
                ::testing::HasSubstr(std::string(backends::messages::kCannotWriteTo) + " `" +
                                     backends::messages::kStandardOutput + "`: Broken pipe"));
}

using Files = std::map<std::string, std::string>;

/// Maps names to contents; a file counts as a folder of one.
Files files_of(const fs::path& output) {
    if (!fs::is_directory(output)) return {{"", read_file(output)}};
    Files files;
    for (const auto& entry : fs::directory_iterator(output))
        files[entry.path().filename().string()] = read_file(entry.path());
    return files;
}

int64_t bytes_of(const Files& files) {
    int64_t sum = 0;
    for (const auto& [name, bytes] : files)
        sum += static_cast<int64_t>(bytes.size() + 4095) / 4096 * 4096;
    return sum;
}

TEST_F(PipesAndDisks, AFullDiskThatIsFreedIsGoneOnWith) {
    for (const std::string format : {"ofr", "png"}) {
        const std::vector<std::string> options{"--format", format};
        const auto arguments = [&](const std::string& output, bool resume) {
            std::vector<std::string> all = options;
            all.insert(all.end(), {"-o", output});
            if (resume) all.push_back("--resume");
            return all;
        };
        ASSERT_EQ(print("ball.fab.json", arguments(path("whole." + format), false)).exit_code, 0);
        const Files whole = files_of(path("whole." + format));
        std::string why_not;
        const std::unique_ptr<SmallDisk> disk =
            SmallDisk::create(2 * bytes_of(whole) + 100'000, &why_not);
        if (disk == nullptr) GTEST_SKIP() << why_not;
        const std::string output = disk->path("a");

        disk->fill("other", bytes_of(whole) * 2 / 3);
        const Outcome full = print("ball.fab.json", arguments(output, false));
        EXPECT_EQ(full.exit_code, 3);
        EXPECT_THAT(full.err, HasSubstr("No space left on device"));
        EXPECT_THAT(full.err, testing::Says(backends::messages::kWholeSlicesBefore));
        EXPECT_THAT(full.err, Says(program::messages::kResumeHelp));
        const Files left = files_of(output);

        // Still full: no complete slice is lost.
        const Outcome again = print("ball.fab.json", arguments(output, true));
        EXPECT_EQ(again.exit_code, 3);
        if (format == "ofr") {
            EXPECT_GE(files_of(output).begin()->second.size() + 4096, left.begin()->second.size());
        } else {
            for (const auto& [name, bytes] : left) {
                if (!name.starts_with("slice_")) continue;
                EXPECT_TRUE(bytes == whole.at(name)) << name;
                EXPECT_TRUE(files_of(output).contains(name)) << name;
            }
            EXPECT_GT(left.size(), whole.size() / 3);
        }

        fs::remove(disk->path("other"));
        const Outcome freed = print("ball.fab.json", arguments(output, true));
        EXPECT_EQ(freed.exit_code, 0) << freed.err;
        EXPECT_THAT(freed.err, Says(program::messages::kSummaryResumed));
        EXPECT_TRUE(files_of(output) == whole);
    }
}

// A mesh is invalid before its end, so one that does not fit leaves nothing and is made again.
TEST_F(PipesAndDisks, AMeshThatFillsTheDiskLeavesItAsItWas) {
    ASSERT_EQ(print("ball.fab.json", {"-o", path("whole.3mf")}).exit_code, 0);
    const int64_t bytes = static_cast<int64_t>(fs::file_size(path("whole.3mf")));
    std::string why_not;
    const std::unique_ptr<SmallDisk> disk = SmallDisk::create(3 * bytes + 100'000, &why_not);
    if (disk == nullptr) GTEST_SKIP() << why_not;
    disk->fill("other", bytes / 2);
    const Outcome full = print("ball.fab.json", {"-o", disk->path("a.3mf")});
    EXPECT_EQ(full.exit_code, 3);
    EXPECT_THAT(full.err, HasSubstr("No space left on device"));
    EXPECT_FALSE(fs::exists(disk->path("a.3mf")));
    fs::remove(disk->path("other"));
    const Outcome freed = print("ball.fab.json", {"-o", disk->path("a.3mf")});
    EXPECT_EQ(freed.exit_code, 0) << freed.err;
    EXPECT_TRUE(read_file(disk->path("a.3mf")) == read_file(path("whole.3mf")));
}

}  // namespace
}  // namespace openfab::testing
