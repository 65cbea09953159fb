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

EmbeddedProfile::Found EmbeddedProfile::find(std::span<const uint8_t> bytes) {
    std::unique_ptr<EmbeddedProfile> out(new EmbeddedProfile);
    const CmsProfile profile = out->context_.open(bytes);
    if (profile == nullptr || cmsGetColorSpace(profile.get()) != cmsSigRgbData) return {};
    const cmsContext context = out->context_.get();
    const CmsProfile linear = linear_srgb(context);
    if (linear == nullptr) return {};
    out->transform_.reset(cmsCreateTransformTHR(context, profile.get(), TYPE_RGB_FLT, linear.get(),
                                                TYPE_RGB_FLT, INTENT_RELATIVE_COLORIMETRIC,
                                                cmsFLAGS_NOOPTIMIZE | cmsFLAGS_NOCACHE));
    if (out->transform_ == nullptr) return {};
    if (out->is_srgb()) return {true, nullptr};
    return {false, std::move(out)};
}

bool EmbeddedProfile::is_srgb() const {
    constexpr int kSteps = 8;
    constexpr double kHalfStep = 0.5 / 255;
    for (int r = 0; r <= kSteps; ++r) {
        for (int g = 0; g <= kSteps; ++g) {
            for (int b = 0; b <= kSteps; ++b) {
                const std::array<float, 3> in = {static_cast<float>(r) / kSteps,
                                                 static_cast<float>(g) / kSteps,
                                                 static_cast<float>(b) / kSteps};
                std::array<float, 3> out{};
                decode(in.data(), out.data());
                for (size_t c = 0; c < 3; ++c) {
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

void EmbeddedProfile::decode(const float* in, float* out) const {
    constexpr float kOne = 65536;
    cmsDoTransform(transform_.get(), in, out, 1);
    for (size_t c = 0; c < 3; ++c)
        out[c] = std::floor(out[c] * kOne + 0.5f) / kOne;
}

}  // namespace openfab::tools
