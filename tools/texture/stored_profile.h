// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// ICC profiles where OpenImageIO gives none: libpng leaves out those of other colours than the picture's, as of a grey
// one that was made of colours, and of WebP it reads none.

#include <cstdint>
#include <vector>

#include "base/input_file.h"

namespace openfab::tools {

/// Returns the profile of an iCCP chunk whose data begin at `at`; empty where it is damaged or too large.
std::vector<uint8_t> png_profile(const InputFile& file, int64_t at, int64_t bytes);

struct WebpProfile {
    bool is_there = false;
    std::vector<uint8_t> bytes;  ///< empty where it is damaged or too large
};
WebpProfile webp_profile(const InputFile& file);

}  // namespace openfab::tools
