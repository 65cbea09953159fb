// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/file_color.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "tools/texture/exif.h"
#include "tools/texture/messages.h"
#include "tools/texture/png_color.h"
#include "tools/texture/stored_profile.h"

namespace openfab::tools {
namespace {

RgbSpace srgb_with(Curve curve) {
    return RgbSpace::make(kSrgbChromaticities, curve).value_or(RgbSpace());
}

std::vector<uint8_t> profile_of(const OIIO::ImageSpec& spec) {
    const OIIO::ParamValue* icc = spec.find_attribute("ICCProfile");
    if (icc == nullptr) return {};
    const auto* const bytes = static_cast<const uint8_t*>(icc->data());
    return {bytes, bytes + icc->datasize()};
}

/// Heeds what a camera's file without a profile says of its colours.
void heed_exif(const InputFile& file, std::string_view format, FileColor* color) {
    // Primaries and curve of Adobe RGB (1998).
    constexpr Chromaticities kAdobe = {0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.3290};
    constexpr double kExponent = 563.0 / 256;
    switch (exif_colors(file, format)) {
        case ExifColors::kUnsaid:
            return;
        case ExifColors::kAdobeRgb:
            color->space = RgbSpace::make(kAdobe, Curve::kPower, kExponent).value_or(color->space);
            return;
        case ExifColors::kUncalibrated:
            color->note = messages::kUncalibrated;
            return;
    }
}

FileColor color_of_png(const InputFile& file) {
    const PngColor says = read_png_color(file);
    if (says.code_points) {
        if (const std::optional<RgbSpace> space = space_of(*says.code_points))
            return {Lab::kNone, *space, {}};
    }
    FileColor color{Lab::kNone, srgb_with(Curve::kSrgb), {}};
    const bool has_profile = says.profile_bytes >= 0;
    if (!says.is_srgb && (says.gamma || says.corners)) {
        const Chromaticities corners = says.corners.value_or(kSrgbChromaticities);
        const std::optional<RgbSpace> space =
            says.gamma ? RgbSpace::make(corners, Curve::kPower, 1 / *says.gamma)
                       : RgbSpace::make(corners, Curve::kSrgb);
        color.space = space.value_or(color.space);
    } else if (!says.is_srgb && !has_profile) {
        heed_exif(file, "png", &color);
    }
    if (has_profile) {
        color.profile = png_profile(file, says.profile_at, says.profile_bytes);
        if (color.profile.empty()) color.note = messages::kProfileUnused;
    }
    return color;
}

std::optional<RgbSpace> space_of_exr(const OIIO::ImageSpec& spec) {
    const OIIO::ParamValue* found = spec.find_attribute("chromaticities");
    Chromaticities c{};
    if (found == nullptr || found->type() != OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8))
        return std::nullopt;
    const auto* const values = static_cast<const float*>(found->data());
    std::copy_n(values, c.size(), c.begin());
    return RgbSpace::make(c, Curve::kLinear);
}

/// X, Y and Z as shares of those of D50.
constexpr Chromaticities kSharesOfD50 = {1, 0, 0, 1, 0, 0, 0.3457, 0.3585};

double share_of(double f) {
    constexpr double kBend = 6.0 / 29;
    return f > kBend ? f * f * f : 3 * kBend * kBend * (f - 4.0 / 29);
}

}  // namespace

Lab lab_of(const OIIO::ImageSpec& spec) {
    const std::string_view name = spec.get_string_attribute("tiff:ColorSpace");
    return name == "CIELAB" ? Lab::kSigned : name == "ICCLAB" ? Lab::kShifted : Lab::kNone;
}

LabDecoder::LabDecoder(Lab stored, float steps)
    : stored_(stored),
      steps_(static_cast<double>(steps)),
      from_xyz_(RgbSpace::make(kSharesOfD50, Curve::kLinear).value_or(RgbSpace())) {}

// Values of 16 bits are those of 8 with 8 bits behind the point (TIFF 6.0, section 23; ICC.1, annex A).
void LabDecoder::decode(const float* in, float* rgb) const {
    constexpr double kLightest = 100, kWhole = 256, kHalf = 128;
    const double unit = steps_ > 255 ? kWhole : 1;
    const bool shifted = stored_ == Lab::kShifted;
    const double white = shifted && steps_ > 255 ? 255 * kWhole : steps_;
    const auto number = [&](size_t c) { return std::round(static_cast<double>(in[c]) * steps_); };
    const auto difference = [&](size_t c) {
        const double n = number(c) / unit;
        if (shifted) return n - kHalf;
        return n >= kHalf ? n - kWhole : n;
    };
    const double y = (kLightest * number(0) / white + 16) / 116;
    rgb[0] = static_cast<float>(share_of(y + difference(1) / 500));
    rgb[1] = static_cast<float>(share_of(y));
    rgb[2] = static_cast<float>(share_of(y - difference(2) / 200));
    from_xyz_.convert(rgb);
}

FileColor color_of(const InputFile& file, std::string_view format, const OIIO::ImageSpec& spec) {
    if (format == "png") return color_of_png(file);
    const bool eight_bit = spec.format.basetype == OIIO::TypeDesc::UINT8;
    FileColor out{lab_of(spec), srgb_with(eight_bit ? Curve::kSrgb : Curve::kLinear),
                  profile_of(spec)};
    if (format == "openexr") {
        if (const std::optional<RgbSpace> space = space_of_exr(spec)) out.space = *space;
    }
    if (format == "webp") {
        WebpProfile found = webp_profile(file);
        if (found.is_there && found.bytes.empty()) out.note = messages::kProfileUnused;
        if (found.is_there) out.profile = std::move(found.bytes);
    }
    const bool camera = format == "jpeg" || format == "tiff";
    if (camera && eight_bit && out.profile.empty() && out.lab == Lab::kNone && spec.nchannels >= 3)
        heed_exif(file, format, &out);
    return out;
}

}  // namespace openfab::tools
