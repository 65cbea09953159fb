// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Colour spaces that a file names by its primaries and its curve, without an ICC profile: the chunks of
// PNG, the chromaticities of OpenEXR.

#include <array>
#include <optional>

namespace openfab::tools {

/// CIE x and y of red, green, blue and white.
using Chromaticities = std::array<double, 8>;

/// Those of Rec. 709 and sRGB.
constexpr Chromaticities kSrgbChromaticities = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};

/// How values are decoded to linear light.
enum class Curve { kLinear, kSrgb, kPower, kRec709 };

/// A colour space of red, green and blue.
class RgbSpace {
  public:
    /// Fails where the primaries span no colours. `exponent` counts for kPower. White becomes white, by
    /// Bradford's adaptation.
    static std::optional<RgbSpace> make(const Chromaticities& chromaticities, Curve curve,
                                        double exponent = 1);

    /// Whether colours are those of sRGB, apart from the curve.
    bool has_srgb_primaries() const { return same_primaries_; }
    Curve curve() const { return curve_; }

    /// Decodes one value of a grey or of a colour. Powers are multiples of 2^-20, so that they do not
    /// depend on the last bits of a mathematical library.
    double decode(double value) const;
    /// Converts decoded colours to linear light with the primaries of sRGB, in place.
    void convert(float* rgb) const;

  private:
    Curve curve_ = Curve::kLinear;
    double exponent_ = 1;
    bool same_primaries_ = true;
    std::array<double, 9> to_srgb_{};  ///< row by row
};

}  // namespace openfab::tools
