// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Samples of a TIFF as floats.

#include <cstdint>

#include "tools/texture/tiff_image.h"

namespace openfab::tools {

/// Converts `count` samples, in this machine's order of bytes, or bits from the highest of the first byte
/// on; writes each `stride` floats behind the last. Sets `rounded` where a float does not hold an integer.
void convert_samples(const TiffDirectory& page, TiffImage::Scale scale, const uint8_t* in,
                     int64_t count, int stride, float* out, bool* rounded);
/// Returns whether samples of this kind and width are known.
bool knows_samples(const TiffDirectory& page);

}  // namespace openfab::tools
