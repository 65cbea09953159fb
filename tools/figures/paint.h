// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures for the figures' side view (polygonise.h): row 0 on top, so v = 1.

#include <cstdint>
#include <string>
#include <vector>

namespace openfab::figures {

struct Painting {
    std::string name;
    int32_t width = 0;
    int32_t height = 0;
    int32_t channels = 0;         ///< 1 grey, 3 sRGB
    std::vector<uint8_t> pixels;  ///< top row first
};

/// Returns zebra (grey, for the rhino) and reef (colours, for the fish).
std::vector<Painting> all_paintings();

}  // namespace openfab::figures
