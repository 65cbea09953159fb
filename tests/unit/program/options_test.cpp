// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/options.h"

#include <gmock/gmock.h>

#include <map>
#include <sstream>

#include "program/messages.h"
#include "program/outputs.h"
#include "tests/support/says/says.h"

namespace openfab::program {
namespace {

using openfab::testing::Says;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Le;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

Result<Options> parse(std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), "card");
    return parse_options(static_cast<int>(arguments.size()), arguments.data(), "card");
}

TEST(PrintOptions, Defaults) {
    const Result<Options> options = parse({"w.fab.json", "-o", "out"});
    ASSERT_TRUE(options) << options.error().text();
    EXPECT_EQ(options->input, "w.fab.json");
    EXPECT_EQ(options->output, "out");
    EXPECT_EQ(options->memory_bytes, 1'500'000'000);
    EXPECT_FALSE(options->threads.has_value());
    EXPECT_TRUE(options->culling);
    EXPECT_FALSE(options->isa.has_value());
}

TEST(PrintOptions, Everything) {
    const Result<Options> options = parse({"w.fab.json", "--output=-",
                                           "--printer",  "j750",
                                           "--dpi",      "600x300",
                                           "--layer",    "27um",
                                           "--draft",    "2",
                                           "--z",        "3mm:5mm",
                                           "--memory",   "300MB",
                                           "--threads",  "2",
                                           "--seed",     "18446744073709551615",
                                           "--set",      "a.b=[1,2.5]",
                                           "--set",      "c.on=true",
                                           "--set",      "c.m=oak",
                                           "--preview",  "p.png,view=bottom",
                                           "--preview",  "q.png",
                                           "--flip-x",   "--stats",
                                           "s.json",     "--progress",
                                           "json",       "--no-cull",
                                           "--isa",      "sse41",
                                           "--estimate", "--png",
                                           "indexed"});
    ASSERT_TRUE(options) << options.error().text();
    EXPECT_EQ(options->output, "-");
    EXPECT_EQ(options->dpi->x, 600);
    EXPECT_EQ(options->dpi->y, 300);
    EXPECT_DOUBLE_EQ(*options->layer_mm, 0.027);
    EXPECT_DOUBLE_EQ(options->z_range_mm->x, 3);
    EXPECT_DOUBLE_EQ(options->z_range_mm->y, 5);
    EXPECT_EQ(options->memory_bytes, 300'000'000);
    EXPECT_EQ(options->seed, 18446744073709551615ULL);
    EXPECT_THAT(options->settings, ElementsAre("a.b=[1,2.5]", "c.on=true", "c.m=oak"));
    ASSERT_EQ(options->previews.size(), 2u);
    EXPECT_EQ(options->progress, program::ProgressMode::kJson);
    EXPECT_FALSE(options->culling);
    EXPECT_EQ(options->isa, OPENFAB_ISA_SSE41);
    EXPECT_TRUE(options->png_indexed);
    EXPECT_TRUE(options->flip_x);
    const Vec3d pitch = print_pitch(*options, {1, 1, 1});
    EXPECT_DOUBLE_EQ(pitch.x, 2 * 25.4 / 600);
    EXPECT_DOUBLE_EQ(pitch.y, 2 * 25.4 / 300);
    EXPECT_DOUBLE_EQ(pitch.z, 2 * 0.027);
}

TEST(PrintOptions, ThePrintersPitchUnlessTold) {
    const Vec3d j750{25.4 / 600, 25.4 / 300, 0.027};
    EXPECT_EQ(print_pitch(*parse({"w", "-o", "o"}), j750), j750);
    EXPECT_EQ(print_pitch(*parse({"w", "-o", "o", "--voxel", "0.1mm"}), j750),
              (Vec3d{0.1, 0.1, 0.1}));
    EXPECT_EQ(print_pitch(*parse({"w", "-o", "o", "--layer", "14um"}), j750).z, 0.014);
    // Printers that take meshes do not print their voxels.
    EXPECT_EQ(print_pitch(*parse({"w", "-o", "o.3mf"}), j750, true), (Vec3d{0.1, 0.1, 0.1}));
    EXPECT_EQ(print_pitch(*parse({"w", "-o", "o.3mf", "--mesh-pitch", "0.25mm"}), j750, true),
              (Vec3d{0.25, 0.25, 0.25}));
    EXPECT_EQ(print_pitch(*parse({"w", "-o", "o.3mf", "--layer", "14um"}), j750, true),
              (Vec3d{j750.x, j750.y, 0.014}));
}

TEST(PrintOptions, MistakesAreUsageErrorsThatNameTheOption) {
    const std::vector<std::pair<std::vector<const char*>, const char*>> cases{
        {{}, "INPUT"},
        {{"w", "-o"}, "output"},
        {{"w"}, "-o OUT"},
        {{"w", "-o", "x", "--nonsense"}, "--nonsense"},
        {{"w", "-o", "x", "y"}, "y"},
        {{"w", "-o", "x", "--voxel", "0.1"}, "--voxel"},
        {{"w", "-o", "x", "--voxel", "-1mm"}, "--voxel"},
        {{"w", "-o", "x", "--voxel", "nanmm"}, "--voxel"},
        {{"w", "-o", "x", "--voxel", "0.1mm", "--layer", "1mm"}, "give one"},
        {{"w", "-o", "x", "--dpi", "600x"}, "--dpi"},
        {{"w", "-o", "x", "--dpi", "0x0"}, "--dpi"},
        {{"w", "-o", "x", "--z", "3mm"}, "--z"},
        {{"w", "-o", "x", "--z", "5mm:3mm"}, "--z"},
        {{"w", "-o", "x", "--slices", "a:b"}, "--slices"},
        {{"w", "-o", "x", "--slices", "4:4"}, "--slices"},
        {{"w", "-o", "x", "--slices", "0:4", "--z", "0mm:1mm"}, "give one"},
        {{"w", "-o", "x", "--memory", "lots"}, "--memory"},
        {{"w", "-o", "x", "--memory", "300"}, "--memory"},
        {{"w", "-o", "x", "--threads", "0"}, "--threads"},
        {{"w", "-o", "x", "--draft", "0"}, "--draft"},
        {{"w", "-o", "x", "--seed", "-1"}, "--seed"},
        {{"w", "-o", "x", "--set", "a.b"}, "--set"},
        {{"w", "-o", "x", "--set", "=1"}, "--set"},
        {{"w", "-o", "x", "--set", "a.b="}, "--set"},
        {{"w", "-o", "x", "--preview", "a.bmp"}, "--preview"},
        {{"w", "-o", "x", "--preview", "a.png,slice:5"}, "a.png,view=slice:5`"},
        {{"w", "-o", "x", "--preview", "a.png,back"}, "a.png,view=back`"},
        {{"w", "-o", "x", "--preview", "a.png,transmitted"}, "a.png,light=transmitted`"},
        {{"w", "-o", "x", "--png", "grey"}, "--png"},
        {{"w", "-o", "x", "--format", "jpeg"}, "bmp"},
        {{"w", "-o", "-", "--format", "png"}, "standard output"},
        {{"w", "-o", "-", "--format", "3mf"}, "standard output"},
        {{"w", "-o", "x.3mf", "--mesh-pitch", "0.1"}, "--mesh-pitch"},
        {{"w", "-o", "x.3mf", "--mesh-pitch", "0.1mm", "--voxel", "0.1mm"}, "--voxel"},
        {{"w", "-o", "-", "--resume"}, "--resume"},
        {{"w", "--preview", "x.png", "--resume"}, "--resume"},
        {{"w", "-o", "x", "--isa", "foo"}, "`--isa`: `foo` is none of sse41"},
        {{"w", "-o", "x", "--groups-in-flight", "0"}, "`--groups-in-flight`: `0` is not"},
    };
    for (const auto& [arguments, expected] : cases) {
        const Result<Options> options = parse(arguments);
        ASSERT_FALSE(options) << expected;
        EXPECT_EQ(options.error().code, ErrorCode::kUsage);
        EXPECT_THAT(options.error().text(), HasSubstr(expected));
    }
}

TEST(PrintOptions, ValuesAreCheckedWhateverMadeThem) {
    const auto error_of = [](const auto& change) {
        Options options;
        change(&options);
        const Result<void> fine = validate_options(options);
        return fine ? std::string() : fine.error().text();
    };
    EXPECT_EQ(error_of([](Options*) {}), "");
    EXPECT_THAT(error_of([](Options* o) { o->voxel_mm = 200; }),
                Says(messages::kBadValue, "--voxel", "200mm"));
    EXPECT_THAT(error_of([](Options* o) { o->layer_mm = std::nan(""); }),
                Says(messages::kBadValue, "--layer"));
    EXPECT_THAT(error_of([](Options* o) {
                    o->dpi = Vec2<double>{600, 0};
                }),
                Says(messages::kBadValue, "--dpi", "600x0"));
    EXPECT_THAT(error_of([](Options* o) { o->draft = 0; }),
                Says(messages::kBadValue, "--draft", "0"));
    EXPECT_THAT(error_of([](Options* o) { o->threads = 1025; }),
                Says(messages::kBadValue, "--threads", "1025"));
    EXPECT_THAT(error_of([](Options* o) {
                    o->slices = Vec2<int32_t>{-1, 5};
                }),
                Says(messages::kBadValue, "--slices", "-1:5"));
    EXPECT_THAT(error_of([](Options* o) { o->effects["--bleed"] = "some"; }),
                Says(messages::kBadValue, "--bleed", "some"));
    EXPECT_THAT(error_of([](Options* o) { o->memory_bytes = 0; }),
                Says(messages::kBadValue, "--memory", "0B"));
    EXPECT_THAT(error_of([](Options* o) { o->fractions_supersample = 33; }),
                Says(messages::kBadValue, "--fractions-supersample", "33"));
}

TEST(PrintOptions, HelpIsInGroupsThatFitOnAScreen) {
    const Result<Options> options = parse({"--help"});
    ASSERT_TRUE(options);
    EXPECT_TRUE(options->help);
    EXPECT_THAT(options->text, HasSubstr("Examples:"));
    EXPECT_THAT(options->text, ::testing::Not(HasSubstr("--no-cull")));
    // A heading, the lines of its options, an empty line.
    std::istringstream lines(options->text);
    std::map<std::string, int> of_group;
    std::string heading;
    for (std::string line; std::getline(lines, line);) {
        if (line.ends_with(':')) heading = line;
        if (line.starts_with("  -")) ++of_group[heading];
    }
    EXPECT_THAT(of_group, UnorderedElementsAre(
                              Pair("Options:", 1), Pair("Output:", Le(16)),
                              Pair("Part of a print:", Le(16)), Pair("World and material:", Le(16)),
                              Pair("Machine:", Le(16)), Pair("Progress and resources:", Le(16))));
}

TEST(PrintOptions, HelpOfAHostHasNoOutputs) {
    const char* const ask[] = {"card", "--help"};
    const Result<Options> options = parse_options(2, ask, "card", false);
    ASSERT_TRUE(options);
    EXPECT_THAT(options->text, HasSubstr("--voxel"));
    for (const char* const left_out : {"Examples:", " -o", "--preview", "--resume", "--stats"})
        EXPECT_THAT(options->text, ::testing::Not(HasSubstr(left_out)));
}

TEST(PrintOutputs, Format) {
    const auto format = [](std::vector<const char*> arguments, const char* native) {
        arguments.insert(arguments.begin(), "w");
        world::Printer printer;
        printer.native_format = native;
        const Result<Options> options = parse(arguments);
        const Result<const backends::Format*> chosen = choose_format(*options, printer);
        if (!chosen) return Result<std::string>(chosen.error());
        if (const Result<void> fine = check_mesh_pitch(*options, *chosen); !fine)
            return Result<std::string>(fine.error());
        return Result<std::string>(*chosen == nullptr ? "" : std::string((*chosen)->name));
    };
    EXPECT_EQ(*format({"-o", "a.ofr"}, "png"), "ofr");
    EXPECT_EQ(*format({"-o", "folder"}, "png"), "png");
    EXPECT_EQ(*format({"-o", "out/v1.2"}, "png"), "png");
    EXPECT_EQ(*format({"-o", "folder"}, "ofr"), "ofr");
    EXPECT_EQ(*format({"-o", "-"}, "png"), "ofr");
    EXPECT_EQ(*format({"-o", "a.ofr", "--format", "png"}, "ofr"), "png");
    EXPECT_EQ(*format({"--preview", "a.png"}, "png"), "");
    EXPECT_FALSE(format({"-o", "a.png"}, "png"));
    for (const char* file : {"a.bmp", "a.gcode", "out/a.tif", "a.zip"}) {
        for (const char* native : {"png", "ofr"})
            EXPECT_FALSE(format({"-o", file}, native)) << file;
    }
    EXPECT_EQ(*format({"-o", "a.zip/"}, "png"), "png");
    EXPECT_EQ(*format({"-o", "a.stl"}, "png"), "stl");
    EXPECT_EQ(*format({"-o", "a.3mf", "--mesh-pitch", "0.2mm"}, "png"), "3mf");
    EXPECT_EQ(*format({"-o", "a", "--format", "3mf"}, "png"), "3mf");
    EXPECT_THAT(format({"-o", "a.ofr", "--mesh-pitch", "0.2mm"}, "png").error().text(),
                Says(messages::kMeshPitchOfSlices));
}

}  // namespace
}  // namespace openfab::program
