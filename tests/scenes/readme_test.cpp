// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Executes README.md and the guides of docs/ literally, in a folder that looks like a built clone:
// their code blocks in order in one shell, and every command of OpenFab in their text.

#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "tests/scenes/scene_fixture.h"
#include "tests/scenes/walkthrough.h"
#include "tests/support/long_run.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string section_of_readme(const std::string& title) {
    const std::string all = read_file(source_dir() / "README.md");
    const size_t begin = all.find("## " + title + "\n");
    EXPECT_NE(begin, std::string::npos);
    return all.substr(begin, all.find("\n## ", begin) - begin);
}

TEST(Readme, FiveMinutesWorkAsWritten) {
    const Walkthrough walk = walkthrough_of(section_of_readme("Your own part in five minutes"));
    EXPECT_EQ(walk.files, 2);
    EXPECT_GE(walk.commands, 7);
    const ScratchFolder clone;
    fs::create_directories(clone / "build/release");
    fs::create_directory_symlink(OPENFAB_BIN_DIR, clone / "build/release/bin");
    // The user's own mesh.
    fs::create_directories(clone / "out/ball");
    clone.write("out/ball/robot.obj",
                "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2\nv 4 0 2\nv 4 3 2\nv 0 3 2\n"
                "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    RunOptions options;
    options.folder = clone.path();
    options.environment = {{"OPENFAB_CACHE", (clone / "cache").string()},
                           {"PATH", "/usr/local/bin:/usr/bin:/bin"}};
    const Outcome outcome = run({"/bin/bash", "-c", walk.script}, options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("slices are whole"));
    for (const char* made : {"slices/manifest.json", "ball.png", "ball.ofr", "ball-print",
                             "soft_toy/soft_toy.fab.json", "robot/robot.fab.json", "ball.3mf"})
        EXPECT_TRUE(fs::exists(clone / "out/ball" / made)) << made;
    EXPECT_EQ(read_ofr(clone / "out/ball/again.ofr").materials,
              (std::vector<std::string>{"white", "black"}));
}

/// The folders of guides, with what they have in common: a folder for their cache of kernels.
class Guides : public ::testing::TestWithParam<std::string> {
  protected:
    static void SetUpTestSuite() { cache_ = new ScratchFolder; }
    static void TearDownTestSuite() {
        delete cache_;
        cache_ = nullptr;
    }
    static ScratchFolder* cache_;
};

ScratchFolder* Guides::cache_ = nullptr;

std::vector<std::string> guides() {
    std::vector<std::string> out;
    // Kernels of lattices and of inks, for which LLVM takes longest; the gallery's tests have them.
    const std::vector<std::string> only_long{"graded-lattice", "picture", "colour"};
    for (const char* folder : {"docs/tutorial", "docs/how-to"}) {
        for (const fs::directory_entry& entry : fs::directory_iterator(source_dir() / folder)) {
            const std::string stem = entry.path().stem().string();
            const bool late =
                std::find(only_long.begin(), only_long.end(), stem) != only_long.end();
            if (entry.path().extension() == ".md" && (!late || long_run()))
                out.push_back(fs::relative(entry.path(), source_dir()).string());
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

TEST_P(Guides, WorkAsWritten) {
    const std::string page = read_file(source_dir() / GetParam());
    const Walkthrough walk = walkthrough_of(page);
    EXPECT_GE(walk.files, 1);
    const ScratchFolder clone;
    fs::create_directories(clone / "build/release");
    fs::create_directory_symlink(OPENFAB_BIN_DIR, clone / "build/release/bin");
    RunOptions options;
    options.folder = clone.path();
    options.environment = {
        {"OPENFAB_CACHE", cache_->path().string()},
        {"PATH", std::string(OPENFAB_BIN_DIR) + ":/usr/local/bin:/usr/bin:/bin"}};
    const Outcome outcome = run({"/bin/bash", "-c", walk.script}, options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    // The pictures that it shows are some that its commands make.
    std::map<std::string, uintmax_t> made;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(clone.path())) {
        if (entry.is_regular_file()) made[entry.path().filename().string()] = entry.file_size();
    }
    for (const std::string& picture : pictures_of(page)) {
        EXPECT_GT(made[picture], 0U) << picture;
        EXPECT_TRUE(fs::exists((source_dir() / GetParam()).parent_path() / picture)) << picture;
    }
}

INSTANTIATE_TEST_SUITE_P(Pages, Guides, ::testing::ValuesIn(guides()), [](const auto& page) {
    std::string name = fs::path(page.param).replace_extension().string();
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == '/' || c == '-'; }, '_');
    return name;
});

}  // namespace
}  // namespace openfab::testing
