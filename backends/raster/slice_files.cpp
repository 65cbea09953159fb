// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/slice_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "backends/common/tee_sink.h"
#include "backends/raster/bmp_slice.h"
#include "backends/raster/grey_slice.h"
#include "backends/raster/png_slice.h"

namespace openfab::raster {

size_t files_a_slice(const pipeline::PrintInfo& info, const FolderOptions& options) {
    return options.format == SliceFormat::kBitmaps ? info.materials.size() : 1;
}

std::string slice_file_name(int32_t z, size_t file, const pipeline::PrintInfo& info,
                            const FolderOptions& options) {
    const size_t digits = std::max<size_t>(4, std::to_string(info.size.z).size());
    const std::string stem = fmt::format("slice_{:0{}}", z + 1, digits);
    if (options.format == SliceFormat::kBitmaps) return fmt::format("{}_{}.bmp", stem, file + 1);
    return stem + (is_tiff(options.format) ? ".tif" : ".png");
}

bool is_slice_name(const std::string& name) {
    // `.part` is what an interrupted write leaves.
    static const std::regex kName("slice_[0-9]+(\\.png|\\.tif|_[0-9]+\\.bmp)(\\.part)?");
    return std::regex_match(name, kName);
}

std::vector<uint8_t> encode_slice(const pipeline::SliceView& slice, const pipeline::PrintInfo& info,
                                  const FolderOptions& options) {
    if (is_grey(options.format)) return encode_grey_slice(slice, info, options);
    return options.format == SliceFormat::kBitmaps
               ? encode_bmp_slice(slice, info, options.flip_x)
               : encode_png_slice(slice, info, options.format == SliceFormat::kIndexed,
                                  options.flip_x);
}

std::vector<uint8_t> decode_slice(std::span<const uint8_t> files, const pipeline::PrintInfo& info,
                                  const FolderOptions& options) {
    // Fractions do not tell what the dither made of them.
    if (is_grey(options.format)) return {};
    std::vector<uint8_t> codes =
        options.format == SliceFormat::kBitmaps
            ? decode_bmp_slice(files, info)
            : decode_png_slice(files, info, options.format == SliceFormat::kIndexed);
    if (codes.empty()) return {};
    const auto width = static_cast<size_t>(info.size.x);
    const size_t row_bytes = backends::packed_row_bytes(info.size.x, info.bits);
    std::vector<uint8_t> rows(row_bytes * static_cast<size_t>(info.size.y));
    for (size_t y = 0; y < static_cast<size_t>(info.size.y); ++y) {
        const std::span<uint8_t> row(codes.data() + width * y, width);
        if (options.flip_x) std::reverse(row.begin(), row.end());
        backends::pack_row(row, info.bits, rows.data() + row_bytes * y);
    }
    return rows;
}

}  // namespace openfab::raster
