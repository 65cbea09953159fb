// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The formats of pictures, told by their first bytes, and what is known of a file before a library opens
// it: libraries make room for what a header claims.

#include <cstdint>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

struct PictureFormat {
    std::string reader;       ///< OpenImageIO's name of it; empty where it is none that is read
    int64_t at_once = 0;      ///< bytes that the reader takes when it opens the file
    bool fragile = false;     ///< the library was not made for strangers' files (guarded.h)
    bool bare_alpha = false;  ///< a fourth channel is no alpha: viewers look at the other three
    bool plain_bits = false;  ///< a PBM in digits
};

/// Errors do not name the file.
Result<PictureFormat> picture_format(const InputFile& file);

/// Returns the same picture as a PBM in bits. Digits may follow each other without blanks, which
/// OpenImageIO does not read. Takes as much memory as the file has bytes, and an eighth of it.
Result<std::vector<char>> packed_bits(const InputFile& plain);

}  // namespace openfab::tools
