// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// DICOM files, written byte by byte after the standard (PS3.5, PS3.10), of nobody, and what comes of a
// folder of them.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "tests/unit/texture/field_test.h"
#include "tools/dicom/dicom_series.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

inline constexpr const char* kExplicit = "1.2.840.10008.1.2.1";
inline constexpr const char* kBigEndian = "1.2.840.10008.1.2.2";
inline constexpr const char* kRunLengths = "1.2.840.10008.1.2.5";
/// Of a person who must not show up anywhere.
inline constexpr const char* kPerson = "DOE^JANE";

inline std::string number(uint64_t value, size_t bytes, bool big = false) {
    std::string out;
    for (size_t i = 0; i < bytes; ++i)
        out += static_cast<char>(value >> (8 * (big ? bytes - 1 - i : i)) & 0xff);
    return out;
}

inline std::string element(uint32_t group, uint32_t item, const std::string& kind,
                           std::string value, bool big = false) {
    if (value.size() % 2 != 0) value += kind == "UI" || kind == "OB" ? '\0' : ' ';
    const std::string tag = number(group, 2, big) + number(item, 2, big) + kind;
    if (kind == "OW" || kind == "OB" || kind == "OF" || kind == "OD" || kind == "OV" ||
        kind == "SQ")
        return tag + number(0, 2) + number(value.size(), 4, big) + value;
    return tag + number(value.size(), 2, big) + value;
}

/// A sequence of items, of which each has elements.
inline std::string sequence(uint32_t group, uint32_t item, const std::vector<std::string>& items,
                            bool big = false) {
    std::string all;
    for (const std::string& one : items)
        all += number(0xfffe, 2, big) + number(0xe000, 2, big) + number(one.size(), 4, big) + one;
    return element(group, item, "SQ", all, big);
}

inline std::string decimals(const std::vector<double>& values) {
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
    int bits_allocated = 16, bits_stored = 12;
    std::string photometric = "MONOCHROME2";
    std::string series = "1.2.3", description;
    int series_number = 1;
    bool is_placed = true;         ///< else it does not say where it lies
    std::vector<uint32_t> pixels;  ///< of all frames
    size_t frames = 1;
    std::string more;    ///< elements of group 0028 before its size
    std::string groups;  ///< elements before the pixels
    std::string object = "1.2.840.10008.5.1.4.1.1.2", modality = "CT";
    std::string packed;  ///< instead of the pixels' element

    std::string bytes(const std::string& syntax = kExplicit) const {
        const bool big = syntax == kBigEndian;
        const auto add = [&](uint32_t group, uint32_t item, const std::string& kind,
                             const std::string& value) {
            return element(group, item, kind, value, big);
        };
        const auto us = [&](uint32_t item, size_t value) {
            return add(0x28, item, "US", number(value, 2, big));
        };
        std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) +
                           element(2, 2, "UI", object) + element(2, 3, "UI", "1.2.3.4") +
                           element(2, 0x10, "UI", syntax);
        meta = element(2, 0, "UL", number(meta.size(), 4)) + meta;
        std::string out = std::string(128, '\0') + "DICM" + meta + add(8, 0x16, "UI", object) +
                          add(8, 0x60, "CS", modality);
        if (!description.empty()) out += add(8, 0x103e, "LO", description);
        out += add(0x10, 0x10, "PN", kPerson) + add(0x20, 0x0e, "UI", series) +
               add(0x20, 0x11, "IS", std::to_string(series_number));
        if (is_placed)
            out += add(0x20, 0x32, "DS", decimals({position.x, position.y, position.z})) +
                   add(0x20, 0x37, "DS",
                       decimals({across.x, across.y, across.z, down.x, down.y, down.z}));
        out += us(2, 1) + add(0x28, 4, "CS", photometric);
        if (frames > 1) out += add(0x28, 8, "IS", std::to_string(frames));
        return out + more + us(0x10, static_cast<size_t>(height)) +
               us(0x11, static_cast<size_t>(width)) +
               add(0x28, 0x30, "DS", decimals({row_mm, column_mm})) +
               us(0x100, static_cast<size_t>(bits_allocated)) +
               us(0x101, static_cast<size_t>(bits_stored)) +
               us(0x102, static_cast<size_t>(bits_stored - 1)) + us(0x103, has_sign ? 1 : 0) +
               add(0x28, 0x1052, "DS", decimals({intercept})) +
               add(0x28, 0x1053, "DS", decimals({slope})) + groups +
               (!packed.empty()         ? packed
                : syntax == kRunLengths ? run_lengths()
                                        : plain(big));
    }
    std::string plain(bool big) const {
        const auto bytes = static_cast<size_t>(bits_allocated) / 8;
        std::string out;
        for (const uint32_t value : pixels)
            out += number(value, bytes, big);
        if (out.size() % 2 != 0) out += '\0';
        for (size_t i = 0; big && bytes == 1 && i < out.size(); i += 2)
            std::swap(out[i], out[i + 1]);
        return element(0x7fe0, 0x10, "OW", out, big);
    }
    /// Pixels as two planes of bytes a frame, the high ones first, in literal runs (PS3.5, annex G).
    std::string run_lengths() const {
        const std::string item = number(0xfffe, 2) + number(0xe000, 2);
        std::string out = number(0x7fe0, 2) + number(0x10, 2) + "OB" + number(0, 2) +
                          number(0xffffffff, 4) + item + number(0, 4);
        const size_t count = pixels.size() / frames;
        for (size_t begin = 0; begin < pixels.size(); begin += count) {
            std::array<std::string, 2> planes;
            for (size_t plane = 0; plane < 2; ++plane) {
                for (size_t at = 0; at < count; at += 100) {
                    const size_t n = std::min<size_t>(100, count - at);
                    planes[plane] += static_cast<char>(n - 1);
                    for (size_t i = 0; i < n; ++i)
                        planes[plane] += static_cast<char>(
                            pixels[begin + at + i] >> (plane == 0 ? 8 : 0) & 0xff);
                }
                if (planes[plane].size() % 2 != 0) planes[plane] += '\0';
            }
            std::string frame = number(2, 4) + number(64, 4) + number(64 + planes[0].size(), 4);
            frame += std::string(64 - frame.size(), '\0') + planes[0] + planes[1];
            out += item + number(frame.size(), 4) + frame;
        }
        return out + number(0xfffe, 2) + number(0xe0dd, 2) + number(0, 4);
    }
};

/// Converts a folder of slices.
class DicomTest : public FieldTest {
  protected:
    DicomTest() { fs::create_directory(series()); }
    fs::path series() const { return folder_.path() / "series"; }
    void write(const std::string& name, const std::string& bytes) {
        folder_.write("series/" + name, bytes);
    }
    /// Fills the slice with the field, in steps of 1/16 above an intercept of -100.
    static void fill(Slice* slice) {
        slice->pixels.clear();
        add_frame(slice, slice->position);
    }
    /// Adds a frame of the field that lies at `position`.
    static void add_frame(Slice* slice, const Vec3d& position) {
        slice->slope = 1.0 / 16;
        slice->intercept = -100;
        for (int y = 0; y < slice->height; ++y) {
            for (int x = 0; x < slice->width; ++x) {
                const Vec3d at = position + slice->across * (x * slice->column_mm) +
                                 slice->down * (y * slice->row_mm);
                const double stored = (linear(at) + 100) * 16;
                EXPECT_TRUE(stored >= 0 && stored < 4096) << stored;
                slice->pixels.push_back(static_cast<uint32_t>(std::lround(stored)));
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
    /// What is told of a folder that is read.
    std::string told(const VolumeOptions& options = {}) {
        ::testing::internal::CaptureStderr();
        EXPECT_NE(converted(options), nullptr);
        return ::testing::internal::GetCapturedStderr();
    }
    std::string trouble(const VolumeOptions& options = {}, const texture::ReadLimits& limits = {}) {
        const Result<void> made =
            make_dicom_volume_file(series(), folder_.path() / "out.oftx", options, limits);
        if (made) return "no error";
        const std::string text = made.error().text();
        EXPECT_THAT(text, Not(HasSubstr("DOE")));
        const std::string start = fmt::format(messages::kCannotReadBefore, series().string());
        EXPECT_TRUE(text.starts_with(start)) << text;
        return text.substr(start.size());
    }
};

}  // namespace openfab::tools
