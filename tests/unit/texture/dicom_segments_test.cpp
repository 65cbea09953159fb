// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Segmentations and maps of measured values: bits, fractions, labels, what stored numbers mean.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/dicom_groups.h"
#include "tools/dicom/messages.h"
#include "tools/dicom/segment_list.h"
#include "tools/texture/guarded.h"

namespace openfab::tools {
namespace {

constexpr const char* kSegmentation = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr const char* kLabelMap = "1.2.840.10008.5.1.4.1.1.66.7";
constexpr const char* kParametricMap = "1.2.840.10008.5.1.4.1.1.30";

/// A frame of a segment at a height, of pixels.
struct Part {
    int segment;
    double z;
    std::vector<uint32_t> pixels;
};

std::string segments(const std::vector<std::string>& labels) {
    std::vector<std::string> items;
    for (size_t i = 0; i < labels.size(); ++i)
        items.push_back(element(0x62, 4, "US", number(i + 1, 2)) +
                        element(0x62, 5, "LO", labels[i]));
    return sequence(0x62, 2, items);
}

std::string of_segment(int segment) {
    return sequence(0x62, 0x0a, {element(0x62, 0x0b, "US", shorts({segment}))});
}

/// Frames of 5 x 3 pixels, so that bits of frames do not begin with a byte.
Slice segmentation(const std::string& type, const std::vector<Part>& parts, double spacing = 0) {
    Slice slice;
    slice.object = type == "LABELMAP" ? kLabelMap : kSegmentation;
    slice.modality = "SEG";
    slice.width = 5;
    slice.height = 3;
    slice.intercept = 0;
    slice.is_placed = false;
    slice.frames = parts.size();
    const bool binary = type == "BINARY";
    slice.bits_allocated = slice.bits_stored = binary ? 1 : 8;
    std::vector<std::string> items;
    for (const Part& part : parts) {
        items.push_back(at_z(part.z) + (type == "LABELMAP" ? "" : of_segment(part.segment)));
        slice.pixels.insert(slice.pixels.end(), part.pixels.begin(), part.pixels.end());
    }
    std::string measures = element(0x18, 0x50, "DS", "2") + element(0x28, 0x30, "DS", "1\\1");
    if (spacing > 0) measures += element(0x18, 0x88, "DS", decimals({spacing}));
    slice.groups = element(0x62, 1, "CS", type) + segments({"aorta", "liver", "skin"});
    if (type == "FRACTIONAL") slice.groups += element(0x62, 0x0e, "US", shorts({200}));
    slice.groups += sequence(0x5200, 0x9229, {straight() + sequence(0x28, 0x9110, {measures})}) +
                    sequence(0x5200, 0x9230, items);
    if (binary) {
        slice.packed = element(0x7fe0, 0x10, "OB", bits_of(slice.pixels));
    }
    return slice;
}

class DicomSegments : public DicomTest {
  protected:
    /// The texels of each plane must be all of one number.
    void expect_planes(const std::vector<float>& planes, const VolumeOptions& options = {}) {
        const auto p = converted(options);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{5, 3, static_cast<int>(planes.size())}));
        const std::vector<float> texels = level0(*p);
        for (size_t i = 0; i < texels.size(); ++i)
            ASSERT_EQ(texels[i], planes[i / 15]) << i;
    }
    static std::vector<uint32_t> all(uint32_t value) { return std::vector<uint32_t>(15, value); }
    static VolumeOptions of(const std::string& segment) {
        VolumeOptions options;
        options.segment = segment;
        return options;
    }
};

TEST_F(DicomSegments, BitsLieAcrossFrames) {
    std::mt19937 random(5);
    for (const char* syntax : {kExplicit, kBigEndian}) {
        for (int frames = 1; frames <= 4; ++frames) {
            std::vector<Part> parts;
            for (int k = frames - 1; k >= 0; --k) {
                Part part{1, 2.0 * k, {}};
                for (int i = 0; i < 15; ++i)
                    part.pixels.push_back(random() & 1);
                parts.push_back(std::move(part));
            }
            if (std::strcmp(syntax, kExplicit) != 0) continue;  // newer than that order of bytes
            write("seg", segmentation("BINARY", parts).bytes(syntax));
            const auto p = converted();
            ASSERT_NE(p, nullptr);
            const std::vector<float> texels = level0(*p);
            ASSERT_EQ(texels.size(), 15 * parts.size());
            for (size_t i = 0; i < texels.size(); ++i)
                EXPECT_EQ(texels[i],
                          static_cast<float>(parts[parts.size() - 1 - i / 15].pixels[i % 15]))
                    << i;
        }
    }
}

TEST_F(DicomSegments, BitsThatAreCompressedAreNamed) {
    for (const char* syntax : {"1.2.840.10008.1.2.5", "1.2.840.10008.1.2.4.90"}) {
        write("seg", segmentation("BINARY", {{1, 0, all(1)}}).bytes(syntax));
        EXPECT_THAT(trouble(), testing::Says(messages::kPackedBits, syntax));
    }
}

TEST_F(DicomSegments, EachSegmentIsAFieldOverThePlanesOfAll) {
    for (const char* type : {"BINARY", "FRACTIONAL"}) {
        const bool binary = type[0] == 'B';
        const uint32_t one = binary ? 1 : 200, half = binary ? 1 : 100;
        const float part = binary ? 1.0F : 0.5F;
        // In one place, in others, and none at all.
        write("seg",
              segmentation(
                  type, {{1, 0, all(one)}, {1, 2, all(one)}, {2, 2, all(half)}, {2, 6, all(half)}})
                  .bytes());
        EXPECT_EQ(trouble(),
                  fmt::format(messages::kFramesOfSeveral, "segments", "1 (`aorta`), 2 (`liver`)") +
                      "; " + fmt::format(messages::kFramesOfSeveralChoose, "segment"));
        for (const char* name : {"aorta", "1"})
            expect_planes({1, 1, 0, 0}, of(name));
        expect_planes({0, part, 0, part}, of("liver"));
        expect_planes({0, 0, 0, 0}, of("3"));
        VolumeOptions options;
        options.field = "liver";
        expect_planes({0, part, 0, part}, options);
        EXPECT_EQ(trouble(of("spleen")), fmt::format(messages::kNoSuchSegment, "spleen",
                                                     "1 (`aorta`), 2 (`liver`), 3 (`skin`)"));
    }
    // A segment that is the only one needs no name.
    write("seg", segmentation("FRACTIONAL", {{2, 0, all(50)}}).bytes());
    expect_planes({0.25F});
}

TEST_F(DicomSegments, FramesThatAreLeftOutAreEmpty) {
    for (const char* type : {"BINARY", "LABELMAP"}) {
        write("seg", segmentation(type, {{1, 2, all(1)}, {1, 4, all(1)}, {1, 10, all(1)}}).bytes());
        expect_planes({1, 1, 0, 0, 1});
        // By the distance that it states, where no two planes are neighbours.
        write("seg", segmentation(type, {{1, 2, all(1)}, {1, 8, all(1)}}, 2).bytes());
        expect_planes({1, 0, 0, 1});
        EXPECT_EQ(extent(*converted()).z, 8);
        write("seg", segmentation(type, {{1, 2, all(1)}, {1, 4, all(1)}, {1, 7, all(1)}}).bytes());
        EXPECT_THAT(trouble(), testing::Says(messages::kSliceOutOfStep, "3.000"));
    }
}

TEST_F(DicomSegments, LabelsAreNumbersAndEachIsAField) {
    for (const char* photometric : {"MONOCHROME2", "PALETTE COLOR"}) {
        Slice slice = segmentation("LABELMAP", {{0, 0, all(0)}, {0, 2, all(2)}, {0, 4, all(3)}});
        slice.photometric = photometric;
        write("seg", slice.bytes());
        expect_planes({0, 2, 3});
        expect_planes({0, 1, 0}, of("liver"));
        expect_planes({0, 0, 1}, of("3"));
    }
    // Between labels there is nothing: a grid that is turned has fields alone.
    Slice slice = segmentation("LABELMAP", {{0, 0, all(2)}, {0, 2, all(2)}});
    const std::string plain = "1\\0\\0\\0\\1\\0", turned = "0.8\\0.6\\0\\-0.6\\0.8\\0";
    slice.groups = sequence(0x5200, 0x9229,
                            {sequence(0x20, 0x9116, {element(0x20, 0x37, "DS", turned)}) +
                             sequence(0x28, 0x9110, {element(0x28, 0x30, "DS", "1\\1")})}) +
                   sequence(0x5200, 0x9230, {at_z(0), at_z(2)}) + segments({"aorta", "liver"});
    write("seg", slice.bytes());
    EXPECT_EQ(trouble(),
              std::string(messages::kObliqueLabels) + "; " + messages::kObliqueLabelsHelp);
    EXPECT_NE(converted(of("liver")), nullptr);
}

TEST_F(DicomSegments, PartsAreListedForAnImport) {
    const auto list = [&] {
        const fs::path out = folder_.path() / "list.json";
        const Result<void> made = write_segment_list(series() / "seg", out, {});
        if (!made) return made.error().text();
        std::ifstream in(out);
        return std::string{std::istreambuf_iterator<char>(in), {}};
    };
    // L* 53.24, a* 80.09, b* 67.20 for D65 is red; for D50, as files have it, L* 54.29, a* 80.81, b* 69.89.
    const auto lab = [](double l, double a, double b) {
        return element(0x62, 0x0d, "US",
                       shorts({static_cast<int>(std::lround(l / 100 * 65535)),
                               static_cast<int>(std::lround((a + 128) / 255 * 65535)),
                               static_cast<int>(std::lround((b + 128) / 255 * 65535))}));
    };
    for (const char* type : {"BINARY", "LABELMAP"}) {
        Slice slice = segmentation(type, {{1, 0, all(1)}, {3, 2, all(type[0] == 'B' ? 1 : 3)}});
        write("seg", slice.bytes());
        EXPECT_EQ(list(), R"({"size_mm":[5,3,4],"segments":[{"number":1,"label":"aorta"},)"
                          R"({"number":3,"label":"skin"}]})");
    }
    Slice slice = segmentation("BINARY", {{1, 0, all(1)}});
    slice.groups += sequence(0x62, 2,
                             {element(0x62, 4, "US", number(1, 2)) + element(0x62, 5, "LO", "a") +
                              lab(54.29, 80.81, 69.89)});
    const std::string old = segments({"aorta", "liver", "skin"});
    slice.groups.erase(slice.groups.find(old), old.size());
    write("seg", slice.bytes());
    EXPECT_THAT(list(), HasSubstr(R"("color":"#ff0000")"));
    Slice scan;
    scan.pixels.assign(12, 0);
    write("seg", scan.bytes());
    EXPECT_EQ(list(),
              std::string(messages::kNoSegmentation) + "; " + messages::kNoSegmentationHelp);
}

TEST_F(DicomSegments, AMapHasTheValuesThatItsNumbersMean) {
    const auto mapping = [](double slope, double intercept, const std::string& more = {}) {
        return more + element(0x40, 0x9224, "FD", real(intercept)) +
               element(0x40, 0x9225, "FD", real(slope));
    };
    const auto map = [&](const std::vector<std::string>& items) {
        Slice slice;
        slice.object = kParametricMap;
        slice.width = 2;
        slice.height = 1;
        slice.slope = 1;
        slice.intercept = 0;
        slice.pixels = {400, 600};
        slice.groups = sequence(0x40, 0x9096, items);
        write("map", slice.bytes());
    };
    const auto values = [&](const VolumeOptions& options = {}) {
        return level0(*converted(options));
    };
    map({mapping(0.01, -5)});
    EXPECT_EQ(values(), (std::vector<float>{-1, 1}));
    map({mapping(0.01, -5), mapping(0.01, -5)});
    EXPECT_EQ(values(), (std::vector<float>{-1, 1}));
    map({mapping(0.01, -5), mapping(0.02, -5)});
    EXPECT_EQ(trouble(), std::string("map: ") + messages::kSeveralMappings + "; " +
                             messages::kSeveralMappingsHelp);
    map({element(0x40, 0x9212, "FD", real(1) + real(2))});
    EXPECT_EQ(trouble(), std::string("map: ") + messages::kMappingTable);
    map({});
    EXPECT_EQ(trouble(), std::string("map: ") + messages::kNoMapping);
    const std::string range =
        element(0x40, 0x9216, "US", shorts({0})) + element(0x40, 0x9211, "US", shorts({500}));
    map({mapping(0.01, -5, range)});
    EXPECT_EQ(trouble(),
              std::string("map: ") + messages::kNotMapped + "; " + messages::kGiveOutside);
    VolumeOptions options;
    options.outside = -9;
    EXPECT_EQ(values(options), (std::vector<float>{-1, -9}));

    // Others keep their rescale.
    Slice slice;
    slice.width = 2;
    slice.height = 1;
    slice.slope = 2;
    slice.intercept = 1;
    slice.pixels = {400, 600};
    slice.groups = sequence(0x40, 0x9096, {mapping(0.01, -5)});
    write("map", slice.bytes());
    EXPECT_EQ(values(), (std::vector<float>{801, 1201}));
    EXPECT_EQ(told(), "note: " + fmt::format(messages::kOtherValues, "map") + "\n");
}

TEST_F(DicomSegments, NumbersMayHaveAFraction) {
    for (const bool is_double : {false, true}) {
        for (const bool not_a_number : {false, true}) {
            const std::vector<double> values{
                0.25, -3e30, not_a_number ? std::numeric_limits<double>::quiet_NaN() : 7};
            std::string bytes;
            for (const double value : values)
                bytes += is_double ? number(std::bit_cast<uint64_t>(value), 8)
                                   : number(std::bit_cast<uint32_t>(static_cast<float>(value)), 4);
            Slice slice;
            slice.width = 3;
            slice.height = 1;
            slice.bits_allocated = slice.bits_stored = is_double ? 64 : 32;
            slice.intercept = 0;
            slice.packed = element(0x7fe0, is_double ? 9 : 8, is_double ? "OD" : "OF", bytes);
            write("map", slice.bytes());
            if (!not_a_number) {
                EXPECT_EQ(level0(*converted()), (std::vector<float>{0.25F, -3e30F, 7}));
                slice.packed = element(0x7fe0, is_double ? 9 : 8, is_double ? "OD" : "OF",
                                       bytes.substr(0, bytes.size() - 2));
                write("map", slice.bytes());
                const int all = is_double ? 24 : 12;
                EXPECT_EQ(trouble(),
                          "map: " + fmt::format(messages::kPixelsCutShort, all - 2, all) + "; " +
                              messages::kCopyItAgain);
                continue;
            }
            EXPECT_EQ(trouble(), std::string("map: ") + messages::kValueNotANumber + "; " +
                                     messages::kGiveOutside);
            VolumeOptions options;
            options.outside = 5;
            EXPECT_EQ(level0(*converted(options)), (std::vector<float>{0.25F, -3e30F, 5}));
        }
    }
}

TEST_F(DicomSegments, IntegersOfAllWidthsAreKeptOrTold) {
    for (const int bits : {8, 16, 32}) {
        for (const bool has_sign : {false, true}) {
            for (const char* syntax : {kExplicit, kBigEndian}) {
                const uint64_t most = (uint64_t{1} << bits) - 1, high = uint64_t{1} << (bits - 1);
                Slice slice;
                slice.width = 4;
                slice.height = 1;
                slice.intercept = 0;
                slice.bits_allocated = slice.bits_stored = bits;
                slice.has_sign = has_sign;
                const std::vector<uint64_t> stored{0, 1, high, most & ~uint64_t{255} >> 8};
                for (const uint64_t value : stored)
                    slice.pixels.push_back(static_cast<uint32_t>(value));
                write("im", slice.bytes(syntax));
                std::vector<float> wanted;
                for (const uint64_t value : stored) {
                    const auto whole = static_cast<int64_t>(value);
                    wanted.push_back(static_cast<float>(has_sign && value >= high
                                                            ? whole - static_cast<int64_t>(most) - 1
                                                            : whole));
                }
                EXPECT_EQ(level0(*converted()), wanted) << bits << has_sign << syntax;
                const bool fits = bits < 32 || has_sign;
                EXPECT_EQ(told(), fits || (stored[3] & 255) == 0
                                      ? std::string()
                                      : "note: " + fmt::format(messages::kRounded, "im") + "\n");
            }
        }
    }
}

TEST_F(DicomSegments, WhatIsNoVolumeIsNamed) {
    Slice slice;
    slice.pixels.assign(12, 0);
    slice.object = "1.2.840.10008.5.1.4.1.1.481.3";
    const std::string contours = slice.bytes();
    write("a", contours.substr(0, contours.find(element(0x28, 2, "US", number(1, 2)))));
    EXPECT_EQ(trouble(), std::string("a: ") + messages::kContours + "; " + messages::kContoursHelp);
    slice.object = "1.2.840.10008.5.1.4.1.1.66.5";
    write("a", slice.bytes());
    EXPECT_EQ(trouble(), std::string("a: ") + messages::kSurfaces + "; " + messages::kSurfacesHelp);
    slice.object = "1.2.840.10008.5.1.4.1.1.77.1.6";
    slice.groups = element(0x20, 0x9311, "CS", "TILED_FULL");
    write("a", slice.bytes());
    EXPECT_EQ(trouble(), std::string("a: ") + messages::kTiles);
}

TEST_F(DicomSegments, DamagedSegmentationsAreErrors) {
    const int many = testing::long_run() ? 1000 : 25;
    int wrong = 0;
    for (const char* type : {"BINARY", "FRACTIONAL", "LABELMAP"}) {
        const std::string whole =
            segmentation(type, {{1, 0, all(1)}, {2, 2, all(1)}, {1, 8, all(1)}}, 2).bytes();
        for (int seed = 0; seed < many; ++seed) {
            std::mt19937_64 random(static_cast<uint64_t>(seed));
            write("seg", testing::mutate(whole, false, &random));
            VolumeOptions options;
            if (type[0] != 'L') options.segment = "1";
            const Result<void> made = guarded(50'000'000, series(), [&] {
                return make_dicom_volume_file(series(), folder_.path() / "out.oftx", options,
                                              {50'000'000, {}});
            });
            if (made) continue;
            ++wrong;
            EXPECT_EQ(made.error().code, ErrorCode::kUserInput)
                << "seed " << seed << ": " << made.error().text();
        }
    }
    EXPECT_GT(wrong, many / 2) << "most of the file is heads";
}

}  // namespace
}  // namespace openfab::tools
