// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/volume.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libdeflate.h>
#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "base/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/volume_files.h"
#include "texture/reading_progress.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

std::string gzipped(const std::string& plain) {
    std::string packed(plain.size() + 100, 0);
    libdeflate_compressor* c = libdeflate_alloc_compressor(6);
    packed.resize(
        libdeflate_gzip_compress(c, plain.data(), plain.size(), packed.data(), packed.size()));
    libdeflate_free_compressor(c);
    return packed;
}

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

TEST_F(VolumeTest, NpyOfAPrintLiesWhereItWasPrinted) {
    const std::vector<float> two{1, 2};
    const auto file = folder_.write("p.npy", npy("<f4", "False", "(1, 1, 2)", bytes_of(two)));
    const auto beside = [&](const std::string& format, const std::string& shape,
                            const std::string& pitch, const std::string& origin) {
        folder_.write("p.npy.json", fmt::format(R"({{"format": "{}", "shape_zyx": {},
            "first_slice_z": 3, "pitch_mm": {}, "origin_mm": {}}})",
                                                format, shape, pitch, origin));
    };
    const auto key = [&] { return *texture::volume_key(file, {}, {}); };
    const uint64_t alone = key();
    beside("openfab-array", "[1, 1, 2]", "[0.5, 0.25, 2]", "[-3, 4, 5]");
    EXPECT_EQ(domain(*converted(file)), (std::vector<float>{-3, 4, 11, 1, 0.25f, 2}));
    EXPECT_NE(key(), alone) << "the cache would give what was there before";
    VolumeOptions options;
    options.origin_mm = {{0, 0, 0}};
    EXPECT_EQ(domain(*converted(file, options)), (std::vector<float>{0, 0, 0, 1, 0.25f, 2}));
    // Of another array, and of another program.
    for (const auto& [shape, pitch] :
         {std::pair("[1, 2, 1]", "[1, 1, 1]"), std::pair("[1, 1, 2]", "[1, 0, 1]"),
          std::pair("[1, 1, 2]", "3")}) {
        beside("openfab-array", shape, pitch, "[0, 0, 0]");
        EXPECT_THAT(trouble(file), testing::Says(messages::kOtherArray, "p.npy.json"));
    }
    beside("something else", "[1, 1, 2]", "[9, 9, 9]", "[0, 0, 0]");
    EXPECT_EQ(domain(*converted(file)), (std::vector<float>{0, 0, 0, 2, 1, 1}));
    folder_.write("p.npy.json", "no JSON");
    EXPECT_EQ(domain(*converted(file)), (std::vector<float>{0, 0, 0, 2, 1, 1}));
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
    const auto read = [&] {
        const auto made = texture::get_volume(file, {}, 0, 0);
        ASSERT_TRUE(made);
        EXPECT_EQ((*made)->notes(), std::vector<std::string>{"a slice"});
    };
    EXPECT_EQ(told(half_way(milliseconds(0))), "");
    ::setenv(texture::kTellProgress, "1", 1);
    EXPECT_EQ(told(half_way(milliseconds(0))), "reading a.vtu: 25 %\nreading a.vtu: 50 %\n");
    EXPECT_EQ(told(half_way(std::chrono::hours(1))), "");
    EXPECT_EQ(told(read), "reading v.npy: 10 %\nreading v.npy: 60 %\n");
    ::unsetenv(texture::kTellProgress);
}

TEST_F(VolumeTest, NotesOfTheHelperArePassedOnAndKept) {
    const auto file = folder_.write(
        "v.npy", npy("<f4", "False", "(1, 1, 1)", bytes_of(std::vector<float>{0.5f})));
    const auto helper = folder_.write(
        "helper", std::string("#!/bin/sh\necho 'note: a slice' >&2\n") + "exec " +
                      testing::test_program("texture_test_helper").string() + " \"$@\"\n");
    std::filesystem::permissions(helper, std::filesystem::perms::owner_all);
    ::setenv("OPENFAB_HELPER", helper.c_str(), 1);
    // The second time it comes from the cache; where there is no texture, nobody can ask for its notes.
    for (const bool fails : {false, false, true}) {
        if (fails) folder_.write("v.npy", "none");
        ::testing::internal::CaptureStderr();
        const auto made = texture::get_volume(file, {}, 0, 0);
        EXPECT_EQ(::testing::internal::GetCapturedStderr(), fails ? "note: a slice\n" : "");
        ASSERT_EQ(made.has_value(), !fails);
        if (!fails) {
            EXPECT_EQ((*made)->notes(), std::vector<std::string>{"a slice"});
        } else {
            EXPECT_THAT(made.error().text(), testing::Says(messages::kCannotReadBefore))
                << made.error().text();
        }
    }
}

}  // namespace
}  // namespace openfab::tools
