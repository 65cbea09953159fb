// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// DICOM files of which the reader tells something, each one thing.

#include <string>
#include <vector>

#include "tests/unit/texture/dicom_groups.h"

namespace openfab::testing {

/// Frames of 2 x 1 pixels, with values 0 and 1.
inline tools::Slice noted_slice(size_t frames = 1) {
    tools::Slice slice;
    slice.width = 2;
    slice.height = 1;
    slice.intercept = 0;
    slice.frames = frames;
    for (size_t frame = 0; frame < frames; ++frame)
        slice.pixels.insert(slice.pixels.end(), {0, 1});
    return slice;
}

inline std::string plain_dicom() {
    return noted_slice().bytes();
}

/// Of which the lower number is shown in white.
inline std::string inverted_dicom() {
    tools::Slice slice = noted_slice();
    slice.photometric = "MONOCHROME1";
    return slice.bytes();
}

/// Frames that say how far apart they are, and not where.
inline std::string unplaced_dicom() {
    tools::Slice slice = noted_slice(2);
    slice.is_placed = false;
    slice.groups = tools::element(0x18, 0x88, "DS", "1");
    return slice.bytes();
}

/// Frames in the volume of a probe.
inline std::string ultrasound_dicom() {
    using tools::element, tools::real, tools::sequence;
    tools::Slice slice = noted_slice(2);
    slice.is_placed = false;
    std::vector<std::string> places;
    for (const double z : {0, 1}) {
        places.push_back(
            sequence(0x20, 0x930e, {element(0x20, 0x9301, "FD", real(0) + real(0) + real(z))}));
    }
    std::string axes;
    for (const double one : {1, 0, 0, 0, 1, 0})
        axes += real(one);
    slice.groups =
        sequence(0x5200, 0x9229, {sequence(0x20, 0x930f, {element(0x20, 0x9302, "FD", axes)})}) +
        sequence(0x5200, 0x9230, places);
    return slice.bytes();
}

/// Slices of tomography that say how thick they are, and not how far apart.
inline std::string nuclear_dicom() {
    tools::Slice slice = noted_slice(2);
    slice.groups = tools::element(0x18, 0x50, "DS", "1") +
                   tools::element(0x28, 9, "AT", tools::tags({{0x54, 0x80}})) +
                   tools::element(0x54, 0x80, "US", tools::shorts({1, 2}));
    return slice.bytes();
}

/// Values in another unit beside the rescaled ones.
inline std::string mapped_dicom() {
    tools::Slice slice = noted_slice();
    slice.groups = tools::sequence(0x40, 0x9096,
                                   {tools::element(0x40, 0x9224, "FD", tools::real(3)) +
                                    tools::element(0x40, 0x9225, "FD", tools::real(2))});
    return slice.bytes();
}

/// Of more digits than a float has.
inline std::string long_dicom() {
    tools::Slice slice = noted_slice();
    slice.bits_allocated = slice.bits_stored = 32;
    slice.pixels = {(1U << 24) + 1, 0};
    return slice.bytes();
}

/// A picture in colours, of a series of its own.
inline std::string report_dicom() {
    tools::Slice slice = noted_slice();
    slice.series = "1.2.9";
    slice.series_number = 9;
    slice.photometric = "PALETTE COLOR";
    return slice.bytes();
}

/// Two segments, of which the second has no frame; without a place.
inline std::string segments_dicom() {
    using tools::element, tools::sequence, tools::shorts;
    tools::Slice slice = noted_slice(2);
    slice.object = "1.2.840.10008.5.1.4.1.1.66.4";
    slice.modality = "SEG";
    slice.is_placed = false;
    slice.bits_allocated = slice.bits_stored = 1;
    const auto segment = [](int number, const std::string& label) {
        return element(0x62, 4, "US", shorts({number})) + element(0x62, 5, "LO", label);
    };
    const std::string first = sequence(0x62, 0xa, {element(0x62, 0xb, "US", shorts({1}))});
    slice.groups =
        element(0x62, 1, "CS", "BINARY") +
        sequence(0x62, 2, {segment(1, "tissue"), segment(2, "bone")}) +
        sequence(0x5200, 0x9229,
                 {sequence(0x28, 0x9110,
                           {element(0x18, 0x88, "DS", "1") + element(0x28, 0x30, "DS", "1\\1")})}) +
        sequence(0x5200, 0x9230, {first, first});
    slice.packed = element(0x7fe0, 0x10, "OB", tools::bits_of(slice.pixels));
    return slice.bytes();
}

}  // namespace openfab::testing
