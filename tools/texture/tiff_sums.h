// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The check sums behind compressed strips and tiles of TIFF. libtiff stops at the last byte that it needs: of data that
// is damaged so that there is more of it than that, it never gets to the sum, and says nothing.

#include <tiffio.h>

#include <cstdint>
#include <string>
#include <vector>

namespace openfab::tools {

/// What is read of one strip or tile.
struct TiffChunk {
    uint32_t number = 0;
    const std::vector<uint8_t>* decoded = nullptr;
    bool may_be_longer = false;  ///< the last strip of a page, which some programs fill up
    int64_t whole_bytes = 0;     ///< of a strip that is filled up
};

/// Whether a compression has sums: Deflate, and LZMA, where the writer wants them.
bool has_sums(int compression);

/// Returns whether the sum behind a chunk that was decoded is right, and nothing else stands before it. `error`: where
/// the library leaves its words, which is cleared before.
bool has_right_sum(TIFF* tiff, int compression, const TiffChunk& chunk, std::string* error);

}  // namespace openfab::tools
