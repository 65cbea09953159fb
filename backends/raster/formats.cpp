// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/formats.h"

#include "backends/raster/folder_sink.h"
#include "backends/raster/messages.h"
#include "backends/raster/npy_sink.h"
#include "backends/raster/slice_files.h"

namespace openfab::raster {

namespace {

// What slices that wait for their turn take beyond their packed rows: a bit for each material, or a
// byte, in the slabs of eight slices that two threads have in flight.
constexpr int64_t kSlabs = 4;

FolderOptions folder_options(const backends::OutputSettings& settings, SliceFormat format) {
    FolderOptions folder;
    folder.format = format;
    folder.flip_x = settings.flip_x;
    folder.front_end_makes_support = settings.front_end_makes_support;
    folder.handoff = settings.handoff;
    return folder;
}

FolderOptions png_options(const backends::OutputSettings& settings) {
    return folder_options(settings,
                          settings.png_indexed ? SliceFormat::kIndexed : SliceFormat::kRgba);
}

FolderOptions bmp_options(const backends::OutputSettings& settings) {
    return folder_options(settings, SliceFormat::kBitmaps);
}

template <FolderOptions (*options_of)(const backends::OutputSettings&)>
Result<std::unique_ptr<pipeline::SliceSink>> open_folder(const backends::OutputSettings& settings) {
    return settings.resume ? FolderSink::reopen(settings.path, options_of(settings))
                           : FolderSink::create(settings.path, options_of(settings));
}

template <FolderOptions (*options_of)(const backends::OutputSettings&)>
std::vector<uint8_t> encode(const pipeline::SliceView& slice, const pipeline::PrintInfo& info,
                            const backends::OutputSettings& settings) {
    return encode_slice(slice, info, options_of(settings));
}

template <SliceFormat format>
FolderOptions grey_options(const backends::OutputSettings& settings) {
    FolderOptions options = folder_options(settings, format);
    options.grey_material = settings.grey_material;
    return options;
}

template <SliceFormat format>
constexpr backends::Format grey_format(std::string_view name, std::string_view extension) {
    backends::Format made;
    made.name = name;
    made.extension = extension;
    made.kind = backends::FormatKind::kFolder;
    made.flips_x = true;
    made.of_fractions = true;
    made.bytes_per_column = [](size_t) { return kSlabs * 8 * static_cast<int64_t>(sizeof(float)); };
    made.open = open_folder<grey_options<format>>;
    made.encode = encode<grey_options<format>>;
    return made;
}

}  // namespace

const backends::Format kGreyFormat = grey_format<SliceFormat::kGrey8>("grey", ".png");
const backends::Format kGrey16Format = grey_format<SliceFormat::kGrey16>("grey16", ".png");
const backends::Format kTiffFormat = grey_format<SliceFormat::kTiff8>("tiff", ".tif");
const backends::Format kTiff16Format = grey_format<SliceFormat::kTiff16>("tiff16", ".tif");

FolderOptions grey_folder_options(const backends::Format& format, bool flip_x,
                                  const std::string& material) {
    FolderOptions options;
    options.format = &format == &kGreyFormat     ? SliceFormat::kGrey8
                     : &format == &kGrey16Format ? SliceFormat::kGrey16
                     : &format == &kTiffFormat   ? SliceFormat::kTiff8
                                                 : SliceFormat::kTiff16;
    options.flip_x = flip_x;
    options.grey_material = material;
    return options;
}

const backends::Format kPngFormat{
    .name = "png",
    .extension = ".png",
    .kind = backends::FormatKind::kFolder,
    .flips_x = true,
    .has_palette = true,
    .open = open_folder<png_options>,
    .encode = encode<png_options>,
};

const backends::Format kBmpFormat{
    .name = "bmp",
    .extension = ".bmp",
    .kind = backends::FormatKind::kFolder,
    .flips_x = true,
    .bytes_per_column = [](size_t materials) { return kSlabs * static_cast<int64_t>(materials); },
    .open = open_folder<bmp_options>,
    .encode = encode<bmp_options>,
};

const backends::Format kNpyFormat{
    .name = "npy",
    .extension = ".npy",
    .not_resumed = messages::kArrayNotResumed,
    .bytes_per_column = [](size_t) { return kSlabs * 8; },
    .files =
        [](const std::string& path, const std::vector<pipeline::SliceMaterial>&) {
            return std::vector<backends::FormatFile>{{path, false}, {array_json_path(path), true}};
        },
    .open = [](const backends::OutputSettings& settings) { return NpySink::create(settings.path); },
};

}  // namespace openfab::raster
