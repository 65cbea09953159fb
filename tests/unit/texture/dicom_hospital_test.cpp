// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Folders as hospitals hand them out: several series, scouts, lists and notes among slices, slices that
// were copied in part, files of many frames, old orders of bytes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/dicom_files.h"
#include "tests/unit/texture/guarded_error.h"
#include "tools/dicom/messages.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

class DicomHospital : public DicomTest {
  protected:
    /// Reads a folder whose texels must be the field's.
    void expect_field(const Vec3i& wanted, const Vec3d& from) {
        const auto p = converted();
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), wanted);
        EXPECT_EQ(origin(*p), from);
        each(*p, [](const Vec3d& at, const float* value) {
            EXPECT_EQ(*value, static_cast<float>(linear(at)));
        });
    }
    /// Adds frames of which each says where it lies, in no order of places.
    static void add_enhanced(Slice* slice, const Vec3d& step, bool big) {
        const Vec3d first = slice->position;
        slice->is_placed = false;
        slice->frames = 5;
        std::vector<std::string> items;
        for (int k = 0; k < 5; ++k) {
            const Vec3d at = first + step * static_cast<double>(k * 3 % 5);
            add_frame(slice, at);
            items.push_back(sequence(
                0x20, 0x9113, {element(0x20, 0x32, "DS", decimals({at.x, at.y, at.z}), big)}, big));
        }
        const std::string turned = decimals({slice->across.x, slice->across.y, slice->across.z,
                                             slice->down.x, slice->down.y, slice->down.z});
        slice->groups =
            sequence(0x5200, 0x9229,
                     {sequence(0x20, 0x9116, {element(0x20, 0x37, "DS", turned, big)}, big) +
                      sequence(0x28, 0x9145,
                               {element(0x28, 0x1052, "DS", decimals({slice->intercept}), big) +
                                element(0x28, 0x1053, "DS", decimals({slice->slope}), big)},
                               big)},
                     big) +
            sequence(0x5200, 0x9230, items, big);
        // What is said at the top does not count then.
        slice->slope = 77;
    }
    static std::string spacing(double step_mm) {
        return element(0x18, 0x88, "DS", decimals({step_mm}));
    }
};

TEST_F(DicomHospital, PixelsThatAreCutShortAreCounted) {
    Slice slice;
    slice.width = slice.height = 64;
    for (int k = 0; k < 3; ++k) {
        slice.position.z = k;
        slice.pixels.assign(64 * 64, 1000);
        write(fmt::format("im{}", k), slice.bytes());
    }
    ASSERT_EQ(trouble(), "no error");
    const std::string whole = slice.bytes(), help = messages::kCopyItAgain;
    write("im2", whole.substr(0, whole.size() - 62));
    EXPECT_EQ(trouble(),
              "im2: " + fmt::format(messages::kPixelsCutShort, 8130, 8192) + "; " + help);
    // Its length says so, too.
    slice.pixels.resize(4065);
    write("im2", slice.bytes());
    EXPECT_EQ(trouble(),
              "im2: " + fmt::format(messages::kPixelsCutShort, 8130, 8192) + "; " + help);
    slice.pixels.assign(64 * 64, 1000);
    const std::string packed = slice.bytes(kRunLengths);
    write("im2", packed);
    EXPECT_EQ(trouble(), "no error");
    write("im2", packed.substr(0, packed.size() - 100));
    // An empty table, the head of a frame, 64 bytes of its own head and two planes of 41 runs; 8 bytes end all.
    const int needed = 8 + 8 + 64 + 2 * (64 * 64 + 41 + 1);
    EXPECT_EQ(trouble(),
              "im2: " + fmt::format(messages::kPixelsCutShort, needed - 92, needed) + "; " + help);
}

TEST_F(DicomHospital, SeriesAreListedAndOneIsNamed) {
    Slice slice;
    slice.description = "Thorax 1.0 B30f";
    write_series(slice, {0, 0, 1});
    Slice scout = slice;
    scout.series = "1.2.4";
    scout.series_number = 7;
    scout.description = "Scout";
    scout.width = 2;
    scout.down = {0, 0, -1};
    fill(&scout);
    write("scout", scout.bytes());
    const std::string both =
        fmt::format(messages::kSeriesLine, 1, "CT, ", 4, 3, 1.0, 1.0, "axial", 8,
                    fmt::format(messages::kSeriesLine, "s, `Thorax 1.0 B30f`), 7", "CT, ", 2, 3,
                                1.0, 1.0, "coronal", 1, " scout, `Scout`)"));
    EXPECT_EQ(trouble(), fmt::format(messages::kNotOfOneSeries, "series", "") + both + "; " +
                             messages::kNotOfOneSeriesIdentifier);
    VolumeOptions options;
    for (const char* name : {"7", "1.2.4", "Scout"}) {
        options.field = name;
        const auto p = converted(options);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{2, 1, 3})) << name;
    }
    for (const char* name : {"1", "1.2.3", "Thorax 1.0 B30f"}) {
        options.field = name;
        const auto p = converted(options);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{4, 3, 8})) << name;
    }
    options.field = "2";
    EXPECT_EQ(trouble(options), fmt::format(messages::kNoSuchSeries, 2, "") + both);

    // Numbers that do not tell them apart.
    scout.series_number = 1;
    write("scout", scout.bytes());
    options.field = "1";
    for (const VolumeOptions& any : {VolumeOptions(), options})
        EXPECT_THAT(trouble(any),
                    AllOf(HasSubstr(": 1.2.3 (CT, 4 x 3"), HasSubstr("), 1.2.4 (CT, 2 x 3")));
    options.field = "1.2.4";
    EXPECT_NE(converted(options), nullptr);

    // A scout of the same series.
    scout.series = "1.2.3";
    write("scout", scout.bytes());
    EXPECT_THAT(trouble(), AllOf(testing::Says(messages::kNotOfOneSeries, "grid", "1/1 (CT, 4 x 3"),
                                 HasSubstr("), 1/2 (CT, 2 x 3")));
    options.field = "1/1";
    const auto p = converted(options);
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{4, 3, 8}));
}

TEST_F(DicomHospital, AMissingSliceOfFourIsNotTheRule) {
    Slice slice;
    for (const int z : {0, 1, 3}) {
        slice.position.z = 2.5 * z;
        fill(&slice);
        write(fmt::format("im{}", z), slice.bytes());
    }
    EXPECT_THAT(trouble(), testing::Says(messages::kSlicesAreMissing, "1", " is", "im1", "0", "0",
                                         "2.5", "im3", "0", "0", "7.5", "5.000", "2.500"));
    fs::remove(series() / "im1");
    slice.position.z = 2.5 * 4;
    fill(&slice);
    write("im4", slice.bytes());
    EXPECT_THAT(trouble(), HasSubstr("2 slices are missing between im0, at "));
    slice.position.z = 9.25;
    write("im4", slice.bytes());
    EXPECT_THAT(trouble(), HasSubstr("im3: it lies 7.500 mm from im0, where slices are 1.750 mm"));
}

TEST_F(DicomHospital, FramesLieWhereEachSays) {
    for (const char* syntax : {kExplicit, kBigEndian, kRunLengths}) {
        SCOPED_TRACE(syntax);
        Slice slice;
        slice.position = {-3, 4, 10};
        slice.column_mm = 0.5;
        add_enhanced(&slice, {0, 0, 2}, syntax == std::string(kBigEndian));
        write("enhanced", slice.bytes(syntax));
        expect_field({4, 3, 5}, {-3.25, 3.5, 9});
    }
}

TEST_F(DicomHospital, FramesMayBeMissing) {
    Slice slice;
    slice.position = {0, 0, 1};
    add_enhanced(&slice, {0, 0, 2}, false);
    std::string whole = slice.bytes();
    write("enhanced", whole.substr(0, whole.size() - 25));
    EXPECT_THAT(trouble(), ::testing::HasSubstr("enhanced: " +
                                                fmt::format(messages::kPixelsCutShort, 95, 120)));
    // The fourth frame (in places 0 3 1 4 2) moves from 9 mm to where the fifth is.
    const size_t at = whole.find("0\\0\\9");
    ASSERT_NE(at, std::string::npos);
    whole[at + 4] = '5';
    write("enhanced", whole);
    EXPECT_THAT(trouble(),
                ::testing::HasSubstr("enhanced, frame 5: " +
                                     fmt::format(messages::kSliceAtSamePlace, "enhanced, frame 4") +
                                     "; " + messages::kSliceAtSamePlaceHelp));
}

TEST_F(DicomHospital, FramesOfOneDistance) {
    Slice slice;
    slice.position = {1, 2, 3};
    slice.frames = 4;
    for (int k = 0; k < 4; ++k)
        add_frame(&slice, slice.position - Vec3d{0, 0, 1.5 * k});
    std::string bytes = slice.bytes();
    // Before the elements of group 0020.
    bytes.insert(bytes.find(element(0x20, 0x0e, "UI", slice.series)), spacing(-1.5));
    write("frames", bytes);
    expect_field({4, 3, 4}, {0.5, 1.5, -2.25});
}

TEST_F(DicomHospital, FramesWithoutAPlaceAreInPlaceTowardsEachOther) {
    Slice slice;
    slice.is_placed = false;
    slice.frames = 3;
    for (int k = 0; k < 3; ++k)
        add_frame(&slice, {0, 0, 2.0 * k});
    std::string bytes = slice.bytes();
    bytes.insert(bytes.find(element(0x20, 0x0e, "UI", slice.series)), spacing(2));
    write("frames", bytes);
    expect_field({4, 3, 3}, {-0.5, -0.5, -1});
    EXPECT_EQ(told(), fmt::format(messages::kPlaceUnknown, "note: frames") + "\n");
}

TEST_F(DicomHospital, DosesHaveOffsetsAndAScale) {
    Slice slice;
    slice.width = slice.height = 1;
    slice.bits_allocated = slice.bits_stored = 32;
    slice.intercept = 0;
    slice.position = {0, 0, 5};
    slice.frames = 3;
    slice.pixels = {7, 4'000'000'000, 70'000};
    slice.groups = element(0x3004, 0x0c, "DS", "0\\2\\4") + element(0x3004, 0x0e, "DS", "0.25");
    write("dose", slice.bytes());
    const auto p = converted();
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(origin(*p), (Vec3d{-0.5, -0.5, 4}));
    EXPECT_EQ(level0(*p), (std::vector<float>{1.75f, 1e9f, 17'500}));
    EXPECT_EQ(told(), "");
    slice.object = "1.2.840.10008.5.1.4.1.1.481.2";
    slice.groups = element(0x3004, 0x02, "CS", "RELATIVE") + slice.groups;
    write("dose", slice.bytes());
    EXPECT_EQ(told(), "note: " + fmt::format(messages::kRelativeDose, "dose") + "\n");
    // More pixels than its frames.
    slice.pixels.push_back(1);
    write("dose", slice.bytes());
    EXPECT_THAT(told(), HasSubstr("note: " + fmt::format(messages::kPixelsBehind, "dose") + "\n"));
}

TEST_F(DicomHospital, BigEndianPixelsHaveTheirValues) {
    Slice slice;
    slice.position = {-10, 5, 2};
    write_series(slice, {0, 0, 1.5}, kBigEndian);
    expect_field({4, 3, 8}, {-10.5, 4.5, 1.25});
    fs::remove_all(series());
    fs::create_directory(series());

    Slice one;
    one.width = 3;
    one.height = 1;
    one.has_sign = true;
    one.bits_stored = 16;
    one.slope = 2;
    one.intercept = 1;
    one.pixels = {0x8000, 0xffff, 0x0102};
    write("a", one.bytes(kBigEndian));
    EXPECT_EQ(level0(*converted()), (std::vector<float>{-65535, -1, 517}));

    // Of 8 bits, two in a word; the second frame begins within one.
    one.bits_allocated = one.bits_stored = 8;
    one.frames = 2;
    one.pixels = {1, 2, 0xff, 4, 5, 6};
    std::string bytes = one.bytes(kBigEndian);
    bytes.insert(bytes.find(element(0x20, 0x0e, "UI", one.series, true)),
                 element(0x18, 0x88, "DS", "1", true));
    write("a", bytes);
    EXPECT_EQ(level0(*converted()), (std::vector<float>{3, 5, -1, 9, 11, 13}));
}

TEST_F(DicomHospital, ValuesAreAsStoredHoweverTheyAreShown) {
    Slice slice;
    slice.photometric = "MONOCHROME1";
    write_series(slice, {0, 0, 1});
    expect_field({4, 3, 8}, {-0.5, -0.5, -0.5});
    EXPECT_EQ(
        told(),
        "note: " + fmt::format(messages::kStoredMonochrome1, "im0, im1, im2, im3, im4 and 3 more") +
            "\n");
    slice.photometric = "PALETTE COLOR ";
    write_series(slice, {0, 0, 1});
    EXPECT_EQ(trouble(), "im0: " + fmt::format(messages::kPixelsAreColours, "PALETTE COLOR"));
}

TEST_F(DicomHospital, WhatIsNoSliceIsPassedOverAndTold) {
    Slice slice;
    slice.position = {0, 0, 1};
    write_series(slice, {0, 0, 1});
    EXPECT_EQ(told(), "");
    write("DICOMDIR", "a list");
    write("README", "how to see it");
    write("preview.jpg", "\xff\xd8");
    write("empty", "");
    expect_field({4, 3, 8}, {-0.5, -0.5, 0.5});
    EXPECT_EQ(told(), fmt::format(messages::kPassedOverNoSlices, "note: series",
                                  "DICOMDIR, README, empty, preview.jpg\n"));

    // A picture of a report, and a report, of series of their own.
    Slice report = slice;
    report.series = "1.2.9";
    report.series_number = 9;
    report.photometric = "PALETTE COLOR";
    report.pixels.assign(12, 0);
    write("report", report.bytes());
    const std::string text = report.bytes();
    write("words", text.substr(0, text.find(element(0x28, 2, "US", number(1, 2)))));
    expect_field({4, 3, 8}, {-0.5, -0.5, 0.5});
    EXPECT_THAT(told(),
                testing::Says(
                    messages::kPassedOverOtherSeries, "note: series",
                    "report (its pixels are colours (PALETTE COLOR)), words (it has no pixels)\n"));
    VolumeOptions options;
    options.field = "9";
    EXPECT_EQ(trouble(options),
              "report: " + fmt::format(messages::kPixelsAreColours, "PALETTE COLOR"));
    // One of the same series may be a slice.
    report.series = slice.series;
    write("report", report.bytes());
    EXPECT_EQ(trouble(), "report: " + fmt::format(messages::kPixelsAreColours, "PALETTE COLOR"));
}

TEST_F(DicomHospital, ABrokenListIsPassedOverWhateverItsName) {
    Slice slice;
    slice.position = {0, 0, 1};
    write_series(slice, {0, 0, 1});
    Slice list = slice;
    list.object = "1.2.840.10008.1.3.10";
    const std::string bytes = list.bytes();
    const size_t head = bytes.find(element(8, 0x16, "UI", list.object));
    ASSERT_NE(head, std::string::npos);
    // A sequence that is cut short, and bytes that are no elements.
    for (const std::string& rest :
         {sequence(4, 0x1220, {element(4, 0x1430, "CS", "PATIENT")}).substr(0, 20),
          std::string(50, '\xa5')}) {
        for (const char* name : {"DICOMDIR", "dicomdir.bak", "LIST.DCM", "DICOMDIR.1"}) {
            SCOPED_TRACE(name);
            write(name, bytes.substr(0, head) + rest);
            expect_field({4, 3, 8}, {-0.5, -0.5, 0.5});
            EXPECT_EQ(told(),
                      fmt::format(messages::kPassedOverNoSlices, "note: series", name) + "\n");
            fs::remove(series() / name);
        }
    }
    // What might be a slice is not.
    write("im0", slice.bytes().substr(0, head) + std::string(50, '\xa5'));
    EXPECT_EQ(trouble(), std::string("im0: ") + messages::kNotDicom);
}

TEST_F(DicomHospital, TilesAndTablesAreNotTakenForValues) {
    Slice slice;
    slice.pixels.assign(12, 0);
    slice.more = sequence(0x28, 0x3000, {});
    write("a", slice.bytes());
    EXPECT_EQ(trouble(), std::string("a: ") + messages::kModalityLut);
    slice.more.clear();
    std::string bytes = slice.bytes();
    const std::string after = element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2");
    bytes.insert(bytes.find(after), element(8, 8, "CS", "ORIGINAL\\PRIMARY\\M\\MOSAIC"));
    write("a", bytes);
    EXPECT_EQ(trouble(), std::string("a: ") + messages::kMosaic + "; " + messages::kMosaicHelp);
}

TEST_F(DicomHospital, AFolderWithoutSlicesSaysWhy) {
    write("DICOMDIR", "a list");
    EXPECT_EQ(trouble(), std::string(messages::kNoSlices) + "; " + messages::kNoSlicesHelp);
    write("README", "a list");
    EXPECT_EQ(trouble(), std::string(messages::kNoSlices) + "; " + messages::kNoSlicesHelp);
}

TEST_F(DicomHospital, TooManyOrientationsAreRefused) {
    Slice slice;
    slice.width = slice.height = 1;
    slice.is_placed = false;
    slice.frames = 1001;
    std::vector<std::string> items;
    for (size_t k = 0; k < slice.frames; ++k) {
        const double angle = 0.003 * static_cast<double>(k);
        const std::string turned =
            decimals({std::cos(angle), std::sin(angle), 0, -std::sin(angle), std::cos(angle), 0});
        items.push_back(sequence(0x20, 0x9113, {element(0x20, 0x32, "DS", "0\\0\\0")}) +
                        sequence(0x20, 0x9116, {element(0x20, 0x37, "DS", turned)}));
        slice.pixels.push_back(0);
    }
    slice.row_mm = slice.column_mm = 100;
    slice.groups = sequence(0x5200, 0x9230, items);
    write("radial", slice.bytes());
    EXPECT_EQ(trouble(),
              fmt::format(messages::kTooManySeries, 1000) + "; " + messages::kTooManySeriesHelp);
}

TEST_F(DicomHospital, DamagedFilesOfFramesAreErrors) {
    const int many = testing::long_run() ? 1000 : 25;
    int wrong = 0;
    for (const char* syntax : {kExplicit, kBigEndian, kRunLengths}) {
        Slice slice;
        slice.position = {0, 0, 1};
        add_enhanced(&slice, {0, 0, 2}, syntax == std::string(kBigEndian));
        const std::string whole = slice.bytes(syntax);
        for (int seed = 0; seed < many; ++seed) {
            std::mt19937_64 random(static_cast<uint64_t>(seed));
            write("enhanced", testing::mutate(whole, false, &random));
            const Result<void> made = guarded(50'000'000, series(), [&] {
                return make_dicom_volume_file(series(), folder_.path() / "out.oftx", {},
                                              {50'000'000, {}});
            });
            if (made) continue;
            ++wrong;
            EXPECT_EQ(made.error().code, ErrorCode::kUserInput)
                << "seed " << seed << ": " << made.error().text();
            EXPECT_THAT(made.error().text(), SaysWhyNotRead()) << "seed " << seed;
        }
    }
    EXPECT_GT(wrong, many / 2) << "most of the file is heads";
}

}  // namespace
}  // namespace openfab::tools
