// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Series of DICOM slices.
#include "tools/dicom/dicom_series.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "base/vec.h"
#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/border_reach.h"
#include "tests/unit/texture/dicom_files.h"
#include "tests/unit/texture/guarded_error.h"
#include "tools/dicom/messages.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

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

TEST_F(DicomTest, AnotherUnitThanMillimetresHasNoEffect) {
    for (const bool turned : {false, true}) {
        Slice slice;
        if (turned) slice.down = {0, 0, -1};
        write_series(slice, turned ? Vec3d{0, 3, 0} : Vec3d{0, 0, 3});
        VolumeOptions options;
        options.unit = "cm";
        EXPECT_THAT(trouble(options), testing::Says(messages::kKeyWithoutEffect,
                                                    messages::kLengthsInAnyUnit, "unit"));
    }
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
    EXPECT_THAT(trouble(), testing::Says(messages::kObliqueSlices));
    VolumeOptions options;
    options.outside = -1000;
    options.pitch_mm = 0.5;
    const auto p = converted(options);
    ASSERT_NE(p, nullptr);
    int inside = 0, outside = 0;
    const double reach = border_reach({c, s, 0}, options.pitch_mm) + 1e-6;
    each(*p, [&](const Vec3d& at, const float* value) {
        const double x = c * (at.x - 1) + s * (at.y - 2), y = -s * (at.x - 1) + c * (at.y - 2);
        if (x > 0 && x < 8 && y > 0 && y < 8 && at.z > 3 && at.z < 17) {
            EXPECT_NEAR(*value, linear(at), 1.0 / 16);  // as far as stored values are rounded
            ++inside;
        } else if (std::max({-x, x - 8, -y, y - 8}) > reach) {
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
    EXPECT_EQ(trouble(), fmt::format(messages::kSlicesAreMissing, 1.0, " is", "im4", 0.0, 0.0, 4.0,
                                     "im6", 0.0, 0.0, 6.0, 2.000, 1.000) +
                             "; " + messages::kSlicesAreMissingHelp);
    slice.position = {0, 0, 5};
    fill(&slice);
    write("im1", slice.bytes());
    write("again", slice.bytes());
    EXPECT_THAT(trouble(), testing::Says(messages::kSliceAtSamePlace));
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
                testing::Says(messages::kSeriesLine, "1/1", "CT, ", "4", "3", "1", "1", "axial",
                              "7", "s), 1/2 (CT, 3 x 3 *, axial, 1 *im1)*"));
    EXPECT_THAT(with([](Slice* s) { s->row_mm = 1.1; }),
                testing::Says(messages::kSeriesLine, "1/2", "CT, ", "4", "3", "1", "1.1", "axial",
                              "1", " im1)"));
    EXPECT_THAT(with([](Slice* s) { s->position.x = 1; }),
                ::testing::HasSubstr(std::string("im1: ") + messages::kSliceBesideLine));
    EXPECT_EQ(
        with([](Slice* s) { s->pixels.pop_back(); }),
        "im1: " + fmt::format(messages::kPixelsCutShort, 22, 24) + "; " + messages::kCopyItAgain);
    EXPECT_THAT(with([](Slice* s) { s->frames = 2; }),
                HasSubstr(std::string("im1: frame 1: ") + messages::kNoSliceSpacing));
    EXPECT_THAT(with([](Slice* s) { s->more = element(0x28, 8, "IS", "99999"); }),
                ::testing::HasSubstr("im1: " + fmt::format(messages::kFrameCount, 99999, 16384)));
    EXPECT_THAT(with([](Slice* s) {
                    s->across = {1, 1, 0};
                }),
                HasSubstr("im1: the axes of its orientation are not at right angles"));
    write("im1", good.substr(0, good.find(element(0x28, 2, "US", number(1, 2)))));
    write("im1.dcm", "no scan");
    EXPECT_EQ(trouble(), std::string("im1: ") + messages::kNoPixels);
    fs::remove(series() / "im1");
    EXPECT_EQ(trouble(), std::string("im1.dcm: ") + messages::kNotDicom);
    fs::remove(series() / "im1.dcm");
    write("im1", good);
    EXPECT_THAT(trouble({}, {2000, {}}), HasSubstr("im0: it takes"));
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
            EXPECT_THAT(made.error().text(), SaysWhyNotRead()) << "seed " << seed;
            if (made.error().text().starts_with("the reader of")) {
                EXPECT_THAT(made.error().text(), HasSubstr("at `im1`")) << "seed " << seed;
            }
        }
    }
    EXPECT_GT(wrong, many / 4) << "most of the file is heads";
}

}  // namespace
}  // namespace openfab::tools
