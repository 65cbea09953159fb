// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/embedded_profile.h"

#include <array>
#include <cmath>
#include <utility>

#include "base/color.h"

namespace openfab::tools {

namespace {

/// sRGB's primaries and white with linear light.
CmsProfile linear_srgb(cmsContext context) {
    const cmsCIExyY white{0.3127, 0.3290, 1};
    const cmsCIExyYTRIPLE primaries{{0.64, 0.33, 1}, {0.30, 0.60, 1}, {0.15, 0.06, 1}};
    cmsToneCurve* const line = cmsBuildGamma(context, 1);
    const std::array<cmsToneCurve*, 3> lines = {line, line, line};
    CmsProfile profile(cmsCreateRGBProfileTHR(context, &white, &primaries, lines.data()));
    cmsFreeToneCurve(line);
    return profile;
}

}  // namespace

EmbeddedProfile::Found EmbeddedProfile::find(std::span<const uint8_t> bytes, int32_t colors) {
    std::unique_ptr<EmbeddedProfile> out(new EmbeddedProfile);
    const CmsProfile profile = out->context_.open(bytes);
    if (profile == nullptr) return {};
    out->grey_picture_ = colors == 1;
    out->grey_profile_ = cmsGetColorSpace(profile.get()) == cmsSigGrayData;
    // A grey picture often keeps the profile of the colours that it was made of.
    out->inks_ = colors == 4;
    const cmsColorSpaceSignature wanted = out->inks_ ? cmsSigCmykData : cmsSigRgbData;
    if (!(out->grey_picture_ && out->grey_profile_) && cmsGetColorSpace(profile.get()) != wanted)
        return {};
    const cmsContext context = out->context_.get();
    const CmsProfile linear = linear_srgb(context);
    if (linear == nullptr) return {};
    const cmsUInt32Number in = out->inks_           ? TYPE_CMYK_FLT
                               : out->grey_profile_ ? TYPE_GRAY_FLT
                                                    : TYPE_RGB_FLT;
    out->transform_.reset(cmsCreateTransformTHR(context, profile.get(), in, linear.get(),
                                                TYPE_RGB_FLT, INTENT_RELATIVE_COLORIMETRIC,
                                                cmsFLAGS_NOOPTIMIZE | cmsFLAGS_NOCACHE));
    if (out->transform_ == nullptr) return {};
    if (!out->inks_ && out->is_srgb()) return {true, nullptr};
    return {false, std::move(out)};
}

bool EmbeddedProfile::is_srgb() const {
    constexpr int kSteps = 8;
    constexpr double kHalfStep = 0.5 / 255;
    for (int r = 0; r <= kSteps; ++r) {
        for (int g = 0; g <= (grey_picture_ ? 0 : kSteps); ++g) {
            for (int b = 0; b <= (grey_picture_ ? 0 : kSteps); ++b) {
                const std::array<float, 3> in = {static_cast<float>(r) / kSteps,
                                                 static_cast<float>(g) / kSteps,
                                                 static_cast<float>(b) / kSteps};
                std::array<float, 3> out{};
                decode(in.data(), out.data());
                for (size_t c = 0; c < (grey_picture_ ? 1 : 3); ++c) {
                    const double v = static_cast<double>(in[c]);
                    const auto is = static_cast<double>(out[c]);
                    if (is < srgb_to_linear(v - kHalfStep) - 1e-4 ||
                        is > srgb_to_linear(v + kHalfStep) + 1e-4)
                        return false;
                }
            }
        }
    }
    return true;
}

std::array<float, 3> EmbeddedProfile::look_up(const float* in) const {
    std::array<float, 3> out{};
    if (inks_) {
        constexpr float kPercent = 100;
        const std::array<float, 4> percent = {in[0] * kPercent, in[1] * kPercent, in[2] * kPercent,
                                              in[3] * kPercent};
        cmsDoTransform(transform_.get(), percent.data(), out.data(), 1);
    } else if (grey_picture_ && !grey_profile_) {
        const std::array<float, 3> equal = {in[0], in[0], in[0]};
        cmsDoTransform(transform_.get(), equal.data(), out.data(), 1);
    } else {
        cmsDoTransform(transform_.get(), in, out.data(), 1);
    }
    return out;
}

void EmbeddedProfile::decode(const float* in, float* out) const {
    constexpr float kOne = 65536;
    std::array<float, 3> light = look_up(in);
    if (grey_picture_) light[0] = luminance(light[0], light[1], light[2]);
    for (size_t c = 0; c < (grey_picture_ ? 1 : 3); ++c)
        out[c] = std::floor(light[c] * kOne + 0.5f) / kOne;
}

}  // namespace openfab::tools
