// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/output_check.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include "backends/formats/formats.h"
#include "program/messages.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::program {
namespace {

using openfab::testing::Says;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class OutputCheck : public ::testing::Test {
  protected:
    OutputCheck() {
        scratch_.write("in.3mf", "mesh");
        fs::create_directories(scratch_ / "folder");
        scratch_.write("folder/slice_0002.png", "picture");
        scratch_.write("folder/leaf.png", "picture");
    }
    fs::path path(const std::string& name) const { return scratch_ / name; }
    static std::string check(const OutputOptions& options, const std::string& format,
                             const std::vector<fs::path>& inputs) {
        const std::vector<pipeline::SliceMaterial> materials{{"white", {}, {}, 1, ""},
                                                             {"a b", {}, {}, 1, ""}};
        const Result<void> done =
            check_outputs(options, backends::find_format(format), materials, inputs);
        if (done) return "";
        EXPECT_EQ(done.error().code, ErrorCode::kUserInput);
        return done.error().text();
    }
    std::string output(const fs::path& output, const std::string& format) const {
        OutputOptions options;
        options.output = output.string();
        return check(options, format, {path("in.3mf"), path("folder/slice_0002.png")});
    }

    testing::ScratchFolder scratch_;
};

TEST_F(OutputCheck, AnInputUnderAnyOfItsNamesIsRefused) {
    fs::create_symlink("in.3mf", path("soft"));
    fs::create_hard_link(path("in.3mf"), path("hard"));
    fs::create_directory_symlink("folder", path("way"));
    for (const fs::path& name :
         {path("in.3mf"), path("soft"), path("hard"), path(".") / "folder" / ".." / "in.3mf",
          path("way") / ".." / "in.3mf", path("folder/slice_0002.png"),
          path("way") / "slice_0002.png"}) {
        EXPECT_THAT(output(name, "ofr"), Says(messages::kWouldOverwrite)) << name;
        EXPECT_THAT(output(name, "3mf"), Says(messages::kWouldOverwrite)) << name;
    }
    EXPECT_EQ(output(path("out.3mf"), "3mf"), "");
    EXPECT_EQ(output(path("in.3mg"), "ofr"), "");
    EXPECT_EQ(output("-", "ofr"), "");
    EXPECT_EQ(output("/dev/null", "ofr"), "");
}

TEST_F(OutputCheck, ATemporaryNameCountsToo) {
    scratch_.write("out.3mf.part", "an input of a strange name");
    OutputOptions options;
    options.output = path("out.3mf").string();
    EXPECT_THAT(check(options, "3mf", {path("out.3mf.part")}), Says(messages::kWouldOverwrite));
    EXPECT_EQ(check(options, "ofr", {path("out.3mf.part")}), "");
}

TEST_F(OutputCheck, StlIsAFileForEachMaterial) {
    scratch_.write("lid_white.stl", "mesh");
    scratch_.write("lid_a_b.stl", "mesh");
    scratch_.write("lid_red.stl", "mesh");
    OutputOptions options;
    options.output = path("lid.stl").string();
    EXPECT_THAT(check(options, "stl", {path("lid_white.stl")}), HasSubstr("lid_white.stl"));
    EXPECT_THAT(check(options, "stl", {path("lid_a_b.stl")}), Says(messages::kWouldOverwrite));
    EXPECT_EQ(check(options, "stl", {path("lid_red.stl"), path("in.3mf")}), "");
}

TEST_F(OutputCheck, TwoOutputsAreTwoFiles) {
    fs::create_symlink("later.png", path("dangling.png"));
    OutputOptions options;
    options.output = path("a.ofr").string();
    options.stats_file = path("a.json").string();
    options.previews.resize(2);
    const auto with = [&](const fs::path& one, const fs::path& two) {
        options.previews[0].file = one.string();
        options.previews[1].file = two.string();
        return check(options, "ofr", {path("in.3mf")});
    };
    EXPECT_EQ(with(path("a.png"), path("b.png")), "");
    EXPECT_THAT(with(path("a.png"), path("a.png")), Says(messages::kOutputsAreOneFile));
    EXPECT_THAT(with(path("later.png"), path("dangling.png")), Says(messages::kOutputsAreOneFile));
    EXPECT_THAT(with(path("new.png"), path(".") / "folder" / ".." / "new.png"),
                Says(messages::kOutputsAreOneFile));
    EXPECT_THAT(with(path("a.json"), path("b.png")), HasSubstr("`--stats"));
    EXPECT_THAT(with(path("a.ofr"), path("b.png")), HasSubstr("`-o"));
    EXPECT_THAT(with(path("in.3mf"), path("b.png")), Says(messages::kWhichIsAnInput));
    EXPECT_EQ(with("/dev/null", "/dev/null"), "");
}

TEST_F(OutputCheck, FilesOfTheHostCountToo) {
    OutputOptions options;
    const auto with = [&](const fs::path& file, const std::string& format) {
        options.more_outputs = {{"--json", file}};
        return check(options, format, {path("in.3mf")});
    };
    for (const std::string format : {"ofr", "png"}) {
        EXPECT_THAT(with(path("in.3mf"), format), HasSubstr("`--json")) << format;
        EXPECT_THAT(with(path("folder"), format), Says(messages::kOutputIsAFolder)) << format;
        EXPECT_EQ(with(path("p.json"), format), "") << format;
        EXPECT_EQ(with("/dev/null", format), "") << format;
    }
    options.stats_file = path("p.json");
    EXPECT_THAT(with(path("p.json"), "ofr"), Says(messages::kOutputsAreOneFile));
}

TEST_F(OutputCheck, PicturesOfTheHostAreNoFiles) {
    OutputOptions options;
    options.previews.resize(2);
    EXPECT_EQ(check(options, "ofr", {}), "");
}

TEST_F(OutputCheck, AFileWithoutAFolderIsToldBeforeTheWork) {
    OutputOptions options;
    options.more_outputs = {{"--json", path("none/p.json")}};
    const Result<void> done = check_outputs(options, nullptr, {}, {});
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kOutside);
    EXPECT_THAT(done.error().text(), HasSubstr("none/p.json`: No such file"));
}

TEST_F(OutputCheck, AFolderOfSlicesSparesItsNeighbours) {
    const std::string folder = path("folder").string();
    EXPECT_THAT(output(folder, "png"), HasSubstr("slice_0002.png"));
    EXPECT_THAT(output(folder + "/", "png"), HasSubstr("slice_0002.png"));
    EXPECT_EQ(output(path("elsewhere"), "png"), "");
    OutputOptions options;
    options.output = folder;
    // Other files are left to the sink, which requires such a folder to be empty.
    EXPECT_EQ(check(options, "png", {path("folder/leaf.png")}), "");
    EXPECT_THAT(check(options, "png", {path("folder/manifest.json")}),
                Says(messages::kWouldOverwrite));
    // A link in the folder that has the name of a slice, and points to an input.
    fs::create_directories(path("linked"));
    fs::create_hard_link(path("in.3mf"), path("linked/slice_0009.png"));
    EXPECT_THAT(output(path("linked"), "png"), Says(messages::kWouldOverwrite));

    options.output = path("new").string();
    options.stats_file = path("new/manifest.json").string();
    EXPECT_THAT(check(options, "png", {}), Says(messages::kWouldOverwrite));
    options.stats_file = path("new.json").string();
    EXPECT_EQ(check(options, "png", {}), "");
}

}  // namespace
}  // namespace openfab::program
