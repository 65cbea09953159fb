// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What programs say of the pages of a TIFF in words of their own: channels and times are never slices.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include <array>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/says/says.h"
#include "tests/unit/texture/field_test.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using ::testing::ElementsAre;

constexpr uint32_t kFluoView = 34361, kMicroManager = 51123, kScaling = 42112, kNoData = 42113;

class TiffMakers : public FieldTest {
  protected:
    TiffMakers() {
        TIFFSetErrorHandler(nullptr);
        TIFFSetWarningHandler(nullptr);
    }
    using Set = std::function<void(TIFF*, int page)>;
    /// Writes pages of one byte, each its number, of `samples` samples, and what `set` adds.
    void write(int pages, const Set& set, int samples = 1, int photometric = 1) {
        TIFF* const out = TIFFOpen((folder_.path() / "a.tif").c_str(), "wl");
        ASSERT_NE(out, nullptr);
        const std::array<TIFFFieldInfo, 4> own{
            {{kFluoView, -3, -3, TIFF_BYTE, FIELD_CUSTOM, 1, 1, const_cast<char*>("FluoView")},
             {kMicroManager, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("MM")},
             {kScaling, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("Scaling")},
             {kNoData, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("NoData")}}};
        for (int page = 0; page < pages; ++page) {
            TIFFMergeFieldInfo(out, own.data(), own.size());
            TIFFSetField(out, TIFFTAG_IMAGEWIDTH, 1);
            TIFFSetField(out, TIFFTAG_IMAGELENGTH, 1);
            TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, 8);
            TIFFSetField(out, TIFFTAG_SAMPLESPERPIXEL, samples);
            TIFFSetField(out, TIFFTAG_PHOTOMETRIC, photometric);
            TIFFSetField(out, TIFFTAG_PLANARCONFIG, 1);
            set(out, page);
            std::vector<uint8_t> row(static_cast<size_t>(samples), static_cast<uint8_t>(page + 60));
            ASSERT_GT(TIFFWriteEncodedStrip(out, 0, row.data(), samples), 0);
            ASSERT_EQ(TIFFWriteDirectory(out), 1);
        }
        TIFFClose(out);
    }
    std::filesystem::path file() const { return folder_.path() / "a.tif"; }
    std::vector<float> read() {
        const auto out = converted(file());
        return out == nullptr ? std::vector<float>() : level0(*out);
    }
    std::string refused() { return trouble(file(), {}); }
    std::string told() {
        ::testing::internal::CaptureStderr();
        EXPECT_NE(converted(file()), nullptr);
        return ::testing::internal::GetCapturedStderr();
    }
};

void nothing(TIFF*, int) {}

TEST_F(TiffMakers, ScanImageSaysHowManyChannelsAndSlicesThereAre) {
    const auto with = [&](const std::string& description, const std::string& software) {
        write(6, [&](TIFF* out, int) {
            TIFFSetField(out, TIFFTAG_IMAGEDESCRIPTION, description.c_str());
            TIFFSetField(out, TIFFTAG_SOFTWARE, software.c_str());
        });
    };
    const std::string head = "SI.VERSION_MAJOR = '2018'\n";
    const std::string frame = "frameNumbers = 1\nacquisitionNumbers = 1\n";
    for (const auto& [description, software] : std::vector<std::pair<std::string, std::string>>{
             {frame, head + "SI.hChannels.channelSave = [1;2]\nSI.hStackManager.numSlices = 3\n"},
             {"scanimage.SI.hChannels.channelSave = [1 3]\n", ""},
             {"scanimage.SI4.channelsSave = [1;2]\n", ""},
             {"state.acq.numberOfChannelsSave=2\rstate.acq.numberOfZSlices=3\r", ""}}) {
        with(description, software);
        EXPECT_THAT(refused(), testing::Says(messages::kPagesByTurns, "ScanImage")) << description;
    }
    with(frame, head + "SI.hChannels.channelSave = 1\nSI.hStackManager.numSlices = 3\n");
    EXPECT_THAT(refused(), testing::Says(messages::kFramesInTime, 2));
    with(frame, head + "SI.hChannels.channelSave = 1\nSI.hStackManager.numSlices = 6\n");
    EXPECT_EQ(read().size(), 6U);
}

TEST_F(TiffMakers, FluoViewNamesItsDimensions) {
    const auto with = [&](const std::vector<std::pair<std::string, int32_t>>& dimensions) {
        std::string header(284 + 1000, '\0');
        for (size_t i = 0; i < dimensions.size(); ++i) {
            const auto& [name, size] = dimensions[i];
            header.replace(284 + 100 * i, name.size(), name);
            std::memcpy(header.data() + 284 + 100 * i + 16, &size, 4);
        }
        write(6, [&](TIFF* out, int page) {
            if (page == 0)
                TIFFSetField(out, kFluoView, static_cast<uint32_t>(header.size()), header.data());
        });
    };
    with({{"X", 1}, {"Y", 1}, {"Z", 3}, {"Ch", 2}});
    EXPECT_THAT(refused(), testing::Says(messages::kPagesByTurns, "FluoView"));
    with({{"X", 1}, {"Y", 1}, {"T", 6}});
    EXPECT_THAT(refused(), testing::Says(messages::kPagesByTurns, "FluoView"));
    with({{"X", 1}, {"Y", 1}, {"Z", 6}, {"Ch", 1}});
    EXPECT_EQ(read().size(), 6U);
}

TEST_F(TiffMakers, MicroManagerSaysOfEachPageWhatItIs) {
    const auto with = [&](int channels) {
        write(6, [&](TIFF* out, int page) {
            const std::string json = fmt::format(R"({{"ChannelIndex": {}, "SliceIndex": {}}})",
                                                 page % channels, page / channels);
            TIFFSetField(out, kMicroManager, json.c_str());
        });
    };
    with(2);
    EXPECT_THAT(refused(), testing::Says(messages::kPagesByTurns, "Micro-Manager"));
    with(1);
    EXPECT_EQ(read().size(), 6U);
    write(6, [&](TIFF* out, int page) {
        if (page == 0)
            TIFFSetField(out, TIFFTAG_IMAGEDESCRIPTION, "<PerkinElmer-QPI-ImageDescription/>");
    });
    EXPECT_THAT(refused(), testing::Says(messages::kPagesByTurns, "PerkinElmer"));
}

TEST_F(TiffMakers, AxesThatAreNotOfSlicesAreNamed) {
    for (const char axis : {'H', 'A', 'R', 'L'}) {
        const std::string text = fmt::format(R"({{"shape": [6, 1, 1], "axes": "{}YX"}})", axis);
        write(6, [&](TIFF* out, int page) {
            if (page == 0) TIFFSetField(out, TIFFTAG_IMAGEDESCRIPTION, text.c_str());
        });
        EXPECT_THAT(refused(), testing::Says(messages::kAxisOfPages, 6, axis));
    }
    write(6, [&](TIFF* out, int page) {
        if (page == 0)
            TIFFSetField(out, TIFFTAG_IMAGEDESCRIPTION, R"({"shape": [6, 1, 1], "axes": "QYX"})");
    });
    EXPECT_EQ(read().size(), 6U);
}

TEST_F(TiffMakers, SeveralSamplesAreColoursOnlyWhereTheFileSaysSo) {
    write(1, nothing, 3);
    const auto number = ::testing::FloatEq(60 / 255.0F);
    EXPECT_THAT(read(), ElementsAre(number, number, number));
    write(1, nothing, 3, PHOTOMETRIC_RGB);
    const float decoded = std::pow((60 / 255.0F + 0.055F) / 1.055F, 2.4F);  // of sRGB
    EXPECT_THAT(read(), ::testing::Each(::testing::FloatNear(decoded, 1e-5F)));
}

TEST_F(TiffMakers, WhatGdalSaysOfItsNumbersIsTold) {
    write(1, [](TIFF* out, int) {
        TIFFSetField(out, kNoData, "-9999");
        TIFFSetField(
            out, kScaling,
            R"(<GDALMetadata><Item name="SCALE" sample="0" role="scale">0.1</Item></GDALMetadata>)");
    });
    const std::string notes = told();
    EXPECT_THAT(notes, ::testing::HasSubstr(fmt::format(messages::kNoDataAsStored, "-9999")));
    EXPECT_THAT(notes, ::testing::HasSubstr(messages::kScalingLeftOut));
}

}  // namespace
}  // namespace openfab::tools
