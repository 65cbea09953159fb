// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/volume.h"
#include "tests/support/places/places.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libdeflate.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <functional>

#include "base/color.h"
#include "base/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "texture/reading_progress.h"
#include "tools/texture/convert_volume.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using texture::Pyramid;
using texture::VolumeOptions;

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::string npy(const std::string& descr, const std::string& order, const std::string& shape,
                const std::string& data) {
    std::string header =
        "{'descr': '" + descr + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }\n";
    const auto n = static_cast<uint16_t>(header.size());
    std::string out = "\x93NUMPY";
    out += '\x01';
    out += '\x00';
    out += static_cast<char>(n & 0xff);
    out += static_cast<char>(n >> 8);
    return out + header + data;
}

std::string gzipped(const std::string& plain) {
    std::string packed(plain.size() + 100, 0);
    libdeflate_compressor* c = libdeflate_alloc_compressor(6);
    packed.resize(
        libdeflate_gzip_compress(c, plain.data(), plain.size(), packed.data(), packed.size()));
    libdeflate_free_compressor(c);
    return packed;
}

class VolumeTest : public ::testing::Test {
  protected:
    VolumeTest() {
        ::setenv("OPENFAB_CACHE", (folder_.path() / "cache").c_str(), 1);
        ::setenv("OPENFAB_HELPER", testing::test_program("texture_test_helper").c_str(), 1);
        ::setenv("PATH", "/nonexistent", 1);
    }

    std::shared_ptr<const Pyramid> converted(const std::filesystem::path& file,
                                             const VolumeOptions& options = {}) {
        const std::filesystem::path out = folder_.path() / "out.oftx";
        const Result<void> made = make_volume_file(file, out, options);
        EXPECT_TRUE(made) << made.error().text();
        const auto opened = Pyramid::open(out, 1, 0);
        EXPECT_TRUE(opened) << opened.error().text();
        return opened ? *opened : nullptr;
    }
    std::string trouble(const std::filesystem::path& file, const VolumeOptions& options = {}) {
        const Result<void> made = make_volume_file(file, folder_.path() / "out.oftx", options);
        if (made) return "no error";
        const std::string start = fmt::format(messages::kCannotReadBefore, file.string());
        return made.error().text().starts_with(start) ? made.error().text().substr(start.size())
                                                      : made.error().text();
    }
    static Vec3i size(const Pyramid& p) { return {p.info()[15], p.info()[16], p.info()[17]}; }
    static std::vector<float> level0(const Pyramid& p) {
        const Vec3i s = size(p);
        return {p.texels().begin(), p.texels().begin() + s.x * s.y * s.z * p.channels()};
    }
    /// Origin, then extent.
    static std::vector<float> domain(const Pyramid& p) {
        std::vector<float> out;
        for (size_t k = 8; k < 14; ++k)
            out.push_back(std::bit_cast<float>(p.info()[k]));
        return out;
    }
    /// Rows from the top.
    void picture(const std::string& name, int width, int height, int channels,
                 const std::vector<uint8_t>& data) {
        const std::string file = (folder_.path() / name).string();
        const auto out = OIIO::ImageOutput::create(file);
        ASSERT_TRUE(
            out->open(file, OIIO::ImageSpec(width, height, channels, OIIO::TypeDesc::UINT8)));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, data.data()));
        out->close();
    }

    testing::TempFolder folder_;
};

TEST_F(VolumeTest, NpyInBothOrders) {
    // Texel (x, y, z) is 100 z + 10 y + x.
    std::vector<float> c, fortran;
    for (int z = 0; z < 2; ++z) {
        for (int y = 0; y < 3; ++y) {
            for (int x = 0; x < 4; ++x)
                c.push_back(static_cast<float>(100 * z + 10 * y + x));
        }
    }
    for (int x = 0; x < 4; ++x) {
        for (int y = 0; y < 3; ++y) {
            for (int z = 0; z < 2; ++z)
                fortran.push_back(static_cast<float>(100 * z + 10 * y + x));
        }
    }
    const auto first = folder_.write("c.npy", npy("<f4", "False", "(2, 3, 4)", bytes_of(c)));
    const auto p = converted(first);
    ASSERT_NE(p, nullptr);
    EXPECT_TRUE(p->is_volume());
    EXPECT_EQ(size(*p), (Vec3i{4, 3, 2}));
    EXPECT_EQ(level0(*p), c);
    EXPECT_EQ(domain(*p), (std::vector<float>{0, 0, 0, 4, 3, 2}));
    EXPECT_EQ(p->texels().back(), 61.5f) << "the coarsest level is the mean";
    EXPECT_EQ(p->minmax()[p->minmax().size() - 1], 123.0f);
    const auto second = folder_.write("f.npy", npy("<f4", "True", "(2, 3, 4)", bytes_of(fortran)));
    VolumeOptions options;
    options.origin_mm = {{-1, 2, 0.5}};
    options.spacing_mm = {{0.5, 0.25, 2}};
    const auto q = converted(second, options);
    EXPECT_EQ(level0(*q), c);
    EXPECT_EQ(domain(*q), (std::vector<float>{-1, 2, 0.5f, 2, 0.75f, 4}));
}

TEST_F(VolumeTest, NpyOfIntegersAndChannels) {
    const auto u16 = folder_.write(
        "u.npy", npy("<u2", "False", "(1, 1, 2, 2)", bytes_of<uint16_t>({0, 65535, 13107, 26214})));
    const auto p = converted(u16);
    EXPECT_EQ(p->channels(), 2);
    EXPECT_EQ(level0(*p), (std::vector<float>{0, 1, 0.2f, 0.4f}));
    const auto big = folder_.write(
        "b.npy", npy(">i2", "False", "(1, 1, 2)", std::string("\xff\xfe\x01\x00", 4)));
    EXPECT_EQ(level0(*converted(big)), (std::vector<float>{-2, 256}));
    EXPECT_EQ(trouble(folder_.write("d.npy", npy("<f4", "False", "(2, 2)", std::string(16, 0)))),
              fmt::format(messages::kNpyDimensions, 2));
    EXPECT_EQ(trouble(folder_.write("e.npy", npy("<f4", "False", "(2, 2, 2)", std::string(16, 0)))),
              messages::kCutShort);
    EXPECT_EQ(trouble(folder_.write("g.npy", npy("<c8", "False", "(1, 1, 1)", std::string(16, 0)))),
              fmt::format(messages::kUnknownNumberKind, "'<c8'"));
    EXPECT_EQ(trouble(folder_.write(
                  "n.npy", npy("<f4", "False", "(1, 1, 1)", bytes_of<float>({std::nanf("")})))),
              messages::kValueNotFinite);
}

TEST_F(VolumeTest, NpyOfHalves) {
    // By numpy: the least and the largest of each kind, and what is usual.
    const std::vector<uint16_t> bits = {0x0000, 0x0001, 0x03ff, 0x0400, 0x2e66, 0x3800,
                                        0x3c00, 0x3555, 0xc248, 0x7bff, 0xfbff, 0x8001};
    const std::vector<float> values = {
        0, 5.9604645e-8f, 6.097555e-5f, 6.1035156e-5f, 0.099975586f, 0.5f,
        1, 0.33325195f,   -3.140625f,   65504,         -65504,       -5.9604645e-8f};
    const auto file =
        folder_.write("h.npy", npy("<f2", "False", "(1, 3, 4)", bytes_of<uint16_t>(bits)));
    const std::vector<float> read = level0(*converted(file));
    ASSERT_EQ(read.size(), values.size());
    for (size_t i = 0; i < values.size(); ++i)
        EXPECT_NEAR(read[i], values[i], 4e-8 * std::abs(values[i])) << i;
    const auto big = folder_.write("b.npy", npy(">f2", "False", "(1, 1, 1)", "\x3e\xff"));
    EXPECT_EQ(level0(*converted(big)), std::vector<float>{1.7490234f});
    for (const uint16_t bad : {0x7c00, 0xfc00, 0x7e00}) {
        EXPECT_EQ(trouble(folder_.write(
                      "n.npy", npy("<f2", "False", "(1, 1, 1)", bytes_of<uint16_t>({bad})))),
                  messages::kValueNotFinite);
    }
}

TEST_F(VolumeTest, NrrdWithItsPlace) {
    const std::vector<float> values = {1, 2, 3, 4, 5, 6, 7, 8};
    const std::string header =
        "NRRD0004\n# made by hand\ntype: float\ndimension: 3\nsizes: 2 2 2\nendian: little\n"
        "space directions: (0.5,0,0) (0,1,0) (0,0,2)\nspace origin: (10,20,30)\n";
    const auto raw = folder_.write("r.nrrd", header + "encoding: raw\n\n" + bytes_of(values));
    const auto p = converted(raw);
    EXPECT_EQ(level0(*p), values);
    EXPECT_EQ(domain(*p), (std::vector<float>{9.75f, 19.5f, 29, 1, 2, 4}));
    EXPECT_EQ(level0(*converted(
                  folder_.write("t.nrrd", header + "encoding: ascii\n\n1 2 3 4\n5 6 7 8\n"))),
              values);

    const std::string plain = bytes_of(values);
    EXPECT_EQ(
        level0(*converted(folder_.write("z.nrrd", header + "encoding: gzip\n\n" + gzipped(plain)))),
        values);
    folder_.write("beside.raw", plain);
    EXPECT_EQ(level0(*converted(
                  folder_.write("h.nhdr", header + "encoding: raw\ndata file: beside.raw\n"))),
              values);
    EXPECT_EQ(
        level0(*converted(folder_.write(
            "c.nrrd",
            "NRRD0001\ntype: uchar\ndimension: 4\nsizes: 2 1 1 1\nencoding: raw\n\n\x33\xff"))),
        (std::vector<float>{0.2f, 1}));

    EXPECT_EQ(trouble(folder_.write("s.nrrd", header + "encoding: raw\n\nxx")),
              messages::kCutShort);
    EXPECT_EQ(trouble(folder_.write("y.nrrd", header + "encoding: gzip\n\nxx")),
              messages::kCompressedOfOtherSize);
    EXPECT_EQ(trouble(folder_.write("w.nrrd", header + "encoding: bzip2\n\nxx")),
              fmt::format(messages::kUnknownEncoding, "bzip2"));
}

TEST_F(VolumeTest, NrrdBehindWhatItSkips) {
    const std::string header =
        "NRRD0005\ntype: float\ndimension: 3\nsizes: 2 2 2\n"
        "endian: little\n";
    const std::vector<float> values = {1, 2, 3, 4, 5, 6, 7, 8};
    const std::string raw = bytes_of(values), junk = "a line\n\nanother\n", seven = "1234567";
    const std::string numbers = "1 2 3 4 5 6 7 8\n";
    int number = 0;
    const auto file = [&](const std::string& fields, const std::string& data) {
        return folder_.write(std::to_string(++number) + ".nrrd", header + fields + "\n" + data);
    };
    for (const auto& [fields, data] : std::vector<std::pair<std::string, std::string>>{
             {"encoding: raw\nline skip: 3\n", junk + raw},
             {"encoding: raw\nlineskip: 3\nbyteskip: 7\n", junk + seven + raw},
             {"encoding: raw\nbyte skip: 7 \n", seven + raw},
             {"encoding: raw\nbyte skip: -1\n", junk + raw},
             {"encoding: raw\nbyte skip: -1\nline skip: 0\n", raw},
             {"encoding: ascii\nline skip: 3\nbyte skip: 7\n", junk + seven + numbers},
             // Lines are counted in the file, bytes in the decompressed data.
             {"encoding: gzip\nline skip: 3\n", junk + gzipped(raw)},
             {"encoding: gzip\nbyte skip: 7\n", gzipped(seven + raw)}}) {
        const auto p = converted(file(fields, data));
        ASSERT_NE(p, nullptr) << fields;
        EXPECT_EQ(level0(*p), values) << fields;
    }
    // In a file of its own.
    folder_.write("d.raw", junk + raw);
    EXPECT_EQ(level0(*converted(file("encoding: raw\nline skip: 3\ndata file: d.raw\n", ""))),
              values);
    EXPECT_EQ(level0(*converted(file("encoding: raw\nbyte skip: -1\ndata file: d.raw\n", ""))),
              values);

    EXPECT_EQ(trouble(file("encoding: gzip\nbyte skip: -1\n", gzipped(raw))),
              messages::kByteSkipOfPacked);
    EXPECT_EQ(trouble(file("encoding: raw\nline skip: 1\nbyte skip: -1\n", "\n" + raw)),
              messages::kBothSkips);
    EXPECT_EQ(trouble(file("encoding: raw\nbyte skip: -2\n", raw)),
              fmt::format(messages::kNotAWholeNumberFrom, "byte skip", -2, -1));
    EXPECT_EQ(trouble(file("encoding: raw\nline skip: some\n", raw)),
              fmt::format(messages::kNotAWholeNumberFrom, "line skip", "some", 0));
    EXPECT_EQ(trouble(file("encoding: raw\nline skip: 4\n", "a\nb\n")),
              messages::kFewerLinesThanSkip);
    EXPECT_EQ(trouble(file("encoding: raw\nbyte skip: 1\n", raw)), messages::kCutShort);
    EXPECT_EQ(trouble(file("encoding: raw\nbyte skip: 9223372036854775807\n", raw)),
              messages::kCutShort);
    EXPECT_EQ(trouble(file("encoding: gzip\nbyte skip: 7\n", gzipped(raw))),
              messages::kCompressedOfOtherSize);
}

TEST_F(VolumeTest, CubeTables) {
    std::string text = "# a table\nTITLE \"x\"\nLUT_3D_SIZE 2\nDOMAIN_MAX 1 2 1\n";
    std::vector<float> values;
    for (int i = 0; i < 8; ++i) {
        for (const int bit : {i & 1, i >> 1 & 1, i >> 2})
            values.push_back(static_cast<float>(bit));
        text += std::to_string(i & 1) + ".0 " + std::to_string(i >> 1 & 1) + " " +
                std::to_string(i >> 2) + "\n";
    }
    const auto p = converted(folder_.write("t.cube", text));
    EXPECT_EQ(p->channels(), 3);
    EXPECT_EQ(level0(*p), values);
    EXPECT_EQ(domain(*p), (std::vector<float>{-0.5f, -1, -0.5f, 2, 4, 2}));
    EXPECT_EQ(p->info()[2], 0) << "a table is clamped, whatever the world says";
    EXPECT_EQ(p->info()[3], texture::kFilterFinest);
    std::string old = "\xEF\xBB\xBF" + text;
    std::replace(old.begin(), old.end(), '\n', '\r');
    EXPECT_EQ(level0(*converted(folder_.write("old.cube", old))), values);
    EXPECT_EQ(trouble(folder_.write("wide.cube", std::string_view("\xFF\xFEL\0U\0T\0", 8))),
              fmt::format(openfab::messages::kWideText, "UTF-16") + "; " +
                  openfab::messages::kWideTextHelp);
    EXPECT_EQ(trouble(folder_.write("short.cube", "LUT_3D_SIZE 2\n0 0 0\n")),
              fmt::format(messages::kLutRows, 1, 2, 8));
    EXPECT_EQ(trouble(folder_.write("one.cube", "LUT_1D_SIZE 2\n0 0 0\n1 1 1\n")),
              messages::kLutIs1d);
    EXPECT_EQ(trouble(folder_.write("bad.cube", "LUT_3D_SIZE 2\n0 0\n")),
              fmt::format(messages::kLineNotThreeNumbers, 2));
    EXPECT_EQ(trouble(folder_.write("late.cube", "0 0 0\nLUT_3D_SIZE 2\n")),
              fmt::format(messages::kColourBeforeLutSize, 1));
    EXPECT_EQ(trouble(folder_.write("none.cube", "# nothing\n")), messages::kNoLutSize);
    EXPECT_EQ(trouble(folder_.write("side.cube", "LUT_3D_SIZE 257\n")),
              fmt::format(messages::kLutSize, 257.0, 256));
}

TEST_F(VolumeTest, LargeCubeTablesAreReadSoon) {
    std::string text = "LUT_3D_SIZE 256\n";
    for (int i = 0; i < 256 * 256 * 256 + 1; ++i)
        text += "0 1 0\n";
    EXPECT_EQ(trouble(folder_.write("large.cube", text)),
              fmt::format(messages::kLutRows, 16777217, 256, 16777216));
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

// The rule: x, y and z increase with the position in the file, for any format.
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
    EXPECT_EQ(trouble(folder_.write("more.tif", tiff(2049, false, false))),
              fmt::format(messages::kTooManyPages, 2048));
    // A repeated directory is not a page.
    EXPECT_EQ(size(*converted(folder_.write("ring.tif", tiff(5, false, false, 8)))),
              (Vec3i{2, 1, 5}));
    EXPECT_EQ(size(*converted(folder_.write("off.tif", tiff(5, false, false, 1 << 30)))),
              (Vec3i{2, 1, 5}));
}

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

TEST_F(VolumeTest, ComesFromTheCacheAndTheHelper) {
    const std::vector<float> values = {0.25f, 0.5f};
    const auto file = folder_.write("v.npy", npy("<f4", "False", "(1, 1, 2)", bytes_of(values)));
    VolumeOptions options;
    options.origin_mm = {{-1.5, 0, 0}};
    const auto made = texture::get_volume(file, options, 2, 1);
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_EQ(level0(**made), values);
    EXPECT_EQ(domain(**made)[0], -1.5f);
    ::unsetenv("OPENFAB_HELPER");
    EXPECT_TRUE(texture::get_volume(file, options, 0, 0)) << "the second time it is in the cache";
    options.spacing_mm = {{2, 2, 2}};
    EXPECT_FALSE(texture::get_volume(file, options, 0, 0)) << "another place is another pyramid";
}

TEST_F(VolumeTest, HowFarItIsIsToldWhereSomebodyLooks) {
    using std::chrono::milliseconds;
    const auto told = [](const std::function<void()>& act) {
        ::testing::internal::CaptureStderr();
        act();
        return ::testing::internal::GetCapturedStderr();
    };
    const auto half_way = [](milliseconds pause) {
        return [=] {
            texture::ReadingProgress progress("a.vtu", pause);
            for (const double done : {0.25, 0.5, 1.0})
                progress.at(done);
        };
    };
    const auto file = folder_.write(
        "v.npy", npy("<f4", "False", "(1, 1, 1)", bytes_of(std::vector<float>{0.5f})));
    const auto helper =
        folder_.write("helper",
                      "#!/bin/sh\necho 'reading v.npy: 10 %' >&2\necho 'note: a slice' >&2\n"
                      "echo 'reading v.npy: 60 %' >&2\nexec " +
                          testing::test_program("texture_test_helper").string() + " \"$@\"\n");
    std::filesystem::permissions(helper, std::filesystem::perms::owner_all);
    ::setenv("OPENFAB_HELPER", helper.c_str(), 1);
    const auto read = [&] { EXPECT_TRUE(texture::get_volume(file, {}, 0, 0)); };
    EXPECT_EQ(told(half_way(milliseconds(0))), "");
    ::setenv(texture::kTellProgress, "1", 1);
    EXPECT_EQ(told(half_way(milliseconds(0))), "reading a.vtu: 25 %\nreading a.vtu: 50 %\n");
    EXPECT_EQ(told(half_way(std::chrono::hours(1))), "");
    EXPECT_EQ(told(read), "reading v.npy: 10 %\nreading v.npy: 60 %\nnote: a slice\n");
    ::unsetenv(texture::kTellProgress);
}

TEST_F(VolumeTest, NotesOfTheHelperArePassedOn) {
    const auto file = folder_.write(
        "v.npy", npy("<f4", "False", "(1, 1, 1)", bytes_of(std::vector<float>{0.5f})));
    const auto helper = folder_.write(
        "helper", std::string("#!/bin/sh\necho 'note: a slice' >&2\n") + "exec " +
                      testing::test_program("texture_test_helper").string() + " \"$@\"\n");
    std::filesystem::permissions(helper, std::filesystem::perms::owner_all);
    ::setenv("OPENFAB_HELPER", helper.c_str(), 1);
    for (const bool fails : {false, true}) {
        if (fails) folder_.write("v.npy", "none");
        ::testing::internal::CaptureStderr();
        const auto made = texture::get_volume(file, {}, 0, 0);
        EXPECT_EQ(::testing::internal::GetCapturedStderr(), "note: a slice\n");
        ASSERT_EQ(made.has_value(), !fails);
        if (fails) {
            EXPECT_THAT(made.error().text(), testing::Says(messages::kCannotReadBefore))
                << made.error().text();
        }
    }
}

}  // namespace
}  // namespace openfab::tools
