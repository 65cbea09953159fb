// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Programs of microscopes that write channels or times between the slices, and say so in words of their own.

#include <cstdint>
#include <string>

#include "base/result.h"
#include "tools/texture/tiff_image.h"

namespace openfab::tools {

/// Fails where the first of `pages` pages says that they are not slices: by ScanImage
/// (https://docs.scanimage.org), Olympus FluoView (its tag 34361) or PerkinElmer's scanners of slides.
Result<void> check_maker(const TiffDirectory& first, int64_t pages);

/// Fails where the last of `pages` pages is not the last of so many slices, by what Micro-Manager writes with each
/// (its tag 51123).
Result<void> check_micro_manager(const TiffDirectory& last, int64_t pages);

}  // namespace openfab::tools
