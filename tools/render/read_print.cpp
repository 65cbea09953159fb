// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/read_print.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "backends/common/tee_sink.h"
#include "backends/read/print_file.h"
#include "base/units.h"
#include "tools/render/messages.h"

namespace openfab::render {

namespace {

/// Returns false where the memory does not suffice for these cells.
Result<bool> read_slices(const prints::PrintFile& file, VolumeBuilder* builder) {
    const pipeline::PrintInfo& info = file.info();
    const auto width = static_cast<size_t>(info.size.x);
    std::vector<uint8_t> codes(width * static_cast<size_t>(info.size.y));
    prints::SliceBuffers buffers;
    for (int32_t i = 0; i < file.whole_slices(); ++i) {
        const int32_t z = info.slice_begin + i;
        if (Result<void> read = file.read_slice(z, &buffers); !read) return read.error();
        const pipeline::SliceView slice{z, buffers.rows.data(), file.row_bytes(), info.size.x,
                                        info.size.y};
        for (int32_t y = 0; y < info.size.y; ++y)
            backends::unpack_row(slice, y, info.bits,
                                 codes.data() + static_cast<size_t>(y) * width);
        for (uint8_t& code : codes) {
            if (code > info.materials.size()) {
                return user_error(fmt::format(messages::kSliceHasMaterial, file.path(), z, code,
                                              info.materials.size()));
            }
            if (code == info.support_code) code = 0;
        }
        if (!builder->add(z, codes.data())) return false;
    }
    return true;
}

}  // namespace

Result<ReadPrint> read_print(const std::string& path, int64_t memory_bytes) {
    Result<std::unique_ptr<prints::PrintFile>> file = prints::PrintFile::open(path, memory_bytes);
    if (!file) return file.error();
    const pipeline::PrintInfo& info = (*file)->info();
    const int64_t slice_bytes = int64_t{info.size.x} * info.size.y + 2 * (*file)->slice_bytes();
    VolumeGrid grid{info.size, info.pitch_mm, info.origin_mm, {1, 1, 1}, {}};
    for (size_t code = 1; code <= info.materials.size(); ++code) {
        if (static_cast<int32_t>(code) != info.support_code)
            grid.codes.push_back(static_cast<uint8_t>(code));
    }
    const int64_t left = memory_bytes - slice_bytes;
    for (;;) {
        if (VolumeBuilder::least_bytes(grid) < left) {
            VolumeBuilder builder(grid, left, info.seed);
            Result<bool> fits = read_slices(**file, &builder);
            if (!fits) return fits.error();
            ReadPrint out;
            if (*fits && builder.finish(&out.volume)) {
                out.info = info;
                out.cell = grid.cell;
                if (!grid.is_own()) {
                    out.mixed = grid.codes;
                    out.mixtures = builder.mixtures().by_code();
                }
                out.slices = (*file)->whole_slices();
                if (out.volume.solid_mm().empty())
                    return user_error(fmt::format(messages::kNothingPrinted, path));
                return out;
            }
        }
        grid.coarsen();
        constexpr int32_t kFewest = 8;  // with less the print is not there any more
        const Vec3i cells = grid.cells();
        if (std::max({cells.x, cells.y, cells.z}) < kFewest) {
            return user_error(
                fmt::format(messages::kPictureBeyondMemory, path, format_bytes(memory_bytes)));
        }
    }
}

}  // namespace openfab::render
