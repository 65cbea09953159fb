// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab render` of prints and worlds.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "backends/ofr/messages.h"
#include "backends/ofr/ofr_sink.h"
#include "program/messages.h"
#include "tests/programs/print/simple_world.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"
#include "tools/render/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

class Render : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    void write_ofr(const SamplePrint& print, bool complete = true) {
        Result<std::unique_ptr<pipeline::SliceSink>> sink = ofr::OfrSink::create(path("a.ofr"));
        ASSERT_TRUE(sink);
        ASSERT_TRUE(print.send(sink->get(), complete));
    }
    Outcome render(const std::vector<std::string>& words, const RunOptions& options = {}) {
        std::vector<std::string> argv{program("openfab"), "render"};
        argv.insert(argv.end(), words.begin(), words.end());
        return run(argv, options);
    }
    /// Of the sample, small.
    Outcome render_sample(const std::string& output, std::vector<std::string> more = {},
                          const RunOptions& options = {}) {
        more.insert(more.begin(), {path("a.ofr"), "-o", path(output), "--size", "32x24"});
        if (std::find(more.begin(), more.end(), "--samples") == more.end())
            more.insert(more.end(), {"--samples", "2"});
        return render(more, options);
    }

    ScratchFolder scratch_;
    SamplePrint print_ = make_sample({40, 30, 35});
};

TEST_F(Render, MakesTheSamePictureWithAnyNumberOfThreads) {
    write_ofr(print_);
    const Outcome one = render_sample("one.png", {"--threads", "1"});
    ASSERT_EQ(one.exit_code, 0) << one.err;
    EXPECT_THAT(one.err, HasSubstr("clear \"x\""));  // of which nothing is known
    EXPECT_THAT(one.err, Not(HasSubstr("white,")));
    EXPECT_THAT(one.err, HasSubstr("2 samples a pixel"));
    const Outcome many = render_sample("many.png", {"--threads", "3", "--quiet"});
    ASSERT_EQ(many.exit_code, 0) << many.err;
    EXPECT_EQ(many.err, "");
    EXPECT_EQ(read_file(path("one.png")), read_file(path("many.png")));
    const ReadPng picture = read_png(scratch_ / "one.png");
    EXPECT_EQ(picture.width, 32);
    EXPECT_EQ(picture.height, 24);
    ASSERT_EQ(render_sample("other.png", {"--seed", "3"}).exit_code, 0);
    EXPECT_NE(read_file(path("one.png")), read_file(path("other.png")));
}

TEST_F(Render, TakesOpticsAndTellsTheScene) {
    write_ofr(print_);
    scratch_.write("dark.json", R"({"openfab_optics": 1, "surface": {"refractive_index": 1},
        "materials": {"white": {"extinction_per_mm": 1000, "albedo": 0},
                      "black": {"extinction_per_mm": 1000, "albedo": 0},
                      "clear \"x\"": {"extinction_per_mm": 1000, "albedo": 0}}})");
    const Outcome dark =
        render_sample("dark.png", {"--optics", path("dark.json"), "--backdrop", "none", "--light",
                                   "dome", "--describe", path("scene.json")});
    ASSERT_EQ(dark.exit_code, 0) << dark.err;
    EXPECT_THAT(dark.err, Not(HasSubstr("guessed")));
    const ReadPng picture = read_png(scratch_ / "dark.png");
    // Nothing but the edges of the print, which its last thousandths of a millimetre do not darken.
    int64_t bright = 0;
    for (const auto& pixel : picture.rgba)
        bright += pixel[0] > 60 ? 1 : 0;
    EXPECT_LT(bright, 10);
    EXPECT_THAT(read_file(path("scene.json")), HasSubstr("\"dome\":[1,1,1]"));
}

TEST_F(Render, OfAWorldIsThatOfItsPrint) {
    scratch_.write("f.fl", R"(fablet F { @uniform { Material a, b; }
        @Volume(@varying { VolumeAttributes attr })
        { MaterialComposition mc; mc.Set(attr.voxelCenter.x > 0 ? a : b, 1); return mc; } })");
    scratch_.write("w.fab.json", SimpleWorld{"F", R"({"sphere": 4})"}.text());
    const std::vector<std::string> picture{"--size", "32x24", "--samples", "2", "--quiet"};
    std::vector<std::string> words{path("w.fab.json"), "-o", path("world.png"), "--draft", "4"};
    words.insert(words.end(), picture.begin(), picture.end());
    const Outcome world = render(words);
    ASSERT_EQ(world.exit_code, 0) << world.err;
    ASSERT_EQ(
        run({program("openfab"), "print", path("w.fab.json"), "-o", path("w.ofr"), "--draft", "4"})
            .exit_code,
        0);
    words = {path("w.ofr"), "-o", path("print.png")};
    words.insert(words.end(), picture.begin(), picture.end());
    ASSERT_EQ(render(words).exit_code, 0);
    EXPECT_EQ(read_file(path("world.png")), read_file(path("print.png")));
    // A world that is wrong is told of as by `openfab print`.
    const Outcome wrong = render({path("w.fab.json"), "-o", path("x.png"), "--set", "thing.c=1"});
    EXPECT_EQ(wrong.exit_code, 1);
    EXPECT_THAT(wrong.err, HasSubstr("error: "));
    EXPECT_THAT(wrong.err, HasSubstr("`c`"));
    EXPECT_FALSE(fs::exists(path("x.png")));
}

TEST_F(Render, MakesAPictureForAPrinterWhosePitchIsNotKnown) {
    scratch_.write("f.fl", R"(fablet F { @uniform { Material a, b; }
        @Volume(@varying { VolumeAttributes attr })
        { MaterialComposition mc; mc.Set(a, 1); return mc; } })");
    scratch_.write("w.fab.json", SimpleWorld{"F", R"({"sphere": 4})", "j55"}.text());
    const Outcome made = render({path("w.fab.json"), "-o", path("p.png"), "--draft", "4", "--size",
                                 "32x24", "--samples", "2"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    // A slice of a J55 is 18.75 um thick; the rest is as for meshes, 0.1 mm.
    EXPECT_THAT(made.err,
                Says(program::messages::kPitchStandsIn, "*", "j55", "*", 0.4, 0.4, 0.075));
}

TEST_F(Render, WritesWhatThereIsWhenInterrupted) {
    write_ofr(print_);
    RunOptions options;
    options.interrupt_when = [](int, const Outcome& so_far) {
        return so_far.err.find("samples a pixel") != std::string::npos;
    };
    const Outcome outcome = render_sample("cut.png", {"--samples", "1000000"}, options);
    EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
    EXPECT_THAT(outcome.err, testing::Says(render::messages::kInterruptedPicture));
    EXPECT_EQ(read_png(scratch_ / "cut.png").width, 32);
    const Outcome timed = render_sample("timed.pfm", {"--samples", "1000000", "--time", "100ms"});
    EXPECT_EQ(timed.exit_code, 0) << timed.err;
    EXPECT_EQ(fs::file_size(path("timed.pfm")),
              32u * 24 * 12 + std::string("PF\n32 24\n-1.0\n").size());
}

TEST_F(Render, KeepsItsMemoryByACoarserPitch) {
    SamplePrint large = make_sample({600, 500, 60});
    write_ofr(large);
    const Outcome outcome = render_sample("small.png", {"--memory", "60MB", "--samples", "1"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, testing::Says(render::messages::kVoxelsTakenTogether));
#ifndef OPENFAB_SANITIZED
    EXPECT_LT(outcome.peak_rss_bytes, 60'000'000);
#endif
    const Outcome none = render_sample("none.png", {"--memory", "1MB"});
    EXPECT_EQ(none.exit_code, 1);
    EXPECT_THAT(none.err, testing::Says(render::messages::kPictureTakes));
}

TEST_F(Render, TellsOfAPrintThatIsNotComplete) {
    write_ofr(print_, false);
    const Outcome outcome = render_sample("part.png");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    print_.info.slice_end = 60;
    for (int32_t z = 35; z < 60; ++z)
        print_.codes.insert(print_.codes.end(), 40 * 30, uint8_t{0});
    print_.info.size.z = 60;
    std::fill(print_.codes.begin(), print_.codes.end(), uint8_t{0});
    write_ofr(print_);
    const Outcome empty = render_sample("empty.png");
    EXPECT_EQ(empty.exit_code, 1);
    EXPECT_THAT(empty.err, testing::Says(render::messages::kNothingPrinted));
}

TEST_F(Render, RefusesWhatItCannotRead) {
    write_ofr(print_);
    std::string damaged = read_file(path("a.ofr"));
    const std::string whole = damaged;
    damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x40);
    scratch_.write("a.ofr", damaged);
    Outcome outcome = render_sample("x.png");
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("slice "));
    scratch_.write("a.ofr", "no print");
    EXPECT_THAT(render_sample("x.png").err, testing::Says(ofr::messages::kNotOfr));
    scratch_.write("a.ofr", whole);
    scratch_.write("bad.json", "{\"openfab_optics\": 1, \"materials\": {\"white\": {}}}");
    outcome = render_sample("x.png", {"--optics", path("bad.json")});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("bad.json:1:"));
    EXPECT_THAT(outcome.err, testing::Says(render::messages::kKeyMissing, "extinction_per_mm"));
    EXPECT_EQ(render({path("gone.ofr"), "-o", path("x.png")}).exit_code, 1);
    // It never overwrites what it reads.
    outcome = render({path("a.ofr"), "-o", path("x.png"), "--describe", path("a.ofr")});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_EQ(read_file(path("a.ofr")), whole);
    EXPECT_FALSE(fs::exists(path("x.png")));
}

TEST_F(Render, RefusesOptionsThatItDoesNotKnow) {
    write_ofr(print_);
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
        {{"--view", "side"}, fmt::format(render::messages::kNoView, "side")},
        {{"--light", "sun"}, fmt::format(render::messages::kNoLight, "sun")},
        {{"--backdrop", "grey"}, fmt::format(render::messages::kNoColour, "grey")},
        {{"--size", "32"}, fmt::format(render::messages::kNoSize, "32", "{}")},
        {{"--size", "0x5"}, render::messages::kNoSize},
        {{"--samples", "0"}, "--samples"},
        {{"--time", "3"}, "`--time`"},
        {{"--roughness", "2"}, "--roughness"},
        {{"--smaples", "4"}, "--samples"},
        {{"--exposure", "bright"}, "--exposure"},
    };
    for (const auto& [words, message] : cases) {
        std::vector<std::string> argv{path("a.ofr"), "-o", path("x.png")};
        argv.insert(argv.end(), words.begin(), words.end());
        const Outcome outcome = render(argv);
        EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
        EXPECT_THAT(outcome.err, testing::Says(message));
    }
    const Outcome jpeg = render({path("a.ofr"), "-o", path("x.jpg")});
    EXPECT_EQ(jpeg.exit_code, 2);
    EXPECT_THAT(jpeg.err, HasSubstr(".png"));
    EXPECT_FALSE(fs::exists(path("x.png")));
}

}  // namespace
}  // namespace openfab::testing
