// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Programs whose libraries crash over a stranger's file: the library dies in a jail, and the program says of which file.

#include <gmock/gmock.h>

#include <csignal>
#include <cstring>
#include <filesystem>

#include "base/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

#ifndef OPENFAB_SANITIZED  // whose libraries have to be the first

class Converters : public ::testing::Test {
  protected:
    Outcome crash(std::vector<std::string> words) const {
        words.insert(words.begin(), program("openfab").string());
        RunOptions options;
        options.environment = {{"LD_PRELOAD", test_program("libcrashing_libraries.so").string()},
                               {"OPENFAB_CACHE", (scratch_ / "cache").string()}};
        options.folder = scratch_.path();
        return run(words, options);
    }
    void expect_told(const std::vector<std::string>& words, const std::string& file) const {
        SCOPED_TRACE(words[0]);
        const Outcome outcome = crash(words);
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_THAT(outcome.err,
                    Says(messages::kReaderCrashed, file, SIGABRT, ::strsignal(SIGABRT)));
    }

    ScratchFolder scratch_;
};

TEST_F(Converters, OfFontsDieInAJail) {
    scratch_.write("a.ttf", "no font");
    expect_told({"text", "Ada", "-o", "a.obj", "--font", "a.ttf"}, "a.ttf");
    EXPECT_FALSE(std::filesystem::exists(scratch_ / "a.obj"));
}

TEST_F(Converters, OfProfilesDieInAJail) {
    scratch_.write("a.icc", std::string(200, 'a'));
    expect_told({"color", "bake", "a.icc", "-o", "a.nrrd"}, "a.icc");
}

#ifdef OPENFAB_READS_STEP
TEST_F(Converters, OfStepDieInAJail) {
    scratch_.write("a.step", "ISO-10303-21;\n");
    expect_told({"import", "a.step", "-o", "a.fab.json"}, "a.step");
}
#endif

#ifdef OPENFAB_READS_VRML
TEST_F(Converters, OfVrmlDieInAJail) {
    scratch_.write("a.wrl", "#VRML V2.0 utf8\nShape { geometry Box { } }\n");
    expect_told({"import", "a.wrl", "-o", "a.fab.json"}, "a.wrl");
}
#endif

/// A font's program may write its output where folders are yet to be made, and shows what it made.
TEST_F(Converters, StillWriteAndShow) {
    const std::filesystem::path font = source_dir() / "tests/unit/text/variable.ttf";
    RunOptions options;
    options.folder = scratch_.path();
    const Outcome text = run({program("openfab").string(), "text", "A", "-o", "a.obj", "--font",
                              font.string() + ":wght=400"},
                             options);
    EXPECT_EQ(text.exit_code, 0) << text.err;
    EXPECT_THAT(text.out, ::testing::StartsWith("a.obj: "));
    const Outcome chart =
        run({program("openfab").string(), "color", "chart", "-o", "new/and/more"}, options);
    EXPECT_EQ(chart.exit_code, 0) << chart.err;
    EXPECT_TRUE(std::filesystem::exists(scratch_ / "new/and/more/chart.fab.json"));
}

#endif

}  // namespace
}  // namespace openfab::testing
