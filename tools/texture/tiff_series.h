// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the first page of a TIFF says of all of them: ImageJ, OME and tifffile write there which pages are
// slices, which are channels or steps of time between them, and how large a texel is.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/texture/tiff_image.h"

namespace openfab::tools {

struct TiffSeries {
    int64_t channels = 1, slices = 1, frames = 1;
    std::vector<std::string>
        names;  ///< of the channels: numbers from 1, or what the file calls them
    /// The strides of a channel, a slice and a frame in pages.
    std::array<int64_t, 3> strides{1, 1, 1};
    /// Of each plane, (frame * slices + slice) * channels + channel, where pages are listed.
    struct Place {
        std::string file;  ///< empty: this one
        int64_t page = -1;
    };
    std::vector<Place> places;
    std::optional<std::array<double, 3>> spacing_mm;
    double unit_mm = 1;  ///< in which the file gives it
    std::vector<std::string> notes;

    int64_t planes() const { return channels * slices * frames; }
    /// The page of a plane, as far as all pages are in this file.
    int64_t page(int64_t channel, int64_t slice) const {
        return channel * strides[0] + slice * strides[1];
    }
};

/// Reads the description of the first of `pages` pages of the file named `name`. Without one that is known,
/// all pages are slices. Fails where the description contradicts itself.
Result<TiffSeries> read_tiff_series(const TiffDirectory& first, int64_t pages,
                                    const std::string& name);
/// Reads OME-XML, https://docs.openmicroscopy.org/ome-model, likewise.
Result<TiffSeries> read_ome_series(const TiffDirectory& first, int64_t pages,
                                   const std::string& name);

}  // namespace openfab::tools
