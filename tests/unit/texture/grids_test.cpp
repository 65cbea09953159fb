// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Where grids lie and what their files are made of: turned ones and right angles with rounding, numbers in
// several files or members, values that are none.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libdeflate.h>
#include <algorithm>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "tests/support/says/says.h"
#include "tests/unit/texture/border_reach.h"
#include "tests/unit/texture/field_test.h"
#include "tests/unit/texture/vtk_files.h"
#include "texture/messages.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using GridsTest = FieldTest;

template <typename T>
std::string raw(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::string packed(const std::string& plain) {
    std::string out(plain.size() + 100, 0);
    libdeflate_compressor* c = libdeflate_alloc_compressor(6);
    out.resize(libdeflate_gzip_compress(c, plain.data(), plain.size(), out.data(), out.size()));
    libdeflate_free_compressor(c);
    return out;
}

std::string nrrd(const std::vector<float>& values, const Vec3i& n, const std::string& more) {
    return fmt::format(
               "NRRD0005\ntype: float\ndimension: 3\nsizes: {} {} {}\nendian: little\n"
               "encoding: raw\n{}\n",
               n.x, n.y, n.z, more) +
           raw(values);
}

std::string told(const std::function<void()>& act) {
    ::testing::internal::CaptureStderr();
    act();
    return ::testing::internal::GetCapturedStderr();
}

TEST_F(GridsTest, ATurnedConstantIsItselfToItsBorder) {
    const std::vector<float> ones(216, 1);
    for (const double degrees : {30.0, 45.0, 61.0}) {
        const double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
        const std::string place = fmt::format(
            "space dimension: 3\nspace directions: ({0},{1},0) ({2},{0},0) (0,0,1)\nspace origin: "
            "({3},{4},-2.5)\n",
            c, s, -s, -2.5 * c + 2.5 * s, -2.5 * s - 2.5 * c);
        VolumeOptions options;
        options.pitch_mm = degrees == 45 ? 0.3 : 0;
        options.outside = -9;
        const auto p = converted(folder_.write("a.nrrd", nrrd(ones, {6, 6, 6}, place)), options);
        ASSERT_NE(p, nullptr);
        int inside = 0, outside = 0;
        each(*p, [&](const Vec3d& at, const float* value) {
            // Texels from which a look-up within the grid takes its value.
            const Vec3d step = pitch(*p);
            const double i = c * at.x + s * at.y, j = c * at.y - s * at.x;
            const double reach = 2.5 + border_reach({c, s, 0}, step.x);
            const bool near = std::abs(i) <= reach - 1e-6 && std::abs(j) <= reach - 1e-6;
            const bool far = std::abs(i) > reach + 1e-6 || std::abs(j) > reach + 1e-6;
            inside += near ? 1 : 0;
            outside += far ? 1 : 0;
            if (near) {
                EXPECT_EQ(*value, 1);
            }
            if (far) {
                EXPECT_EQ(*value, -9);
            }
        });
        EXPECT_GT(inside, 200);
        EXPECT_GT(outside, 4);
    }
}

TEST_F(GridsTest, RightAnglesWithRoundingAreRightAngles) {
    std::vector<float> values(24);
    for (size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<float>(i % 7);
    const auto straight = [&](const std::string& directions) {
        const std::string more = "space dimension: 3\nspace directions: " + directions + "\n";
        const auto p = converted(folder_.write("a.nrrd", nrrd(values, {4, 3, 2}, more)));
        return p != nullptr && size(*p) == Vec3i{4, 3, 2} && level0(*p) == values;
    };
    // Over three steps, the last texel moves by 0.9e-4 or 1.2e-4 of a texel.
    EXPECT_TRUE(straight("(1,0,0.00003) (0,1,0) (0,0,1)"));
    EXPECT_FALSE(straight("(1,0,0.00004) (0,1,0) (0,0,1)"));
    EXPECT_TRUE(straight("(10,0.0003,0) (0,10,0) (0,0,10)"));
    EXPECT_FALSE(straight("(10,0.0004,0) (0,10,0) (0,0,10)"));
    EXPECT_FALSE(straight("(1,0,0.00003) (0,0.1,0) (0,0,0.1)")) << "of a texel across";
}

TEST_F(GridsTest, FieldsOfNrrdAreReadAsTeemReadsThem) {
    const std::string big("\x3f\x00\x00\x00\x3e\x80\x00\x00", 8);
    for (const char* fields :
         {"type: float\ndimension: 3\nsizes: 2 1 1\nendian: big\nencoding: raw\n",
          "type:  float \ndimension: 3\nsizes:  2  1  1\nendian: \t big\nencoding:   raw\n",
          "Type: Float\nDIMENSION: 3\nSizes: 2 1 1\nEndian: Big\nEncoding: RAW\n",
          "endian:=little\ntype: float\ndimension: 3\nsizes: 2 1 1\nendian: big\nencoding: raw\n"
          "note:=endian: little\n"}) {
        const auto p =
            converted(folder_.write("a.nrrd", std::string("NRRD0004\n") + fields + "\n" + big));
        ASSERT_NE(p, nullptr) << fields;
        EXPECT_EQ(level0(*p), (std::vector<float>{0.5F, 0.25F})) << fields;
    }
    EXPECT_THAT(trouble(folder_.write(
                    "a.nrrd",
                    "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n\n" + big)),
                testing::Says(messages::kNoEndian, 4));
    EXPECT_THAT(trouble(folder_.write("a.nrrd",
                                      "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 1 1\n"
                                      "endian: middle\nencoding: raw\n\n" +
                                          big)),
                testing::Says(messages::kNoEndian, 4));
    for (const auto& [unit, mm] : std::vector<std::pair<std::string, float>>{{"micrometer", 1e-3F},
                                                                             {"Microns", 1e-3F},
                                                                             {"\u00b5m", 1e-3F},
                                                                             {"cm", 10},
                                                                             {"Metres", 1000}}) {
        const std::string more =
            fmt::format("spacings: 2 2 2\nunits: \"{0}\" \"{0}\" \"{0}\"\n", unit);
        const auto p = converted(folder_.write("a.nrrd", nrrd({1, 2}, {2, 1, 1}, more)));
        ASSERT_NE(p, nullptr) << unit;
        EXPECT_FLOAT_EQ(domain(*p)[3], 4 * mm) << unit;
    }
}

TEST_F(GridsTest, GzipOfSeveralMembersIsRead) {
    const std::vector<float> values{1, 2, 3, 4, 5, 6, 7, 8};
    const std::string plain = raw(values);
    const std::string head =
        "NRRD0005\ntype: float\ndimension: 3\nsizes: 2 2 2\nendian: little\nencoding: gzip\n\n";
    for (const size_t cut : {size_t{1}, size_t{12}, plain.size()}) {
        // The last member may be empty, and zeros may follow.
        const std::string members =
            packed(plain.substr(0, cut)) + packed(plain.substr(cut)) + packed("");
        for (const std::string& behind : {std::string(), std::string(7, '\0')}) {
            const auto p = converted(folder_.write("a.nrrd", head + members + behind));
            ASSERT_NE(p, nullptr);
            EXPECT_EQ(level0(*p), values);
        }
        EXPECT_EQ(trouble(folder_.write("a.nrrd", head + members + packed("more"))),
                  messages::kCompressedOfOtherSize);
        EXPECT_EQ(trouble(folder_.write("a.nrrd", head + members.substr(0, 30))),
                  messages::kCompressedOfOtherSize);
    }
}

TEST_F(GridsTest, NumbersMayLieInAFileASlice) {
    const std::vector<float> values{1, 2, 3, 4, 5, 6, 7, 8};
    const auto part = [&](size_t from, size_t count) {
        return raw(std::vector<float>(values.begin() + static_cast<long>(from),
                                      values.begin() + static_cast<long>(from + count)));
    };
    for (size_t k = 0; k < 4; ++k) {
        folder_.write(fmt::format("s{:03}.raw", k), part(2 * k, 2));
        folder_.write(fmt::format("t{}.raw", 9 - 3 * k), "before" + part(2 * k, 2));
        folder_.write(fmt::format("z{}.gz", k), packed(part(2 * k, 2)));
    }
    const std::string list = "s000.raw\r\ns001.raw\ns002.raw\ns003.raw\n";
    const std::string nrrd = "NRRD0005\ntype: float\ndimension: 3\nsizes: 2 1 4\nendian: little\n";
    const std::string meta = "NDims = 3\nDimSize = 2 1 4\nElementType = MET_FLOAT\n";
    for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
             {"a.nhdr", nrrd + "encoding: raw\ndata file: s%03d.raw 0 3 1\n"},
             {"b.nhdr", nrrd + "encoding: raw\ndata file: s%03d.raw 0 3 1 2\n"},
             {"c.nhdr", nrrd + "encoding: raw\nbyte skip: 6\ndata file: t%d.raw 9 0 -3\n"},
             {"d.nhdr", nrrd + "encoding: raw\nbyte skip: -1\ndata file: t%d.raw 9 0 -3\n"},
             {"e.nhdr", nrrd + "encoding: raw\ndata file: LIST\n" + list},
             {"f.nhdr", nrrd + "encoding: raw\ndatafile: LIST 2\n" + list},
             {"g.nhdr", nrrd + "encoding: gzip\ndata file: z%d.gz 0 3 1\n"},
             {"a.mhd", meta + "ElementDataFile = s%03d.raw 0 3 1\n"},
             {"b.mhd", meta + "ElementDataFile = LIST\n" + list},
             {"d.mhd", meta + "ElementDataFile = LIST 2D\n" + list},
             {"c.mhd", meta + "HeaderSize = 6\nElementDataFile = t%d.raw 9 0 -3\n"},
             {"d.mhd", meta + "HeaderSize = -1\nElementDataFile = t%d.raw 9 0 -3\n"}}) {
        const auto p = converted(folder_.write(name, text));
        ASSERT_NE(p, nullptr) << name;
        EXPECT_EQ(level0(*p), values) << name;
        EXPECT_EQ(texture::detached_data(folder_.path() / name, {}).size(), 4U) << name;
    }
    const auto wrong = [&](const std::string& files) {
        return trouble(folder_.write("w.nhdr", nrrd + "encoding: raw\ndata file: " + files + "\n"));
    };
    EXPECT_THAT(wrong("s%03d.raw 0 4 1"), testing::Says(messages::kUnequalFiles, 5));
    EXPECT_THAT(wrong("u%d.raw 0 3 1"),
                testing::Says(texture::messages::kDataFileUnreadable, "u0.raw"));
    for (const char* bad : {"s%03d.raw", "s%03d.raw 0 3", "s%03d.raw 3 0 1", "s%03d.raw 0 3 0",
                            "s%s.raw 0 3 1", "s%d%d.raw 0 3 1", "LIST", "s%d.raw 0 999999999 1"})
        EXPECT_THAT(wrong(bad), testing::Says(texture::messages::kDataFilesMalformed, bad));
    folder_.write("s002.raw", part(4, 1));
    EXPECT_THAT(wrong("s%03d.raw 0 3 1"), testing::Says(messages::kCutShort));
}

TEST_F(GridsTest, NanIsOutsideWhereThatIsGiven) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::string vti =
        R"(<VTKFile type="ImageData"><ImageData WholeExtent="0 2 0 1 0 1"><Piece Extent="0 2 0 1 0 1"><CellData>
<DataArray type="Float32" Name="a" format="ascii">nan 2</DataArray></CellData></Piece></ImageData></VTKFile>)";
    const std::string turned =
        "space dimension: 3\nspace directions: (0.6,0.8,0) (-0.8,0.6,0) (0,0,1)\n";
    std::string npy("\x93NUMPY\1\0\x50\0", 10);
    npy += "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 2)}";
    npy = npy.append(90 - npy.size(), ' ') + raw(std::vector<float>{nan, 2});
    for (const auto& file :
         {folder_.write("a.nrrd", nrrd({nan, 2}, {2, 1, 1}, "")), folder_.write("a.vti", vti),
          folder_.write("b.nrrd", nrrd({nan, 2}, {2, 1, 1}, turned)),
          folder_.write("a.npy", npy)}) {
        EXPECT_THAT(trouble(file), testing::Says(messages::kValueNotFinite)) << file;
        VolumeOptions options;
        options.outside = -1;
        const auto p = converted(file, options);
        ASSERT_NE(p, nullptr) << file;
        if (size(*p) == Vec3i{2, 1, 1}) {
            EXPECT_EQ(level0(*p), (std::vector<float>{-1, 2})) << file;
        }
    }
    const float infinite = std::numeric_limits<float>::infinity();
    VolumeOptions options;
    options.outside = 0;
    EXPECT_THAT(trouble(folder_.write("a.nrrd", nrrd({infinite, 2}, {2, 1, 1}, "")), options),
                testing::Says(messages::kValueNotFinite));
}

TEST_F(GridsTest, IntegersThatNoFloatHoldsAreTold) {
    const auto file = [&](int32_t value) {
        return folder_.write(
            "a.mha",
            "NDims = 3\nDimSize = 2 1 1\nElementType = MET_INT\nElementDataFile = LOCAL\n" +
                raw(std::vector<int32_t>{7, value}));
    };
    EXPECT_EQ(told([&] { converted(file(1 << 24)); }), "");
    EXPECT_THAT(told([&] { converted(file((1 << 24) + 1)); }),
                testing::Says(messages::kIntegersRounded, "a.mha"));
    // Of which not even a double holds each.
    for (const int64_t value : {(int64_t{1} << 53) + 1, -(int64_t{1} << 53) - 1, INT64_MAX}) {
        const std::vector<int64_t> numbers{7, value};
        const auto mha = folder_.write(
            "a.mha",
            "NDims = 3\nDimSize = 2 1 1\nElementType = MET_LONG_LONG\nElementDataFile = LOCAL\n" +
                raw(numbers));
        EXPECT_THAT(told([&] { converted(mha); }),
                    testing::Says(messages::kIntegersRounded, "a.mha"))
            << value;
        const std::string head =
            R"(<VTKFile type="ImageData" byte_order="LittleEndian"><ImageData WholeExtent="0 2 0 1 0 1"><Piece Extent="0 2 0 1 0 1"><CellData>
<DataArray type="Int64" Name="a" )";
        const std::string tail = "</DataArray></CellData></Piece></ImageData></VTKFile>";
        const std::string size("\x10\0\0\0", 4);
        for (const std::string& data : {fmt::format("format=\"ascii\">7 {}", value),
                                        "format=\"binary\">" + base64(size + raw(numbers))}) {
            const auto vti = folder_.write("a.vti", head + data + tail);
            EXPECT_THAT(told([&] { converted(vti); }),
                        testing::Says(messages::kIntegersRounded, messages::kItsFieldAlone))
                << data;
        }
    }
    const auto whole = folder_.write(
        "a.mha",
        "NDims = 3\nDimSize = 2 1 1\nElementType = MET_LONG_LONG\nElementDataFile = LOCAL\n" +
            raw(std::vector<int64_t>{7, int64_t{1} << 60}));
    EXPECT_EQ(told([&] { converted(whole); }), "");
}

TEST_F(GridsTest, AFourthAxisOfOneIsLeftOut) {
    const std::string head =
        "NDims = 4\nElementType = MET_UCHAR\nElementSpacing = 2 3 4 9\nOffset = 5 6 7 8\n"
        "TransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n";
    const auto p = converted(
        folder_.write("a.mha", head + "DimSize = 2 1 1 1\nElementDataFile = LOCAL\n\x01\x02"));
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(level0(*p), (std::vector<float>{1, 2}));
    EXPECT_EQ(domain(*p), (std::vector<float>{4, 4.5F, 5, 4, 3, 4}));
    EXPECT_THAT(trouble(folder_.write("a.mha",
                                      head + "DimSize = 2 1 1 3\nElementDataFile = LOCAL\n123456")),
                testing::Says(messages::kVolumesInTime, 3));
}

/// A map of 3 x 2 x 1 numbers, with axes and origin.
std::string mrc(int mode, const std::string& numbers, bool big = false) {
    std::string out(1024, '\0');
    const auto put = [&](int word, const auto value) {
        std::string text(sizeof value, '\0');
        std::memcpy(text.data(), &value, sizeof value);
        if (big) std::reverse(text.begin(), text.end());
        out.replace(static_cast<size_t>(4 * (word - 1)), 4, text);
    };
    int word = 1;
    for (const int32_t value : {3, 2, 1, mode, 0, 0, 0, 3, 2, 1})
        put(word++, value);
    for (const float value : {6.0F, 10.0F, 4.0F, 90.0F, 90.0F, 90.0F})
        put(word++, value);
    for (const int32_t value : {1, 2, 3})
        put(word++, value);
    put(50, 11.0F);
    out.replace(208, 4, "MAP ");
    out[212] = big ? 0x11 : 0x44;
    return out + numbers;
}

TEST_F(GridsTest, MapsOfMicroscopesAreRead) {
    VolumeOptions options;
    options.unit = "mm";
    const std::vector<float> wanted{1, 2, 3, 4, 5, 6};
    for (const auto& text :
         {mrc(2, raw(wanted)), mrc(1, raw(std::vector<int16_t>{1, 2, 3, 4, 5, 6})),
          mrc(0, "\x01\x02\x03\x04\x05\x06"),
          mrc(1, std::string("\0\1\0\2\0\3\0\4\0\5\0\6", 12), true)}) {
        const auto p = converted(folder_.write("a.mrc", text), options);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(level0(*p), wanted);
        EXPECT_EQ(domain(*p), (std::vector<float>{10, -2.5F, -2, 6, 10, 4}));
    }
    EXPECT_FLOAT_EQ(domain(*converted(folder_.write("a.mrc", mrc(2, raw(wanted)))))[3], 6e-7F);
    EXPECT_THAT(trouble(folder_.write("a.mrc", mrc(4, raw(wanted)))),
                testing::Says(messages::kMrcMode, 4));
    EXPECT_EQ(trouble(folder_.write("a.mrc", mrc(2, "1234"))), messages::kCutShort);
    EXPECT_EQ(trouble(folder_.write("a.mrc", std::string(1024, 'a'))), messages::kNotMrc);
}

TEST_F(GridsTest, StacksOfMapsAreNamed) {
    const auto stack = [](int32_t group, int32_t sections) {
        std::string out = mrc(0, "\x01\x02\x03\x04\x05\x06");
        const auto put = [&](size_t word, int32_t value) {
            std::memcpy(out.data() + 4 * (word - 1), &value, sizeof value);
        };
        put(2, 1);
        put(3, 2);
        put(10, sections);
        put(23, group);
        return out;
    };
    EXPECT_EQ(trouble(folder_.write("a.mrc", stack(0, 1))),
              fmt::format(messages::kMrcImages, 2) + "; " + messages::kMrcImagesHelp);
    EXPECT_THAT(trouble(folder_.write("a.mrc", stack(401, 1))),
                testing::Says(messages::kMrcVolumes, 2));
    for (const int32_t group : {0, 1, 401}) {
        const auto p = converted(folder_.write("a.mrc", stack(group, 2)));
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(level0(*p), (std::vector<float>{1, 2, 3, 4, 5, 6}));
    }
}

TEST_F(GridsTest, TheRangeOfWhatWasQuantizedIsTold) {
    const std::string head = "NRRD0004\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n";
    const std::string range = "old min: 0\nold max: 1000\n\n";
    EXPECT_THAT(
        told([&] { converted(folder_.write("a.nrrd", head + "type: uchar\n" + range + "12")); }),
        testing::Says(messages::kOldRangeLeftOut, "a.nrrd"));
}

TEST_F(GridsTest, OtherContainersAreNamed) {
    EXPECT_THAT(trouble(folder_.write("a.mrc.gz", std::string("\x1f\x8b\x08\0", 4))),
                testing::Says(messages::kIsGzip));
    const std::string hdf("\x89HDF\r\n\x1a\n");
    EXPECT_THAT(trouble(folder_.write("a.mat", "MATLAB 7.3" + std::string(502, ' ') + hdf)),
                testing::Says(messages::kIsHdf5));
    EXPECT_THAT(trouble(folder_.write("a.mat", "MATLAB 5.0 MAT-file")),
                testing::Says(messages::kIsMatlab));
}

}  // namespace
}  // namespace openfab::tools
