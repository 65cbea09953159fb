// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ICC profile that a picture carries: what its numbers mean where they are not sRGB.

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "tools/texture/icc_context.h"

namespace openfab::tools {

class EmbeddedProfile {
  public:
    /// What a picture's profile says. It says nothing where it is damaged, or of another colour space
    /// than red, green and blue, or grey for a grey picture, or cyan, magenta, yellow and black for one of
    /// inks: viewers ignore it then, too.
    struct Found {
        bool is_srgb = false;  ///< to half a step of eight bits: take the exact formula
        std::unique_ptr<EmbeddedProfile> other;
    };
    /// `colors`: of the picture, 1 or 3; 4 for inks, 0..1 of each.
    static Found find(std::span<const uint8_t> bytes, int32_t colors = 3);

    /// Converts three encoded values, or one of a grey picture, or four inks, to linear light with the primaries of
    /// sRGB, by the relative colorimetric intent. Colours beyond sRGB are below 0 or above 1. Values are multiples of
    /// 2^-16, so that they do not depend on the last bits of a mathematical library.
    void decode(const float* in, float* out) const;

  private:
    EmbeddedProfile() = default;
    bool is_srgb() const;
    std::array<float, 3> look_up(const float* in) const;

    bool grey_picture_ = false, grey_profile_ = false, inks_ = false;

    IccContext context_;  ///< outlives transform_
    CmsTransform transform_;
};

}  // namespace openfab::tools
