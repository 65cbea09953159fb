// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// How files and media hold slices: items, fragments, compression, planes at several distances, folders.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <numeric>
#include <random>

#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/dicom_groups.h"
#include "tools/dicom/messages.h"
#include "tools/texture/guarded.h"

namespace openfab::tools {
namespace {

constexpr const char* kRawItems = "1.2.840.10008.1.2.1.98";
constexpr const char* kDeflatedItems = "1.2.840.10008.1.2.8.1";

std::string deflated(const std::string& bytes) {
    z_stream stream{};
    deflateInit2(&stream, 9, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
    std::string out(bytes.size() + 100, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    out.resize(stream.total_out + stream.total_out % 2);
    deflateEnd(&stream);
    return out;
}

class DicomStorage : public DicomTest {
  protected:
    /// Three frames of 4 x 3 pixels.
    static Slice frames() {
        Slice slice;
        slice.intercept = 0;
        slice.frames = 3;
        slice.position = {0, 0, 0};
        slice.groups = element(0x18, 0x88, "DS", "1");
        for (uint32_t i = 0; i < 36; ++i)
            slice.pixels.push_back(i * 77);
        return slice;
    }
    static std::string frame(const Slice& slice, size_t k) {
        std::string out;
        for (size_t i = 0; i < 12; ++i)
            out += number(slice.pixels[12 * k + i], 2);
        return out;
    }
    void expect_frames(const VolumeOptions& options = {}) {
        std::vector<float> wanted;
        for (int i = 0; i < 36; ++i)
            wanted.push_back(static_cast<float>(i * 77));
        const auto p = converted(options);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(level0(*p), wanted);
    }
    /// Doses in planes at these distances from the first.
    Slice dose(const std::string& offsets, const std::vector<uint32_t>& values) {
        Slice slice;
        slice.object = "1.2.840.10008.5.1.4.1.1.481.2";
        slice.width = slice.height = 1;
        slice.intercept = 0;
        slice.position = {0, 0, 5};
        slice.frames = values.size();
        slice.pixels = values;
        slice.groups = element(0x3004, 0x0c, "DS", offsets);
        return slice;
    }
};

TEST_F(DicomStorage, FramesMayBeInSeveralItems) {
    Slice slice = frames();
    std::vector<std::string> pieces;
    std::string offsets, long_offsets;
    size_t at = 0;
    for (size_t k = 0; k < 3; ++k) {
        offsets += number(at, 4);
        long_offsets += number(at, 8);
        const std::string whole = frame(slice, k);
        for (size_t from = 0; from < whole.size(); from += 10) {
            pieces.push_back(whole.substr(from, 10));
            at += 8 + pieces.back().size();
        }
    }
    slice.packed = items_of_pixels(offsets, pieces);
    write("frames", slice.bytes(kRawItems));
    expect_frames();
    slice.packed = element(0x7fe0, 1, "OV", long_offsets) + items_of_pixels("", pieces);
    write("frames", slice.bytes(kRawItems));
    expect_frames();
    slice.packed = items_of_pixels("", {frame(slice, 0), frame(slice, 1), frame(slice, 2)});
    write("frames", slice.bytes(kRawItems));
    expect_frames();
    const auto problem = [&](const std::string& table) {
        slice.packed = items_of_pixels(table, pieces);
        write("frames", slice.bytes(kRawItems));
        return trouble();
    };
    const std::string unknown = "frames: " + fmt::format(messages::kFramesInFragments, 3, 9) +
                                "; " + messages::kWriteUncompressed;
    EXPECT_EQ(problem(""), unknown);
    EXPECT_EQ(problem(number(0, 4) + number(7, 4) + number(64, 4)), unknown);
    pieces.resize(2);
    EXPECT_EQ(problem(""), "frames: " + fmt::format(messages::kFramesOfItems, 2, 3) + "; " +
                               messages::kCopyItAgain);
}

TEST_F(DicomStorage, FramesMayBeDeflatedEachByItself) {
    Slice slice = frames();
    slice.packed = items_of_pixels(
        "", {deflated(frame(slice, 0)), deflated(frame(slice, 1)), deflated(frame(slice, 2))});
    write("frames", slice.bytes(kDeflatedItems));
    expect_frames();
    slice.packed = items_of_pixels(
        "", {deflated(frame(slice, 0)), deflated("short"), deflated(frame(slice, 2))});
    write("frames", slice.bytes(kDeflatedItems));
    EXPECT_EQ(trouble(), std::string("frames, frame 2: ") + messages::kPackedPixelsDamaged);
}

TEST_F(DicomStorage, CompressionThatIsNotReadIsNamed) {
    Slice slice = frames();
    slice.packed = items_of_pixels("", {"ab", "cd", "ef"});
    for (const auto& [syntax, name] : {std::pair{"1.2.840.10008.1.2.4.110", "JPEG XL"},
                                       std::pair{"1.2.840.10008.1.2.4.102", "MPEG-4"},
                                       std::pair{"1.2.3.4", "of an unknown kind"}}) {
        write("frames", slice.bytes(syntax));
        EXPECT_EQ(trouble(), "frames: " + fmt::format(messages::kSyntaxNotRead, name, syntax) +
                                 "; " + messages::kWriteUncompressed);
    }
    write("frames", slice.bytes("1.2.840.10008.1.2.4.201"));
    EXPECT_THAT(trouble(), HasSubstr("HTJ2K (1.2.840.10008.1.2.4.201)"));
}

TEST_F(DicomStorage, NewerKindsOfObjectsMayBeCompressed) {
    for (const char* object :
         {"1.2.840.10008.5.1.4.1.1.66.7", "1.2.840.10008.5.1.4.1.1.2.2", "1.2.3"}) {
        Slice slice = frames();
        slice.object = object;
        write("frames", slice.bytes(kRunLengths));
        expect_frames();
    }
}

TEST_F(DicomStorage, DosesInPlanesAtSeveralDistancesAreFilled) {
    write("dose", dose("0\\3\\6\\12", {0, 1, 2, 4}).bytes());
    auto p = converted();
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(level0(*p), (std::vector<float>{0, 1, 2, 3, 4}));
    EXPECT_EQ(origin(*p).z, 3.5);
    write("dose", dose("0\\2\\5", {0, 2, 5}).bytes());
    EXPECT_EQ(level0(*converted()), (std::vector<float>{0, 1, 2, 3, 4, 5}));
    write("dose", dose("0\\3\\6.7", {0, 1, 2}).bytes());
    EXPECT_EQ(trouble(), "dose, frame 3: " +
                             fmt::format(messages::kSliceOutOfStep, 3.7, "dose, frame 2", 3.0) +
                             "; " + messages::kUnequalFramesHelp);
    // Offsets that are positions along z, whichever way the planes look.
    for (const double y : {1.0, -1.0}) {
        Slice slice = dose("5\\8\\11", {1, 2, 3});
        slice.down = {0, y, 0};
        write("dose", slice.bytes());
        p = converted();
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(level0(*p), (std::vector<float>{1, 2, 3})) << y;
        EXPECT_EQ(origin(*p).z, 3.5);
    }
    write("dose", dose("4\\7\\10", {1, 2, 3}).bytes());
    EXPECT_THAT(trouble(), testing::Says(messages::kFrameOffsetsStart, "4"));
    // Of others a gap is one, and a file cannot be copied again.
    Slice slice = frames();
    slice.is_placed = false;
    slice.groups = sequence(0x5200, 0x9229, {straight()}) +
                   sequence(0x5200, 0x9230, {at_z(0), at_z(1), at_z(3)});
    write("dose", slice.bytes());
    EXPECT_THAT(trouble(), testing::Says(messages::kSlicesAreMissing));
    EXPECT_THAT(trouble(), HasSubstr(messages::kUnequalFramesHelp));
}

TEST_F(DicomStorage, ColumnsThatAreNearlyStraightAre) {
    Slice slice = frames();
    slice.across = {1, 1e-5, 0};
    slice.down = {-1e-5, 1, 0};
    write("frames", slice.bytes());
    expect_frames();
    slice.across = {1, 1e-4, 0};
    slice.down = {-1e-4, 1, 0};
    write("frames", slice.bytes());
    EXPECT_THAT(trouble(), testing::Says(messages::kObliqueSlices));
    // Of a wide slice the sixth decimal is rounding, more is not.
    constexpr int kWide = 600;
    Slice wide;
    wide.width = kWide;
    wide.height = 1;
    for (uint32_t i = 0; i < kWide; ++i)
        wide.pixels.push_back(1000 + i);
    for (const double aside : {1e-6, -1e-6, 2e-6}) {
        wide.across = {1, aside, 0};
        wide.down = {-aside, 1, 0};
        write("frames", wide.bytes());
        if (std::abs(aside) > 1.5e-6) {
            EXPECT_THAT(trouble(), testing::Says(messages::kObliqueSlices));
            continue;
        }
        const auto made = converted();
        ASSERT_NE(made, nullptr);
        std::vector<float> wanted(kWide);
        std::iota(wanted.begin(), wanted.end(), 0.0F);
        EXPECT_EQ(level0(*made), wanted);
    }
}

TEST_F(DicomStorage, AMediumIsReadByItsListOrItsFolders) {
    const auto put = [&](const char* series, int number, const char* date, const char* folder) {
        Slice slice;
        slice.width = slice.height = 1;
        slice.intercept = 0;
        slice.series = series;
        slice.series_number = number;
        slice.more = element(8, 0x21, "DA", date);
        fs::create_directories(this->series() / folder);
        for (int k = 0; k < 2; ++k) {
            slice.position.z = k;
            slice.pixels = {static_cast<uint32_t>(10 * number + k)};
            write(fmt::format("{}/IM{}", folder, k), slice.bytes());
        }
    };
    put("1.2.3", 2, "20240105", "DICOM/ST0/SE0");
    put("1.2.4", 3, "20240106", "DICOM/ST0/SE1");
    for (const bool has_list : {false, true}) {
        if (has_list) write("DICOMDIR", "a list");
        EXPECT_EQ(trouble(),
                  fmt::format(messages::kNotOfOneSeries, "series",
                              fmt::format(messages::kSeriesLine, 2, "CT of 2024-01-05, ", 1, 1, 1.0,
                                          1.0, "axial", 2, "s), ") +
                                  fmt::format(messages::kSeriesLine, 3, "CT of 2024-01-06, ", 1, 1,
                                              1.0, 1.0, "axial", 2, "s)")) +
                      "; " + messages::kNotOfOneSeriesIdentifier);
        VolumeOptions options;
        options.field = "3";
        EXPECT_EQ(level0(*converted(options)), (std::vector<float>{30, 31}));
    }
    VolumeOptions options;
    options.field = "2";
    const fs::path out = folder_.path() / "out.oftx";
    ASSERT_TRUE(make_dicom_volume_file(series() / "DICOMDIR", out, options));
    EXPECT_EQ(level0(**Pyramid::open(out, 0, 0)), (std::vector<float>{20, 21}));
    // A file of the medium that is damaged is named by its path.
    write("DICOM/ST0/SE0/IM1", "no scan");
    fs::rename(series() / "DICOM/ST0/SE0/IM1", series() / "DICOM/ST0/SE0/IM1.dcm");
    EXPECT_EQ(trouble(options), std::string("DICOM/ST0/SE0/IM1.dcm: ") + messages::kNotDicom);
}

TEST_F(DicomStorage, DamagedItemsAreErrors) {
    Slice slice = frames();
    std::vector<std::string> pieces;
    std::string offsets;
    for (size_t k = 0; k < 3; ++k) {
        offsets += number(k * 40, 4);
        pieces.push_back(frame(slice, k).substr(0, 12));
        pieces.push_back(frame(slice, k).substr(12));
    }
    slice.packed = items_of_pixels(offsets, pieces);
    const std::string whole = slice.bytes(kRawItems);
    write("frames", whole);
    expect_frames();
    const int many = testing::long_run() ? 1000 : 40;
    int wrong = 0;
    for (int seed = 0; seed < many; ++seed) {
        std::mt19937_64 random(static_cast<uint64_t>(seed));
        write("frames", testing::mutate(whole, false, &random));
        const Result<void> made = guarded(50'000'000, series(), [&] {
            return make_dicom_volume_file(series(), folder_.path() / "out.oftx", {},
                                          {50'000'000, {}});
        });
        if (made) continue;
        ++wrong;
        EXPECT_EQ(made.error().code, ErrorCode::kUserInput)
            << "seed " << seed << ": " << made.error().text();
    }
    EXPECT_GT(wrong, many / 4) << "most of the file is heads";
}

}  // namespace
}  // namespace openfab::tools
