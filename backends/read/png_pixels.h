// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pixels of a PNG of any kind as its file has them: nothing is converted between colours, which are the
// names of materials here.

#include <cstdint>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::prints {

struct PngPixels {
    std::vector<uint8_t> rgba;  ///< four bytes a pixel, the highest row first
    bool has_alpha = false;     ///< the file says how opaque they are
};

/// Decodes a PNG of a known size. Errors: no PNG, damaged, of another size, of 16 bits a channel.
Result<PngPixels> read_png_pixels(std::string_view bytes, const Vec2<int32_t>& size);

}  // namespace openfab::prints
