// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Prints that are interrupted by real signals and limits, and resumed: the bytes must be those of
// an undisturbed print.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <random>
#include <thread>

#include "backends/boundary/messages.h"
#include "backends/common/messages.h"
#include "backends/common/part_file.h"
#include "backends/ofr/messages.h"
#include "backends/ofr/ofr_reader.h"
#include "backends/ofr/ofr_sink.h"
#include "backends/raster/folder_sink.h"
#include "backends/raster/messages.h"
#include "base/sha256.h"
#include "program/messages.h"
#include "runtime/pipeline/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

#ifdef OPENFAB_SANITIZED
constexpr int kRounds = 1;
constexpr const char* kPitch = "0.2mm";
constexpr const char *kThird = "1", *kSixth = "2";  ///< drafts with about as many slices
#else
constexpr int kRounds = 5;
constexpr const char* kPitch = "0.08mm";
constexpr const char *kThird = "3", *kSixth = "6";
#endif
constexpr int kKillsARound = 4;

using Files = std::map<std::string, std::string>;

/// Maps names to contents.
Files files_of(const fs::path& folder) {
    Files files;
    if (!fs::exists(folder)) return files;  // killed before it was created
    for (const auto& entry : fs::directory_iterator(folder))
        files[entry.path().filename().string()] = read_file(entry.path());
    return files;
}

class Resume : public ::testing::Test {
  protected:
    Resume() {
        scratch_.write("f.fl", "fablet Skin {}\n");
        write_world("world.fab.json", R"({"sphere": 26})");
    }
    void write_world(const std::string& name, const std::string& mesh,
                     const std::string& black = "#000000", const std::string& place = "") {
        scratch_.write(name, fmt::format(R"({{
  "openfab": 1,
  "printer": "generic",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "Skin"}}}},
  "materials": {{
    "white": {{"key": "#ffffff", "preview": "#f0f0f0ff", "density_g_cm3": 1.18}},
    "black": {{"key": "{}", "preview": "#101010ff", "density_g_cm3": 1.18}}
  }},
  "meshes": {{"ball": {}}},
  "objects": {{"thing": {{"mesh": "ball", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}}}},
  "build": [{{"object": "thing"{}}}]
}}
)",
                                         black, mesh, place));
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(std::vector<std::string> arguments, const RunOptions& options = {}) {
        std::vector<std::string> argv{test_program("openfab_test_print_4"), path("world.fab.json"),
                                      "--voxel", kPitch};
        argv.insert(argv.end(), arguments.begin(), arguments.end());
        return run(argv, options);
    }
    /// Kills the print with SIGKILL, unless it ends sooner.
    Outcome killed_print(std::vector<std::string> arguments, int after_us) {
        RunOptions options;
        options.signal = SIGKILL;
        options.interrupt_when = [after_us](int elapsed_ms, const Outcome&) {
            const int left = after_us - elapsed_ms * 1000;
            if (left > 5000) return false;
            std::this_thread::sleep_for(std::chrono::microseconds(std::max(left, 0)));
            return true;
        };
        return print(std::move(arguments), options);
    }
    /// Returns the number of complete slices of a file; fails if its header is unreadable.
    int whole_slices(const std::string& name) {
        const Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(path(name));
        if (!reader) {
            EXPECT_THAT(reader.error().text(),
                        ::testing::AnyOf(testing::Says(ofr::messages::kTooShort),
                                         testing::Says(ofr::messages::kCutShortInHeader),
                                         testing::Says(ofr::messages::kCannotOpen)));
            return 0;
        }
        Result<bool> more = true;
        while ((more = (*reader)->next()) && *more) {
        }
        const int whole = (*reader)->whole_slices();
        if (!more) {
            const Outcome info = run({program("openfab"), "info", path(name)});
            EXPECT_EQ(info.exit_code, 0) << info.err;
            EXPECT_THAT(info.out, testing::Says(tools::messages::kSlicesWhole, whole));
        }
        return whole;
    }
    /// An undisturbed print of the same world, and its duration.
    int undisturbed(const std::vector<std::string>& arguments) {
        const auto start = std::chrono::steady_clock::now();
        const Outcome outcome = print(arguments);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return static_cast<int>(std::chrono::duration_cast<std::chrono::microseconds>(
                                    std::chrono::steady_clock::now() - start)
                                    .count());
    }

    ScratchFolder scratch_;
    std::mt19937 random_{20260101};
};

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

/// After a power loss names of an earlier print may be there again, with its digests.
TEST_F(Resume, SlicesOfAnotherPrintInTheFolderAreMadeAgain) {
    for (const std::string format : {"png", "bmp"}) {
        const auto arguments = [&](const std::string& folder, const std::string& seed) {
            return std::vector<std::string>{"-o",      path(folder), "--format", format,
                                            "--draft", "2",          "--seed",   seed};
        };
        undisturbed(arguments("other" + format, "7"));
        undisturbed(arguments("whole" + format, "8"));
        const Files other = files_of(path("other" + format)),
                    expected = files_of(path("whole" + format));
        int differ = 0;
        for (const auto& [name, bytes] : expected)
            differ += name.starts_with("slice_") && other.at(name) != bytes ? 1 : 0;
        ASSERT_GT(differ, 20);  // the dither is of the seed
        // Killed, with the first slices and their digests; then the others of both kinds come back.
        for (const bool with_digests : {false, true}) {
            fs::remove_all(path("a"));
            const std::string third =
                path(format == "png" ? "a/slice_0003.png" : "a/slice_0003_1.bmp");
            RunOptions killed;
            killed.signal = SIGKILL;
            killed.interrupt_when = [&](int, const Outcome&) { return fs::exists(third); };
            std::vector<std::string> first = arguments("a", "8");
            first.insert(first.end(), {"--threads", "1"});
            ASSERT_NE(print(first, killed).exit_code, 0);
            for (const auto& [name, bytes] : other) {
                const bool back =
                    name.starts_with("slice_") || (with_digests && name.starts_with("SHA"));
                if (back && !fs::exists(path("a/" + name))) scratch_.write("a/" + name, bytes);
            }
            std::vector<std::string> again = arguments("a", "8");
            again.push_back("--resume");
            const Outcome outcome = print(again);
            ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
            EXPECT_TRUE(files_of(path("a")) == expected) << format << with_digests;
        }
        // Two slices of the same print, exchanged after its end.
        const std::string end = format == "png" ? ".png" : "_1.bmp";
        fs::rename(path("a/slice_0020" + end), path("a/x"));
        fs::rename(path("a/slice_0021" + end), path("a/slice_0020" + end));
        fs::rename(path("a/x"), path("a/slice_0021" + end));
        std::vector<std::string> again = arguments("a", "8");
        again.push_back("--resume");
        EXPECT_THAT(print(again).err, HasSubstr("(19 resumed)"));
        EXPECT_TRUE(files_of(path("a")) == expected) << format;
    }
}

/// Exchanged by hand, with all that is recorded of it: a slice of another print, and two of this one.
TEST_F(Resume, SlicesThatWereExchangedWithTheirDigestsAreMadeAgain) {
    const auto arguments = [&](const std::string& folder, const std::string& seed) {
        return std::vector<std::string>{"-o",      path(folder), "--format", "png",
                                        "--draft", "2",          "--seed",   seed};
    };
    undisturbed(arguments("other", "7"));
    undisturbed(arguments("whole", "8"));
    const Files other = files_of(path("other")), expected = files_of(path("whole"));
    const std::string twenty = "slice_0020.png", next = "slice_0021.png";
    ASSERT_NE(other.at(twenty), expected.at(twenty));
    ASSERT_NE(expected.at(next), expected.at(twenty));
    // The digests of a name: those of the file, and that which its print gave it.
    const auto recorded = [](const std::string& manifest, const std::string& name) {
        std::vector<std::string> digests;
        const std::string before = '"' + name + "\": \"";
        for (size_t at = manifest.find(before); at != std::string::npos;
             at = manifest.find(before, at + 1))
            digests.push_back(manifest.substr(at + before.size(), 64));
        return digests;
    };
    const auto replace = [](std::string* text, const std::string& from, const std::string& to) {
        ASSERT_NE(text->find(from), std::string::npos);
        text->replace(text->find(from), from.size(), to);
    };
    // Puts what lies in `from` under `source` in the place `name`.
    const auto put = [&](const Files& from, const std::string& source, const std::string& name) {
        std::string manifest = read_file(path("a/manifest.json"));
        const auto there = recorded(from.at("manifest.json"), source),
                   here = recorded(expected.at("manifest.json"), name);
        ASSERT_EQ(there.size(), here.size());
        ASSERT_GE(here.size(), 1U);
        for (size_t i = 0; i < here.size(); ++i)
            replace(&manifest, '"' + name + "\": \"" + here[i], '"' + name + "\": \"" + there[i]);
        const std::string before = read_file(path("a/manifest.json"));
        std::string sums = read_file(path("a/SHA256SUMS"));
        replace(&sums, here[0] + "  " + name, there[0] + "  " + name);
        replace(&sums, hex_text(sha256(before)), hex_text(sha256(manifest)));
        scratch_.write("a/manifest.json", manifest);
        scratch_.write("a/SHA256SUMS", sums);
        scratch_.write("a/" + name, from.at(source));
    };
    std::vector<std::string> again = arguments("a", "8");
    again.push_back("--resume");
    for (const bool of_another : {true, false}) {
        fs::remove_all(path("a"));
        fs::copy(path("whole"), path("a"));
        put(of_another ? other : expected, of_another ? twenty : next, twenty);
        if (!of_another) put(expected, twenty, next);
        EXPECT_EQ(run({"/bin/sh", "-c",
                       "cd '" + path("a") + "' && sha256sum --check --strict SHA256SUMS"})
                      .exit_code,
                  0);
        const Outcome told = run({program("openfab"), "verify", path("a")});
        EXPECT_EQ(told.exit_code, 1);
        EXPECT_THAT(told.err, HasSubstr(fmt::format(tools::messages::kFileOfOther, twenty)));
        EXPECT_THAT(print(again).err, HasSubstr("(19 resumed)"));
        EXPECT_TRUE(files_of(path("a")) == expected) << of_another;
    }
}

/// What lies in the place of a slice, and is none.
TEST_F(Resume, APlaceThatIsTakenIsTold) {
    const std::vector<std::string> arguments{"-o", path("a"), "--format", "png", "--draft", "4"};
    undisturbed(arguments);
    const Files expected = files_of(path("a"));
    std::vector<std::string> again = arguments;
    again.push_back("--resume");
    for (const std::string name : {"slice_0003.png", "manifest.json"}) {
        for (const bool folder : {true, false}) {
            fs::remove(path("a/" + name));
            if (folder) {
                fs::create_directories(path("a/" + name + "/sub"));
            } else {
                ASSERT_EQ(::mkfifo(path("a/" + name).c_str(), 0600), 0);
            }
            const Outcome refused = print(again);
            EXPECT_EQ(refused.exit_code, 1);
            EXPECT_THAT(refused.err,
                        HasSubstr(fmt::format(
                            raster::messages::kNotAFile, path("a/" + name),
                            folder ? raster::messages::kIsAFolder : raster::messages::kIsNoFile)));
            fs::remove_all(path("a/" + name));
            scratch_.write("a/" + name, expected.at(name));
        }
    }
    // A link to what the slice was is as good as the slice.
    fs::rename(path("a/slice_0003.png"), path("elsewhere"));
    fs::create_symlink(path("elsewhere"), path("a/slice_0003.png"));
    EXPECT_EQ(print(again).exit_code, 0);
    EXPECT_TRUE(files_of(path("a")) == expected);
}

/// Who seals other slices for a print contradicts the hash of all of them, which is of the voxels.
TEST_F(Resume, SlicesThatContradictTheHashOfThePrintAreMadeAgain) {
    const std::vector<std::string> arguments{"-o", path("a"), "--format", "png", "--draft", "4"};
    undisturbed(arguments);
    const Files expected = files_of(path("a"));
    std::string manifest = expected.at("manifest.json");
    const size_t at = manifest.find("\"hash\": \"");
    ASSERT_NE(at, std::string::npos);
    char& digit = manifest[at + 9];
    digit = digit == '0' ? '1' : '0';
    scratch_.write("a/manifest.json", manifest);
    std::vector<std::string> again = arguments;
    again.push_back("--resume");
    const Outcome refused = print(again);
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, testing::Says(raster::messages::kHashOfOther));
    EXPECT_EQ(print(again).exit_code, 0);
    EXPECT_TRUE(files_of(path("a")) == expected);
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

TEST_F(Resume, AnotherPrintIsRefusedAndLosesNothing) {
    const std::vector<std::string> ofr{"-o", path("a.ofr"), "--draft", "6", "--resume"};
    const std::vector<std::string> png{"-o",      path("a"), "--format", "png",
                                       "--draft", "6",       "--resume"};
    scratch_.write(
        "own.printer.json",
        R"({"name": "own", "pitch_mm": [0.1, 0.1, 0.1], "build_volume_mm": [99, 99, 99]})");
    ASSERT_EQ(print(ofr).exit_code, 0);
    ASSERT_EQ(print(png).exit_code, 0);
    const std::string file = read_file(path("a.ofr"));
    scratch_.write("a.ofr", file.substr(0, file.size() * 2 / 3));
    fs::remove(path("a/slice_0031.png"));
    const std::string cut = read_file(path("a.ofr"));
    const Files slices = files_of(path("a"));
    const auto refused = [&](std::vector<std::string> arguments, const std::string& why) {
        const Outcome outcome = print(std::move(arguments));
        EXPECT_EQ(outcome.exit_code, 1) << why;
        EXPECT_THAT(outcome.err, testing::Says(backends::messages::kResumeRefused));
        EXPECT_THAT(outcome.err, HasSubstr(why));
        EXPECT_TRUE(read_file(path("a.ofr")) == cut) << why;
        EXPECT_TRUE(files_of(path("a")) == slices) << why;
    };
    const auto both_refuse = [&](const std::vector<std::string>& option, const std::string& why) {
        for (std::vector<std::string> arguments : {ofr, png}) {
            arguments.insert(arguments.end(), option.begin(), option.end());
            refused(arguments, why);
        }
    };
    both_refuse({"--dither", "decorrelated"},
                fmt::format(backends::messages::kIsOther, "dither", "blue_noise", "decorrelated"));
    both_refuse({"--seed", "7"}, fmt::format(backends::messages::kIsOther, "seed", "0", "7"));
    both_refuse({"--set", "thing.a=black"},
                fmt::format(backends::messages::kNotTheSame, "uniforms"));
    both_refuse({"--printer", path("own.printer.json")},
                fmt::format(backends::messages::kIsOther, "printer", "generic", "own"));
    refused({"-o", path("a.ofr"), "--resume", "--draft", "7"}, backends::messages::kPitchInMm);
    std::vector<std::string> part = ofr;
    part.insert(part.end(), {"--slices", "0:9"});
    refused(part, backends::messages::kRangeOfSlices);
    for (const auto& [option, why] : std::map<std::string, std::string>{
             {"--flip-x", "image_right"},
             {"--png=indexed",
              fmt::format(backends::messages::kIsOther, "color_mode", "rgba", "indexed")}}) {
        std::vector<std::string> arguments = png;
        arguments.push_back(option);
        refused(arguments, why);
    }
    write_world("world.fab.json", R"({"box": [26, 26, 26]})");
    both_refuse({}, fmt::format(backends::messages::kNotTheSame, "meshes"));
    write_world("world.fab.json", R"({"sphere": 26})", "#000001");
    both_refuse({}, "#000001");
    write_world("world.fab.json", R"({"sphere": 26})", "#000000", R"(, "rotate_deg": [0, 0, 9])");
    both_refuse({}, fmt::format(backends::messages::kNotTheSame, "placements"));
    write_world("world.fab.json", R"({"sphere": 26})");
    EXPECT_EQ(print(ofr).exit_code, 0);
    EXPECT_TRUE(read_file(path("a.ofr")) == file);
}

TEST_F(Resume, SlicesThatComeOutOtherwiseAreRefused) {
    // Changes that no header shows: another program, a bug, corruption on the disk.
    undisturbed({"-o", path("a.ofr"), "--draft", kSixth});
    undisturbed({"-o", path("b.ofr"), "--draft", kSixth, "--seed", "1"});
    Result<std::unique_ptr<ofr::OfrReader>> header = ofr::OfrReader::open(path("a.ofr"));
    Result<std::unique_ptr<ofr::OfrReader>> slices = ofr::OfrReader::open(path("b.ofr"));
    ASSERT_TRUE(header && slices);
    Result<std::unique_ptr<pipeline::SliceSink>> forged = ofr::OfrSink::create(path("c.ofr"));
    ASSERT_TRUE(forged);
    ASSERT_TRUE((*forged)->begin((*header)->info()));
    for (int32_t z = 0; z < 30; ++z) {
        ASSERT_TRUE((*slices)->next());
        ASSERT_TRUE((*forged)->commit(z, (*forged)->encode((*slices)->slice())));
    }
    ASSERT_TRUE((*forged)->finish({}));
    forged->reset();
    const std::string bytes = read_file(path("c.ofr"));
    const Outcome outcome = print({"-o", path("c.ofr"), "--draft", kSixth, "--resume"});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, testing::Says(pipeline::messages::kSliceDiffers));
    EXPECT_TRUE(read_file(path("c.ofr")) == bytes);
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
