// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A small print in memory for the tests of backends, and PNG files read back by libpng.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::testing {

struct SamplePrint {
    pipeline::PrintInfo info;
    std::vector<uint8_t> codes;  ///< one a voxel, x fastest, then y, z

    uint8_t& at(int32_t x, int32_t y, int32_t z);
    uint8_t at(int32_t x, int32_t y, int32_t z) const {
        return const_cast<SamplePrint*>(this)->at(x, y, z);
    }
    /// Returns the packed rows of a slice.
    std::vector<uint8_t> rows(int32_t z) const;
    pipeline::SliceView view(int32_t z, const std::vector<uint8_t>& rows) const;
    pipeline::PrintTotals totals() const;
    /// Sends begin, every slice of the range, finish.
    Result<void> send(pipeline::SliceSink* sink, bool complete = true) const;
};

/// Makes a print of 3 materials, an odd width, and a pattern in which all slices differ.
SamplePrint make_sample(Vec3i size, int32_t bits = 4);

/// Makes an F of code 1 whose stem is at the lowest x and whose bars point to +x at the highest y;
/// 5 x 7 cells of `cell` voxels.
SamplePrint make_letter_f(int32_t cell, int32_t slices);

struct ReadPng {
    int32_t width = 0, height = 0;
    int color_type = 0, bit_depth = 0;
    uint32_t pixels_per_metre_x = 0, pixels_per_metre_y = 0;
    std::vector<std::array<uint8_t, 4>> rgba;  ///< top row first

    const std::array<uint8_t, 4>& at(int32_t x, int32_t y) const {
        return rgba[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
    }
};

/// Reads a PNG; fails the test where libpng reports an error.
ReadPng read_png(const std::filesystem::path& file);

}  // namespace openfab::testing
