// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The pixels of slices in folders, of bitmaps and of arrays: those of the voxels.

#include <OpenImageIO/imageio.h>

#include "tests/unit/backends/slice_folder.h"

namespace openfab::testing {
namespace {

TEST_F(SliceFolder, EveryPixelOfEveryKind) {
    for (int32_t bits : {4, 8}) {
        for (int32_t width : {12, 13}) {
            const SamplePrint print = make_sample({width, 7, 3}, bits);
            for (bool indexed : {false, true}) {
                for (bool flip : {false, true}) {
                    raster::FolderOptions options;
                    options.format =
                        indexed ? raster::SliceFormat::kIndexed : raster::SliceFormat::kRgba;
                    options.flip_x = flip;
                    ASSERT_TRUE(write(print, options));
                    for (int32_t z = 0; z < 3; ++z) {
                        const ReadPng png = read_png(
                            scratch_ / ("slices/slice_000" + std::to_string(z + 1) + ".png"));
                        expect_slice(print, png, z, flip);
                        EXPECT_EQ(png.color_type, indexed ? 3 : 6);
                        EXPECT_EQ(png.bit_depth, indexed ? bits : 8);
                        EXPECT_EQ(png.pixels_per_metre_x, 23622u);  // 600 dpi
                        EXPECT_EQ(png.pixels_per_metre_y, 11811u);
                    }
                }
            }
        }
    }
}

TEST_F(SliceFolder, LargeRuns) {
    // Runs longer than deflate's longest match, rows that repeat, wider than one window of 32 kB.
    SamplePrint print = make_sample({9001, 40, 1});
    for (int32_t y = 0; y < 40; ++y) {
        for (int32_t x = 0; x < 9001; ++x) {
            print.at(x, y, 0) = static_cast<uint8_t>(
                x > 100 && x < 8000 && y > 4 ? 1 + (x / 700 + y / 13) % 3 : (x % 977 == 0 ? 2 : 0));
        }
    }
    ASSERT_TRUE(write(print, {}));
    expect_slice(print, read_png(scratch_ / "slices/slice_0001.png"), 0, false);
}

// Pictures of all shapes, from noise to runs, with more colours than four bits hold.
TEST_F(SliceFolder, RandomPictures) {
    uint32_t state = 7;
    const auto random = [&state](uint32_t below) {
        state = state * 1664525U + 1013904223U;
        return (state >> 8) % below;
    };
    for (int32_t round = 0; round < 60; ++round) {
        SamplePrint print = make_sample({static_cast<int32_t>(1 + random(round < 50 ? 90 : 3000)),
                                         static_cast<int32_t>(1 + random(90)), 1},
                                        8);
        for (uint32_t m = 3; m < 40; ++m) {
            print.info.materials.push_back(print.info.materials[0]);
            print.info.materials.back().key = {static_cast<uint8_t>(m * 37),
                                               static_cast<uint8_t>(m * 11),
                                               static_cast<uint8_t>(m), 255};
        }
        const uint32_t run = 1 + random(300), colors = 1 + random(41);
        for (size_t i = 0; i < print.codes.size();) {
            const uint32_t end = std::min<uint32_t>(static_cast<uint32_t>(print.codes.size()),
                                                    static_cast<uint32_t>(i) + 1 + random(run));
            const auto code = static_cast<uint8_t>(random(colors));
            for (; i < end; ++i)
                print.codes[i] = code;
        }
        ASSERT_TRUE(write(print, {}));
        expect_slice(print, read_png(scratch_ / "slices/slice_0001.png"), 0, false);
    }
}

// Another reader than the one that most programs have.
TEST_F(SliceFolder, OpenImageIoReadsTheSamePixels) {
    for (const bool indexed : {false, true}) {
        const SamplePrint print = make_sample({1023, 301, 1});
        raster::FolderOptions options;
        options.format = indexed ? raster::SliceFormat::kIndexed : raster::SliceFormat::kRgba;
        ASSERT_TRUE(write(print, options));
        OIIO::ImageSpec as_stored;
        as_stored["oiio:UnassociatedAlpha"] = 1;
        const auto file =
            OIIO::ImageInput::open((scratch_ / "slices/slice_0001.png").string(), &as_stored);
        ASSERT_NE(file, nullptr) << OIIO::geterror();
        ASSERT_EQ(file->spec().width, 1023);
        ASSERT_EQ(file->spec().height, 301);
        ASSERT_EQ(file->spec().nchannels, 4);
        std::vector<std::array<uint8_t, 4>> pixels(size_t{1023} * 301);
        ASSERT_TRUE(file->read_image(0, 0, 0, 4, OIIO::TypeDesc::UINT8, pixels.data()))
            << file->geterror();
        for (int32_t y = 0; y < 301; ++y) {
            for (int32_t x = 0; x < 1023; ++x) {
                ASSERT_EQ(pixels[static_cast<size_t>(300 - y) * 1023 + static_cast<size_t>(x)],
                          color(print, x, y, 0))
                    << x << ' ' << y;
            }
        }
    }
}

// What the compressor keeps from slice to slice leaves no trace, whichever thread it is of.
TEST_F(SliceFolder, AFileDependsOnItsSliceAlone) {
    const SamplePrint noise = make_sample({700, 500, 1});
    const SamplePrint letter = make_letter_f(90, 1);
    const std::vector<uint8_t> noise_rows = noise.rows(0), letter_rows = letter.rows(0);
    const auto encode = [&](bool first_noise) {
        std::vector<uint8_t> bytes;
        std::thread([&] {
            if (first_noise) raster::encode_slice(noise.view(0, noise_rows), noise.info, {});
            bytes = raster::encode_slice(letter.view(0, letter_rows), letter.info, {});
        }).join();
        return bytes;
    };
    const std::vector<uint8_t> alone = encode(false);
    ASSERT_FALSE(alone.empty());
    EXPECT_TRUE(encode(true) == alone);
}

// Pictures that do not compress, up to rows wider than what goes into the compressor at once.
TEST_F(SliceFolder, NoiseHasRoom) {
    std::mt19937 random(11);
    for (const int32_t width : {1, 1000, 70'001}) {
        raster::PngImage image;
        image.width = width;
        image.height = 2 + 3'000'000 / (width + 3000);
        std::vector<uint8_t> rows;
        const std::vector<uint8_t> bytes =
            raster::encode_png_rows(image, [&](int32_t, uint8_t* row) {
                rows.push_back(0);
                for (int32_t i = 0; i < 4 * width; ++i)
                    rows.push_back(row[i] = static_cast<uint8_t>(random()));
            });
        ASSERT_FALSE(bytes.empty()) << width;
        EXPECT_LT(bytes.size(), rows.size() + rows.size() / 50 + 300) << width;
        EXPECT_TRUE(raster::decode_png(bytes, image) == rows) << width;
    }
}

// Black where the material goes, white elsewhere, as another reader sees it.
TEST_F(SliceFolder, BitmapsHoldOneMaterialEach) {
    for (const int32_t bits : {4, 8}) {
        for (const int32_t width : {5, 64, 93}) {
            for (const bool flip : {false, true}) {
                const SamplePrint print = make_sample({width, 7, 2}, bits);
                raster::FolderOptions options;
                options.format = raster::SliceFormat::kBitmaps;
                options.flip_x = flip;
                ASSERT_TRUE(write(print, options));
                for (size_t m = 0; m < print.info.materials.size(); ++m) {
                    const auto file = OIIO::ImageInput::open(
                        (scratch_ / "slices" / fmt::format("slice_0002_{}.bmp", m + 1)).string());
                    ASSERT_NE(file, nullptr) << OIIO::geterror();
                    ASSERT_EQ(file->spec().width, width);
                    ASSERT_EQ(file->spec().height, 7);
                    const auto channels = static_cast<size_t>(file->spec().nchannels);
                    std::vector<uint8_t> pixels(static_cast<size_t>(width) * 7 * channels);
                    ASSERT_TRUE(file->read_image(0, 0, 0, file->spec().nchannels,
                                                 OIIO::TypeDesc::UINT8, pixels.data()));
                    for (int32_t y = 0; y < 7; ++y) {
                        for (int32_t x = 0; x < width; ++x) {
                            const int32_t column = flip ? width - 1 - x : x;
                            const size_t pixel = static_cast<size_t>((6 - y) * width + column);
                            ASSERT_EQ(pixels[pixel * channels] == 0, print.at(x, y, 1) == m + 1)
                                << x << ' ' << y << ' ' << m;
                        }
                    }
                }
            }
        }
    }
}

TEST_F(SliceFolder, BitmapsAreResumedAndDamageIsSeen) {
    const SamplePrint print = make_sample({37, 9, 5});
    raster::FolderOptions options;
    options.format = raster::SliceFormat::kBitmaps;
    const auto resumed = [&] {
        auto sink = raster::FolderSink::reopen(scratch_ / "slices", options);
        EXPECT_TRUE(sink && (*sink)->begin(print.info));
        Result<int32_t> slices = (*sink)->resume([&](const pipeline::SliceView& slice) {
            const std::vector<uint8_t> rows = print.rows(slice.z);
            EXPECT_TRUE(std::equal(rows.begin(), rows.end(), slice.data)) << slice.z;
            return true;
        });
        EXPECT_TRUE(slices);
        return slices ? *slices : -1;
    };
    ASSERT_TRUE(write(print, options));
    EXPECT_EQ(resumed(), 5);
    const fs::path third = scratch_ / "slices/slice_0003_2.bmp";
    const std::string good = read_file(third);
    EXPECT_EQ(good.size(), 62u + 8 * 9);
    for (const size_t at : {size_t{3}, size_t{20}, good.size() - 1}) {  // the last byte pads a row
        ASSERT_TRUE(write(print, options));
        std::string bad = good;
        bad[at] = static_cast<char>(bad[at] ^ 1);
        scratch_.write("slices/slice_0003_2.bmp", bad);
        EXPECT_EQ(resumed(), 2) << at;
        EXPECT_FALSE(fs::exists(third)) << "what comes after is printed again";
    }
    EXPECT_THAT(read_file(scratch_ / "slices/manifest.json"),
                HasSubstr("\"file_suffix\": \"_3.bmp\""));
    EXPECT_THAT(read_file(scratch_ / "slices/HANDOFF.txt"), HasSubstr("_2.bmp   black"));
}

TEST_F(SliceFolder, AnArrayHasTheCodesOfTheVoxels) {
    for (const int32_t bits : {4, 8}) {
        for (const bool complete : {true, false}) {
            const SamplePrint print = make_sample({13, 7, 3}, bits);
            auto sink = raster::NpySink::create((scratch_ / "a.npy").string());
            ASSERT_TRUE(sink);
            ASSERT_TRUE(print.send(sink->get(), complete));
            const std::string file = read_file(scratch_ / "a.npy");
            EXPECT_EQ(file.substr(0, 10), std::string("\x93NUMPY\x01\x00\x76\x00", 10));
            EXPECT_THAT(
                file.substr(10, 118),
                HasSubstr("{'descr': '|u1', 'fortran_order': False, 'shape': (3, 7, 13), }"));
            EXPECT_EQ(file[127], '\n');
            ASSERT_EQ(file.size(), 128u + 13 * 7 * 3);
            for (size_t i = 0; i < print.codes.size(); ++i)
                ASSERT_EQ(static_cast<uint8_t>(file[128 + i]), print.codes[i]) << i;
            rapidjson::Document text;
            text.Parse(read_file(scratch_ / "a.npy.json").c_str());
            ASSERT_FALSE(text.HasParseError());
            EXPECT_EQ(text["complete"].GetBool(), complete);
            EXPECT_EQ(text["shape_zyx"][2].GetInt(), 13);
            EXPECT_STREQ(text["materials"][1]["name"].GetString(), "black");
        }
    }
}

TEST_F(SliceFolder, TheLetterFStandsUprightSeenFromAbove) {
    const SamplePrint print = make_letter_f(3, 1);
    ASSERT_TRUE(write(print, {}));
    const ReadPng png = read_png(scratch_ / "slices/slice_0001.png");
    const auto inked = [&](int32_t column, int32_t row) {
        return png.at(column * 3 + 1, row * 3 + 1)[3] == 255;
    };
    const std::vector<std::string> rows{"#####", "#....", "#....", "###..",
                                        "#....", "#....", "#...."};
    for (int32_t row = 0; row < 7; ++row) {
        for (int32_t column = 0; column < 5; ++column) {
            EXPECT_EQ(inked(column, row), rows[row][column] == '#') << column << ' ' << row;
        }
    }
}

}  // namespace
}  // namespace openfab::testing
