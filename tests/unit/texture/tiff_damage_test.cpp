// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Compressed strips and tiles of TIFF with a wrong byte: an error, or the numbers that were written, wherever the
// compression has a check sum. Every byte of a strip is changed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/field_test.h"
#include "tools/texture/messages.h"
#include "tools/texture/tiff_image.h"

namespace openfab::tools {
namespace {

constexpr int kSide = 16, kRows = 8;

/// A way to write 16 x 20 numbers of 16 bits.
struct Packed {
    int compression = COMPRESSION_ADOBE_DEFLATE, predictor = 1;
    bool tiled = false;
    const char* mode = "wl";
};

uint16_t value(int x, int y) {
    return static_cast<uint16_t>(x * x * 31 + y * 257 + x * y);
}

class TiffDamage : public FieldTest {
  protected:
    static constexpr int kHeight = 20;
    TiffDamage() {
        TIFFSetErrorHandler(nullptr);
        TIFFSetWarningHandler(nullptr);
    }
    std::filesystem::path file() const { return folder_.path() / "a.tif"; }
    /// Writes the file, and finds where the bytes of its second strip or tile are.
    void write(const Packed& how) {
        TIFF* const out = TIFFOpen(file().c_str(), how.mode);
        ASSERT_NE(out, nullptr);
        TIFFSetField(out, TIFFTAG_IMAGEWIDTH, kSide);
        TIFFSetField(out, TIFFTAG_IMAGELENGTH, kHeight);
        TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, 16);
        TIFFSetField(out, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
        TIFFSetField(out, TIFFTAG_COMPRESSION, how.compression);
        if (how.predictor > 1) TIFFSetField(out, TIFFTAG_PREDICTOR, how.predictor);
        if (how.tiled) {
            TIFFSetField(out, TIFFTAG_TILEWIDTH, kSide);
            TIFFSetField(out, TIFFTAG_TILELENGTH, kSide);
        } else {
            TIFFSetField(out, TIFFTAG_ROWSPERSTRIP, kRows);
        }
        const int rows = how.tiled ? kSide : kRows;
        for (int y = 0; y < kHeight; y += rows) {
            std::vector<uint16_t> numbers;
            const int end = how.tiled ? y + rows : std::min(y + rows, kHeight);
            for (int row = y; row < end; ++row) {
                for (int x = 0; x < kSide; ++x)
                    numbers.push_back(value(x, row));
            }
            const auto chunk = static_cast<uint32_t>(y / rows);
            const auto bytes = static_cast<tmsize_t>(2 * numbers.size());
            ASSERT_GT(how.tiled ? TIFFWriteEncodedTile(out, chunk, numbers.data(), bytes)
                                : TIFFWriteEncodedStrip(out, chunk, numbers.data(), bytes),
                      0);
        }
        TIFFClose(out);
        TIFF* const in = TIFFOpen(file().c_str(), "r");
        ASSERT_NE(in, nullptr);
        at_ = static_cast<size_t>(TIFFGetStrileOffset(in, 1));
        bytes_ = static_cast<size_t>(TIFFGetStrileByteCount(in, 1));
        TIFFClose(in);
        std::ifstream stream(file(), std::ios::binary);
        whole_.assign(std::istreambuf_iterator<char>(stream), {});
    }
    /// What reading all rows says: nothing, that a number is wrong, or the error.
    std::string read() const {
        const Result<InputFile> opened = InputFile::open(file());
        if (!opened) return opened.error().text();
        Result<std::unique_ptr<TiffImage>> image =
            TiffImage::open(*opened, first_directory(), 100'000'000);
        if (!image) return image.error().text();
        bool right = true;
        const Result<void> done = (*image)->each_row(
            0, TiffImage::Scale::kVolume, 0, [&](int32_t y, const float* row) -> Result<void> {
                for (int x = 0; x < kSide; ++x)
                    right = right && std::abs(row[x] * 65535 - value(x, y)) < 0.1F;
                return {};
            });
        if (!done) return done.error().text();
        return right ? "" : "wrong numbers";
    }
    uint64_t first_directory() const {
        const bool big = whole_[0] == 'M';
        uint64_t out = 0;
        for (size_t i = 0; i < 4; ++i)
            out |= uint64_t{static_cast<uint8_t>(whole_[4 + (big ? 3 - i : i)])} << (8 * i);
        return out;
    }

    std::string whole_;
    size_t at_ = 0, bytes_ = 0;
};

TEST_F(TiffDamage, AWrongByteIsFoundByTheSum) {
    for (const int compression : {COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE}) {
        for (const Packed& how :
             {Packed{compression}, Packed{compression, 2}, Packed{compression, 1, true},
              Packed{compression, 2, false, "wb"}, Packed{compression, 1, false, "wb"}}) {
            SCOPED_TRACE(fmt::format("compression {}, predictor {}, {}, {}", how.compression,
                                     how.predictor, how.tiled ? "tiles" : "strips", how.mode));
            write(how);
            ASSERT_EQ(read(), "");
            int errors = 0;
            for (size_t i = 0; i < bytes_; ++i) {
                for (const int change : {0x01, 0x80}) {
                    std::string damaged = whole_;
                    damaged[at_ + i] = static_cast<char>(damaged[at_ + i] ^ change);
                    folder_.write("a.tif", damaged);
                    const std::string said = read();
                    if (said.empty()) continue;
                    ++errors;
                    ASSERT_THAT(said, testing::Says(messages::kChunkDamaged,
                                                    how.tiled ? "tile" : "strip", 1))
                        << "byte " << i << " of " << bytes_ << " by " << change;
                }
            }
            EXPECT_GT(errors, static_cast<int>(bytes_) / 2);
        }
    }
}

TEST_F(TiffDamage, SoItIsOfLzmaThatHasASum) {
    // Bytes (37 i + 11) % 251, i to 63, by xz with a CRC32; libtiff itself writes none.
    const std::vector<uint8_t> stream{
        0xfd, 0x37, 0x7a, 0x58, 0x5a, 0x00, 0x00, 0x01, 0x69, 0x22, 0xde, 0x36, 0x02, 0x00, 0x21,
        0x01, 0x0c, 0x00, 0x00, 0x00, 0x8f, 0x98, 0x41, 0x9c, 0x01, 0x00, 0x3f, 0x0b, 0x30, 0x55,
        0x7a, 0x9f, 0xc4, 0xe9, 0x13, 0x38, 0x5d, 0x82, 0xa7, 0xcc, 0xf1, 0x1b, 0x40, 0x65, 0x8a,
        0xaf, 0xd4, 0xf9, 0x23, 0x48, 0x6d, 0x92, 0xb7, 0xdc, 0x06, 0x2b, 0x50, 0x75, 0x9a, 0xbf,
        0xe4, 0x0e, 0x33, 0x58, 0x7d, 0xa2, 0xc7, 0xec, 0x16, 0x3b, 0x60, 0x85, 0xaa, 0xcf, 0xf4,
        0x1e, 0x43, 0x68, 0x8d, 0xb2, 0xd7, 0x01, 0x26, 0x4b, 0x70, 0x95, 0xba, 0xdf, 0x09, 0x2e,
        0x53, 0x00, 0x6d, 0x9f, 0x88, 0x63, 0x00, 0x01, 0x54, 0x40, 0xeb, 0x6c, 0x8d, 0x88, 0x90,
        0x42, 0x99, 0x0d, 0x01, 0x00, 0x00, 0x00, 0x00, 0x01, 0x59, 0x5a,
    };
    for (size_t i = 0; i <= stream.size(); ++i) {
        std::vector<uint8_t> damaged = stream;
        if (i < stream.size()) damaged[i] ^= 0x10;
        TIFF* const out = TIFFOpen(file().c_str(), "wl");
        ASSERT_NE(out, nullptr);
        TIFFSetField(out, TIFFTAG_IMAGEWIDTH, 8);
        TIFFSetField(out, TIFFTAG_IMAGELENGTH, 8);
        TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, 8);
        TIFFSetField(out, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
        TIFFSetField(out, TIFFTAG_ROWSPERSTRIP, 8);
        TIFFSetField(out, TIFFTAG_COMPRESSION, COMPRESSION_LZMA);
        ASSERT_GT(TIFFWriteRawStrip(out, 0, damaged.data(), static_cast<tmsize_t>(damaged.size())),
                  0);
        TIFFClose(out);
        if (i < stream.size()) {
            EXPECT_THAT(trouble(file(), {}), testing::Says(messages::kChunkDamaged, "strip", 0))
                << "byte " << i;
            continue;
        }
        const auto whole = converted(file());
        ASSERT_NE(whole, nullptr);
        for (size_t at = 0; at < 64; ++at)
            EXPECT_FLOAT_EQ(level0(*whole)[at], static_cast<float>((37 * at + 11) % 251) / 255);
    }
}

TEST_F(TiffDamage, TheLastStripMayBeFilledUp) {
    write({});
    // Twenty rows in strips of 8 leave 4: the file is made to say that there are fewer than were written.
    std::string fewer = whole_;
    const std::string height("\x01\x01\x03\x00\x01\x00\x00\x00\x14", 9);  // ImageLength, 20
    const size_t found = fewer.find(height);
    ASSERT_NE(found, std::string::npos);
    fewer[found + 8] = 14;
    folder_.write("a.tif", fewer);
    EXPECT_EQ(read(), "") << "6 rows of 8";
}

TEST_F(TiffDamage, JpegOfTheOldStyleIsNamedWhereItIsNotDecoded) {
    write({COMPRESSION_NONE});
    std::string old = whole_;
    const std::string tag("\x03\x01\x03\x00\x01\x00\x00\x00", 8);  // Compression
    for (size_t at = old.find(tag); at != std::string::npos; at = old.find(tag, at + 12))
        old[at + 8] = COMPRESSION_OJPEG;
    const std::string bits("\x02\x01\x03\x00\x01\x00\x00\x00\x10", 9);  // BitsPerSample, 16
    ASSERT_NE(old.find(bits), std::string::npos);
    old[old.find(bits) + 8] = 8;
    EXPECT_THAT(trouble(folder_.write("a.tif", old)),
                AllOf(::testing::StartsWith(messages::kOldJpegNotRead),
                      ::testing::HasSubstr(messages::kOldJpegHelp)));
}

}  // namespace
}  // namespace openfab::tools
