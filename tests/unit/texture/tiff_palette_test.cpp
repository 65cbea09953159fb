// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// TIFFs with a palette, of every width that has one: their numbers are read, and the note says which of them is 1.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include <array>
#include <vector>

#include "tests/unit/texture/field_test.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using TiffPalette = FieldTest;

/// Writes a row of four numbers of these bits, with a palette.
void write(const std::string& path, int bits, const std::array<uint32_t, 4>& numbers) {
    TIFF* const out = TIFFOpen(path.c_str(), "w");
    TIFFSetField(out, TIFFTAG_IMAGEWIDTH, 4);
    TIFFSetField(out, TIFFTAG_IMAGELENGTH, 1);
    TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, bits);
    TIFFSetField(out, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(out, TIFFTAG_ROWSPERSTRIP, 1);
    TIFFSetField(out, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_PALETTE);
    std::vector<uint16_t> shades(size_t{1} << bits);
    TIFFSetField(out, TIFFTAG_COLORMAP, shades.data(), shades.data(), shades.data());
    std::vector<uint8_t> row(static_cast<size_t>(bits + 1) / 2,
                             0);  // four numbers, the first in the highest bits
    for (size_t i = 0; i < 4; ++i) {
        for (int bit = 0; bit < bits; ++bit) {
            const size_t at = i * static_cast<size_t>(bits) + static_cast<size_t>(bit);
            const bool one = (numbers[i] >> (bits - 1 - bit) & 1) != 0;
            if (one) row[at / 8] = static_cast<uint8_t>(row[at / 8] | 0x80 >> at % 8);
        }
    }
    EXPECT_EQ(TIFFWriteEncodedStrip(out, 0, row.data(), static_cast<tmsize_t>(row.size())),
              static_cast<tmsize_t>(row.size()));
    TIFFClose(out);
}

TEST_F(TiffPalette, NumbersAreReadAndTheNoteSaysWhichIsOne) {
    for (const int bits : {1, 2, 4, 8}) {
        const uint32_t most = (1U << bits) - 1;
        const std::array<uint32_t, 4> numbers{0, most, most / 2, 1};
        const auto path = folder_.path() / "p.tif";
        write(path.string(), bits, numbers);
        ::testing::internal::CaptureStderr();
        const auto p = converted(path);
        EXPECT_EQ(::testing::internal::GetCapturedStderr(),
                  fmt::format(messages::kPaletteAsNumbers, "note: p.tif", most) + "\n");
        ASSERT_NE(p, nullptr) << bits;
        for (size_t i = 0; i < 4; ++i)
            EXPECT_FLOAT_EQ(level0(*p)[i],
                            static_cast<float>(numbers[i]) / static_cast<float>(most))
                << bits;
    }
}

}  // namespace
}  // namespace openfab::tools
