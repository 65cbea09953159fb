// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Executes the pages of the site literally, in a folder that looks like a built clone: their code
// blocks in order in one shell, and every command of OpenFab in their text.

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "tests/scenes/scene_fixture.h"
#include "tests/scenes/walkthrough.h"
#include "tests/support/long_run.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// The pages of the site: all documents but the tests'.
std::vector<std::string> pages() {
    std::vector<std::string> out;
    for (auto at = fs::recursive_directory_iterator(source_dir()); at != fs::end(at); ++at) {
        const std::string path = fs::relative(at->path(), source_dir()).string();
        const bool other = path.starts_with(".") || path == "build" || path == "out" ||
                           path == "tests" || path == "gallery/figures" ||
                           path.ends_with("/node_modules");
        if (at->is_directory() && other) at.disable_recursion_pending();
        if (at->is_regular_file() && at->path().extension() == ".md" && !other) out.push_back(path);
    }
    std::sort(out.begin(), out.end());
    return out;
}

WalkthroughOptions options() {
    const char* python = std::getenv("OPENFAB_PYTHON");
    WalkthroughOptions out{
        .whole = long_run(), .python = python == nullptr ? "" : python, .parts = {}};
    for (const auto& [part, program] :
         {std::pair{"DICOM", "openfab-texture-dicom"}, std::pair{"HDF5", "openfab-texture-hdf5"},
          std::pair{"VDB", "openfab-vdb"}, std::pair{"STEP", "openfab-step"}}) {
        if (fs::exists(build_dir() / "bin" / program)) out.parts.emplace_back(part);
    }
    return out;
}

/// Whether something of a page waits for a long run.
bool has_long_blocks(const std::string& page) {
    const std::vector<Block> blocks = blocks_of(page);
    return std::any_of(blocks.begin(), blocks.end(),
                       [](const Block& block) { return block.how == "long"; });
}

/// Those on which there is something to try. Where OPENFAB_PYTHON names an interpreter that has the package, those with
/// Python, which nobody else tries.
std::vector<std::string> pages_to_follow() {
    std::vector<std::string> out;
    for (const std::string& path : pages()) {
        const std::string page = read_file(source_dir() / path);
        const std::vector<Block> blocks = blocks_of(page);
        const Walkthrough walk = walkthrough_of(page);
        const bool python = std::any_of(blocks.begin(), blocks.end(), [](const Block& block) {
            return block.language == "python" && block.how.empty();
        });
        const bool any = walk.blocks + walk.commands + walk.files > 0;
        if (options().python.empty() ? any : python) out.push_back(path);
    }
    return out;
}

/// What a world has besides its placements, as far as the closing brace.
constexpr const char* kRestOfAWorld = R"({
    "openfab": 1,
    "printer": "generic",
    "fablets": {"ball": {"source": "ball.fl", "fablet": "Ball"}},
    "materials": {"white": {"key": "#ffffff"}, "black": {"key": "#000000"}},
    "meshes": {"box": {"box": [4, 4, 2]}},
    "objects": {
        "rim": {"mesh": "box", "fablet": "ball", "uniforms": {"core": "white", "shell": "black"}},
        "tyre": {"mesh": "box", "fablet": "ball", "uniforms": {"core": "white", "shell": "black"}},
        "pin": {"mesh": "box", "fablet": "ball", "uniforms": {"core": "white", "shell": "black"}}
    },
)";

/// Where a reader of a page is: a folder that looks like a built clone, and in it what the page takes for granted.
class Reader {
  public:
    Reader(const std::string& path, const fs::path& cache) {
        fs::create_directories(clone_ / "build/release");
        fs::create_directory_symlink(build_dir() / "bin", clone_ / "build/release/bin");
        run_.folder = clone_.path();
        run_.environment = {
            {"OPENFAB_CACHE", cache.string()},
            {"PATH", (build_dir() / "bin").string() + ":/usr/local/bin:/usr/bin:/bin"}};
        if (path == "README.md") {
            run_.environment.back().second = "/usr/local/bin:/usr/bin:/bin";
            add_robot();
        } else if (path.starts_with("gallery/")) {
            enter_gallery(fs::path(path).parent_path());
        } else if (path == "schedules/README.md") {
            enter_gallery("gallery/magic_postcard");
        } else if (!path.starts_with("docs/tutorial/") && !path.starts_with("docs/how-to/")) {
            add_ball();
        }
    }

    Outcome follow(const Walkthrough& walk) const {
        return run({"/bin/bash", "-c", walk.script}, run_);
    }
    const fs::path& folder() const { return run_.folder; }

  private:
    /// README's example, and the rest of the world of which WORLDS.md shows some members.
    void add_ball() {
        for (const Block& block : blocks_of(read_file(source_dir() / "README.md"))) {
            if (!block.file.empty()) clone_.write(block.file, block.text);
        }
        clone_.write("rest.fab.json", kRestOfAWorld);
        clone_.write("pins.txt", "120 10 0\n1 0 0 130  0 1 0 10  0 0 1 0\n");
    }
    /// The user's own mesh.
    void add_robot() {
        fs::create_directories(clone_ / "out/ball");
        clone_.write("out/ball/robot.obj",
                     "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2\nv 4 0 2\nv 4 3 2\nv 0 3 2\n"
                     "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    }
    /// A copy of an exhibit's folder, beside those whose files others read.
    void enter_gallery(const fs::path& exhibit) {
        run_.folder = clone_ / exhibit;
        fs::create_directories(run_.folder.parent_path());
        fs::copy(source_dir() / exhibit, run_.folder, fs::copy_options::recursive);
        fs::copy_file(source_dir() / "gallery/openfab.project", clone_ / "gallery/openfab.project");
        // Worlds read nothing through links that lead out of their project.
        for (const char* shared : {"gallery/figures", "gallery/magic_postcard"}) {
            if (exhibit != shared) fs::copy(source_dir() / shared, clone_ / shared);
        }
    }

    ScratchFolder clone_;
    RunOptions run_;
};

/// The pages, with what they have in common: a folder for their cache of kernels.
class Pages : public ::testing::TestWithParam<std::string> {
  protected:
    static void SetUpTestSuite() { cache_ = new ScratchFolder; }
    static void TearDownTestSuite() {
        delete cache_;
        cache_ = nullptr;
    }
    static ScratchFolder* cache_;
};

ScratchFolder* Pages::cache_ = nullptr;

TEST_P(Pages, WorkAsWritten) {
    const std::string& path = GetParam();
    const std::string page = read_file(source_dir() / path);
    const Walkthrough walk = walkthrough_of(page, options());
    const Reader reader(path, cache_->path());
    const Outcome outcome = reader.follow(walk);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    if (path == "README.md") {
        EXPECT_EQ(walk.files, 3);
        // The knob is that of the tutorial, where it is printed.
        EXPECT_THAT(read_file(source_dir() / "docs/tutorial/index.md"),
                    HasSubstr(read_file(reader.folder() / "knob.fl")));
        EXPECT_GE(walk.commands, 7);
        EXPECT_THAT(outcome.err, HasSubstr("slices are whole"));
        const fs::path ball = reader.folder() / "out/ball";
        for (const char* made : {"slices/manifest.json", "ball.png", "ball.ofr", "ball-print",
                                 "soft_toy/soft_toy.fab.json", "robot/robot.fab.json"})
            EXPECT_TRUE(fs::exists(ball / made)) << made;
        EXPECT_EQ(read_ofr(ball / "again.ofr").materials,
                  (std::vector<std::string>{"white", "black"}));
    }
    // The pictures that it shows are some that its commands make, or, with OPENFAB_UPDATE, become so.
    std::map<std::string, fs::path> made;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(reader.folder())) {
        if (entry.is_regular_file()) made[entry.path().filename().string()] = entry.path();
    }
    const fs::path beside = (source_dir() / path).parent_path();
    if (std::getenv("OPENFAB_UPDATE") != nullptr && path.starts_with("docs/")) {
        for (const std::string& picture : pictures_of(page)) {
            if (made.contains(picture))
                fs::copy_file(made[picture], beside / picture,
                              fs::copy_options::overwrite_existing);
        }
    }
    if (!path.starts_with("docs/tutorial/") && !path.starts_with("docs/how-to/")) return;
    EXPECT_GE(walk.files, 1);
    if (has_long_blocks(page) && !long_run()) return;
    for (const std::string& picture : pictures_of(page)) {
        // What the gallery shows is printed there.
        const bool elsewhere = picture.starts_with("../../gallery/");
        if (!elsewhere) {
            EXPECT_TRUE(made.contains(picture) && fs::file_size(made[picture]) > 0) << picture;
        }
        EXPECT_TRUE(fs::exists(beside / picture)) << picture;
    }
}

INSTANTIATE_TEST_SUITE_P(Site, Pages, ::testing::ValuesIn(pages_to_follow()), [](const auto& page) {
    std::string name = fs::path(page.param).replace_extension().string();
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == '/' || c == '-' || c == '.'; }, '_');
    return name;
});

// A block that the words after its fence do not account for is tried by nobody.
TEST(Blocks, SayWhatTheyHold) {
    int tried = 0, files = 0, by_hand = 0, python = 0;
    for (const std::string& path : pages()) {
        const std::string page = read_file(source_dir() / path);
        const Walkthrough walk = walkthrough_of(page);
        for (const std::string& mistake : walk.mistakes)
            ADD_FAILURE() << path << ':' << mistake
                          << ": docs/testing.md lists what may stand here";
        for (const std::string& reason : walk.by_hand)
            std::printf("by hand: %s:%s\n", path.c_str(), reason.c_str());
        for (const Block& block : blocks_of(page))
            python += block.language == "python" ? 1 : 0;
        tried += walk.blocks;
        files += walk.files;
        by_hand += static_cast<int>(walk.by_hand.size());
    }
    std::printf("%d blocks are tried, %d of them of Python; %d are files for them; %d by hand\n",
                tried, python, files, by_hand);
    EXPECT_GT(tried, 50);
    EXPECT_GT(files, 25);
    EXPECT_LE(by_hand, 14) << "too much of the documents is tried by nobody";
}

}  // namespace
}  // namespace openfab::testing
