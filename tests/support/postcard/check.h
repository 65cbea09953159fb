// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Compares a printed magic postcard with its two pictures, from first principles: pictures decoded
// by OpenImageIO, colour and filter in double, no code of the pipeline.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/vec.h"

namespace openfab::postcard {

/// A picture as linear luminance (Rec. 709), bottom row first.
struct Picture {
    int32_t width = 0, height = 0;
    std::vector<double> luminance;

    /// Samples bilinearly, clamped at the edges; v = 0 is the bottom.
    double sample(double u, double v) const;
};

/// Decodes an 8-bit sRGB image file; empty where it cannot be read.
Picture read_picture(const std::string& file);

/// A print as voxels: the grid and the code of a voxel, 0 for void.
struct Voxels {
    Vec3i size;
    Vec3d pitch_mm, origin_mm;
    std::function<uint8_t(int32_t x, int32_t y, int32_t z)> code;
    uint8_t white = 1, black = 2;
};

/// The card of gallery/magic_postcard: x and y centred, its base from z = 0 to base_mm, relief
/// below.
struct Card {
    double width_mm = 100, height_mm = 70, base_mm = 1.3;
    double texture_depth_mm = 0.4, max_thickness_mm = 1.2;
    double border_u = 0.04, border_v = 0.057;
};

struct Findings {
    int64_t windows = 0;      ///< 32 x 32 windows compared
    double worst_window = 0;  ///< largest |mean white - mean luminance| of a window
    double signed_mean = 0;   ///< over all windows
    int64_t not_white = 0;    ///< voxels below the texture's depth that are not white
    int64_t columns = 0;
    int64_t relief_misses =
        0;  ///< columns whose lowest voxel lies outside the reference by more than a slice
    int64_t holes = 0;            ///< columns with a void between two solid voxels
    int64_t missing_columns = 0;  ///< columns over the card with nothing printed
    std::string first_fault;      ///< a description, empty where nothing is wrong
};

Findings compare(const Voxels& print, const Card& card, const Picture& front,
                 const Picture& hidden);

}  // namespace openfab::postcard
