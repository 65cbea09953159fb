// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Folders of slices that tests write.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <random>
#include <thread>

#include "backends/raster/folder_sink.h"
#include "backends/raster/messages.h"
#include "backends/raster/npy_sink.h"
#include "backends/raster/png_encode.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class SliceFolder : public ::testing::Test {
  protected:
    Result<void> write(const SamplePrint& print, const raster::FolderOptions& options,
                       const std::string& folder = "slices", bool complete = true) {
        Result<std::unique_ptr<pipeline::SliceSink>> sink =
            raster::FolderSink::create(scratch_ / folder, options);
        if (!sink) return sink.error();
        return print.send(sink->get(), complete);
    }
    /// Returns the expected pixel of a voxel, by the print's own colours.
    static std::array<uint8_t, 4> color(const SamplePrint& print, int32_t x, int32_t y, int32_t z) {
        const uint8_t code = print.at(x, y, z);
        return code == 0 ? std::array<uint8_t, 4>{} : print.info.materials[code - 1].key;
    }
    static void expect_slice(const SamplePrint& print, const ReadPng& png, int32_t z, bool flip_x) {
        ASSERT_EQ(png.width, print.info.size.x);
        ASSERT_EQ(png.height, print.info.size.y);
        for (int32_t y = 0; y < png.height; ++y) {
            for (int32_t x = 0; x < png.width; ++x) {
                const int32_t column = flip_x ? png.width - 1 - x : x;
                ASSERT_EQ(png.at(column, png.height - 1 - y), color(print, x, y, z))
                    << x << ' ' << y << ' ' << z;
            }
        }
    }

    ScratchFolder scratch_;
};

}  // namespace openfab::testing
