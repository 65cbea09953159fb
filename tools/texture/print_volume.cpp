// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/print_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "backends/common/tee_sink.h"
#include "backends/ofr/format.h"
#include "backends/read/folder_print.h"
#include "backends/read/gcvf_print.h"
#include "texture/zarr_store.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Gives a volume the size, and the place, of the slices that a print has.
void place(const pipeline::PrintInfo& info, VolumeReader* volume) {
    volume->size = {info.size.x, info.size.y, info.slice_end - info.slice_begin};
    volume->origin = {info.origin_mm.x, info.origin_mm.y,
                      info.origin_mm.z + info.slice_begin * info.pitch_mm.z};
    volume->spacing = {info.pitch_mm.x, info.pitch_mm.y, info.pitch_mm.z};
    volume->no_nan = true;
}

class CodeReader final : public VolumeReader {
  public:
    explicit CodeReader(std::unique_ptr<prints::PrintFile> print)
        : print_(std::move(print)), codes_(static_cast<size_t>(print_->info().size.x)) {
        place(print_->info(), this);
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const pipeline::PrintInfo& info = print_->info();
        if (Result<void> read = print_->read_slice(info.slice_begin + z, &buffers_); !read)
            return read;
        const pipeline::SliceView slice{z, buffers_.rows.data(), print_->row_bytes(), size.x,
                                        size.y};
        for (int32_t y = 0; y < size.y; ++y) {
            backends::unpack_row(slice, y, info.bits, codes_.data());
            out = std::copy(codes_.begin(), codes_.end(), out);
            wrote(4 * row_floats());
        }
        return {};
    }

  private:
    std::unique_ptr<prints::PrintFile> print_;
    prints::SliceBuffers buffers_;
    std::vector<uint8_t> codes_;
};

/// Pictures, whose first rows are the highest.
class GreyReader final : public VolumeReader {
  public:
    GreyReader(std::unique_ptr<VolumeReader> pictures, const prints::FolderPrint& print)
        : pictures_(std::move(pictures)), flips_x_(print.flips_x()) {
        place(print.info(), this);
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        if (Result<void> read = pictures_->read_slice(z, out, wrote); !read) return read;
        const int64_t row = row_floats();
        for (int64_t y = 0; y < size.y / 2; ++y)
            std::swap_ranges(out + y * row, out + (y + 1) * row, out + (size.y - 1 - y) * row);
        if (!flips_x_) return {};
        for (int64_t y = 0; y < size.y; ++y)
            std::reverse(out + y * row, out + (y + 1) * row);
        return {};
    }

  private:
    std::unique_ptr<VolumeReader> pictures_;
    bool flips_x_;
};

Result<void> all_there(const prints::PrintFile& print) {
    const int32_t planned = print.info().slice_end - print.info().slice_begin;
    if (print.whole_slices() == planned) return {};
    return user_error(fmt::format(messages::kPrintLacksSlices, print.whole_slices(), planned),
                      messages::kPrintLacksSlicesHelp);
}

MadeReader open_grey(const prints::FolderPrint& print, const texture::ReadLimits& limits) {
    std::vector<fs::path> files;
    for (int32_t z = print.info().slice_begin; z < print.info().slice_end; ++z)
        files.emplace_back(print.slice_files(z).front());
    texture::VolumeOptions options;
    options.image.space = "linear";
    MadeReader pictures = open_stack(files, options, limits);
    if (!pictures) return pictures;
    const Vec3i& size = print.info().size;
    if ((*pictures)->size.x != size.x || (*pictures)->size.y != size.y ||
        (*pictures)->channels != 1)
        return user_error(messages::kNotAsManifestSays);
    return std::unique_ptr<VolumeReader>(std::make_unique<GreyReader>(std::move(*pictures), print));
}

}  // namespace

bool is_print(const fs::path& file, std::string_view begin) {
    return std::equal(ofr::kMagic.begin(), ofr::kMagic.end(), begin.begin(),
                      begin.begin() + std::min(begin.size(), ofr::kMagic.size()),
                      [](uint8_t a, char b) { return a == static_cast<uint8_t>(b); }) ||
           prints::is_gcvf(file);
}

MadeReader open_print(const fs::path& path, const texture::ReadLimits& limits) {
    std::unique_ptr<prints::PrintFile> print;
    std::error_code ignored;
    const bool is_store = !texture::zarr_metadata(path.empty() ? "." : path).empty();
    if (!is_store && fs::is_directory(path.empty() ? "." : path, ignored)) {
        Result<std::unique_ptr<prints::FolderPrint>> folder =
            prints::FolderPrint::open(path.empty() ? "." : path.string(), limits.memory_bytes);
        if (!folder) return folder.error();
        if (Result<void> whole = all_there(**folder); !whole) return whole.error();
        if ((*folder)->is_grey()) return open_grey(**folder, limits);
        print = std::move(*folder);
    } else {
        Result<std::unique_ptr<prints::PrintFile>> file =
            prints::PrintFile::open(path.string(), limits.memory_bytes);
        if (!file) return file.error();
        print = std::move(*file);
    }
    if (Result<void> whole = all_there(*print); !whole) return whole.error();
    return std::unique_ptr<VolumeReader>(std::make_unique<CodeReader>(std::move(print)));
}

}  // namespace openfab::tools
