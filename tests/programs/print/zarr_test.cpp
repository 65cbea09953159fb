// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Stores of Zarr by processes: several at once, killed at any moment, on a full disk. The bytes must be those of one
// undisturbed print, and no file that was whole is written again.

#include <future>

#include "backends/read/print_file.h"
#include "backends/zarr/messages.h"
#include "tests/programs/print/resume.h"

namespace openfab::testing {
namespace {

/// Maps names to contents, but for lists, which are one a writer.
Files store_files(const fs::path& store) {
    Files files;
    if (!fs::exists(store)) return files;
    for (const auto& entry : fs::recursive_directory_iterator(store)) {
        const std::string name = fs::relative(entry.path(), store).string();
        if (entry.is_regular_file() && !name.ends_with(".list"))
            files[name] = read_file(entry.path());
    }
    return files;
}

/// Maps the names of shards to what changes where they are written: their inodes.
std::map<std::string, ino_t> shards_of(const fs::path& store) {
    std::map<std::string, ino_t> shards;
    if (!fs::exists(store)) return shards;
    for (const auto& entry : fs::recursive_directory_iterator(store)) {
        const std::string name = fs::relative(entry.path(), store).string();
        struct stat status {};
        if (entry.is_regular_file() && name.find("/c/") != std::string::npos &&
            !name.ends_with(".part") && ::stat(entry.path().c_str(), &status) == 0)
            shards[name] = status.st_ino;
    }
    return shards;
}

class ZarrPrint : public Resume {
  protected:
    Outcome tool(std::vector<std::string> words) {
        words.insert(words.begin(), program("openfab").string());
        return run(words);
    }
};

TEST_F(ZarrPrint, KilledAtAnyMomentNothingTornIsTakenForWholeAndNothingIsWrittenTwice) {
    const int whole_us = undisturbed({"-o", path("whole.zarr")});
    const Files expected = store_files(path("whole.zarr"));
    EXPECT_GT(expected.size(), 40u);
    constexpr int kKills = 12, kKillsEach = 4;
    std::uniform_int_distribution<int> moment(0, whole_us / 2);
    int killed = 0;
    for (int kill = 0; kill < kKills; ++kill) {
        if (kill % kKillsEach == 0) fs::remove_all(path("a.zarr"));
        const auto before = shards_of(path("a.zarr"));
        const Outcome outcome = killed_print({"-o", path("a.zarr"), "--resume"}, moment(random_));
        killed += outcome.exit_code == 0 ? 0 : 1;
        for (const auto& [name, bytes] : store_files(path("a.zarr"))) {
            // What has its name is whole.
            const bool is_shard = !name.ends_with(".part") && name.find("/c/") != std::string::npos;
            EXPECT_TRUE(!is_shard || bytes == expected.at(name)) << name;
        }
        const auto after = shards_of(path("a.zarr"));
        for (const auto& [name, inode] : before)
            EXPECT_EQ(after.at(name), inode) << name << " was written again";
        if (kill % kKillsEach + 1 < kKillsEach) continue;
        const Outcome last = print({"-o", path("a.zarr"), "--resume"});
        ASSERT_EQ(last.exit_code, 0) << last.err;
        Files files = store_files(path("a.zarr"));
        // A group or an array whose writing was cut leaves a file beside it, which nobody reads.
        std::erase_if(files, [](const auto& file) {
            return file.first.ends_with(".part") && file.first.find("/c/") == std::string::npos;
        });
        EXPECT_TRUE(files == expected);
        for (const auto& [name, inode] : after)
            EXPECT_EQ(shards_of(path("a.zarr")).at(name), inode) << name << " was written again";
        EXPECT_EQ(tool({"verify", path("a.zarr")}).exit_code, 0);
    }
    EXPECT_GE(killed,
              kKills / 2);  // otherwise the print was too short for the test to mean anything
}

TEST_F(ZarrPrint, WorkersFillOneStoreAtOnce) {
    undisturbed({"-o", path("whole.zarr")});
    std::vector<std::future<Outcome>> workers;
    for (int part = 1; part <= 4; ++part) {
        workers.push_back(std::async(std::launch::async, [this, part] {
            return print(
                {"-o", path("shared.zarr"), "--part", fmt::format("{}/4", part), "--threads", "1"});
        }));
    }
    for (std::future<Outcome>& worker : workers) {
        const Outcome outcome = worker.get();
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    }
    EXPECT_TRUE(store_files(path("shared.zarr")) == store_files(path("whole.zarr")));
    const Outcome verified = tool({"verify", path("shared.zarr")});
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
}

/// As the tasks of a job array name them: the last range reaches past the end, or is open.
TEST_F(ZarrPrint, RangesOfAJobArrayFillAStore) {
    undisturbed({"-o", path("whole.zarr")});
    const int slices = [&] {
        const auto whole = prints::PrintFile::open(path("whole.zarr"), int64_t{1} << 30);
        return whole ? (*whole)->info().size.z : 0;
    }();
    ASSERT_GT(slices, 80);
    const int third = (slices / 3 + 7) / 8 * 8;
    undisturbed({"-o", path("past.zarr"), "--slices", fmt::format("0:{}", third)});
    const Outcome info = tool({"info", path("past.zarr")});
    EXPECT_THAT(info.out,
                HasSubstr(fmt::format("{} slices of the print are elsewhere", slices - third)));
    undisturbed(
        {"-o", path("past.zarr"), "--slices", fmt::format("{}:{}", 2 * third, 3 * third + 800)});
    EXPECT_THAT(tool({"info", path("past.zarr")}).out,
                Says(tools::messages::kStoreLacks, fmt::format("{}:{}", third, 2 * third)));
    EXPECT_THAT(tool({"verify", path("past.zarr")}).err, Says(tools::messages::kStoreLacksSlices));
    EXPECT_THAT(tool({"export", path("past.zarr"), "-o", path("a.ofr")}).err,
                Says(tools::messages::kSlicesMissing));
    undisturbed({"-o", path("past.zarr"), "--slices", fmt::format("{}:{}", third, 2 * third)});
    EXPECT_TRUE(store_files(path("past.zarr")) == store_files(path("whole.zarr")));
    undisturbed({"-o", path("open.zarr"), "--slices", fmt::format("{}:", third)});
    undisturbed({"-o", path("open.zarr"), "--slices", fmt::format("0:{}", third)});
    EXPECT_TRUE(store_files(path("open.zarr")) == store_files(path("whole.zarr")));
}

TEST_F(ZarrPrint, StoresOfPartsAreMergedAsFilesAre) {
    undisturbed({"-o", path("whole.ofr")});
    undisturbed({"-o", path("low.zarr"), "--part", "1/2"});
    undisturbed({"-o", path("high.zarr"), "--part", "2/2"});
    const Outcome alone = tool({"merge", path("high.zarr"), "--whole", "-o", path("a.ofr")});
    EXPECT_EQ(alone.exit_code, 1);
    EXPECT_FALSE(fs::exists(path("a.ofr")));
    Outcome merged = tool({"merge", path("high.zarr"), path("low.zarr"), "-o", path("a.ofr")});
    ASSERT_EQ(merged.exit_code, 0) << merged.err;
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("whole.ofr")));
    merged = tool({"merge", path("high.zarr"), path("low.zarr"), "-o", path("b.zarr")});
    ASSERT_EQ(merged.exit_code, 0) << merged.err;
    undisturbed({"-o", path("whole.zarr")});
    EXPECT_TRUE(store_files(path("b.zarr")) == store_files(path("whole.zarr")));
    // Of one that is not complete nothing is made.
    for (const auto& entry : fs::directory_iterator(path("low.zarr") + "/openfab")) {
        if (entry.path().extension() == ".list")
            fs::resize_file(entry.path(), entry.file_size() / 2);
    }
    merged = tool({"merge", path("high.zarr"), path("low.zarr"), "-o", path("c.ofr")});
    EXPECT_EQ(merged.exit_code, 1);
    EXPECT_THAT(merged.err, Says(tools::messages::kStoreLacksSlices));
    EXPECT_FALSE(fs::exists(path("c.ofr")));
}

TEST_F(ZarrPrint, IsVerifiedShardByShard) {
    undisturbed({"-o", path("a.zarr")});
    const fs::path store = path("a.zarr"), shard = store / "0/c/9/0/0";
    EXPECT_EQ(tool({"verify", store}).exit_code, 0);
    const std::string bytes = read_file(shard);
    const auto refused = [&](const char* message) {
        const Outcome outcome = tool({"verify", store});
        EXPECT_EQ(outcome.exit_code, 1);
        EXPECT_THAT(outcome.err, Says(message));
    };
    fs::resize_file(shard, bytes.size() - 1);
    refused(zarr::messages::kShardOtherSize);
    scratch_.write("a.zarr/0/c/9/0/0", bytes);
    fs::copy_file(store / "1/c/9/0/0", store / "1/c/8/0/0", fs::copy_options::overwrite_existing);
    EXPECT_EQ(tool({"verify", store}).exit_code, 1);
    EXPECT_EQ(print({"-o", store, "--resume"}).exit_code, 0);
    EXPECT_EQ(tool({"verify", store}).exit_code, 0);
    fs::remove(store / "openfab/manifest.json");
    refused(tools::messages::kStoreWithoutManifest);
    EXPECT_EQ(print({"-o", store, "--resume"}).exit_code, 0);
    EXPECT_EQ(tool({"verify", store}).exit_code, 0);
}

TEST_F(ZarrPrint, FractionsAreNoStore) {
    const Outcome refused = print({"--fractions", path("f.zarr")});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err,
                Says(program::messages::kFractionsNoZarr, path("f.zarr"), path("f.npy")));
    EXPECT_FALSE(fs::exists(path("f.zarr")));
}

TEST_F(ZarrPrint, AFullStoreIsNamedAndGoesOnOnceThereIsRoom) {
    undisturbed({"-o", path("whole.zarr")});
    uintmax_t largest = 0;
    for (const auto& [name, bytes] : store_files(path("whole.zarr")))
        largest = std::max<uintmax_t>(largest, bytes.size());
    RunOptions full;
    full.largest_file_bytes = static_cast<int64_t>(largest * 4 / 5);
    const Outcome refused = print({"-o", path("a.zarr")}, full);
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_THAT(refused.err, Says(zarr::messages::kCannotWrite));
    EXPECT_THAT(refused.err, Says(backends::messages::kRestTakes));
    for (const auto& [name, bytes] : store_files(path("a.zarr")))
        EXPECT_FALSE(name.ends_with(".part")) << name;
    const Outcome again = print({"-o", path("a.zarr"), "--resume"});
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_TRUE(store_files(path("a.zarr")) == store_files(path("whole.zarr")));
}

}  // namespace
}  // namespace openfab::testing
