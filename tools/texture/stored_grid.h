// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A grid whose numbers a file holds one after the other, behind a header that says how: NRRD, NIfTI and
// MetaImage. The axis of channels may be any of its axes.

#include <array>
#include <cstdint>
#include <memory>

#include "tools/texture/byte_stream.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

struct StoredGrid {
    Vec3i size;            ///< of the axes that lie in space, in the file's order
    int32_t channels = 1;  ///< 1 to 4
    int channel_axis = 0;  ///< how many of the axes in space run faster than that of channels
    NumberFormat format;
    bool text = false;                ///< numbers with blanks or commas between them
    bool packed = false;              ///< which `stream` decompresses
    bool goes_on = false;             ///< others stand behind its numbers
    double slope = 1, intercept = 0;  ///< of what stands in the file
    int64_t skip = 0;                 ///< bytes of the stream before the first number
    std::unique_ptr<ByteStream> stream;

    /// Counts its numbers.
    int64_t numbers() const { return int64_t{size.x} * size.y * size.z * channels; }
    /// Counts the bytes that they take at least.
    int64_t bytes() const { return text ? 2 * numbers() - 1 : numbers() * format.bytes; }
};

/// Checks three or four sides, and sets size and channels by them. Fails for what is not possible.
Result<void> set_sides(const std::array<int64_t, 3>& sides, int64_t channels, StoredGrid* grid);

/// Opens one of its data files.
using OpenDataFile = std::function<Result<std::unique_ptr<ByteStream>>(InputFile)>;
/// Sets the stream of a grid whose numbers lie in several files, an equal share in each; `header` names them,
/// and `source` is open.
Result<void> chain_data_files(const std::filesystem::path& header, InputFile source,
                              const std::vector<std::string>& names,
                              const texture::ReadLimits& limits, const OpenDataFile& open,
                              StoredGrid* grid);

/// Opens the reader of its texels, as yet without a place: slice by slice where the channels come first,
/// else by way of memory. Fails where the file cannot hold the numbers, or where they take too much memory.
MadeReader open_stored_grid(StoredGrid grid, const texture::ReadLimits& limits);

}  // namespace openfab::tools
