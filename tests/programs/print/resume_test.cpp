// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Prints that are interrupted by real signals and limits, and resumed: the bytes must be those of
// an undisturbed print.

#include "tests/programs/print/resume.h"

namespace openfab::testing {
namespace {

TEST_F(Resume, KilledAtAnyMomentAFileEndsWithTheSameBytes) {
    const int whole_us = undisturbed({"-o", path("whole.ofr")});
    const std::string expected = read_file(path("whole.ofr"));
    std::uniform_int_distribution<int> moment(0, whole_us * 9 / 10 / kKillsARound * 2);
    const std::vector<std::vector<std::string>> ways{
        {"--threads", "1"}, {"--threads", "3", "--memory", "200MB"}, {"--no-cull"}, {}};
    int killed = 0, with_slices = 0;
    for (int round = 0; round < kRounds; ++round) {
        fs::remove(path("a.ofr"));
        int before = 0;
        for (int kill = 0; kill < kKillsARound; ++kill) {
            std::vector<std::string> arguments{"-o", path("a.ofr"), "--resume"};
#ifndef OPENFAB_SANITIZED
            const auto& way = ways[static_cast<size_t>(kill) % ways.size()];
            arguments.insert(arguments.end(), way.begin(), way.end());
#endif
            const Outcome outcome = killed_print(arguments, moment(random_));
            EXPECT_THAT(outcome.exit_code, ::testing::AnyOf(0, 128 + SIGKILL)) << outcome.err;
            killed += outcome.exit_code == 0 ? 0 : 1;
            const int now = whole_slices("a.ofr");
            EXPECT_GE(now, before);  // no complete slice is lost
            with_slices += now > before ? 1 : 0;
            before = now;
        }
        const Outcome last = print({"-o", path("a.ofr"), "--resume"});
        ASSERT_EQ(last.exit_code, 0) << last.err;
        ASSERT_TRUE(read_file(path("a.ofr")) == expected) << "round " << round;
    }
    // Otherwise the print was too short for the test to mean anything.
    EXPECT_GE(killed, kRounds * kKillsARound / 2);
#ifndef OPENFAB_SANITIZED  // there most of the time goes before the first slice
    EXPECT_GE(with_slices, kRounds);
#endif
}

TEST_F(Resume, KilledAtAnyMomentAFolderEndsWithTheSameFiles) {
    const int whole_us = undisturbed({"-o", path("whole"), "--format", "png", "--draft", "2"});
    const Files expected = files_of(path("whole"));
    std::uniform_int_distribution<int> moment(whole_us / 20, whole_us / 2);
    const std::vector<std::string> arguments{"-o",      path("a"), "--format", "png",
                                             "--draft", "2",       "--resume"};
    for (int kill = 0; kill < std::min(kRounds, 3); ++kill) {
        killed_print(arguments, moment(random_));
        // A file with the name of a slice is complete.
        for (const auto& [name, bytes] : files_of(path("a"))) {
            if (!name.starts_with("slice_") || !name.ends_with(".png")) continue;
            EXPECT_TRUE(bytes == expected.at(name)) << name;
        }
    }
    const Outcome last = print(arguments);
    ASSERT_EQ(last.exit_code, 0) << last.err;
    EXPECT_TRUE(files_of(path("a")) == expected);
}

TEST_F(Resume, SlicesThatAreNotWholeAreMadeAgain) {
    const std::vector<std::string> arguments{"-o",      path("a"), "--format", "png",
                                             "--draft", "4",       "--png",    "indexed"};
    undisturbed(arguments);
    const Files expected = files_of(path("a"));
    // As it stands when the print is killed.
    std::string manifest = read_file(path("a/manifest.json"));
    const std::string whole = "\"complete\": true";
    ASSERT_NE(manifest.find(whole), std::string::npos);
    manifest.replace(manifest.find(whole), whole.size(), "\"complete\": false");
    scratch_.write("a/manifest.json", manifest);
    const Outcome told = run({program("openfab"), "info", path("a")});
    EXPECT_THAT(told.out, testing::Says(tools::messages::kFolderIncomplete, expected.size() - 3));
    std::vector<std::string> again = arguments;
    again.push_back("--resume");
    // Files after a power failure: renamed but empty or full of zeros; and a part that was never
    // renamed.
    for (const std::string& damage : {std::string(), std::string(900, '\0'), std::string("x")}) {
        scratch_.write("a/slice_0011.png", damage);
        scratch_.write("a/slice_0013.png.part", "x");
        const Outcome outcome = print(again);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("(10 resumed)"));
        EXPECT_TRUE(files_of(path("a")) == expected);
    }
}

TEST_F(Resume, GreyPicturesGoOn) {
    for (const char* format : {"grey", "tiff16"}) {
        const auto arguments = [&](const std::string& folder) {
            return std::vector<std::string>{"-o",
                                            path(folder),
                                            "--format",
                                            format,
                                            "--draft",
                                            kSixth,
                                            "--fractions-supersample",
                                            "2"};
        };
        const std::string whole = std::string("whole") + format, cut = std::string("cut") + format;
        undisturbed(arguments(whole));
        const Files expected = files_of(path(whole));
        fs::copy(path(whole), path(cut));
        const std::string end = std::string(format) == "grey" ? ".png" : ".tif";
        ASSERT_TRUE(fs::remove(path(cut + "/slice_0012" + end)));
        std::vector<std::string> again = arguments(cut);
        again.push_back("--resume");
        for (int i = 0; i < 2; ++i) {  // the second time all are there
            const Outcome outcome = print(again);
            ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
            EXPECT_TRUE(files_of(path(cut)) == expected) << format;
        }
        again.insert(again.end(), {"--seed", "9"});
        EXPECT_EQ(print(again).exit_code, 1);
        EXPECT_TRUE(files_of(path(cut)) == expected) << format;
    }
}

TEST_F(Resume, TotalsAndPicturesAreThoseOfTheWholePrint) {
    const std::vector<std::string> range{"--draft", kThird, "--slices", "13:61"};
    const auto arguments = [&](std::vector<std::string> more) {
        more.insert(more.end(), range.begin(), range.end());
        return more;
    };
    const auto with_all = [&](const std::string& name) {
        return arguments({"-o", path(name + ".ofr"), "--stats", path(name + ".json"), "--preview",
                          path(name + ".png"), "--resume"});
    };
    ASSERT_EQ(print(with_all("a")).exit_code, 0);  // no output yet: an ordinary print
    // Truncated in the middle of a slice.
    const std::string bytes = read_file(path("a.ofr"));
    scratch_.write("b.ofr", bytes.substr(0, bytes.size() / 2));
    const Outcome outcome = print(with_all("b"));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(read_file(path("b.ofr")) == bytes);
    EXPECT_TRUE(read_file(path("b.png")) == read_file(path("a.png")));
    rapidjson::Document a, b;
    a.Parse(read_file(path("a.json")).c_str());
    b.Parse(read_file(path("b.json")).c_str());
    EXPECT_FALSE(a.HasMember("slices_kept"));
    const int kept = b["slices_kept"].GetInt();
    EXPECT_GT(kept, 4);
    EXPECT_LT(kept, 44);
    for (const char* same : {"hash", "complete", "slices", "voxels_total", "voxels_solid",
                             "voxels_by_material", "ml_by_material", "g_by_material"})
        EXPECT_TRUE(a[same] == b[same]) << same;
    // Once more: it is complete.
    const Outcome done = print(with_all("b"));
    EXPECT_EQ(done.exit_code, 0);
    EXPECT_THAT(done.err, HasSubstr("48 slices (48 resumed)"));
    EXPECT_TRUE(read_file(path("b.ofr")) == bytes);
}

TEST_F(Resume, WhatKeepsNothingIsRefused) {
    for (const char* output : {"a.3mf", "a.stl"}) {
        const Outcome outcome = print({"-o", path(output), "--resume"});
        EXPECT_EQ(outcome.exit_code, 2);
        EXPECT_THAT(outcome.err, testing::Says(boundary::messages::kMeshNotResumed));
    }
    EXPECT_EQ(print({"-o", "/dev/null", "--format", "ofr", "--resume"}).exit_code, 2);
    EXPECT_EQ(print({"-o", "-", "--resume"}).exit_code, 2);
    scratch_.write("letter.ofr", "dear ");
    EXPECT_EQ(print({"-o", path("letter.ofr"), "--resume"}).exit_code, 1);
    EXPECT_EQ(read_file(path("letter.ofr")), "dear ");
}

TEST_F(Resume, AFullDiskIsGoneOnWithOnceThereIsRoom) {
#ifdef OPENFAB_SANITIZED  // slices of the coarse print are smaller than the manifest
    const std::vector<std::string> names{"a.ofr"};
    const std::string range = "30:120";
#else
    const std::vector<std::string> names{"a.ofr", "a"};
    const std::string range = "90:180";
#endif
    for (const std::string& name : names) {
        std::vector<std::string> arguments{
            "-o", path("whole" + name), "--slices", range, "--format", name == "a" ? "png" : "ofr"};
        if (name == "a") arguments.insert(arguments.end(), {"--png", "indexed"});
        undisturbed(arguments);
        arguments[1] = path(name);
        RunOptions full;
        // The middle slices of a ball, which follow, are the largest.
        const std::string middle = path("whole" + name) + "/slice_0110.png";
        full.largest_file_bytes = static_cast<int64_t>(
            name == "a" ? fs::file_size(middle) : fs::file_size(path("wholea.ofr")) / 2);
        const Outcome outcome = print(arguments, full);
        EXPECT_EQ(outcome.exit_code, 3);
        EXPECT_THAT(outcome.err,
                    HasSubstr(std::string(backends::messages::kCannotWriteTo) + " `" + path(name)));
        EXPECT_THAT(outcome.err, HasSubstr("File too large"));
        EXPECT_THAT(outcome.err, testing::Says(backends::messages::kWholeSlicesBefore));
        EXPECT_THAT(outcome.err, Says(program::messages::kResumeHelp));
        if (name != "a") {
            EXPECT_GT(whole_slices(name), 10);
            EXPECT_LE(static_cast<int64_t>(fs::file_size(path(name))), full.largest_file_bytes);
        }
        arguments.push_back("--resume");
        ASSERT_EQ(print(arguments).exit_code, 0);
        if (name == "a") {
            EXPECT_TRUE(files_of(path(name)) == files_of(path("whole" + name)));
        } else {
            EXPECT_TRUE(read_file(path(name)) == read_file(path("whole" + name)));
        }
    }
}

TEST_F(Resume, InterruptedGoesOn) {
    undisturbed({"-o", path("whole.ofr")});
    RunOptions options;
    options.interrupt_when = [](int, const Outcome& so_far) {
        return so_far.err.find("slice ") != std::string::npos;
    };
    const Outcome outcome = print({"-o", path("a.ofr"), "--progress", "plain"}, options);
    EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("`--resume` continues"));
    EXPECT_EQ(print({"-o", path("a.ofr"), "--resume"}).exit_code, 0);
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("whole.ofr")));
}

TEST_F(Resume, TwoWritersAreRefused) {
    const auto refused = [&](const std::string& output, const std::string& format) {
        for (const bool resume : {false, true}) {
            std::vector<std::string> arguments{"-o", path(output), "--draft",
                                               "9",  "--format",   format};
            if (resume && format == "3mf") continue;
            if (resume) arguments.push_back("--resume");
            const Outcome outcome = print(arguments);
            EXPECT_EQ(outcome.exit_code, 3) << output;
            EXPECT_THAT(outcome.err, testing::Says(backends::messages::kBeingWritten));
            // In some containers the kernel's list of locks has other numbers.
            if (outcome.err.find(backends::messages::kAnotherProcess) != std::string::npos)
                continue;
            EXPECT_THAT(outcome.err, HasSubstr(fmt::format(backends::messages::kProcessNamed,
                                                           ::getpid(), "print_resume_test")));
        }
    };
    {
        const Result<std::unique_ptr<pipeline::SliceSink>> file =
            ofr::OfrSink::create(path("a.ofr"));
        ASSERT_TRUE(file);
        scratch_.write("a.ofr", "what the first one has written");
        refused("a.ofr", "ofr");
        EXPECT_EQ(read_file(path("a.ofr")), "what the first one has written");
        const Result<std::unique_ptr<pipeline::SliceSink>> folder =
            raster::FolderSink::create(path("a"), {});
        ASSERT_TRUE(folder);
        refused("a", "png");
        const Result<std::unique_ptr<backends::PartFile>> mesh =
            backends::PartFile::create(path("a.3mf"));
        ASSERT_TRUE(mesh);
        refused("a.3mf", "3mf");
    }
    for (const auto& [output, format] :
         std::map<std::string, std::string>{{"a.ofr", "ofr"}, {"a", "png"}, {"a.3mf", "3mf"}}) {
        EXPECT_EQ(print({"-o", path(output), "--draft", "9", "--format", format}).exit_code, 0);
    }
}

}  // namespace
}  // namespace openfab::testing
