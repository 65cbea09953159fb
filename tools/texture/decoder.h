// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pixel decoding, shared by the converters of pictures and of stacks of slices.

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "base/color.h"
#include "texture/cache.h"
#include "tools/texture/embedded_profile.h"
#include "tools/texture/file_color.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

/// Converts each pixel between the file and the pyramid. Colours are decoded by what the picture
/// says of itself where the space is `auto` (file_color.h), else as the space says. Those
/// with alpha become what they look like on white (texture/pyramid.h), unless they are data.
class Decoder {
  public:
    /// What a picture's alpha is: of slices of a volume, a number like others.
    enum class Alpha { kCoverage, kNumber };

    /// What is not known of the picture's colours, a message; null: nothing.
    const char* note() const { return note_; }

    /// `color` counts where the space is `auto`.
    Decoder(const OIIO::ImageSpec& spec, const FileColor& color,
            const texture::ImageOptions& options, Alpha alpha = Alpha::kCoverage)
        : channels_in_(spec.nchannels) {
        // Grey with alpha and colour with alpha: alpha is the last of 2 or 4.
        colors_ = channels_in_ == 2 || channels_in_ == 4 ? channels_in_ - 1 : channels_in_;
        has_alpha_ = alpha == Alpha::kCoverage && colors_ < channels_in_ && last_is_alpha(spec);
        is_data_ = options.space == "data";
        premultiplied_ =
            spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0 && !color.straight_alpha;
        to_luminance_ = options.luminance && colors_ == 3;
        const bool bare = color.bare_alpha || (options.opaque && alpha == Alpha::kCoverage);
        if (bare) has_alpha_ = false;
        channels_out_ = options.luminance ? 1 : bare ? colors_ : channels_in_;
        inks_ = color.inks;
        if (inks_) {
            colors_ = 3;
            has_alpha_ = false;
            to_luminance_ = options.luminance;
            channels_out_ = options.luminance ? 1 : 3;
        }
        const bool eight_bit = spec.format.basetype == OIIO::TypeDesc::UINT8;
        if (options.space == "srgb") space_ = srgb();
        if (options.space == "auto") take(color);
        if (color.lab != Lab::kNone && colors_ == 3 && !is_data_)
            lab_.emplace(color.lab, eight_bit ? 255 : 65535);
        if (space_.curve() == Curve::kSrgb && eight_bit) {
            for (size_t i = 0; i < table_.size(); ++i) {
                table_[i] = static_cast<float>(srgb_to_linear(static_cast<double>(i) / 255.0));
            }
            use_table_ = true;
        }
    }
    int32_t channels_in() const { return channels_in_; }
    int32_t channels_out() const { return channels_out_; }
    /// Whether the last channel of what comes out is alpha.
    bool alpha_out() const { return has_alpha_ && !is_data_ && channels_out_ == channels_in_; }

    /// Converts one pixel; returns false where a value is not finite.
    bool pixel(const float* in, float* out) const {
        std::array<float, 4> encoded{}, v{};
        for (int32_t c = 0; c < channels_in_; ++c) {
            if (!std::isfinite(in[c])) return false;
            encoded[c] = in[c];
        }
        const float alpha = has_alpha_ ? std::clamp(in[colors_], 0.0f, 1.0f) : 1.0f;
        // Light is multiplied by alpha already, but encoded values are decoded first.
        const bool multiplied = premultiplied_ && !is_encoded();
        if (has_alpha_ && premultiplied_ && !multiplied && alpha > 0) {
            for (int32_t c = 0; c < colors_; ++c)
                encoded[c] = std::min(encoded[c] / alpha, 1.0f);
        }
        // Without a profile, ideal inks.
        if (inks_ && !profile_) {
            for (size_t c = 0; c < 3; ++c)
                encoded[c] = (1 - encoded[c]) * (1 - encoded[3]);
        }
        v = encoded;
        if (lab_) {
            lab_->decode(encoded.data(), v.data());
        } else if (profile_) {
            profile_->decode(encoded.data(), v.data());
        } else {
            for (int32_t c = 0; c < colors_; ++c)
                v[c] = decode(encoded[c]);
            if (colors_ == 3) space_.convert(v.data());
        }
        if (to_luminance_) v[0] = luminance(v[0], v[1], v[2]);
        if (has_alpha_) put_alpha(alpha, multiplied, v.data());
        std::copy_n(v.data(), channels_out_, out);
        return true;
    }

  private:
    static bool last_is_alpha(const OIIO::ImageSpec& spec) {
        return spec.alpha_channel == spec.nchannels - 1 ||
               (!spec.channelnames.empty() && spec.channelnames.back() == "A");
    }

    static RgbSpace srgb() {
        return RgbSpace::make(kSrgbChromaticities, Curve::kSrgb).value_or(RgbSpace());
    }

    void take(const FileColor& color) {
        space_ = color.space;
        note_ = color.note;
        if (!color.profile.empty() && (colors_ == 1 || colors_ == 3)) {
            EmbeddedProfile::Found found =
                EmbeddedProfile::find(color.profile, color.inks ? 4 : colors_);
            if (found.is_srgb) space_ = srgb();
            profile_ = std::move(found.other);
            if (!found.is_srgb && profile_ == nullptr) note_ = messages::kProfileUnused;
        }
    }

    bool is_encoded() const {
        return lab_ || profile_ != nullptr || space_.curve() != Curve::kLinear;
    }

    /// Lays colours on white. Data stay, but the one number that is made of them, a height, is 0 where
    /// nothing is.
    void put_alpha(float alpha, bool multiplied, float* v) const {
        if (is_data_) {
            if (channels_out_ == 1) v[0] *= multiplied ? 1.0f : alpha;
            return;
        }
        const double a = static_cast<double>(alpha);
        for (int32_t c = 0; c < colors_; ++c) {
            const double value = static_cast<double>(v[c]);
            const double light = alpha > 0 || multiplied ? value * (multiplied ? 1 : a) : 0;
            v[c] = static_cast<float>(light + (1 - a));
        }
        v[colors_] = alpha;
    }

    float decode(float value) const {
        // OpenImageIO gives 8-bit values as i / 255.
        if (use_table_)
            return table_[static_cast<size_t>(std::clamp(value * 255.0f + 0.5f, 0.0f, 255.0f))];
        if (space_.curve() == Curve::kLinear) return value;
        return static_cast<float>(space_.decode(static_cast<double>(value)));
    }

    int32_t channels_in_ = 0;
    int32_t channels_out_ = 0;
    int32_t colors_ = 0;
    RgbSpace space_;
    std::optional<LabDecoder> lab_;
    bool inks_ = false;
    bool has_alpha_ = false;
    bool is_data_ = false;
    bool premultiplied_ = false;  ///< colours with alpha, in the file
    bool to_luminance_ = false;
    bool use_table_ = false;
    std::unique_ptr<EmbeddedProfile> profile_;
    const char* note_ = nullptr;
    std::array<float, 256> table_{};
};

}  // namespace openfab::tools
