// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pixel decoding, shared by the converters of pictures and of stacks of slices.

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "base/color.h"
#include "texture/cache.h"
#include "tools/texture/embedded_profile.h"

namespace openfab::tools {

/// Converts each pixel between the file and the pyramid. Colours are decoded by the picture's own ICC
/// profile where the space is `auto`, else as the space says.
class Decoder {
  public:
    Decoder(const OIIO::ImageSpec& spec, const texture::ImageOptions& options)
        : channels_in_(spec.nchannels) {
        const bool eight_bit = spec.format.basetype == OIIO::TypeDesc::UINT8;
        srgb_ = options.space == "srgb" || (options.space == "auto" && eight_bit);
        // Grey with alpha and colour with alpha: alpha is the last of 2 or 4.
        colors_ = channels_in_ == 2 || channels_in_ == 4 ? channels_in_ - 1 : channels_in_;
        to_luminance_ = options.luminance && colors_ == 3;
        channels_out_ = options.luminance ? 1 : channels_in_;
        if (const OIIO::ParamValue* icc = spec.find_attribute("ICCProfile");
            icc != nullptr && options.space == "auto" && colors_ == 3) {
            EmbeddedProfile::Found found = EmbeddedProfile::find(
                {static_cast<const uint8_t*>(icc->data()), static_cast<size_t>(icc->datasize())});
            srgb_ = srgb_ || found.is_srgb;
            profile_ = std::move(found.other);
        }
        if (srgb_ && eight_bit) {
            for (size_t i = 0; i < table_.size(); ++i) {
                table_[i] = static_cast<float>(srgb_to_linear(static_cast<double>(i) / 255.0));
            }
            use_table_ = true;
        }
    }
    int32_t channels_in() const { return channels_in_; }
    int32_t channels_out() const { return channels_out_; }

    /// Converts one pixel; returns false where a value is not finite.
    bool pixel(const float* in, float* out) const {
        std::array<float, 4> v{};
        for (int32_t c = 0; c < channels_in_; ++c) {
            const float value = in[c];
            if (!std::isfinite(value)) return false;
            v[c] = srgb_ && c < colors_ && !profile_ ? decode(value) : value;
        }
        if (profile_) profile_->decode(in, v.data());
        if (to_luminance_) v[0] = luminance(v[0], v[1], v[2]);
        std::copy_n(v.data(), channels_out_, out);
        return true;
    }

  private:
    float decode(float value) const {
        // OpenImageIO gives 8-bit values as i / 255.
        if (use_table_)
            return table_[static_cast<size_t>(std::clamp(value * 255.0f + 0.5f, 0.0f, 255.0f))];
        return static_cast<float>(srgb_to_linear(static_cast<double>(value)));
    }

    int32_t channels_in_ = 0;
    int32_t channels_out_ = 0;
    int32_t colors_ = 0;
    bool srgb_ = false;
    bool to_luminance_ = false;
    bool use_table_ = false;
    std::unique_ptr<EmbeddedProfile> profile_;
    std::array<float, 256> table_{};
};

}  // namespace openfab::tools
