// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Volumes that are slices: pictures of a folder, and the pages of one file.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "base/color.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/volume_files.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

/// A TIFF of pages of 2 x 1, each with its number in it; the last one's next offset is
/// `behind_last`.
std::string tiff(size_t pages, bool big_endian, bool large, uint64_t behind_last = 0) {
    std::string out;
    const auto put = [&](uint64_t value, size_t bytes) {
        for (size_t k = 0; k < bytes; ++k)
            out += static_cast<char>(value >> 8 * (big_endian ? bytes - 1 - k : k) & 0xff);
    };
    const size_t domain = large ? 8 : 4, entry = large ? 20 : 12, count = large ? 8 : 2;
    out = big_endian ? "MM" : "II";
    put(large ? 43 : 42, 2);
    if (large) put(8, 2), put(0, 2);
    put(out.size() + domain, domain);
    for (size_t page = 0; page < pages; ++page) {
        const std::array<std::pair<int, uint64_t>, 9> tags = {{{256, 2},
                                                               {257, 1},
                                                               {258, 8},
                                                               {259, 1},
                                                               {262, 1},
                                                               {273, 0},
                                                               {277, 1},
                                                               {278, 1},
                                                               {279, 2}}};
        const size_t data = out.size() + count + tags.size() * entry + domain;
        put(tags.size(), count);
        for (const auto& [tag, value] : tags) {
            put(static_cast<uint64_t>(tag), 2);
            put(4, 2);
            put(1, domain);
            put(tag == 273 ? data : value, 4);
            out.append(domain - 4, '\0');
        }
        put(page + 1 < pages ? data + 2 : behind_last, domain);
        out += std::string(2, static_cast<char>(page % 256));
    }
    return out;
}

TEST_F(VolumeTest, SlicesInOrderOfTheirNumbers) {
    for (const int k : {9, 10, 1}) {
        const auto v = static_cast<uint8_t>(k);
        picture("slice_" + std::to_string(k) + ".png", 2, 2, 1,
                {static_cast<uint8_t>(20 + v), static_cast<uint8_t>(30 + v), v,
                 static_cast<uint8_t>(10 + v)});
    }
    picture("other.png", 2, 2, 1, {0, 0, 0, 0});
    std::vector<float> want;
    for (const int k : {1, 9, 10}) {
        // The picture's first row has the lowest y.
        for (const int v : {20 + k, 30 + k, k, 10 + k})
            want.push_back(static_cast<float>(v / 255.0));
    }
    EXPECT_EQ(texture::volume_files(folder_.path())->size(), 4u);
    for (const char* pattern : {"slice_*.png", "slice_%d.png"}) {
        const auto p = converted(folder_.path() / pattern);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{2, 2, 3}));
        for (size_t i = 0; i < want.size(); ++i)
            EXPECT_FLOAT_EQ(level0(*p)[i], want[i]);
    }
    EXPECT_EQ(texture::volume_files(folder_.path() / "slice_##.png")->size(), 1u);
    EXPECT_FALSE(texture::volume_files(folder_.path() / "slab_*.png"));
    picture("slice_11.png", 3, 2, 1, {0, 0, 0, 0, 0, 0});
    EXPECT_THAT(trouble(folder_.path() / "slice_*.png"),
                testing::Says(messages::kSliceOfOtherSize, 3, 3, 2));
}

// Microscopes' programs number channels, times and places besides slices in the names of files.
TEST_F(VolumeTest, NamesOfSeveralSeriesAreRefused) {
    struct Case {
        std::vector<std::string> names;
        const char* of;       ///< empty: they are slices
        std::string pattern;  ///< what the remedy names
    };
    const std::vector<Case> cases = {
        {{"z00_c0", "z00_c1", "z01_c0", "z01_c1"}, "channel", "z%d_c0.pgm"},
        {{"c0_z00", "c0_z01", "c1_z00", "c1_z01"}, "channel", "c0_z%d.pgm"},
        {{"cell_z00_ch00", "cell_z00_ch01", "cell_z01_ch00"}, "channel", "cell_z%d_ch00.pgm"},
        {{"s_C001Z001T001", "s_C001Z002T001", "s_C002Z001T001"}, "channel", "s_C001Z%dT001.pgm"},
        {{"imageCh1-0001", "imageCh1-0002", "imageCh2-0001"}, "channel", "imageCh1-%d.pgm"},
        {{"e_w1DAPI_s1", "e_w1DAPI_s2", "e_w2GFP_s1"}, "channel", "e_w1DAPI_s%d.pgm"},
        {{"z0_t0", "z1_t0", "z0_t1", "z1_t1"}, "time", "z%d_t0.pgm"},
        {{"z5_c0", "z5_c1"}, "channel", "z%d_c0.pgm"},
        {{"i0001_z0_c0", "i0002_z0_c1", "i0003_z1_c0"}, "channel", "i0001_z%d_c0.pgm"},
        {{"tile1_z0", "tile1_z1", "tile2_z0"}, "series", "tile1_z%d.pgm"},
        {{"dapi_0", "dapi_1", "gfp_0", "gfp_1"}, "series", "dapi_%d.pgm"},
        {{"DAPI_z0", "DAPI_z1", "GFP_z0"}, "series", "DAPI_z%d.pgm"},
        {{"c0", "c1", "c2"}, "", ""},
        {{"scan_c1_0001", "scan_c1_0002"}, "", ""},
        {{"z1_c0", "z2_c0", "z3_c0"}, "", ""},
        {{"z1_t120300", "z2_t120301", "z3_t120301"}, "", ""},
        {{"slice_10.0", "slice_10.5", "slice_11.0"}, "", ""},
        {{"part1_0001", "part1_0002", "part2_0001"}, "", ""},
        {{"IMG_20260101_1", "IMG_20260102_2", "IMG_20260102_3"}, "", ""},
        {{"a", "b"}, "", ""},
    };
    for (const Case& the : cases) {
        SCOPED_TRACE(the.names.front());
        testing::TempFolder folder;
        for (const std::string& name : the.names)
            folder.write(name + ".pgm", "P2\n1 1\n255\n128\n");
        if (*the.of == '\0') {
            EXPECT_EQ(size(*converted(folder.path())).z, static_cast<int>(the.names.size()));
            continue;
        }
        const std::string why = trouble(folder.path());
        EXPECT_THAT(why, ::testing::HasSubstr(fmt::format("slices of one {}:", the.of)));
        EXPECT_THAT(why, ::testing::HasSubstr("`" + the.pattern + "`"));
        EXPECT_NE(converted(folder.path() / the.pattern), nullptr) << "the remedy reads";
    }
}

// Of the same bytes, one folder is read and one refused.
TEST_F(VolumeTest, TheCacheKnowsTheNamesOfSlices) {
    const testing::TempFolder good, bad;
    for (const auto& [folder, names] :
         {std::pair{&good, std::array{"z0_c0", "z1_c0"}}, {&bad, std::array{"z0_c0", "z0_c1"}}}) {
        for (const char* name : names)
            folder->write(std::string(name) + ".pgm", "P2\n1 1\n255\n128\n");
    }
    EXPECT_TRUE(texture::get_volume(good.path(), {}, 0, 0));
    EXPECT_FALSE(texture::get_volume(bad.path(), {}, 0, 0));
}

// A stack a file, of several channels or times.
TEST_F(VolumeTest, StacksOfSeveralTimesAreRefused) {
    const auto tiffs = [&](testing::TempFolder& folder, const char* word) {
        for (const int k : {0, 1})
            folder.write(fmt::format("{}{}.tif", word, k), tiff(3, false, false));
    };
    testing::TempFolder times, parts;
    tiffs(times, "t");
    tiffs(parts, "part");
    EXPECT_THAT(trouble(times.path()),
                testing::Says(messages::kSeveralSeries, "time", "t0.tif", "t1.tif"));
    EXPECT_EQ(size(*converted(times.path() / "t0.tif")).z, 3);
    EXPECT_EQ(size(*converted(parts.path())).z, 6);
}

TEST_F(VolumeTest, PagesOfATiff) {
    const std::string file = (folder_.path() / "pages.tif").string();
    const auto out = OIIO::ImageOutput::create(file);
    const OIIO::ImageSpec spec(2, 1, 3, OIIO::TypeDesc::UINT8);
    for (uint8_t page = 0; page < 3; ++page) {
        const std::vector<uint8_t> data(6, static_cast<uint8_t>(page * 100));
        ASSERT_TRUE(out->open(
            file, spec, page == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, data.data()));
    }
    out->close();
    const auto p = converted(file);
    EXPECT_EQ(size(*p), (Vec3i{2, 1, 3}));
    EXPECT_EQ(level0(*p)[12], static_cast<float>(srgb_to_linear(200 / 255.0)))
        << "8-bit colour is sRGB";
}

TEST_F(VolumeTest, ManyPagesOfATiffAreReadOneByOne) {
#ifdef OPENFAB_SANITIZED  // where reading a page takes ten times as long
    constexpr size_t kPages = 256;
#else
    constexpr size_t kPages = 2048;
#endif
    for (const auto& [big_endian, large] :
         {std::pair{false, false}, {true, false}, {false, true}, {true, true}}) {
        SCOPED_TRACE(::testing::Message() << big_endian << large);
        const auto p = converted(folder_.write("many.tif", tiff(kPages, big_endian, large)));
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{2, 1, kPages}));
        const std::vector<float> texels = level0(*p);
        for (size_t page = 0; page < kPages; ++page)
            ASSERT_FLOAT_EQ(texels[2 * page], static_cast<float>(page % 256) / 255.0f);
    }
    EXPECT_EQ(trouble(folder_.write("more.tif", tiff(65537, false, false))),
              fmt::format(messages::kTooManyPages, 65536));
    // A repeated directory is not a page.
    EXPECT_EQ(size(*converted(folder_.write("ring.tif", tiff(5, false, false, 8)))),
              (Vec3i{2, 1, 5}));
    EXPECT_EQ(trouble(folder_.write("off.tif", tiff(5, false, false, 1 << 30))),
              fmt::format(messages::kTiffCut, 5));
}

// The rule: x, y and z increase with the position in the file, for any format.
TEST_F(VolumeTest, TheSameVolumeInEveryFormat) {
    const std::vector<uint8_t> values = {0,   51,  102, 153,
                                         204, 255, 85,  17};  // x fastest, then y, z
    std::string numbers, table = "LUT_3D_SIZE 2\n";
    std::vector<uint8_t> fortran;
    for (size_t i = 0; i < 8; ++i) {
        numbers += std::to_string(values[i]) + " ";
        const std::string level = std::to_string(values[i] / 255.0);
        table += level + " " + level + " " + level + "\n";
        fortran.push_back(values[(i & 1) << 2 | (i & 2) | i >> 2]);
    }
    const std::string tiff = (folder_.path() / "v.tif").string();
    const auto out = OIIO::ImageOutput::create(tiff);
    for (size_t z = 0; z < 2; ++z) {
        picture("slice_" + std::to_string(z) + ".png", 2, 2, 1,
                {values.begin() + 4 * static_cast<long>(z),
                 values.begin() + 4 * static_cast<long>(z) + 4});
        ASSERT_TRUE(
            out->open(tiff, OIIO::ImageSpec(2, 2, 1, OIIO::TypeDesc::UINT8),
                      z == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, &values[4 * z]));
    }
    out->close();
    const std::string head = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: ";
    const std::filesystem::path files[] = {
        tiff,
        folder_.path() / "slice_*.png",
        folder_.write("c.npy", npy("|u1", "False", "(2, 2, 2)", bytes_of(values))),
        folder_.write("f.npy", npy("|u1", "True", "(2, 2, 2)", bytes_of(fortran))),
        folder_.write("r.nrrd", head + "raw\n\n" + bytes_of(values)),
        folder_.write("t.nrrd", head + "ascii\n\n" + numbers),
        folder_.write("t.cube", table)};
    for (const std::filesystem::path& file : files) {
        const auto p = converted(file);
        ASSERT_NE(p, nullptr) << file;
        ASSERT_EQ(size(*p), (Vec3i{2, 2, 2})) << file;
        for (size_t i = 0; i < 8; ++i) {
            const float found = level0(*p)[i * static_cast<size_t>(p->channels())];
            EXPECT_NEAR(found, values[i] / 255.0F, 1e-6) << file << " at " << i;
        }
    }
}

}  // namespace
}  // namespace openfab::tools
