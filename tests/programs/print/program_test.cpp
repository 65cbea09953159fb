// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The print program as a black box: its outputs, messages and exit codes.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <algorithm>

#include "backends/common/messages.h"
#include "backends/gcvf/messages.h"
#include "backends/ofr/messages.h"
#include "backends/ofr/ofr_reader.h"
#include "program/messages.h"
#include "runtime/pipeline/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

bool has_printed_a_slice(int /*elapsed_ms*/, const Outcome& so_far) {
    return so_far.err.find("slice 1 of") != std::string::npos;
}

class PrintProgram : public ::testing::Test {
  protected:
    PrintProgram() {
        scratch_.write("f.fl", "fablet Skin {}\n");
        write_world("world.fab.json", "Skin", "[6, 4, 3]");
    }
    void write_world(const std::string& name, const std::string& fablet, const std::string& box) {
        scratch_.write(name, fmt::format(R"({{
  "openfab": 1,
  "printer": "generic",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "{}"}}}},
  "materials": {{
    "white": {{"key": "#ffffff", "preview": "#f0f0f0ff", "density_g_cm3": 1.18}},
    "black": {{"key": "#000000", "preview": "#101010ff", "density_g_cm3": 1.18}}
  }},
  "meshes": {{"block": {{"box": {}}}}},
  "objects": {{"thing": {{"mesh": "block", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}}}},
  "build": [{{"object": "thing"}}]
}}
)",
                                         fablet, box));
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(std::vector<std::string> arguments, const RunOptions& options = {},
                  const std::string& world = "world.fab.json") {
        std::vector<std::string> argv{test_program("openfab_test_print_4"), path(world)};
        argv.insert(argv.end(), arguments.begin(), arguments.end());
        return run(argv, options);
    }
    static Outcome openfab(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), program("openfab"));
        return run(arguments);
    }
    std::vector<std::string> slices_of(const std::string& folder) const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(scratch_ / folder))
            names.push_back(entry.path().filename().string());
        std::sort(names.begin(), names.end());
        return names;
    }

    ScratchFolder scratch_;
};

TEST_F(PrintProgram, AFileAndAStreamAreTheSame) {
    const Outcome file = print({"-o", path("a.ofr")});
    ASSERT_EQ(file.exit_code, 0) << file.err;
    EXPECT_EQ(file.out, "");
    const Outcome stream = print({"-o", "-", "--threads", "2", "--no-cull"});
    ASSERT_EQ(stream.exit_code, 0) << stream.err;
    EXPECT_TRUE(stream.out == read_file(path("a.ofr")));
    const Outcome verified = openfab({"verify", path("a.ofr")});
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
    EXPECT_THAT(verified.err, testing::Says(tools::messages::kAllSlicesWhole, "*", 30));
}

TEST_F(PrintProgram, ExportGivesTheFilesOfADirectPrint) {
    const std::vector<std::vector<std::string>> kinds{{}, {"--png", "indexed", "--flip-x"}};
    for (const std::vector<std::string>& kind : kinds) {
        std::vector<std::string> direct{"-o", path("direct"), "--format", "png"};
        direct.insert(direct.end(), kind.begin(), kind.end());
        ASSERT_EQ(print(direct).exit_code, 0);
        ASSERT_EQ(print({"-o", path("a.ofr")}).exit_code, 0);
        std::vector<std::string> exported{"export", path("a.ofr"), "-o", path("exported")};
        exported.insert(exported.end(), kind.begin(), kind.end());
        const Outcome outcome = openfab(exported);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::vector<std::string> names = slices_of("direct");
        EXPECT_EQ(names.size(), 33u);  // 30 slices, the manifest, digests, the note
        EXPECT_EQ(slices_of("exported"), names);
        for (const std::string& name : names) {
            EXPECT_TRUE(read_file(scratch_ / "direct" / name) ==
                        read_file(scratch_ / "exported" / name))
                << name;
        }
    }
}

TEST_F(PrintProgram, ExportOfOneSliceAndOfPictures) {
    ASSERT_EQ(print({"-o", path("a.ofr"), "--preview", path("p.png")}).exit_code, 0);
    EXPECT_EQ(openfab({"export", path("a.ofr"), "-o", path("one.png"), "--slice", "7"}).exit_code,
              0);
    ASSERT_EQ(openfab({"export", path("a.ofr"), "-o", path("all")}).exit_code, 0);
    EXPECT_TRUE(read_file(path("one.png")) == read_file(scratch_ / "all/slice_0008.png"));
    EXPECT_EQ(openfab({"export", path("a.ofr"), "-o", path("one.png"), "--slice", "70"}).exit_code,
              1);
    ASSERT_EQ(openfab({"export", path("a.ofr"), "--preview", path("q.png")}).exit_code, 0);
    EXPECT_TRUE(read_file(path("p.png")) == read_file(path("q.png")));
}

TEST_F(PrintProgram, InfoTellsWhatAPrintIs) {
    ASSERT_EQ(print({"-o", path("a.ofr")}).exit_code, 0);
    const Outcome file = openfab({"info", path("a.ofr")});
    EXPECT_EQ(file.exit_code, 0) << file.err;
    for (const char* text : {"60 x 40 x 30", "generic", "white", "black", "complete   yes"})
        EXPECT_THAT(file.out, HasSubstr(text));
    ASSERT_EQ(print({"-o", path("slices"), "--format", "png"}).exit_code, 0);
    const Outcome folder = openfab({"info", path("slices")});
    EXPECT_EQ(folder.exit_code, 0) << folder.err;
    for (const char* text : {"60 x 40", "generic", "white"})
        EXPECT_THAT(folder.out, HasSubstr(text));
    EXPECT_EQ(openfab({"info", path("world.fab.json")}).exit_code, 0);
    EXPECT_EQ(openfab({"info", path("gone.ofr")}).exit_code, 1);
    EXPECT_EQ(openfab({"nonsense"}).exit_code, 2);
}

TEST_F(PrintProgram, StatisticsPreviewsAndNothingElse) {
    const Outcome outcome = print({"--preview", path("p.png"), "--preview",
                                   path("b.png") + ",view=bottom", "--stats", path("s.json")});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(fs::exists(path("p.png")));
    EXPECT_TRUE(fs::exists(path("b.png")));
    rapidjson::Document stats;
    stats.Parse(read_file(path("s.json")).c_str());
    ASSERT_FALSE(stats.HasParseError());
    EXPECT_EQ(stats["voxels_total"].GetInt64(), 60 * 40 * 30);
    EXPECT_GT(stats["voxels_solid"].GetInt64(), 60 * 40 * 30 / 2);
    // Where the time of the last sync goes.
    EXPECT_GT(stats["seconds_by_phase"]["finish"].GetDouble(), 0);
}

TEST_F(PrintProgram, EstimateAndDryRunWriteNothing) {
    for (const char* option : {"--estimate", "--dry-run"}) {
        const Outcome outcome = print({"-o", path("none.ofr"), option});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("60 x 40 x 30 voxels"));
        EXPECT_FALSE(fs::exists(path("none.ofr")));
    }
}

TEST_F(PrintProgram, WhatIsNotWrittenIsTold) {
    for (const char* option : {"--estimate", "--dry-run"}) {
        const Outcome outcome = print({"-o", path("none.ofr"), "--preview", path("p.png,view=top"),
                                       "--fractions", path("f.npy"), option});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        for (const char* name : {"p.png", "f.npy"}) {
            EXPECT_THAT(outcome.err,
                        Says(program::messages::kNotWritten, option, path(name), option));
            EXPECT_FALSE(fs::exists(path(name)));
        }
        EXPECT_THAT(print({"-o", path("none.ofr"), option}).err,
                    Not(Says(program::messages::kNotWritten, option, "*", option)));
    }
}

TEST_F(PrintProgram, ProgressOnlyOnStderr) {
    const Outcome json = print({"-o", path("a.ofr"), "--progress", "json"});
    EXPECT_THAT(json.err, HasSubstr("{\"event\": \"progress\""));
    const Outcome none = print({"-o", path("a.ofr"), "--progress", "none"});
    EXPECT_EQ(none.err, "");
    EXPECT_EQ(none.out, "");
}

TEST_F(PrintProgram, TheErrorOfASettingNamesItAsData) {
    for (const std::string setting : {"thing.c=1", "thing.shininess=1", "thing.a=[]",
                                      "thing.a={\"keys\": 1}", "thing.a=[", "none.a=1"}) {
        const Outcome outcome =
            print({"-o", path("a.ofr"), "--progress", "json", "--set", setting});
        EXPECT_NE(outcome.exit_code, 0) << setting;
        rapidjson::Document event;
        event.Parse(outcome.err.c_str());
        ASSERT_FALSE(event.HasParseError()) << outcome.err;
        EXPECT_STREQ(event["event"].GetString(), "error");
        EXPECT_EQ(event["setting"].GetString(), setting);
        EXPECT_FALSE(event.HasMember("file")) << outcome.err;
        // For people, it is on the line of the error.
        EXPECT_THAT(print({"-o", path("a.ofr"), "--set", setting}).err,
                    HasSubstr("error: --set " + setting + ": "));
    }
    scratch_.write("wrong.fab.json", "{\n  \"pritner\": 1}");
    const Outcome outcome =
        print({"-o", path("a.ofr"), "--progress", "json"}, {}, "wrong.fab.json");
    rapidjson::Document event;
    event.Parse(outcome.err.c_str());
    ASSERT_FALSE(event.HasParseError()) << outcome.err;
    EXPECT_THAT(event["file"].GetString(), ::testing::EndsWith("wrong.fab.json"));
    EXPECT_EQ(event["line"].GetInt(), 2);
    EXPECT_FALSE(event.HasMember("setting"));
}

TEST_F(PrintProgram, AFullDiskKeepsWholeSlices) {
    const Outcome outcome = print({"-o", "/dev/full", "--format", "ofr"});
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_THAT(outcome.err,
                ::testing::HasSubstr(std::string("error: ") + backends::messages::kCannotWriteTo +
                                     " `/dev/full`: No space left on device"));
}

TEST_F(PrintProgram, ReplacesNoFolderByAFileAndLosesNoFiles) {
    fs::create_directories(path("mine"));
    scratch_.write("mine/letter.txt", "dear");
    EXPECT_EQ(print({"-o", path("mine"), "--format", "ofr"}).exit_code, 1);
    EXPECT_EQ(print({"-o", path("mine"), "--format", "png"}).exit_code, 1);
    EXPECT_TRUE(fs::exists(path("mine/letter.txt")));
}

TEST_F(PrintProgram, MistakesHaveTheirExitCodes) {
    EXPECT_EQ(print({}).exit_code, 2);
    EXPECT_EQ(print({"-o", path("a.ofr"), "--nonsense"}).exit_code, 2);
    EXPECT_EQ(print({"-o", path("a.3mf"), "--resume"}).exit_code, 2);
    EXPECT_EQ(print({"-o", path("a.gcvf"), "--resume"}).exit_code, 2);
    EXPECT_THAT(print({"-o", path("a.vdb")}).err, HasSubstr("openfab export"));
    EXPECT_THAT(print({"-o", path("a.ofr"), "--fractions", path("a.vdb")}).err,
                HasSubstr("openfab export"));
    EXPECT_EQ(print({"-o", path("a.ofr"), "--printer", "no-such"}).exit_code, 1);
    EXPECT_EQ(print({"-o", path("a.ofr"), "--set", "thing.c=1"}).exit_code, 1);
    EXPECT_EQ(print({"-o", path("a.ofr"), "--slices", "500:600"}).exit_code, 1);
    EXPECT_EQ(print({"-o", path("a.ofr")}, {}, "gone.fab.json").exit_code, 1);
    const Outcome help = run({test_program("openfab_test_print_4"), "--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.out, HasSubstr("Examples:"));
    EXPECT_FALSE(fs::exists(path("a.ofr")));
}

TEST_F(PrintProgram, APrintLargerThanThePrinterIsRefused) {
    const Outcome outcome =
        print({"-o", path("a.ofr"), "--printer", "j750", "--dry-run", "--draft", "20"}, {},
              "world.fab.json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    write_world("large.fab.json", "Solid", "[600, 20, 20]");
    const Outcome large =
        print({"-o", path("a.ofr"), "--printer", "j750", "--draft", "20"}, {}, "large.fab.json");
    EXPECT_EQ(large.exit_code, 1);
    EXPECT_THAT(large.err, Says(program::messages::kPrintTooLarge, "601.13", "x", "111.1", "*"));
    EXPECT_THAT(large.err, Says(program::messages::kRoomOfPrinter, "j750", 490, 390, 200));
}

/// The world with additional keys before its fablets, and another build.
std::string changed(std::string world, const std::string& keys, const std::string& build) {
    world.insert(world.find("\"fablets\""), keys);
    const std::string old = "[{\"object\": \"thing\"}]";
    return world.replace(world.find(old), old.size(), build);
}

TEST_F(PrintProgram, APartBesideTheTrayIsRefused) {
    const std::string world = read_file(scratch_ / "world.fab.json");
    // 6 x 4 x 3 mm about x = y = 0: half of it is beside the corner of the tray.
    scratch_.write(
        "corner.fab.json",
        changed(world, "\"tray\": \"corner\", ",
                R"([{"object": "thing", "translate_mm": [9, 9]}, {"object": "thing"}])"));
    const Outcome beside = print({"-o", path("a.ofr")}, {}, "corner.fab.json");
    EXPECT_EQ(beside.exit_code, 1);
    EXPECT_THAT(beside.err, Says(program::messages::kPartOutsideTray, "thing", 1, 3, "-", "x"));
    scratch_.write("center.fab.json",
                   changed(world, "\"tray\": \"center\", ", R"([{"object": "thing"}])"));
    EXPECT_EQ(print({"-o", path("a.ofr")}, {}, "center.fab.json").exit_code, 0);
    scratch_.write("below.fab.json",
                   changed(world, "\"tray\": \"center\", ",
                           R"([{"object": "thing", "translate_mm": [0, 0, -1]}])"));
    EXPECT_THAT(print({"-o", path("a.ofr")}, {}, "below.fab.json").err,
                Says(program::messages::kPartOutsideTray, "*", "*", 1, "-", "z"));
}

TEST_F(PrintProgram, SlicesCanBeAsWideAsTheTray) {
    scratch_.write(
        "small.printer.json",
        R"({"name": "small", "pitch_mm": [0.25, 0.5, 0.5], "build_volume_mm": [20, 12, 9]})");
    scratch_.write("tray.fab.json",
                   changed(read_file(scratch_ / "world.fab.json"), "\"tray\": \"center\", ",
                           R"([{"object": "thing", "translate_mm": [2, 1]}])"));
    const std::vector<std::string> options = {"--printer", path("small.printer.json"), "-o",
                                              path("a.ofr")};
    std::vector<std::string> cropped = options;
    cropped.insert(cropped.end(), {"--crop", "tray"});
    ASSERT_EQ(print(cropped, {}, "tray.fab.json").exit_code, 0);
    const std::string info = openfab({"info", path("a.ofr")}).out;
    EXPECT_THAT(info, HasSubstr("voxels     80 x 24 x 6"));
    EXPECT_THAT(info, HasSubstr("origin     -10.000 -6.000 0.000 mm"));
    // From the corner, where nothing else is said; the block is half outside.
    EXPECT_EQ(print(cropped, {}, "world.fab.json").exit_code, 1);
    ASSERT_EQ(print(options, {}, "tray.fab.json").exit_code, 0);
    EXPECT_THAT(openfab({"info", path("a.ofr")}).out, HasSubstr("voxels     24 x 8 x 6"));
}

TEST_F(PrintProgram, EstimateTellsMaterialsTimeAndOverlaps) {
    scratch_.write(
        "two.fab.json",
        changed(read_file(scratch_ / "world.fab.json"), "",
                R"([{"object": "thing"}, {"object": "thing", "translate_mm": [5, 0]}])"));
    const auto json = [&](const std::string& name) {
        rapidjson::Document d;
        d.Parse(read_file(scratch_ / name).c_str());
        EXPECT_FALSE(d.HasParseError()) << name;
        return d;
    };
    const Outcome estimated =
        print({"--estimate", "--printer", "j750", "--stats", path("e.json")}, {}, "two.fab.json");
    ASSERT_EQ(estimated.exit_code, 0) << estimated.err;
    EXPECT_THAT(estimated.err,
                HasSubstr("112 slices, 18 min 40 s on `j750`, which this machine keeps up with"));
    EXPECT_THAT(estimated.err,
                testing::Says(pipeline::messages::kPartsOverlap, "thing", 0, "thing", 1));
    const Outcome unknown = print({"--estimate", "--printer", "j850"}, {}, "two.fab.json");
    EXPECT_THAT(unknown.err, testing::Says(program::messages::kPrinterTimeUnknown, "*", "j850"));
    const rapidjson::Document e = json("e.json");
    EXPECT_TRUE(e["keeps_up"].GetBool());
    EXPECT_GT(e["processor_seconds"].GetDouble(), 0);
    const Outcome printed = print(
        {"-o", path("a.ofr"), "--format", "ofr", "--printer", "j750", "--stats", path("p.json")},
        {}, "two.fab.json");
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    EXPECT_THAT(printed.err, testing::Says(pipeline::messages::kPartsOverlap));
    const Outcome silent =
        print({"-o", path("a.ofr"), "--printer", "j750", "--progress", "none"}, {}, "two.fab.json");
    EXPECT_THAT(silent.err, HasSubstr("warning: "));
    EXPECT_THAT(silent.err, testing::Says(pipeline::messages::kPartsOverlap));
    const rapidjson::Document p = json("p.json");
    EXPECT_EQ(p["warnings"].Size(), 1u);
    for (const char* material : {"white", "black"}) {
        const double exact = p["ml_by_material"][material].GetDouble();
        EXPECT_NEAR(e["ml_by_material"][material].GetDouble(), exact, 0.04 * exact) << material;
        EXPECT_NEAR(p["g_by_material"][material].GetDouble(), 1.18 * exact, 1e-5);
    }
    EXPECT_EQ(p["print_seconds"].GetDouble(), 1120);
    EXPECT_EQ(e["print_seconds"].GetDouble(), 1120);
}

TEST_F(PrintProgram, TenThousandInstancesShareTheirShape) {
#ifdef OPENFAB_SANITIZED
    GTEST_SKIP() << "sanitizers keep their own memory";
#endif
    scratch_.write(
        "many.fab.json",
        changed(
            read_file(scratch_ / "world.fab.json"), "",
            R"([{"object": "thing", "scale": 0.3, "grid": {"count": [100, 100], "spacing_mm": 0.2}}])"));
    std::string world = read_file(scratch_ / "many.fab.json");
    const std::string box = "{\"box\": [6, 4, 3]}";
    world.replace(world.find(box), box.size(), "{\"sphere\": 3}");
    scratch_.write("many.fab.json", world);
    const Outcome outcome =
        print({"--voxel", "0.5mm", "--stats", path("m.json")}, {}, "many.fab.json");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    rapidjson::Document d;
    d.Parse(read_file(scratch_ / "m.json").c_str());
    // A sphere's trees take 1 MB; ten thousand of them would be 10 GB.
    EXPECT_LT(d["peak_rss_bytes"].GetInt64(), 400'000'000);
    EXPECT_GT(d["voxels_solid"].GetInt64(), 10'000);
}

TEST_F(PrintProgram, AFailingKernelIsOurBug) {
    write_world("broken.fab.json", "Broken", "[6, 4, 3]");
    const Outcome outcome = print({"-o", path("a.ofr")}, {}, "broken.fab.json");
    EXPECT_EQ(outcome.exit_code, 4) << outcome.err;
    EXPECT_THAT(openfab({"verify", path("a.ofr")}).err, testing::Says(ofr::messages::kWholeSlices));
}

TEST_F(PrintProgram, InterruptedKeepsWholeSlices) {
    write_world("large.fab.json", "Skin", "[60, 60, 60]");
    RunOptions options;
    options.interrupt_when = has_printed_a_slice;
    const Outcome outcome = print(
        {"-o", path("a.ofr"), "--voxel", "0.05mm", "--threads", "1", "--stats", path("s.json")},
        options, "large.fab.json");
    EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
    EXPECT_THAT(outcome.err, testing::Says(pipeline::messages::kInterruptedAfter));
    EXPECT_EQ(openfab({"verify", path("a.ofr")}).exit_code, 1);
    EXPECT_THAT(read_file(path("s.json")), HasSubstr("\"complete\": false"));
}

TEST_F(PrintProgram, AGcvfIsTheSamePrintedOrExportedAndNeverInPart) {
    EXPECT_EQ(print({"-o", path("a.ofr")}).exit_code, 0);
    EXPECT_EQ(print({"-o", path("a.gcvf")}).exit_code, 0);
    EXPECT_EQ(openfab({"export", path("a.ofr"), "-o", path("b"), "--format", "gcvf"}).exit_code, 0);
    EXPECT_TRUE(read_file(path("a.gcvf")) == read_file(path("b")));
    write_world("large.fab.json", "Skin", "[60, 60, 60]");
    RunOptions options;
    options.interrupt_when = has_printed_a_slice;
    const Outcome outcome = print({"-o", path("c.gcvf"), "--voxel", "0.05mm", "--threads", "1"},
                                  options, "large.fab.json");
    EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
    EXPECT_THAT(outcome.err, testing::Says(gcvf::messages::kEndedEarly));
    for (const fs::directory_entry& entry : fs::directory_iterator(scratch_.path()))
        EXPECT_FALSE(entry.path().filename().string().starts_with("c.gcvf")) << entry.path();
}

TEST_F(PrintProgram, AMeshAloneIsPrintedAsItIs) {
    scratch_.write("block.obj",
                   "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2\nv 4 0 2\nv 4 3 2\nv 0 3 2\n"
                   "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    const Outcome several = print({"-o", path("a.ofr")}, {}, "block.obj");
    EXPECT_EQ(several.exit_code, 1);
    EXPECT_THAT(several.err, HasSubstr("4 fablets"));
    const Outcome one =
        run({test_program("openfab_test_print_1"), path("block.obj"), "-o", path("a.ofr")});
    EXPECT_EQ(one.exit_code, 0) << one.err;
    EXPECT_THAT(one.err, HasSubstr("note: no printer was named: `generic`"));
    const Outcome told = openfab({"info", path("a.ofr")});
    EXPECT_THAT(told.out, HasSubstr("40 x 30 x 20"));
    const Outcome mesh = openfab({"info", path("block.obj")});
    EXPECT_EQ(mesh.exit_code, 0) << mesh.err;
    EXPECT_THAT(mesh.out, HasSubstr("4 x 3 x 2 mm"));
    EXPECT_THAT(told.out, HasSubstr(" a,"));  // the uniforms name the materials
}

}  // namespace
}  // namespace openfab::testing
