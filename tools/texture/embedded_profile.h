// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ICC profile that a picture carries: what its numbers mean where they are not sRGB.

#include <cstdint>
#include <memory>
#include <span>

#include "tools/texture/icc_context.h"

namespace openfab::tools {

class EmbeddedProfile {
  public:
    /// What a picture's profile says. It says nothing where it is damaged or of another colour space
    /// than red, green and blue: viewers ignore it then, too.
    struct Found {
        bool is_srgb = false;  ///< to half a step of eight bits: take the exact formula
        std::unique_ptr<EmbeddedProfile> other;
    };
    static Found find(std::span<const uint8_t> bytes);

    /// Converts three encoded values to linear light with the primaries of sRGB, by the relative
    /// colorimetric intent. Colours beyond sRGB are below 0 or above 1. Values are multiples of
    /// 2^-16, so that they do not depend on the last bits of a mathematical library.
    void decode(const float* in, float* out) const;

  private:
    EmbeddedProfile() = default;
    bool is_srgb() const;

    IccContext context_;  ///< outlives transform_
    CmsTransform transform_;
};

}  // namespace openfab::tools
