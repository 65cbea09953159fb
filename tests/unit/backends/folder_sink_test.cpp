// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <random>
#include <thread>

#include "backends/raster/folder_sink.h"
#include "backends/raster/messages.h"
#include "backends/raster/npy_sink.h"
#include "backends/raster/png_encode.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class SliceFolder : public ::testing::Test {
  protected:
    Result<void> write(const SamplePrint& print, const raster::FolderOptions& options,
                       const std::string& folder = "slices", bool complete = true) {
        Result<std::unique_ptr<pipeline::SliceSink>> sink =
            raster::FolderSink::create(scratch_ / folder, options);
        if (!sink) return sink.error();
        return print.send(sink->get(), complete);
    }
    /// Returns the expected pixel of a voxel, by the print's own colours.
    static std::array<uint8_t, 4> color(const SamplePrint& print, int32_t x, int32_t y, int32_t z) {
        const uint8_t code = print.at(x, y, z);
        return code == 0 ? std::array<uint8_t, 4>{} : print.info.materials[code - 1].key;
    }
    static void expect_slice(const SamplePrint& print, const ReadPng& png, int32_t z, bool flip_x) {
        ASSERT_EQ(png.width, print.info.size.x);
        ASSERT_EQ(png.height, print.info.size.y);
        for (int32_t y = 0; y < png.height; ++y) {
            for (int32_t x = 0; x < png.width; ++x) {
                const int32_t column = flip_x ? png.width - 1 - x : x;
                ASSERT_EQ(png.at(column, png.height - 1 - y), color(print, x, y, z))
                    << x << ' ' << y << ' ' << z;
            }
        }
    }

    ScratchFolder scratch_;
};

/// Also where a slice takes fewer bytes than before, and where there are fewer.
TEST_F(SliceFolder, AnEarlierPrintIsWrittenOver) {
    ASSERT_TRUE(write(make_sample({40, 30, 9}), {}));
    struct stat before {};
    ASSERT_EQ(::stat((scratch_ / "slices/slice_0002.png").c_str(), &before), 0);
    const SamplePrint print = make_letter_f(2, 5);
    ASSERT_TRUE(write(print, {}));
    ASSERT_TRUE(write(print, {}, "fresh"));
    std::map<std::string, std::string> written, fresh;
    for (const auto& entry : fs::directory_iterator(scratch_ / "slices"))
        written[entry.path().filename().string()] = read_file(entry.path());
    for (const auto& entry : fs::directory_iterator(scratch_ / "fresh"))
        fresh[entry.path().filename().string()] = read_file(entry.path());
    EXPECT_EQ(written, fresh);
    struct stat after {};
    ASSERT_EQ(::stat((scratch_ / "slices/slice_0002.png").c_str(), &after), 0);
    EXPECT_EQ(before.st_ino, after.st_ino);  // file systems take long to make new ones
}

TEST_F(SliceFolder, SlicesOfAnEarlierPrintAreGoneFromTheFirstOn) {
    ASSERT_TRUE(write(make_sample({40, 30, 9}), {}));
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        raster::FolderSink::create(scratch_ / "slices", {});
    ASSERT_TRUE(sink);
    const SamplePrint print = make_letter_f(2, 5);
    ASSERT_TRUE((*sink)->begin(print.info));
    const auto slices = [&] {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(scratch_ / "slices")) {
            if (entry.path().extension() == ".png") names.push_back(entry.path().filename());
        }
        return names;
    };
    EXPECT_THAT(slices(), ::testing::IsEmpty());
    const std::vector<uint8_t> rows = print.rows(0);
    ASSERT_TRUE((*sink)->commit(0, (*sink)->encode(print.view(0, rows))));
    EXPECT_THAT(slices(), ::testing::ElementsAre("slice_0001.png"));
    ASSERT_TRUE((*sink)->finish({}));
    // With the two notes and the digests.
    EXPECT_EQ(std::distance(fs::directory_iterator(scratch_ / "slices"), {}), 4);
}

/// What other names lead to keeps its bytes.
TEST_F(SliceFolder, CopiesByLinkStayAsTheyAre) {
    ASSERT_TRUE(write(make_sample({40, 30, 9}), {}));
    const std::string slice = read_file(scratch_ / "slices/slice_0001.png");
    fs::create_hard_link(scratch_ / "slices/slice_0001.png", scratch_ / "copy.png");
    fs::rename(scratch_ / "slices/slice_0002.png", scratch_ / "elsewhere.png");
    fs::create_symlink(scratch_ / "elsewhere.png", scratch_ / "slices/slice_0002.png");
    const std::string elsewhere = read_file(scratch_ / "elsewhere.png");
    fs::permissions(scratch_ / "slices/slice_0003.png", fs::perms::owner_read);
    ASSERT_TRUE(write(make_letter_f(2, 5), {}));
    EXPECT_EQ(read_file(scratch_ / "copy.png"), slice);
    EXPECT_EQ(read_file(scratch_ / "elsewhere.png"), elsewhere);
    EXPECT_FALSE(fs::is_symlink(scratch_ / "slices/slice_0002.png"));
    ASSERT_TRUE(write(make_letter_f(2, 5), {}, "fresh"));
    for (const char* name : {"slice_0001.png", "slice_0002.png", "slice_0003.png"})
        EXPECT_EQ(read_file(scratch_ / "slices" / name), read_file(scratch_ / "fresh" / name));
}

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

TEST_F(SliceFolder, ManifestAndHandoff) {
    const SamplePrint print = make_sample({600, 300, 10});
    raster::FolderOptions options;
    options.handoff = "Use the voxel print utility.";
    ASSERT_TRUE(write(print, options));
    rapidjson::Document manifest;
    manifest.Parse(read_file(scratch_ / "slices/manifest.json").c_str());
    ASSERT_FALSE(manifest.HasParseError());
    EXPECT_TRUE(manifest["complete"].GetBool());
    EXPECT_EQ(manifest["slices"].GetInt(), 10);
    EXPECT_EQ(manifest["pixels"][0].GetInt(), 600);
    EXPECT_EQ(manifest["pixels"][1].GetInt(), 300);
    EXPECT_DOUBLE_EQ(manifest["dpi"][0].GetDouble(), 600);
    EXPECT_DOUBLE_EQ(manifest["dpi"][1].GetDouble(), 300);
    EXPECT_DOUBLE_EQ(manifest["layer_um"].GetDouble(), 27);
    EXPECT_DOUBLE_EQ(manifest["size_mm"][0].GetDouble(), 25.4);
    EXPECT_DOUBLE_EQ(manifest["size_mm"][1].GetDouble(), 25.4);
    EXPECT_DOUBLE_EQ(manifest["size_mm"][2].GetDouble(), 0.27);
    EXPECT_STREQ(manifest["axes"]["image_right"].GetString(), "+x");
    EXPECT_STREQ(manifest["axes"]["image_up"].GetString(), "+y");
    EXPECT_STREQ(manifest["support_made_by"].GetString(), "front_end");
    EXPECT_STREQ(manifest["first_file"].GetString(), "slice_0001.png");
    EXPECT_STREQ(manifest["last_file"].GetString(), "slice_0010.png");
    ASSERT_EQ(manifest["materials"].Size(), 3u);
    const auto& black = manifest["materials"][1];
    EXPECT_STREQ(black["name"].GetString(), "black");
    EXPECT_STREQ(black["color"].GetString(), "#000000ff");
    const auto voxels = static_cast<double>(print.totals().voxels_by_code[2]);
    EXPECT_EQ(black["voxels"].GetDouble(), voxels);
    const double ml = voxels * (2.54 / 600) * (2.54 / 300) * 0.0027;  // in cubic centimetres
    EXPECT_NEAR(black["ml"].GetDouble(), ml, 1e-6);
    EXPECT_NEAR(black["g"].GetDouble(), ml * 1.2, 1e-6);
    char hash[17];
    std::snprintf(hash, sizeof(hash), "%016llx",
                  static_cast<unsigned long long>(print.totals().hash));
    EXPECT_STREQ(manifest["hash"].GetString(), hash);

    const std::string note = read_file(scratch_ / "slices/HANDOFF.txt");
    for (const char* part : {"600 dpi", "300 dpi", "27 um", "white", "RGB   0   0   0",
                             "Use the voxel print utility."}) {
        EXPECT_THAT(note, HasSubstr(part));
    }
    EXPECT_THAT(note, ::testing::Not(HasSubstr("NOT COMPLETE")));
}

/// `sha256sum` checks a folder, and `openfab verify` tells what is missing, other or none of it.
TEST_F(SliceFolder, EveryFileHasItsDigest) {
    for (const raster::SliceFormat format :
         {raster::SliceFormat::kRgba, raster::SliceFormat::kIndexed, raster::SliceFormat::kBitmaps,
          raster::SliceFormat::kGrey8, raster::SliceFormat::kTiff16}) {
        raster::FolderOptions options;
        options.format = format;
        SamplePrint print = make_sample({40, 30, 12});
        print.info.slice_begin = 2;
        ASSERT_TRUE(write(print, options));
        const auto by_others = [&](const std::string& check) {
            return run(
                {"/bin/sh", "-c", "cd '" + (scratch_ / "slices").string() + "' && " + check});
        };
        EXPECT_EQ(by_others("sha256sum --check --strict --quiet SHA256SUMS").exit_code, 0);
        const size_t files = format == raster::SliceFormat::kBitmaps ? 30 : 10;
        rapidjson::Document manifest;
        manifest.Parse(read_file(scratch_ / "slices/manifest.json").c_str());
        ASSERT_EQ(manifest["sha256"].MemberCount(), files);
        const auto& first = *manifest["sha256"].MemberBegin();
        EXPECT_EQ(by_others(std::string("sha256sum ") + first.name.GetString()).out.substr(0, 64),
                  first.value.GetString());

        const auto told = [&] {
            return run({program("openfab"), "verify", (scratch_ / "slices").string()});
        };
        EXPECT_EQ(told().exit_code, 0) << told().err;
        const std::string end = format == raster::SliceFormat::kBitmaps  ? "_2.bmp"
                                : format == raster::SliceFormat::kTiff16 ? ".tif"
                                                                         : ".png";
        const fs::path one = scratch_ / ("slices/slice_0005" + end);
        const std::string bytes = read_file(one);
        const auto wrong = [&](const char* message, const std::string& name) {
            const Outcome outcome = told();
            EXPECT_EQ(outcome.exit_code, 1);
            EXPECT_THAT(outcome.err, HasSubstr(fmt::format(fmt::runtime(message), name)));
        };
        const std::string name = one.filename().string();
        fs::remove(one);
        wrong(tools::messages::kFileMissing, name);
        EXPECT_THAT(run({program("openfab"), "info", (scratch_ / "slices").string()}).out,
                    HasSubstr(fmt::format(tools::messages::kFolderLacksFiles, 1, files, name)));
        fs::copy(scratch_ / ("slices/slice_0006" + end), one);
        wrong(tools::messages::kFileDiffers, name);
        scratch_.write("slices/" + name, bytes);
        const std::string more = "slice_0012_9.bmp";
        scratch_.write("slices/" + more, bytes);
        wrong(tools::messages::kFileOfOther, more);
        fs::remove(scratch_ / ("slices/" + more));
        std::string other = read_file(scratch_ / "slices/HANDOFF.txt");
        scratch_.write("slices/HANDOFF.txt", other + "Print it twice.\n");
        wrong(tools::messages::kFileDiffers, "HANDOFF.txt");
        scratch_.write("slices/HANDOFF.txt", other);
        EXPECT_EQ(told().exit_code, 0) << told().err;
        ASSERT_TRUE(write(print, options, "slices", false));
        EXPECT_EQ(told().exit_code, 1);
    }
}

/// A folder without digests is checked by the voxels of its pictures.
TEST_F(SliceFolder, WithoutDigestsTheHashOfTheVoxelsTells) {
    ASSERT_TRUE(write(make_sample({40, 30, 5}), {}));
    rapidjson::Document manifest;
    std::string text = read_file(scratch_ / "slices/manifest.json");
    text = text.substr(0, text.find(",\n  \"sha256\"")) + "\n}\n";
    scratch_.write("slices/manifest.json", text);
    fs::remove(scratch_ / "slices/SHA256SUMS");
    const auto verify = [&] {
        return run({program("openfab"), "verify", (scratch_ / "slices").string()});
    };
    EXPECT_EQ(verify().exit_code, 0);
    EXPECT_THAT(verify().err, HasSubstr(tools::messages::kWithoutDigests));
    fs::copy(scratch_ / "slices/slice_0003.png", scratch_ / "slices/slice_0002.png",
             fs::copy_options::overwrite_existing);
    EXPECT_EQ(verify().exit_code, 1);
}

TEST_F(SliceFolder, AnInterruptedPrintSaysSo) {
    ASSERT_TRUE(write(make_sample({6, 5, 3}), {}, "slices", false));
    EXPECT_THAT(read_file(scratch_ / "slices/manifest.json"), HasSubstr("\"complete\": false"));
    EXPECT_THAT(read_file(scratch_ / "slices/HANDOFF.txt"), HasSubstr("NOT COMPLETE"));
    EXPECT_TRUE(fs::exists(scratch_ / "slices/slice_0003.png"));
}

TEST_F(SliceFolder, AnEarlierPrintIsReplacedWhole) {
    ASSERT_TRUE(write(make_sample({6, 5, 9}), {}));
    ASSERT_TRUE(write(make_sample({6, 5, 3}), {}));
    EXPECT_TRUE(fs::exists(scratch_ / "slices/slice_0003.png"));
    EXPECT_FALSE(fs::exists(scratch_ / "slices/slice_0004.png"));
}

TEST_F(SliceFolder, NobodysFilesAreLost) {
    fs::create_directories(scratch_ / "slices");
    scratch_.write("slices/letter.txt", "dear");
    Result<void> done = write(make_sample({6, 5, 3}), {});
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kUserInput);
    EXPECT_THAT(done.error().text(), HasSubstr("letter.txt"));
    scratch_.write("plain", "a file");
    EXPECT_THAT(write(make_sample({6, 5, 3}), {}, "plain").error().text(),
                testing::Says(raster::messages::kOutputIsFile));
}

TEST_F(SliceFolder, AFolderThatCannotBeMadeIsTheOutsidesFault) {
    scratch_.write("plain", "a file");
    Result<void> done = write(make_sample({6, 5, 3}), {}, "plain/slices");
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kOutside);
}

TEST_F(SliceFolder, NamesHaveFixedDigits) {
    const auto name = [](int32_t z, int32_t slices, size_t file, raster::SliceFormat format) {
        raster::FolderOptions options;
        options.format = format;
        return raster::slice_file_name(z, file, make_sample({1, 1, slices}).info, options);
    };
    const auto png = raster::SliceFormat::kRgba, bmp = raster::SliceFormat::kBitmaps;
    EXPECT_EQ(name(0, 1, 0, png), "slice_0001.png");
    EXPECT_EQ(name(9998, 9999, 0, png), "slice_9999.png");
    EXPECT_EQ(name(0, 10000, 0, png), "slice_00001.png");
    EXPECT_EQ(name(9999, 10000, 0, png), "slice_10000.png");
    EXPECT_EQ(name(0, 12, 0, bmp), "slice_0001_1.bmp");
    EXPECT_EQ(name(11, 12, 2, bmp), "slice_0012_3.bmp");
    for (const char* ours :
         {"slice_0001.png", "slice_10000.png.part", "slice_0012_3.bmp", "slice_0012_63.bmp.part"})
        EXPECT_TRUE(raster::is_slice_name(ours)) << ours;
    for (const char* other : {"slice_.png", "slice_1.bmp", "slice_1_.bmp", "slice_1_2.png",
                              "slice_1.png.part2", "my_slice_1.png", "slice_1a.png"})
        EXPECT_FALSE(raster::is_slice_name(other)) << other;
}

/// Two a file: more than JSON of other kinds may have.
TEST(FolderSink, ManifestsHaveDigestsOfVeryManyFiles) {
    constexpr int kFiles = 600'000;
    std::string text = "{";
    for (const char* key : {"sha256", "seals"}) {
        text += fmt::format("\"{}\": {{", key);
        for (int i = 0; i < kFiles; ++i)
            text += fmt::format("{}\"{}\": \"{:064x}\"", i == 0 ? "" : ",", i, i);
        text += "},";
    }
    text += "\"complete\": true}";
    EXPECT_TRUE(manifest_is_complete(text));
    EXPECT_EQ(manifest_seals(text).size(), size_t{kFiles});
}

}  // namespace
}  // namespace openfab::testing
