// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small volumes for fablets, as NRRD with compressed values of 16 bits. A texel is 1 mm, and the
// lowest corner is at 0, so that node i lies at i + 0.5.

#include <cstdint>
#include <span>
#include <string>

#include "base/vec.h"

namespace openfab::color {

/// Returns the file: channels innermost, then x, y, z. `description` becomes a comment of one line.
std::string nrrd_of(const Vec3i& size, int channels, std::span<const uint16_t> values,
                    const std::string& description);

}  // namespace openfab::color
