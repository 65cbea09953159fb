// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What another print, or a hand, has left in the place of an output: it is not taken for slices of this one.

#include "tests/programs/print/resume.h"

namespace openfab::testing {
namespace {

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

}  // namespace
}  // namespace openfab::testing
