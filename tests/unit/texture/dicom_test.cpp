// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Series of DICOM slices, written here byte by byte after the standard (PS3.5, PS3.10), of nobody.
#include "tools/dicom/dicom_series.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>

#include "base/vec.h"
#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/unit/texture/field_test.h"
#include "tools/texture/guarded.h"

namespace openfab::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kExplicit = "1.2.840.10008.1.2.1";
constexpr const char* kRunLengths = "1.2.840.10008.1.2.5";
/// Of a person who must not show up anywhere.
constexpr const char* kPerson = "DOE^JANE";

std::string number(uint32_t value, size_t bytes) {
    std::string out;
    for (size_t i = 0; i < bytes; ++i)
        out += static_cast<char>(value >> (8 * i) & 0xff);
    return out;
}

std::string element(uint32_t group, uint32_t item, const std::string& kind, std::string value) {
    if (value.size() % 2 != 0) value += kind == "UI" || kind == "OB" ? '\0' : ' ';
    const std::string tag = number(group, 2) + number(item, 2) + kind;
    const auto size = static_cast<uint32_t>(value.size());
    if (kind == "OW" || kind == "OB") return tag + number(0, 2) + number(size, 4) + value;
    return tag + number(size, 2) + value;
}

std::string decimals(const std::vector<double>& values) {
    std::string out;
    for (const double value : values)
        out += fmt::format("{}{:.11g}", out.empty() ? "" : "\\", value);
    return out;
}

struct Slice {
    int width = 4, height = 3;
    Vec3d position{}, across{1, 0, 0}, down{0, 1, 0};  ///< unit vectors
    double row_mm = 1, column_mm = 1;
    double slope = 1, intercept = -1000;
    bool has_sign = false;
    std::string series = "1.2.3";
    int series_number = 1;
    std::vector<uint16_t> pixels;
    std::string more;  ///< elements before the pixels

    std::string bytes(const std::string& syntax = kExplicit) const {
        std::string pixel_bytes;
        for (const uint16_t value : pixels)
            pixel_bytes += number(value, 2);
        const std::string data =
            syntax == kExplicit ? element(0x7fe0, 0x10, "OW", pixel_bytes) : run_lengths();
        std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) +
                           element(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.2") +
                           element(2, 3, "UI", "1.2.3.4") + element(2, 0x10, "UI", syntax);
        meta = element(2, 0, "UL", number(static_cast<uint32_t>(meta.size()), 4)) + meta;
        const auto us = [](uint32_t item, uint32_t value) {
            return element(0x28, item, "US", number(value, 2));
        };
        return std::string(128, '\0') + "DICM" + meta +
               element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2") + element(8, 0x60, "CS", "CT") +
               element(0x10, 0x10, "PN", kPerson) + element(0x20, 0x0e, "UI", series) +
               element(0x20, 0x11, "IS", std::to_string(series_number)) +
               element(0x20, 0x32, "DS", decimals({position.x, position.y, position.z})) +
               element(0x20, 0x37, "DS",
                       decimals({across.x, across.y, across.z, down.x, down.y, down.z})) +
               us(2, 1) + element(0x28, 4, "CS", "MONOCHROME2") + more +
               us(0x10, static_cast<uint32_t>(height)) + us(0x11, static_cast<uint32_t>(width)) +
               element(0x28, 0x30, "DS", decimals({row_mm, column_mm})) + us(0x100, 16) +
               us(0x101, 12) + us(0x102, 11) + us(0x103, has_sign ? 1 : 0) +
               element(0x28, 0x1052, "DS", decimals({intercept})) +
               element(0x28, 0x1053, "DS", decimals({slope})) + data;
    }
    /// Pixels as two planes of bytes, the high ones first, in literal runs (PS3.5, annex G).
    std::string run_lengths() const {
        std::array<std::string, 2> planes;
        for (size_t plane = 0; plane < 2; ++plane) {
            for (size_t at = 0; at < pixels.size(); at += 100) {
                const size_t n = std::min<size_t>(100, pixels.size() - at);
                planes[plane] += static_cast<char>(n - 1);
                for (size_t i = 0; i < n; ++i)
                    planes[plane] +=
                        static_cast<char>(pixels[at + i] >> (plane == 0 ? 8 : 0) & 0xff);
            }
            if (planes[plane].size() % 2 != 0) planes[plane] += '\0';
        }
        std::string frame =
            number(2, 4) + number(64, 4) + number(static_cast<uint32_t>(64 + planes[0].size()), 4);
        frame += std::string(64 - frame.size(), '\0') + planes[0] + planes[1];
        const std::string item = number(0xfffe, 2) + number(0xe000, 2);
        return number(0x7fe0, 2) + number(0x10, 2) + "OB" + number(0, 2) + number(0xffffffff, 4) +
               item + number(0, 4) + item + number(static_cast<uint32_t>(frame.size()), 4) + frame +
               number(0xfffe, 2) + number(0xe0dd, 2) + number(0, 4);
    }
};

/// A field whose stored values are whole numbers on the grids below, and not negative.

class DicomTest : public FieldTest {
  protected:
    DicomTest() { fs::create_directory(series()); }
    fs::path series() const { return folder_.path() / "series"; }
    void write(const std::string& name, const std::string& bytes) {
        folder_.write("series/" + name, bytes);
    }
    /// Fills the slice with the field, in steps of 1/16 above an intercept of -100.
    static void fill(Slice* slice) {
        slice->slope = 1.0 / 16;
        slice->intercept = -100;
        slice->pixels.clear();
        for (int y = 0; y < slice->height; ++y) {
            for (int x = 0; x < slice->width; ++x) {
                const Vec3d at = slice->position + slice->across * (x * slice->column_mm) +
                                 slice->down * (y * slice->row_mm);
                const double stored = (linear(at) + 100) * 16;
                EXPECT_TRUE(stored >= 0 && stored < 4096) << stored;
                slice->pixels.push_back(static_cast<uint16_t>(std::lround(stored)));
            }
        }
    }
    /// Eight slices, named in no order.
    void write_series(Slice slice, const Vec3d& step, const std::string& syntax = kExplicit) {
        const Vec3d first = slice.position;
        for (int k = 0; k < 8; ++k) {
            slice.position = first + step * static_cast<double>(k);
            fill(&slice);
            write(fmt::format("im{}", k * 5 % 8), slice.bytes(syntax));
        }
    }
    std::shared_ptr<const Pyramid> converted(const VolumeOptions& options = {}) {
        const fs::path out = folder_.path() / "out.oftx";
        const Result<void> made = make_dicom_volume_file(series(), out, options);
        EXPECT_TRUE(made) << made.error().text();
        if (!made) return nullptr;
        std::ifstream in(out, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(in), {}};
        EXPECT_EQ(bytes.find(kPerson), std::string::npos);
        const auto opened = Pyramid::open(out, 0, 0);
        EXPECT_TRUE(opened) << opened.error().text();
        return opened ? *opened : nullptr;
    }
    std::string trouble(const VolumeOptions& options = {}, const texture::ReadLimits& limits = {}) {
        const Result<void> made =
            make_dicom_volume_file(series(), folder_.path() / "out.oftx", options, limits);
        if (made) return "no error";
        const std::string text = made.error().text();
        EXPECT_THAT(text, Not(HasSubstr("DOE")));
        const std::string start = "cannot read " + series().string() + ": ";
        EXPECT_TRUE(text.starts_with(start)) << text;
        return text.substr(start.size());
    }
};

TEST_F(DicomTest, SlicesAreInPlaceWhateverTheirNames) {
    for (const char* syntax : {kExplicit, kRunLengths}) {
        SCOPED_TRACE(syntax);
        Slice slice;
        slice.position = {-10, 5, 2};
        slice.row_mm = 0.5;
        slice.column_mm = 0.25;
        write_series(slice, {0, 0, 1.5}, syntax);
        const auto p = converted();
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{4, 3, 8}));
        EXPECT_EQ(origin(*p), (Vec3d{-10.125, 4.75, 1.25}));
        EXPECT_EQ(extent(*p), (Vec3d{1, 1.5, 12}));
        each(*p, [](const Vec3d& at, const float* value) {
            EXPECT_EQ(*value, static_cast<float>(linear(at)));
        });
    }
}

TEST_F(DicomTest, StoredValuesMayHaveASign) {
    Slice slice;
    slice.width = 2;
    slice.height = 1;
    slice.has_sign = true;
    slice.slope = 2;
    slice.intercept = 24;
    slice.pixels = {0xfff, 0xf7ff};  // -1 and 2047 in 12 bits; what lies above them is no value
    write("a", slice.bytes());
    const auto p = converted();
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(p->texels()[0], 22);
    EXPECT_EQ(p->texels()[1], 2 * 2047 + 24);
}

TEST_F(DicomTest, OtherPlanesThanTheAxialArePutInOrder) {
    // Coronal: rows along x, columns down along -z, slices along y.
    Slice slice;
    slice.position = {3, -4, 20};
    slice.down = {0, 0, -1};
    slice.row_mm = 2;
    write_series(slice, {0, 3, 0});
    const auto p = converted();
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{4, 8, 3}));
    EXPECT_EQ(origin(*p), (Vec3d{2.5, -5.5, 15}));
    each(*p, [](const Vec3d& at, const float* value) {
        EXPECT_EQ(*value, static_cast<float>(linear(at)));
    });
}

TEST_F(DicomTest, TurnedSlicesAreSampledInPlace) {
    Slice slice;
    slice.width = 9;
    slice.height = 9;
    slice.position = {1, 2, 3};
    const double c = std::cos(0.4), s = std::sin(0.4);
    slice.across = {c, s, 0};
    slice.down = {-s, c, 0};
    write_series(slice, {0, 0, 2});
    EXPECT_THAT(trouble(), HasSubstr("so that it is resampled; say by `outside`"));
    VolumeOptions options;
    options.outside = -1000;
    options.pitch_mm = 0.5;
    const auto p = converted(options);
    ASSERT_NE(p, nullptr);
    int inside = 0, outside = 0;
    each(*p, [&](const Vec3d& at, const float* value) {
        const double x = c * (at.x - 1) + s * (at.y - 2), y = -s * (at.x - 1) + c * (at.y - 2);
        if (x > 0 && x < 8 && y > 0 && y < 8 && at.z > 3 && at.z < 17) {
            EXPECT_NEAR(*value, linear(at), 1.0 / 16);  // as far as stored values are rounded
            ++inside;
        } else if (x < -0.6 || x > 8.6 || y < -0.6 || y > 8.6) {
            EXPECT_EQ(*value, -1000);
            ++outside;
        }
    });
    EXPECT_GT(inside, 5000);
    EXPECT_GT(outside, 1000);
}

TEST_F(DicomTest, SaysWhichSliceIsWrong) {
    Slice slice;
    write_series(slice, {0, 0, 1});
    fs::remove(series() / "im1");  // of z = 5
    EXPECT_EQ(trouble(), "im6: it lies 2.000 mm from im4, where slices are 1.000 mm apart");
    slice.position = {0, 0, 5};
    fill(&slice);
    write("im1", slice.bytes());
    write("again", slice.bytes());
    EXPECT_THAT(trouble(), HasSubstr("it lies where "));
    fs::remove(series() / "again");
    EXPECT_EQ(trouble(), "no error");
    write("DICOMDIR", "a list");
    EXPECT_EQ(trouble(), "no error");

    const std::string good = slice.bytes();
    const auto with = [&](const std::function<void(Slice*)>& change) {
        Slice other = slice;
        change(&other);
        write("im1", other.bytes());
        return trouble();
    };
    EXPECT_THAT(with([](Slice* s) { s->width = 3; }),
                HasSubstr("im1: it has 3 x 3 pixels, im0 has 4 x 3"));
    EXPECT_THAT(with([](Slice* s) { s->row_mm = 1.1; }),
                HasSubstr("im1: it is turned or spaced otherwise than im0"));
    EXPECT_THAT(with([](Slice* s) { s->position.x = 1; }),
                HasSubstr("im1: it lies beside the line of the others"));
    EXPECT_THAT(with([](Slice* s) { s->pixels.pop_back(); }), HasSubstr("im1: it is cut short"));
    EXPECT_THAT(with([](Slice* s) { s->more = element(0x28, 8, "IS", "2"); }),
                HasSubstr("im1: it holds several frames"));
    EXPECT_THAT(with([](Slice* s) {
                    s->across = {1, 1, 0};
                }),
                HasSubstr("im1: the axes of its orientation are not at right angles"));
    write("im1", "no scan");
    EXPECT_EQ(trouble(), "im1: it is not a DICOM file, or damaged");
    write("im1", good);
    EXPECT_THAT(trouble({}, {2000, {}}), HasSubstr("im0: it takes"));
}

TEST_F(DicomTest, ASeriesOfSeveralIsNamed) {
    Slice slice;
    write_series(slice, {0, 0, 1});
    slice.series = "1.2.4";
    slice.series_number = 7;
    fill(&slice);
    write("other", slice.bytes());
    EXPECT_EQ(trouble(), "its slices belong to series 1, 7; name one by `field`");
    VolumeOptions options;
    options.field = "7";
    const auto p = converted(options);
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p).z, 1);
    options.field = "2";
    EXPECT_EQ(trouble(options), "it has no series 2");
}

TEST_F(DicomTest, DamagedSlicesAreErrors) {
    Slice slice;
    write_series(slice, {0, 0, 1});
    slice.position = {0, 0, 5};
    fill(&slice);
    const int many = testing::long_run() ? 2500 : 60;
    int wrong = 0;
    for (const char* syntax : {kExplicit, kRunLengths}) {
        const std::string whole = slice.bytes(syntax);
        for (int seed = 0; seed < many; ++seed) {
            std::mt19937_64 random(static_cast<uint64_t>(seed));
            write("im1", testing::mutate(whole, false, &random));
            const Result<void> made = guarded(50'000'000, series(), [&] {
                return make_dicom_volume_file(series(), folder_.path() / "out.oftx", {},
                                              {50'000'000, {}});
            });
            if (made) continue;
            ++wrong;
            EXPECT_EQ(made.error().code, ErrorCode::kUserInput) << "seed " << seed;
            EXPECT_THAT(made.error().text(), HasSubstr("cannot read ")) << "seed " << seed;
            if (made.error().text().find("crashed") != std::string::npos) {
                EXPECT_THAT(made.error().text(), HasSubstr(": im1: ")) << "seed " << seed;
            }
        }
    }
    EXPECT_GT(wrong, many / 4) << "most of the file is heads";
}

}  // namespace
}  // namespace openfab::tools
