// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Frames whose bytes lie in items (PS3.5, A.4): one or several items a frame.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

/// Where an item's bytes lie.
struct PackedItem {
    int64_t at = 0, bytes = 0;
};

/// The items of each frame.
using PackedFrames = std::vector<std::vector<PackedItem>>;

/// Finds the items of `frames` frames, of which the first element begins at `at`: by the file's table of
/// offsets, else by `long_offsets` (the extended table), else one for each frame, or by how compressed
/// pictures begin. Fails where they do not all end within the file, or where nothing says which frame is
/// whose.
Result<PackedFrames> find_packed_frames(const InputFile& file, int64_t at, int32_t frames,
                                        std::string_view long_offsets);

/// Joins the bytes of a frame's items.
Result<std::string> read_packed_frame(const InputFile& file, const std::vector<PackedItem>& items);

/// Unpacks `bytes` bytes of a deflated frame. Fails where there are fewer, or others than these.
Result<std::string> inflate_frame(std::string_view packed, int64_t bytes);

}  // namespace openfab::tools
