// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Errors of the outside world: a message with a location, the right exit code, and complete slices
// are kept.

#include <gmock/gmock.h>

#include "backends/ofr/ofr_reader.h"
#include "tests/scenes/scene_fixture.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

constexpr int kUserInput = 1, kUsage = 2, kOutside = 3, kInterrupted = 130;

class BadInput : public PostcardScene {
  protected:
    /// A copy of the gallery's postcard, world `postcard.fab.json`, with texts replaced in one of
    /// its files; printed coarsely.
    static Outcome print_changed(
        const std::vector<std::pair<std::string, std::string>>& replacements,
        const std::string& file = "postcard.fab.json") {
        const std::filesystem::path folder = scratch() / "changed";
        std::filesystem::create_directories(folder);
        for (const char* name : {"magic_postcard.fl", "card.obj", "foreground.jpg", "hidden.jpg",
                                 "postcard.fab.json"}) {
            std::filesystem::copy_file(gallery_postcard() / name, folder / name,
                                       std::filesystem::copy_options::overwrite_existing);
        }
        std::string text = read_file(folder / file);
        for (const auto& [from, to] : replacements) {
            const size_t at = text.find(from);
            EXPECT_NE(at, std::string::npos) << from;
            if (at != std::string::npos) text.replace(at, from.size(), to);
        }
        scratch().write("changed/" + file, text);
        return print_world(folder / "postcard.fab.json",
                           {"-o", (scratch() / "changed.ofr").string()});
    }
    static Outcome print_world(const std::filesystem::path& world,
                               std::vector<std::string> arguments) {
        std::vector<std::string> argv{binary().string(), world.string(), "--draft", "8"};
        argv.insert(argv.end(), arguments.begin(), arguments.end());
        return run(argv, environment());
    }
    static Outcome print_here(const std::vector<std::string>& arguments) {
        return print_world(gallery_postcard() / "postcard.fab.json", arguments);
    }
};

TEST_F(BadInput, MissingTexture) {
    const Outcome outcome = print_changed({{"\"file\": \"hidden.jpg\"", "\"file\": \"gone.jpg\""}});
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("gone.jpg"));
    EXPECT_THAT(outcome.err, HasSubstr("postcard.fab.json:13:"));
}

TEST_F(BadInput, ATextureThatIsNoImage) {
    const Outcome outcome = print_changed({{"\"file\": \"hidden.jpg\"", "\"file\": \"card.obj\""}});
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("card.obj"));
}

TEST_F(BadInput, AMeshWithoutTheAttribute) {
    std::filesystem::create_directories(scratch() / "changed");
    scratch().write("changed/plain.obj",
                    "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    const Outcome outcome = print_changed(
        {{"{\"file\": \"card.obj\", \"unit\": \"mm\", \"groups\": {\"front\": 0, \"back\": 1, "
          "\"sides\": 2}}",
          "{\"file\": \"plain.obj\", \"unit\": \"mm\"}"}});
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("`uv`"));
    EXPECT_THAT(outcome.err, HasSubstr("card"));
}

TEST_F(BadInput, AMeshWithoutGroups) {
    const Outcome outcome =
        print_changed({{"g front\n", ""}, {"g back\n", ""}, {"g sides\n", ""}}, "card.obj");
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("group"));
    EXPECT_THAT(outcome.err, HasSubstr("card.obj:"));
}

TEST_F(BadInput, AUniformOfTheWrongType) {
    const Outcome outcome =
        print_changed({{"\"textureDepth\": 0.4", "\"textureDepth\": \"VeroWhite\""}});
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("textureDepth"));
    EXPECT_THAT(outcome.err, HasSubstr("float"));
    EXPECT_THAT(outcome.err, HasSubstr("postcard.fab.json:25:"));
}

TEST_F(BadInput, AMissingUniform) {
    const Outcome outcome = print_changed({{"\"textureDepth\": 0.4,", ""}});
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("textureDepth"));
}

TEST_F(BadInput, AnUnknownKeyWithANearMiss) {
    const Outcome outcome = print_changed({{"\"max_displacement_mm\"", "\"max_displacment_mm\""}});
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("postcard.fab.json:22:"));
    EXPECT_THAT(outcome.err, HasSubstr("max_displacement_mm"));
}

TEST_F(BadInput, AWorldThatIsNoJson) {
    const Outcome outcome = print_changed({{"\"build\": [", "\"build\": [[["}});
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("postcard.fab.json:"));
}

TEST_F(BadInput, AnOpenMesh) {
    const Outcome outcome = print_changed({{"f 4/4 1/1 5/1", ""}}, "card.obj");
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("open"));
    EXPECT_THAT(outcome.err, HasSubstr("3"));  // three open edges
}

TEST_F(BadInput, AFullDisk) {
    const Outcome outcome = print_here({"-o", "/dev/full", "--format", "ofr"});
    EXPECT_EQ(outcome.exit_code, kOutside);
    EXPECT_THAT(outcome.err, HasSubstr("/dev/full"));
}

TEST_F(BadInput, AFolderThatCannotBeMade) {
    scratch().write("plain", "a file, not a folder");
    const Outcome outcome =
        print_here({"-o", (scratch() / "plain" / "slices").string(), "--format", "png"});
    EXPECT_EQ(outcome.exit_code, kOutside);
    EXPECT_THAT(outcome.err, HasSubstr("plain"));
}

TEST_F(BadInput, AnUnknownOption) {
    EXPECT_EQ(print_here({"--dithering", "none", "-o", (scratch() / "x.ofr").string()}).exit_code,
              kUsage);
    EXPECT_EQ(print_here({"--memory", "lots", "-o", (scratch() / "x.ofr").string()}).exit_code,
              kUsage);
}

TEST_F(BadInput, ABudgetThatIsTooSmallNamesTheLeast) {
    const Outcome outcome = print_here({"--memory", "5MB", "-o", (scratch() / "x.ofr").string()});
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("MB"));
    EXPECT_THAT(outcome.err, HasSubstr("--memory"));
}

TEST_F(BadInput, ATruncatedPrintIsGoodUpToItsLastWholeSlice) {
    const std::filesystem::path whole = scratch() / "whole.ofr", cut = scratch() / "cut.ofr";
    ASSERT_EQ(print_here({"-o", whole.string()}).exit_code, 0);
    const std::string bytes = read_file(whole);
    scratch().write("cut.ofr", bytes.substr(0, bytes.size() / 2));
    const Outcome good =
        run({program("openfab").string(), "verify", whole.string()}, environment());
    EXPECT_EQ(good.exit_code, 0) << good.err;
    const Outcome outcome =
        run({program("openfab").string(), "verify", cut.string()}, environment());
    EXPECT_EQ(outcome.exit_code, kUserInput);
    EXPECT_THAT(outcome.err, HasSubstr("cut.ofr"));
    EXPECT_THAT(outcome.err, HasSubstr("slice"));
}

TEST_F(BadInput, CtrlCKeepsWholeSlices) {
    const std::filesystem::path file = scratch() / "interrupted.ofr";
    RunOptions options = environment();
    options.interrupt_when = [](int, const Outcome& so_far) {
        return so_far.err.find("slice 1 of") != std::string::npos;
    };
    // Fine enough to take far longer than that.
    const Outcome outcome =
        run({binary().string(), (gallery_postcard() / "postcard.fab.json").string(), "--threads",
             "1", "--voxel", "0.02mm", "-o", file.string()},
            options);
    EXPECT_EQ(outcome.exit_code, kInterrupted) << outcome.err;
    auto reader = ofr::OfrReader::open(file.string());
    ASSERT_TRUE(reader) << reader.error().text();
    int slices = 0;
    for (;;) {
        Result<bool> more = (*reader)->next();
        if (!more || !*more) break;
        ++slices;
    }
    EXPECT_EQ(slices, (*reader)->whole_slices());
}

}  // namespace
}  // namespace openfab::testing
