// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/input_file.h"

#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/messages.h"
#include "base/own_folder.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"

namespace openfab {
namespace {

namespace fs = std::filesystem;

class InputFileTest : public ::testing::Test {
  protected:
    InputFileTest() : root_(without_links(folder_.path()) / "world") {
        fs::create_directory(root_);
        folder_.write("secret.txt", "secret");
        folder_.write("world/own.txt", "own");
    }
    std::string error_of(const fs::path& file, bool anywhere = false) {
        const Result<InputFile> opened =
            InputFile::open(file, anywhere ? std::vector<fs::path>{} : std::vector{root_});
        return opened ? "no error" : opened.error().text();
    }

    testing::TempFolder folder_;
    fs::path root_;
};

TEST_F(InputFileTest, ALimitOfTheUsersIsNamed) {
    struct rlimit before {};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
    const struct rlimit none { 0, before.rlim_max };
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
    const Result<InputFile> opened = InputFile::open(root_ / "own.txt");
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::kOutside);
    EXPECT_THAT(opened.error().text(), testing::Says(messages::kAllowMoreFiles));
}

TEST_F(InputFileTest, OpensRegularFilesAlone) {
    EXPECT_EQ(error_of(root_ / "own.txt"), "no error");
    EXPECT_THAT(error_of(root_), testing::Says(messages::kKindNotAFile, messages::kKindFolder));
    ASSERT_EQ(::mkfifo((root_ / "pipe").c_str(), 0600), 0);
    EXPECT_THAT(error_of(root_ / "pipe"),
                testing::Says(messages::kKindNotAFile, messages::kKindPipe));
    EXPECT_THAT(error_of("/dev/zero", true),
                testing::Says(messages::kKindNotAFile, messages::kKindDevice));
    const Result<InputFile> none = InputFile::open(root_ / "none.txt");
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, ErrorCode::kUserInput);
    EXPECT_EQ(none.error().text(), "No such file or directory");
}

TEST_F(InputFileTest, StaysBelowItsRootsWhateverTheName) {
    fs::create_symlink("../secret.txt", root_ / "link.txt");
    fs::create_directory_symlink("..", root_ / "up");
    fs::create_symlink("own.txt", root_ / "alias.txt");
    for (const fs::path& file : {root_ / "../secret.txt", root_ / "link.txt",
                                 root_ / "up" / "secret.txt", folder_.path() / "secret.txt"}) {
        EXPECT_THAT(error_of(file), testing::Says(messages::kNotBelow, "*", root_.string()));
        EXPECT_EQ(error_of(file, true), "no error") << "a user's own choice";
    }
    EXPECT_EQ(error_of(root_ / "up/world/own.txt"), "no error");
    EXPECT_EQ(error_of(root_ / "alias.txt"), "no error");
    fs::create_directory(fs::path(root_.string() + "s"));
    folder_.write("worlds/near.txt", "near");
    EXPECT_THAT(error_of(root_.string() + "s/near.txt"), testing::Says(messages::kNotBelow));
}

TEST_F(InputFileTest, ReadsNoMoreThanItMay) {
    const Result<InputFile> file = InputFile::open(root_ / "own.txt");
    ASSERT_TRUE(file);
    EXPECT_EQ(file->bytes(), 3);
    EXPECT_EQ(*file->read_all(3), "own");
    EXPECT_THAT(file->read_all(2).error().text(), testing::Says(messages::kLargerThan, "2 B"));
    // The system reports no size for these.
    const Result<InputFile> endless = InputFile::open("/proc/self/maps");
    ASSERT_TRUE(endless);
    EXPECT_FALSE(endless->read_all(10));
    EXPECT_GT(endless->read_all(100'000'000)->size(), 100u);
    char buffer[8] = {};
    EXPECT_EQ(*file->read(1, buffer, 8), 2u);
    EXPECT_STREQ(buffer, "wn");
}

TEST_F(InputFileTest, AProjectIsTheRootOfWhatIsInIt) {
    fs::create_directories(root_ / "deep/deeper");
    EXPECT_EQ(reading_root(root_ / "deep/deeper"), root_ / "deep/deeper");
    folder_.write("world/openfab.project", "");
    EXPECT_EQ(reading_root(root_ / "deep/deeper"), root_);
    EXPECT_EQ(reading_root(""), reading_root("."));
}

TEST(AsArgument, IsNoOption) {
    EXPECT_EQ(as_argument("--linker=x.fl"), "./--linker=x.fl");
    EXPECT_EQ(as_argument("@list"), "./@list");
    EXPECT_EQ(as_argument("/a/b"), "/a/b");
}

TEST(OwnFolder, IsMadeForOneselfAndClearedOfWhatDied) {
    const testing::TempFolder folder;
    const fs::path own_path = folder.path() / "a/b";
    const Result<fs::path> own = own_folder(own_path);
    ASSERT_TRUE(own) << own.error().text();
    EXPECT_EQ(fs::status(own_path).permissions(), fs::perms(0700));
    EXPECT_EQ(fs::status(own_path.parent_path()).permissions(), fs::perms(0700));
    const fs::path left = own_path / "openfab.tmp-abcdef";
    fs::create_directory(left);
    std::ofstream(left / "half") << "x";
    std::ofstream(own_path / "kept.tmp-abc") << "x";
    {
        const auto held = TemporaryFolder::create(own_path);
        ASSERT_TRUE(held);
        EXPECT_EQ(fs::status((*held)->path()).permissions(), fs::perms(0700));
        clear_left_over(own_path);
        EXPECT_FALSE(fs::exists(left));
        EXPECT_TRUE(fs::exists((*held)->path()));
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(own_path), {}), 1)
        << "another kind of name stays";
    fs::permissions(folder.path() / "a", fs::perms(0770));
    EXPECT_THAT(own_folder(own_path).error().text(),
                testing::Says(messages::kOthersCanWrite,
                              testing::pattern_of(messages::kFolderAbove, {}), "770"));
    if (::geteuid() == 0) {
        fs::permissions(folder.path() / "a", fs::perms(0700));
        ASSERT_EQ(::chown(own_path.c_str(), 12345, 12345), 0);
        EXPECT_THAT(own_folder(own_path).error().text(),
                    testing::Says(messages::kOthersFolder, messages::kItself));
    }
}

}  // namespace
}  // namespace openfab
