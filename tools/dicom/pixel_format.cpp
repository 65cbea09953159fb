// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/pixel_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "tools/dicom/dicom_elements.h"
#include "tools/dicom/messages.h"

namespace openfab::tools {

namespace {

/// Of a texture, too.
constexpr double kMostFrames = 16384;

/// The colour of CIELab for D50 in 16 bits each (PS3.3, C.10.7.1.1), as sRGB for D65 (Bradford).
std::array<uint8_t, 3> color_of_lab(const std::vector<uint64_t>& stored) {
    constexpr double kMost = 65535;
    const double l = static_cast<double>(stored[0]) * 100 / kMost;
    const double a = static_cast<double>(stored[1]) * 255 / kMost - 128;
    const double b = static_cast<double>(stored[2]) * 255 / kMost - 128;
    const auto inverse = [](double t) {
        constexpr double kDelta = 6.0 / 29;
        return t > kDelta ? t * t * t : 3 * kDelta * kDelta * (t - 4.0 / 29);
    };
    const double fy = (l + 16) / 116;
    const double x = 0.96422 * inverse(fy + a / 500), y = inverse(fy),
                 z = 0.82521 * inverse(fy - b / 200);
    const std::array<double, 3> linear{3.1338561 * x - 1.6168667 * y - 0.4906146 * z,
                                       -0.9787684 * x + 1.9161415 * y + 0.0334540 * z,
                                       0.0719453 * x - 0.2289914 * y + 1.4052427 * z};
    std::array<uint8_t, 3> out{};
    for (size_t i = 0; i < 3; ++i) {
        const double v = std::clamp(linear[i], 0.0, 1.0);
        const double shown = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
        out[i] = static_cast<uint8_t>(std::lround(255 * shown));
    }
    return out;
}

Result<void> read_segments(const gdcm::DataSet& set, DicomImage* out) {
    const DicomItems items = items_of(set, {0x0062, 0x0002});
    const size_t count = items == nullptr ? 0 : items->GetNumberOfItems();
    for (size_t i = 1; i <= count; ++i) {
        const gdcm::DataSet& item = items->GetItem(i).GetNestedDataSet();
        DicomSegment segment;
        segment.number = short_of(item, {0x0062, 0x0004}, 0);
        segment.label = trimmed(bytes_of(item, {0x0062, 0x0005}));
        const std::vector<uint64_t> lab = whole_numbers(bytes_of(item, {0x0062, 0x000d}), 2);
        if (lab.size() == 3) segment.color = color_of_lab(lab);
        out->segments.push_back(std::move(segment));
    }
    if (count == 0 && out->kind == DicomKind::kSegmentation)
        return user_error(messages::kNoSegments);
    return {};
}

Result<void> read_bits(const gdcm::DataSet& set, DicomImage* out) {
    out->bits_allocated = short_of(set, {0x0028, 0x0100}, 0);
    const int32_t all = out->bits_allocated;
    if (out->sample == SampleKind::kFloat || out->sample == SampleKind::kDouble) {
        if (all == (out->sample == SampleKind::kFloat ? 32 : 64)) return {};
        return user_error(fmt::format(messages::kPixelBits, all, all));
    }
    out->bits_stored = short_of(set, {0x0028, 0x0101}, all);
    out->high_bit = short_of(set, {0x0028, 0x0102}, out->bits_stored - 1);
    out->has_sign = short_of(set, {0x0028, 0x0103}, 0) == 1;
    if (all == 1 && out->bits_stored == 1 && out->high_bit == 0 && !out->has_sign) {
        out->sample = SampleKind::kBit;
        return {};
    }
    if ((all != 8 && all != 16 && all != 32) || out->bits_stored < 1 || out->bits_stored > all ||
        out->high_bit < out->bits_stored - 1 || out->high_bit >= all)
        return user_error(fmt::format(messages::kPixelBits, out->bits_stored, all));
    return {};
}

}  // namespace

Result<void> read_kind(const gdcm::DataSet& set, DicomImage* out) {
    const std::string_view object = trimmed(bytes_of(set, {0x0008, 0x0016}));
    const std::string_view type = trimmed(bytes_of(set, {0x0062, 0x0001}));
    constexpr std::string_view kStorage = "1.2.840.10008.5.1.4.1.1.";
    const std::string_view kind =
        object.starts_with(kStorage) ? object.substr(kStorage.size()) : std::string_view();
    if (kind == "481.3") return user_error(messages::kContours, messages::kContoursHelp);
    if (kind == "66.5") return user_error(messages::kSurfaces, messages::kSurfacesHelp);
    if (kind == "66.8") return user_error(messages::kHeightMap);
    out->kind = kind == "66.7" || type == "LABELMAP" ? DicomKind::kLabelMap
                : kind == "66.4"                     ? DicomKind::kSegmentation
                : kind == "30"                       ? DicomKind::kParametricMap
                : kind == "481.2"                    ? DicomKind::kDose
                                                     : DicomKind::kImage;
    const bool has_segments =
        out->kind == DicomKind::kSegmentation || out->kind == DicomKind::kLabelMap;
    return has_segments ? read_segments(set, out) : Result<void>();
}

Result<void> read_format(const gdcm::DataSet& set, DicomImage* out) {
    out->height = short_of(set, {0x0028, 0x0010}, 0);
    out->width = short_of(set, {0x0028, 0x0011}, 0);
    if (out->width < 1 || out->height < 1) return user_error(messages::kNoPicture);
    if (const int32_t samples = short_of(set, {0x0028, 0x0002}, 1); samples != 1)
        return user_error(fmt::format(messages::kValuesPerPixel, samples));
    const std::string_view photometric = trimmed(bytes_of(set, {0x0028, 0x0004}));
    out->is_inverted = photometric == "MONOCHROME1";
    // Of a label map a palette only says how labels are shown (PS3.3, C.8.20.2).
    const bool shown_labels = photometric == "PALETTE COLOR" && out->kind == DicomKind::kLabelMap;
    if (!photometric.empty() && !out->is_inverted && photometric != "MONOCHROME2" && !shown_labels)
        return user_error(fmt::format(messages::kPixelsAreColours, photometric));
    if (bytes_of(set, {0x0008, 0x0008}).find("MOSAIC") != std::string_view::npos)
        return user_error(messages::kMosaic, messages::kMosaicHelp);
    const std::string_view organised = trimmed(bytes_of(set, {0x0020, 0x9311}));
    if (organised.starts_with("TILED") || set.FindDataElement(gdcm::Tag(0x0048, 0x0006)))
        return user_error(messages::kTiles);
    if (set.FindDataElement(gdcm::Tag(0x0028, 0x3000))) return user_error(messages::kModalityLut);
    if (Result<void> bits = read_bits(set, out); !bits) return bits;
    double frames = 1;
    const std::string_view count = bytes_of(set, {0x0028, 0x0008});
    if (!trimmed(count).empty() && (!parse_decimals(count, &frames, 1) || !(frames >= 1) ||
                                    frames > kMostFrames || frames != std::floor(frames)))
        return user_error(fmt::format(messages::kFrameCount, trimmed(count), kMostFrames));
    out->frames = static_cast<int32_t>(frames);
    return {};
}

}  // namespace openfab::tools
