// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// NIfTI and MetaImage, made here byte by byte: the same texels must come out in the same place, whichever
// way the axes run and however the file says so.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>

#include "tests/support/says/says.h"
#include "tests/unit/texture/field_test.h"
#include "texture/messages.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using ScansTest = FieldTest;

std::string gzipped(const std::string& plain) {
    std::string packed(plain.size() + 100, 0);
    libdeflate_compressor* c = libdeflate_alloc_compressor(6);
    packed.resize(
        libdeflate_gzip_compress(c, plain.data(), plain.size(), packed.data(), packed.size()));
    libdeflate_free_compressor(c);
    return packed;
}

/// A header of NIfTI, version 1 or 2, in either order of bytes.
class Nifti {
  public:
    explicit Nifti(int version, bool big = false) : old_(version == 1), big_(big) {
        bytes_.assign(old_ ? 352 : 544, '\0');
        put<int32_t>(0, old_ ? 348 : 540);
        if (old_) {
            bytes_.replace(344, 4, std::string("n+1\0", 4));
            put<float>(108, 352);
        } else {
            bytes_.replace(4, 8, std::string("n+2\0\r\n\032\n", 8));
            put<int64_t>(168, 544);
        }
        slope(1, 0);
    }
    Nifti& size(const std::vector<int64_t>& sides) {
        for (size_t i = 0; i < 8; ++i) {
            const int64_t n = i == 0              ? static_cast<int64_t>(sides.size())
                              : i <= sides.size() ? sides[i - 1]
                                                  : 1;
            old_ ? put<int16_t>(40 + 2 * i, n) : put<int64_t>(16 + 8 * i, n);
            real(old_ ? 76 : 104, i, 1);
        }
        return *this;
    }
    Nifti& type(int code, int bits) {
        put<int16_t>(old_ ? 70 : 12, code);
        put<int16_t>(old_ ? 72 : 14, bits);
        return *this;
    }
    Nifti& spacing(const std::array<double, 4>& steps) {  // the first is the sign of the third axis
        for (size_t i = 0; i < 4; ++i)
            real(old_ ? 76 : 104, i, steps[i]);
        return *this;
    }
    Nifti& slope(double slope, double intercept) {
        real(old_ ? 112 : 176, 0, slope);
        real(old_ ? 112 : 176, 1, intercept);
        return *this;
    }
    Nifti& affine(const std::array<std::array<double, 4>, 3>& rows) {
        code(1, 1);
        for (size_t i = 0; i < 12; ++i)
            real(old_ ? 280 : 400, i, rows[i / 4][i % 4]);
        return *this;
    }
    Nifti& quaternion(const std::array<double, 3>& q, const std::array<double, 3>& shift) {
        code(0, 1);
        for (size_t i = 0; i < 3; ++i) {
            real(old_ ? 256 : 352, i, q[i]);
            real(old_ ? 268 : 376, i, shift[i]);
        }
        return *this;
    }
    Nifti& units(int code) {
        old_ ? put<uint8_t>(123, code) : put<int32_t>(500, code);
        return *this;
    }
    Nifti& detached() {
        bytes_[old_ ? 345 : 5] = 'i';
        old_ ? put<float>(108, 0) : put<int64_t>(168, 0);
        return *this;
    }
    template <typename T>
    std::string with(const std::vector<T>& values) const {
        return bytes_ + numbers(values);
    }
    template <typename T>
    std::string numbers(const std::vector<T>& values) const {
        std::string out;
        for (const T value : values)
            out += text_of(value);
        return out;
    }
    const std::string& bytes() const { return bytes_; }

  private:
    template <typename T>
    std::string text_of(T value) const {
        std::string out(sizeof value, '\0');
        std::memcpy(out.data(), &value, sizeof value);
        if (big_) std::reverse(out.begin(), out.end());
        return out;
    }
    template <typename T, typename U>
    void put(size_t at, U value) {
        bytes_.replace(at, sizeof(T), text_of(static_cast<T>(value)));
    }
    void real(size_t at, size_t i, double value) {
        old_ ? put<float>(at + 4 * i, value) : put<double>(at + 8 * i, value);
    }
    void code(size_t which, int value) {  // 0: of the quaternion, 1: of the affine map
        old_ ? put<int16_t>(252 + 2 * which, value) : put<int32_t>(344 + 4 * which, value);
    }

    bool old_, big_;
    std::string bytes_;
};

/// 4 x 3 x 2 texels of 0.5 x 1 x 2 mm from (10, 20, 30) on, of which axes x and z of the file are
/// exchanged, and x falls.
constexpr std::array<std::array<double, 4>, 3> kAffine{
    {{0, 0, -0.5, 11.75}, {0, 1, 0, 20.5}, {2, 0, 0, 31}}};
std::vector<float> in_order() {
    std::vector<float> out(24);
    for (size_t i = 0; i < 24; ++i)
        out[i] = static_cast<float>(i);
    return out;
}
template <typename T>
std::vector<T> exchanged() {
    std::vector<T> out;
    for (int x = 3; x >= 0; --x) {
        for (int y = 0; y < 3; ++y) {
            for (int z = 0; z < 2; ++z)
                out.push_back(static_cast<T>((z * 3 + y) * 4 + x));
        }
    }
    return out;
}
const std::vector<float> kPlace{10, 20, 30, 2, 3, 4};

TEST_F(ScansTest, NiftiIsPutInOrderInEveryForm) {
    for (const int version : {1, 2}) {
        for (const bool big : {false, true}) {
            SCOPED_TRACE(fmt::format("version {}, {}", version, big));
            Nifti image(version, big);
            image.size({2, 3, 4}).type(4, 16).affine(kAffine).units(2);
            const std::vector<int16_t> values = exchanged<int16_t>();
            folder_.write("d.img", image.numbers(values));
            const std::string whole = image.with(values);
            for (const auto& file :
                 {folder_.write("a.nii", whole), folder_.write("a.nii.gz", gzipped(whole)),
                  folder_.write("d.hdr", image.detached().bytes())}) {
                const auto p = converted(file);
                ASSERT_NE(p, nullptr) << file;
                EXPECT_EQ(size(*p), (Vec3i{4, 3, 2}));
                EXPECT_EQ(level0(*p), in_order()) << file;
                EXPECT_EQ(domain(*p), kPlace) << file;
            }
            EXPECT_EQ(texture::detached_data(folder_.path() / "d.hdr", {}).size(), 1U);
            EXPECT_TRUE(texture::detached_data(folder_.path() / "a.nii", {}).empty());
        }
    }
}

TEST_F(ScansTest, NiftiIsPlacedByItsQuaternionElseByItsSpacing) {
    // Turned by 180 degrees about z: x and y fall; the third axis falls by the sign that goes before.
    for (const int version : {1, 2}) {
        Nifti image(version);
        image.size({4, 3, 2}).type(16, 32).spacing({-1, 0.5, 1, 2});
        image.quaternion({0, 0, 1}, {11.75, 22.5, 33});
        std::vector<float> values = in_order();
        std::reverse(values.begin(), values.end());
        const auto p = converted(folder_.write("q.nii", image.with(values)));
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(level0(*p), in_order());
        EXPECT_EQ(domain(*p), kPlace);
    }
    Nifti bare(1);
    bare.size({4, 3, 2}).type(16, 32).spacing({1, 0.5, 1, 2}).units(3);
    const auto p = converted(folder_.write("b.nii", bare.with(in_order())));
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(domain(*p), (std::vector<float>{0, 0, 0, 2e-3F, 3e-3F, 4e-3F})) << "micrometres";
    // A turned one is sampled: a texel's centre has its value.
    const double s = 0.6, c = 0.8;
    Nifti turned(2);
    turned.size({9, 9, 1}).type(64, 64).affine({{{c, -s, 0, 0}, {s, c, 0, 0}, {0, 0, 1, 0}}});
    std::vector<double> values;
    for (int j = 0; j < 9; ++j) {
        for (int i = 0; i < 9; ++i)
            values.push_back(linear({c * i - s * j, s * i + c * j, 0}));
    }
    const auto q = converted(folder_.write("t.nii", turned.with(values)));
    ASSERT_NE(q, nullptr);
    int inside = 0;
    each(*q, [&](const Vec3d& at, const float* value) {
        const double i = c * at.x + s * at.y, j = c * at.y - s * at.x;
        if (i < 0 || j < 0 || i > 8 || j > 8) return;
        ++inside;
        EXPECT_NEAR(*value, linear({at.x, at.y, 0}), 1e-4);
    });
    EXPECT_GT(inside, 40);
}

TEST_F(ScansTest, AQuaternionOfHalfATurnIsStraight) {
    // 0.70710677 is the root of a half as a float: 3.4e-8 are left for the first part, which is none.
    Nifti image(1);
    image.size({4, 3, 2}).type(16, 32).spacing({1, 0.5, 1, 2});
    image.quaternion({0, 0.70710677, 0.70710677}, {0, 0, 0});
    const auto p = converted(folder_.write("h.nii", image.with(in_order())));
    ASSERT_NE(p, nullptr);
    // x falls, and y and z are exchanged.
    EXPECT_EQ(size(*p), (Vec3i{4, 2, 3}));
    size_t i = 0;
    for (int y = 0; y < 3; ++y) {
        for (int z = 0; z < 2; ++z) {
            for (int x = 3; x >= 0; --x)
                EXPECT_EQ(level0(*p)[i++], static_cast<float>((z * 3 + y) * 4 + x));
        }
    }
}

TEST_F(ScansTest, NiftiNumbersAreWhatTheFileMeans) {
    const auto values = [&](const std::string& file, const VolumeOptions& options = {}) {
        const auto p = converted(folder_.write("n.nii", file), options);
        return p == nullptr ? std::vector<float>{} : level0(*p);
    };
    const std::vector<int64_t> two{2, 1, 1};
    EXPECT_EQ(values(Nifti(1).size(two).type(2, 8).with<uint8_t>({0, 255})),
              (std::vector<float>{0, 255}))
        << "as they are";
    EXPECT_EQ(values(Nifti(1).size(two).type(512, 16).slope(0.5, -100).with<uint16_t>({0, 1000})),
              (std::vector<float>{-100, 400}));
    EXPECT_EQ(values(Nifti(1, true).size(two).type(8, 32).slope(0, 5).with<int32_t>({-7, 1 << 20})),
              (std::vector<float>{-7, 1 << 20}))
        << "a slope of 0 is none";
    EXPECT_EQ(values(Nifti(2).size(two).type(1024, 64).with<int64_t>({-7, int64_t{1} << 40})),
              (std::vector<float>{-7, 0x1p40F}));
    EXPECT_EQ(values(Nifti(1).size(two).type(128, 24).slope(9, 9).with<uint8_t>(
                  {0, 51, 255, 255, 0, 51})),
              (std::vector<float>{0, 0.2F, 1, 1, 0, 0.2F}))
        << "colours";
    // Components lie one volume behind the other.
    EXPECT_EQ(values(Nifti(1).size({2, 1, 1, 1, 3}).type(16, 32).with<float>({1, 2, 3, 4, 5, 6})),
              (std::vector<float>{1, 3, 5, 2, 4, 6}));
    const std::string steps =
        Nifti(1).size({2, 1, 1, 3}).type(16, 32).with<float>({1, 2, 3, 4, 5, 6});
    VolumeOptions options;
    for (int step = 0; step < 3; ++step) {
        options.field = std::to_string(step);
        const std::vector<float> wanted{static_cast<float>(2 * step + 1),
                                        static_cast<float>(2 * step + 2)};
        EXPECT_EQ(values(steps, options), wanted);
        EXPECT_EQ(values(gzipped(steps), options), wanted) << "packed";
    }
    EXPECT_EQ(trouble(folder_.write("n.nii", steps)),
              fmt::format(messages::kVolumesInTime, 3) + "; " +
                  fmt::format(messages::kVolumesInTimeHelp, 2));
    EXPECT_EQ(trouble(folder_.write("n.nii", Nifti(1).size(two).type(32, 64).bytes())),
              fmt::format(messages::kNumbersAre, "complex; ") + messages::kNumbersAreHelp);
    EXPECT_EQ(trouble(folder_.write("n.nii", Nifti(1).size(two).type(16, 32).bytes() + "1234")),
              messages::kCutShort);
    EXPECT_EQ(trouble(folder_.write("n.nii", "nothing")), messages::kNotNifti);
    EXPECT_THAT(
        trouble(folder_.write("none.hdr", Nifti(1).size(two).type(2, 8).detached().bytes())),
        testing::Says(texture::messages::kDataFileUnreadable, "none.img"));
    std::string analyze = Nifti(1).size(two).type(2, 8).bytes();
    analyze.replace(344, 4, 4, '\0');
    EXPECT_EQ(trouble(folder_.write("a.hdr", analyze)),
              std::string(messages::kAnalyze75) + "; " + messages::kAnalyze75Help);
    EXPECT_EQ(trouble(folder_.write("a.img", "1234")),
              std::string(messages::kOnlyNumbers) + "; " + messages::kOnlyNumbersHdrHelp);
    EXPECT_EQ(trouble(folder_.write("a.pvtu", "<VTKFile/>")),
              std::string(messages::kPartsOfGrid) + "; " + messages::kPartsOfGridHelp);
}

TEST_F(ScansTest, MetaImageIsPutInOrderInEveryForm) {
    const std::vector<int16_t> values = exchanged<int16_t>();
    const std::string raw(reinterpret_cast<const char*>(values.data()), 2 * values.size());
    const std::string head =
        "ObjectType = Image\nNDims = 3\nDimSize = 2 3 4\nElementType = MET_SHORT\n"
        "ElementSpacing = 2 1 0.5\nOffset = 11.75 20.5 31\nTransformMatrix = 0 0 1 0 1 0 -1 0 0\n";
    std::string swapped = raw, text;
    for (size_t i = 0; i < swapped.size(); i += 2)
        std::swap(swapped[i], swapped[i + 1]);
    for (const int16_t value : values)
        text += fmt::format("{} ", value);
    folder_.write("d.raw", "before" + raw);
    folder_.write("d.zraw", gzipped(raw));
    for (const auto& [name, tail] : std::vector<std::pair<std::string, std::string>>{
             {"a.mha", "ElementDataFile = LOCAL\n" + raw},
             {"b.mha", "BinaryDataByteOrderMSB = True\r\nElementDataFile = LOCAL\r\n" + swapped},
             {"c.mha", "BinaryData = False\nElementDataFile = LOCAL\n" + text},
             {"z.mha", "CompressedData = True\nElementDataFile = LOCAL\n" + gzipped(raw)},
             {"d.mhd", "HeaderSize = 6\nElementDataFile = d.raw\n"},
             {"e.mhd", "HeaderSize = -1\nElementDataFile = d.raw\n"},
             {"f.mhd", "CompressedData = True\nElementDataFile = d.zraw\n"}}) {
        const auto p = converted(folder_.write(name, head + tail));
        ASSERT_NE(p, nullptr) << name;
        EXPECT_EQ(size(*p), (Vec3i{4, 3, 2})) << name;
        EXPECT_EQ(level0(*p), in_order()) << name;
        EXPECT_EQ(domain(*p), kPlace) << name;
    }
    EXPECT_EQ(texture::detached_data(folder_.path() / "d.mhd", {}).size(), 1U);
    const auto vectors = converted(folder_.write(
        "v.mha",
        "NDims = 3\nDimSize = 2 1 1\nElementNumberOfChannels = 2\nElementType = MET_UCHAR\n"
        "ElementDataFile = LOCAL\n\x01\x02\x03\xff"));
    ASSERT_NE(vectors, nullptr);
    EXPECT_EQ(level0(*vectors), (std::vector<float>{1, 2, 3, 255}));
    const auto wrong = [&](const std::string& fields) {
        return trouble(folder_.write("w.mha", fields));
    };
    EXPECT_EQ(wrong("NDims = 3\n"), texture::messages::kNotMetaImage);
    EXPECT_EQ(wrong("ElementType = MET_SHORT\nNDims = 2\nElementDataFile = LOCAL\n"),
              fmt::format(messages::kVolumeDimensions, 2));
    EXPECT_EQ(wrong("ElementType = MET_STRING\nNDims = 3\nElementDataFile = LOCAL\n"),
              fmt::format(messages::kUnknownNumberType, "MET_STRING"));
    EXPECT_THAT(wrong(head + "ElementDataFile = slice%03d.raw 0 3 1\n"),
                testing::Says(texture::messages::kDataFileUnreadable, "slice000.raw"));
    EXPECT_EQ(wrong(head + "ElementDataFile = LOCAL\nxx"), messages::kCutShort);
}

}  // namespace
}  // namespace openfab::tools
