// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/preview/preview.h"

#include <gmock/gmock.h>

#include <cmath>

#include "backends/common/tee_sink.h"
#include "backends/ofr/ofr_sink.h"
#include "backends/preview/columns.h"
#include "backends/preview/messages.h"
#include "backends/preview/picture.h"
#include "base/color.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kLetter{"#####", "#....", "#....", "###..",
                                       "#....", "#....", "#...."};

class Preview : public ::testing::Test {
  protected:
    ReadPng draw(const SamplePrint& print, const std::string& settings) {
        Result<preview::PreviewSpec> spec =
            preview::parse_preview((scratch_ / "picture.png").string() + settings);
        EXPECT_TRUE(spec) << spec.error().text();
        std::vector<std::unique_ptr<backends::SliceObserver>> observers;
        observers.push_back(preview::make_preview(*spec));
        backends::TeeSink sink(std::make_unique<backends::NullSink>(), std::move(observers));
        Result<void> done = print.send(&sink);
        EXPECT_TRUE(done) << done.error().text();
        return read_png(scratch_ / "picture.png");
    }
    /// Reads a picture of the letter, 5 x 7 cells, as text: `#` where it is covered (dark where
    /// `by_light`).
    static std::vector<std::string> read_letter(const ReadPng& png, int32_t cell) {
        std::vector<std::string> rows(7, std::string(5, '.'));
        for (int32_t row = 0; row < 7; ++row) {
            for (int32_t column = 0; column < 5; ++column) {
                const auto& pixel = png.at(column * cell + cell / 2, row * cell + cell / 2);
                if (pixel[3] == 255) rows[row][column] = '#';
            }
        }
        return rows;
    }

    ScratchFolder scratch_;
};

TEST_F(Preview, FrontSliceAndBackShowTheLetterAsAPersonSeesIt) {
    const SamplePrint print = make_letter_f(4, 3);
    EXPECT_EQ(read_letter(draw(print, ""), 4), kLetter);
    EXPECT_EQ(read_letter(draw(print, ",view=slice:1"), 4), kLetter);
    EXPECT_EQ(read_letter(draw(print, ",light=transmitted"), 4), kLetter);
    std::vector<std::string> mirrored = kLetter;
    for (std::string& row : mirrored)
        row = std::string(row.rbegin(), row.rend());
    EXPECT_EQ(read_letter(draw(print, ",view=bottom"), 4), mirrored);
    EXPECT_EQ(read_letter(draw(print, ",view=bottom,light=transmitted"), 4), mirrored);
}

TEST_F(Preview, SectionHasXToTheRightAndZUp) {
    SamplePrint print = make_letter_f(4, 6);
    std::fill(print.codes.begin(), print.codes.end(), uint8_t{0});
    // A stair that rises with x.
    for (int32_t x = 0; x < 20; ++x) {
        for (int32_t z = 0; z <= x / 4; ++z)
            print.at(x, 14, z) = 2;
    }
    const ReadPng png = draw(print, ",view=section");
    ASSERT_EQ(png.width, 20);
    ASSERT_EQ(png.height, 6);
    for (int32_t x = 0; x < 20; ++x) {
        for (int32_t z = 0; z < 6; ++z)
            EXPECT_EQ(png.at(x, 5 - z)[3] == 255, z <= x / 4) << x << ' ' << z;
    }
}

TEST_F(Preview, ColorsAreTheOuterVoxels) {
    SamplePrint print = make_letter_f(4, 40);
    for (int32_t z = 0; z < 40; ++z) {
        for (int32_t y = 0; y < 28; ++y) {
            for (int32_t x = 0; x < 20; ++x)
                print.at(x, y, z) = z < 20 ? 2 : 1;
        }
    }
    const auto front = draw(print, "").at(10, 14);
    EXPECT_NEAR(front[0], 244, 1);
    EXPECT_NEAR(front[1], 242, 1);
    EXPECT_NEAR(front[2], 236, 1);
    const auto back = draw(print, ",view=bottom").at(10, 14);
    EXPECT_LT(back[0], 25);
}

/// `front` is -y, as on the page of `openfab view` and of `openfab import --side`.
TEST_F(Preview, EachSideShowsWhatFacesIt) {
    SamplePrint print = make_letter_f(4, 20);
    // White where y is low, black where it is high.
    for (int32_t z = 0; z < 20; ++z) {
        for (int32_t y = 0; y < 28; ++y) {
            for (int32_t x = 0; x < 20; ++x)
                print.at(x, y, z) = y < 14 ? 1 : 2;
        }
    }
    const auto middle = [&](const char* view) {
        const ReadPng png = draw(print, view);
        return png.at(png.width / 2, png.height / 2)[0];
    };
    const int front = middle(",view=front"), back = middle(",view=back");
    EXPECT_GT(std::abs(front - back), 100);
    const ReadPng right = draw(print, ",view=right"), left = draw(print, ",view=left");
    const auto at = [](const ReadPng& png, int32_t quarter) {
        return png.at(png.width * quarter / 4, png.height / 2)[0];
    };
    // Seen from the right, y runs to the right; from the left, to the left.
    EXPECT_NEAR(at(right, 1), front, 60);
    EXPECT_NEAR(at(right, 3), back, 60);
    EXPECT_NEAR(at(left, 1), back, 60);
    EXPECT_NEAR(at(left, 3), front, 60);
}

TEST_F(Preview, PixelsAreSquare) {
    SamplePrint print = make_letter_f(4, 2);
    print.info.pitch_mm = {0.05, 0.1, 0.1};
    const ReadPng png = draw(print, "");
    EXPECT_EQ(png.width, 20);
    EXPECT_EQ(png.height, 56);
    EXPECT_EQ(png.pixels_per_metre_x, png.pixels_per_metre_y);
}

TEST_F(Preview, TransmissionFallsWithTheSquareOfTheThickness) {
    SamplePrint print = make_letter_f(4, 21);
    std::fill(print.codes.begin(), print.codes.end(), uint8_t{0});
    // Thickness 1 at the left to 20 at the right, in voxels; the part does not start at one level,
    // so order does not matter.
    for (int32_t x = 0; x < 20; ++x) {
        for (int32_t y = 0; y < 28; ++y) {
            for (int32_t n = 0; n <= x; ++n)
                print.at(x, y, 20 - n) = 1;
        }
    }
    const ReadPng png = draw(print, ",light=transmitted");
    for (int32_t x = 0; x < 20; ++x) {
        const double t = x / 19.0;
        EXPECT_EQ(png.at(x, 14)[0], linear_to_srgb8(1 - t * t)) << x;
    }
}

TEST_F(Preview, ModelFromStraightAboveIsTheFront) {
    const SamplePrint print = make_letter_f(10, 12);
    const ReadPng png = draw(print, ",view=model:0:90");
    for (int32_t row = 0; row < 7; ++row) {
        for (int32_t column = 0; column < 5; ++column) {
            const auto& pixel =
                png.at(png.width * (2 * column + 1) / 10, png.height * (2 * row + 1) / 14);
            EXPECT_EQ(pixel[3] > 128, kLetter[row][column] == '#') << column << ' ' << row;
        }
    }
}

// At a turn of 90 degrees the viewer is at +x, and the lowest y is on the left.
TEST_F(Preview, ModelTurnsWithTheViewer) {
    SamplePrint print = make_letter_f(10, 12);
    std::fill(print.codes.begin(), print.codes.end(), uint8_t{0});
    for (int32_t z = 0; z < 12; ++z) {
        for (int32_t y = 0; y < 10; ++y) {
            for (int32_t x = 0; x < 50; ++x)
                print.at(x, y, z) = 1;
        }
    }
    const ReadPng png = draw(print, ",view=model:90:45");
    EXPECT_GT(png.at(png.width / 14, png.height / 2)[3], 200);
    EXPECT_EQ(png.at(png.width * 13 / 14, png.height / 2)[3], 0);
}

TEST_F(Preview, ModelIsOpenedAndSeenThrough) {
    SamplePrint print = make_letter_f(10, 40);
    print.info.materials[0].preview[3] = 20;  // code 1 is clear, code 2 black
    for (int32_t z = 0; z < 40; ++z) {
        for (int32_t y = 0; y < 70; ++y) {
            for (int32_t x = 0; x < 50; ++x) {
                const bool core = z > 10 && z < 30 && x > 15 && x < 35 && y > 20 && y < 50;
                print.at(x, y, z) = core ? 2 : 1;
            }
        }
    }
    const ReadPng whole = draw(print, ",view=model:0:90");
    EXPECT_GT(whole.at(whole.width / 2, whole.height / 2)[3], 250) << "the core hides the ground";
    EXPECT_LT(whole.at(whole.width / 10, whole.height / 10)[3], 200) << "the clear rim does not";
    const ReadPng open = draw(print, ",view=model:0:90,cut=y");
    EXPECT_GT(open.at(open.width / 2, open.height * 4 / 10)[3], 250);
    EXPECT_EQ(open.at(open.width / 2, open.height * 6 / 10)[3], 0) << "the half at low y is gone";
}

/// A block of code 1 under whose skin are cells of void and of code 2, or nothing else.
SamplePrint block_with_skin(double pitch_mm, int32_t skin, bool filled) {
    SamplePrint print = make_letter_f(8, 40);
    print.info.pitch_mm = {pitch_mm, pitch_mm, pitch_mm};
    print.info.materials[0].preview = {255, 128, 0, 255};
    for (int32_t z = 0; z < 40; ++z) {
        for (int32_t y = 0; y < 56; ++y) {
            for (int32_t x = 0; x < 40; ++x) {
                const int32_t depth = std::min({x, y, z, 39 - x, 55 - y, 39 - z});
                const int32_t inside = (x / 6 + y / 6 + z / 6) % 3;
                print.at(x, y, z) = depth < skin || filled ? 1 : static_cast<uint8_t>(inside);
            }
        }
    }
    return print;
}

// Voxels behind an opaque skin are not visible, neither through it nor as dents in it.
TEST_F(Preview, AnOpaqueSkinIsDrawnAsItIs) {
#ifdef OPENFAB_SANITIZED
    const std::vector<std::pair<double, int>> skins = {{0.2, 3}};
#else
    const std::vector<std::pair<double, int>> skins = {{0.1, 4}, {0.085, 5}, {0.2, 3}};
#endif
    for (const auto& [pitch_mm, skin] : skins) {
        for (const char* view :
             {"", ",view=bottom", ",view=model:30:30", ",view=model:200:50", ",view=model:0:90"}) {
            const ReadPng whole = draw(block_with_skin(pitch_mm, skin, true), view);
            const ReadPng hollow = draw(block_with_skin(pitch_mm, skin, false), view);
            ASSERT_EQ(whole.rgba.size(), hollow.rgba.size());
            int most = 0;
            for (size_t i = 0; i < whole.rgba.size(); ++i) {
                for (size_t c = 0; c < 4; ++c)
                    most = std::max(most, std::abs(whole.rgba[i][c] - hollow.rgba[i][c]));
            }
            EXPECT_LE(most, 4) << pitch_mm << " mm" << view;
        }
    }
}

TEST_F(Preview, ASliceThatIsNotPrintedIsRefusedAndNothingIsChanged) {
    const SamplePrint print = make_letter_f(4, 3);
    for (const char* name : {"print.ofr", "front.png", "slice.png"})
        scratch_.write(name, "earlier");
    const auto file = [&](const char* name) { return (scratch_ / name).string(); };
    auto sink = ofr::OfrSink::create(file("print.ofr"));
    ASSERT_TRUE(sink) << sink.error().text();
    std::vector<std::unique_ptr<backends::SliceObserver>> observers;
    for (const std::string& text : {file("front.png"), file("slice.png") + ",view=slice:3"})
        observers.push_back(preview::make_preview(*preview::parse_preview(text)));
    {
        backends::TeeSink tee(std::move(*sink), std::move(observers));
        const Result<void> done = print.send(&tee);
        ASSERT_FALSE(done);
        EXPECT_THAT(done.error().text(),
                    testing::Says(preview::messages::kNoSuchSlice, "*", "*", "0", "2"));
    }
    for (const char* name : {"print.ofr", "front.png", "slice.png"})
        EXPECT_EQ(read_file(scratch_ / name), "earlier") << name;
}

TEST_F(Preview, OfAPrintThatCannotGoOnIsNotDrawn) {
    const SamplePrint print = make_letter_f(4, 3);
    scratch_.write("print.ofr", "no print of ours");
    scratch_.write("front.png", "earlier");
    auto sink = ofr::OfrSink::reopen((scratch_ / "print.ofr").string());
    ASSERT_TRUE(sink) << sink.error().text();
    std::vector<std::unique_ptr<backends::SliceObserver>> observers;
    observers.push_back(
        preview::make_preview(*preview::parse_preview((scratch_ / "front.png").string())));
    backends::TeeSink tee(std::move(*sink), std::move(observers));
    EXPECT_FALSE(print.send(&tee));
    EXPECT_EQ(read_file(scratch_ / "front.png"), "earlier");
}

TEST(PreviewSpec, Settings) {
    const Result<preview::PreviewSpec> plain = preview::parse_preview("out/a,b.png");
    ASSERT_TRUE(plain);
    EXPECT_EQ(plain->file, "out/a,b.png");
    EXPECT_EQ(plain->view, preview::View::kTop);
    const Result<preview::PreviewSpec> full =
        preview::parse_preview("c.png,light=transmitted,view=bottom");
    ASSERT_TRUE(full);
    EXPECT_TRUE(full->transmitted);
    EXPECT_EQ(full->view, preview::View::kBottom);
    // Sides are seen from 5 degrees above, at which the model's view ends.
    for (const auto& [side, turn_deg] : {std::pair("front", 0.0), std::pair("right", 90.0),
                                         std::pair("back", 180.0), std::pair("left", 270.0)}) {
        const auto one = preview::parse_preview(std::string("a.png,cut=x,view=") + side);
        ASSERT_TRUE(one) << side;
        EXPECT_EQ(one->view, preview::View::kModel);
        EXPECT_EQ(one->turn_deg, turn_deg);
        EXPECT_EQ(one->tilt_deg, 5);
    }
    for (const char* bad : {"a.jpg", ".png", "a.png,view=side", "a.png,light=red", "a.png,size=3",
                            "a.png,view=model:x", "a.png,view=model:0:2", "a.png,view=model:0:30:5",
                            "a.png,cut=x", "a.png,view=model,cut=z", "a.png,view=slice:x",
                            "a.png,view=slice:-1", "a.png,view=section,light=transmitted"}) {
        const Result<preview::PreviewSpec> spec = preview::parse_preview(bad);
        ASSERT_FALSE(spec) << bad;
        EXPECT_EQ(spec.error().code, ErrorCode::kUsage);
    }
}

TEST(PreviewSpec, AViewIsSettingsWithoutAFile) {
    const Result<preview::PreviewSpec> model = preview::parse_view("view=model:40:20,cut=x");
    ASSERT_TRUE(model) << model.error().text();
    EXPECT_EQ(model->file, "");
    EXPECT_EQ(model->view, preview::View::kModel);
    EXPECT_EQ(model->turn_deg, 40);
    EXPECT_EQ(model->cut, preview::Cut::kX);
    for (const char* bad : {"", "back", "view=", "view=top,", "view=top,cut=x", "a.png,view=top"})
        EXPECT_FALSE(preview::parse_view(bad)) << bad;
}

TEST(PreviewColor, SrgbAndBack) {
    for (int i = 0; i < 256; ++i)
        EXPECT_EQ(linear_to_srgb8(srgb_to_linear(i / 255.0)), i);
    // The standard's formula.
    for (double v : {0.05, 0.2, 0.5, 0.73, 1.0}) {
        EXPECT_NEAR(srgb_to_linear(v), std::pow((v + 0.055) / 1.055, 2.4), 1e-14);
    }
    // The nearest: as far as half a step on either side.
    for (int i = 0; i < 255; ++i) {
        EXPECT_EQ(linear_to_srgb8(srgb_to_linear((i + 0.49) / 255)), i);
        EXPECT_EQ(linear_to_srgb8(srgb_to_linear((i + 0.51) / 255)), i + 1);
    }
    EXPECT_EQ(linear_to_srgb8(-1), 0);
    EXPECT_EQ(linear_to_srgb8(2), 255);
}

TEST(PreviewPicture, MeansAreOfAreaAndLight) {
    // Three cells over two pixels: the middle one is shared.
    const preview::Picture picture = preview::resample(3000, 1, {1, 1}, [](int32_t x, int32_t) {
        preview::Pixel pixel;
        pixel.coverage = 1;
        pixel.color[0] = x % 2 == 0 ? 1 : 0;
        return pixel;
    });
    EXPECT_EQ(picture.width, 1500);
    for (const preview::Pixel& pixel : picture.pixels)
        EXPECT_NEAR(pixel.color[0], 0.5, 1e-6);
}

TEST(PreviewColumns, SightStopsAtTheFirstVoid) {
    preview::ColumnGrid grid{1, 1, 1};
    for (bool above : {true, false}) {
        preview::SightColumns columns(grid, 4, above);
        const std::vector<uint8_t> stack{0, 1, 2, 0, 3, 2, 2, 0};  // bottom first
        preview::PaddedRow row(8, 0);
        for (size_t z = 0; z < stack.size(); ++z) {
            row[0] = stack[z];
            columns.add_row(static_cast<int32_t>(z), 0, row);
        }
        const preview::Sight sight = columns.at(0, 0);
        const std::vector<uint8_t> seen(sight.codes, sight.codes + sight.count);
        EXPECT_EQ(seen, above ? (std::vector<uint8_t>{2, 2, 3}) : (std::vector<uint8_t>{1, 2}));
        EXPECT_EQ(sight.z, above ? 6 : 1);
    }
}

// Long runs, which are skipped, against a plain scan of each column.
TEST(PreviewColumns, AgreeWithAPlainLookAtEachColumn) {
    uint32_t state = 3;
    const auto random = [&state](uint32_t below) {
        state = state * 1664525U + 1013904223U;
        return (state >> 8) % below;
    };
    for (int32_t bits : {4, 8}) {
        for (int32_t width : {1, 8, 13}) {
            preview::ColumnGrid grid{1, width, 2};
            preview::SightColumns above(grid, bits, true), below(grid, bits, false);
            preview::ThicknessColumns thickness(grid);
            constexpr int32_t kFirst = 5, kSlices = 90;
            std::vector<std::vector<uint8_t>> stacks(static_cast<size_t>(2 * width));
            for (std::vector<uint8_t>& stack : stacks) {
                while (stack.size() < kSlices)
                    stack.insert(stack.end(), 1 + random(width == 1 ? 40 : 60),
                                 static_cast<uint8_t>(random(3)));
            }
            for (int32_t z = 0; z < kSlices; ++z) {
                for (int32_t row = 0; row < 2; ++row) {
                    preview::PaddedRow codes(preview::padded(width), 0);
                    for (int32_t x = 0; x < width; ++x)
                        codes[x] = stacks[static_cast<size_t>(row * width + x)][z];
                    above.add_row(kFirst + z, row, codes);
                    below.add_row(kFirst + z, row, codes);
                    thickness.add_row(kFirst + z, row, codes);
                }
            }
            for (int32_t row = 0; row < 2; ++row) {
                for (int32_t x = 0; x < width; ++x) {
                    std::vector<uint8_t> stack = stacks[static_cast<size_t>(row * width + x)];
                    stack.resize(kSlices);
                    EXPECT_EQ(thickness.at(x, row),
                              kSlices - std::count(stack.begin(), stack.end(), 0));
                    for (bool from_above : {false, true}) {
                        const preview::Sight sight = (from_above ? above : below).at(x, row);
                        if (from_above) std::reverse(stack.begin(), stack.end());
                        const auto first = std::find_if(stack.begin(), stack.end(),
                                                        [](uint8_t code) { return code != 0; });
                        ASSERT_EQ(sight.covered, first != stack.end());
                        if (!sight.covered) continue;
                        const auto index = static_cast<int32_t>(first - stack.begin());
                        EXPECT_EQ(sight.z, kFirst + (from_above ? kSlices - 1 - index : index));
                        const auto end = std::find(first, stack.end(), 0);
                        const std::vector<uint8_t> expected(
                            first, std::min(end, first + std::min<std::ptrdiff_t>(
                                                             64 / bits, stack.end() - first)));
                        EXPECT_EQ(std::vector<uint8_t>(sight.codes, sight.codes + sight.count),
                                  expected);
                    }
                }
            }
        }
    }
}

TEST(PreviewColumns, MemoryIsBounded) {
    const preview::ColumnGrid grid = preview::ColumnGrid::make({11574, 9212, 3000});
    EXPECT_LE(static_cast<int64_t>(grid.count()), preview::kMaxColumns);
    EXPECT_GT(grid.step, 1);
    EXPECT_LT(grid.x(grid.width - 1, {11574, 9212, 1}), 11574);
}

}  // namespace
}  // namespace openfab::testing
