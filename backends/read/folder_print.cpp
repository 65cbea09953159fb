// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/read/folder_print.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "backends/common/hex_color.h"
#include "backends/common/tee_sink.h"
#include "backends/raster/grey_slice.h"
#include "backends/raster/png_slice.h"
#include "backends/raster/slice_digests.h"
#include "backends/read/messages.h"
#include "base/input_file.h"

namespace openfab::prints {

namespace {

constexpr size_t kMostManifest = raster::kMostManifestBytes;
constexpr double kMostVoxels = 1 << 24;  ///< along an axis
constexpr size_t kMostMaterials = 254;

double number_of(const JsonValue& object, const char* key, double none = -1) {
    const JsonMember* const member = object.find(key);
    return member != nullptr && member->value.is(JsonValue::Kind::kNumber) ? member->value.number
                                                                           : none;
}

std::string text_of(const JsonValue& object, const char* key) {
    const JsonMember* const member = object.find(key);
    return member != nullptr ? member->value.text : std::string();
}

bool is_true(const JsonValue& object, const char* key) {
    const JsonMember* const member = object.find(key);
    return member != nullptr && member->value.boolean;
}

/// Reads an array of numbers; false where it is none of so many.
bool read_numbers(const JsonValue& object, const char* key, std::span<double> out) {
    const JsonMember* const member = object.find(key);
    if (member == nullptr || member->value.items.size() != out.size()) return false;
    for (size_t i = 0; i < out.size(); ++i) {
        if (!member->value.items[i].is(JsonValue::Kind::kNumber)) return false;
        out[i] = member->value.items[i].number;
    }
    return true;
}

bool is_count(double number, double least, double most) {
    return number >= least && number <= most && number == std::floor(number);
}

/// Returns `info` with the pitch that the file itself gives: decoding compares all of it, and the
/// manifest's pitch is rounded.
pipeline::PrintInfo with_pitch_of(const std::vector<uint8_t>& file, bool is_bitmap,
                                  pipeline::PrintInfo info) {
    std::array<uint32_t, 2> per_metre{};
    if (is_bitmap) {
        constexpr size_t kAt = 38;
        for (size_t i = 0; i < 8 && kAt + 8 <= file.size(); ++i)
            per_metre[i / 4] |= uint32_t{file[kAt + i]} << (8 * (i % 4));
    } else {
        constexpr std::string_view kChunk = "pHYs";
        const auto end =
            file.begin() + static_cast<std::ptrdiff_t>(std::min<size_t>(file.size(), 4096));
        const auto found = std::search(file.begin(), end, kChunk.begin(), kChunk.end());
        if (end - found < 12) return info;
        for (size_t i = 0; i < 8; ++i)
            per_metre[i / 4] = per_metre[i / 4] << 8 | found[static_cast<std::ptrdiff_t>(4 + i)];
    }
    if (per_metre[0] != 0) info.pitch_mm.x = 1000.0 / per_metre[0];
    if (per_metre[1] != 0) info.pitch_mm.y = 1000.0 / per_metre[1];
    return info;
}

}  // namespace

Result<std::unique_ptr<FolderPrint>> FolderPrint::open(const std::string& path,
                                                       int64_t memory_bytes) {
    std::unique_ptr<FolderPrint> print(new FolderPrint(path));
    const Result<JsonValue> manifest = print->read_manifest();
    if (!manifest) return manifest.error();
    if (Result<void> taken = print->take_manifest(*manifest); !taken) return taken.error();
    // A picture, its codes one a byte, and its packed rows.
    const int64_t pixels = int64_t{print->info_.size.x} * print->info_.size.y;
    const int64_t channels = print->options_.format == raster::SliceFormat::kRgba ? 4 : 1;
    if (Result<void> fits = print->check_memory(pixels * (channels + 2), memory_bytes); !fits)
        return fits.error();
    print->take_totals(*manifest);
    print->look_again();
    return print;
}

Result<JsonValue> FolderPrint::read_manifest() const {
    const std::string name = path_ + "/manifest.json";
    const Result<std::string> text = read_text_file(name, kMostManifest);
    if (!text) return with_context(text.error(), messages::kNoFolderOfSlices);
    return parse_json(*text, name, std::numeric_limits<int64_t>::max(),
                      raster::kMostManifestValues);
}

Result<void> FolderPrint::take_manifest(const JsonValue& manifest) {
    const Error damaged = error(messages::kManifestOfOther);
    std::array<double, 2> pixels{};
    std::array<double, 3> pitch{}, size{}, origin{};
    const double first = number_of(manifest, "first_slice_z");
    const double planned = number_of(manifest, "slices_planned");
    if (!read_numbers(manifest, "pixels", pixels) || !read_numbers(manifest, "pitch_mm", pitch) ||
        !read_numbers(manifest, "size_mm", size) || !read_numbers(manifest, "origin_mm", origin) ||
        !is_count(first, 0, kMostVoxels) || !is_count(planned, 1, kMostVoxels) ||
        !std::all_of(pixels.begin(), pixels.end(),
                     [](double n) { return is_count(n, 1, kMostVoxels); }) ||
        !std::all_of(pitch.begin(), pitch.end(), [](double mm) { return mm > 0; }))
        return damaged;
    // Both are rounded.
    const double slices = std::max(std::round(size[2] / pitch[2]), first + planned);
    const JsonMember* const axes = manifest.find("axes");
    const JsonMember* const materials = manifest.find("materials");
    if (!is_count(slices, first + planned, kMostVoxels) || axes == nullptr ||
        materials == nullptr || materials->value.items.size() > kMostMaterials)
        return damaged;
    info_.size = {static_cast<int32_t>(pixels[0]), static_cast<int32_t>(pixels[1]),
                  static_cast<int32_t>(slices)};
    info_.pitch_mm = {pitch[0], pitch[1], pitch[2]};
    info_.origin_mm = {origin[0], origin[1], origin[2]};
    info_.slice_begin = static_cast<int32_t>(first);
    info_.slice_end = info_.slice_begin + static_cast<int32_t>(planned);
    info_.title = text_of(manifest, "title");
    info_.printer = text_of(manifest, "printer");
    for (const JsonValue& material : materials->value.items) {
        pipeline::SliceMaterial& made = info_.materials.emplace_back();
        made.name = text_of(material, "name");
        made.channel = text_of(material, "channel");
        made.density_g_cm3 = number_of(material, "density_g_cm3", 0);
        if (!backends::read_color(text_of(material, "color"), &made.key)) return damaged;
        made.preview = made.key;
    }
    info_.bits = info_.materials.size() > 15 ? 8 : 4;
    row_bytes_ = backends::packed_row_bytes(info_.size.x, info_.bits);
    const std::string mode = text_of(manifest, "color_mode");
    options_.format = mode == "indexed"   ? raster::SliceFormat::kIndexed
                      : mode == "bitmaps" ? raster::SliceFormat::kBitmaps
                                          : raster::SliceFormat::kRgba;
    if (mode.starts_with("grey")) {
        const bool deep = mode == "grey16";
        options_.format = deep ? raster::SliceFormat::kTiff16 : raster::SliceFormat::kTiff8;
        std::error_code ignored;
        if (!std::filesystem::exists(slice_path(info_.slice_begin, 0), ignored))
            options_.format = deep ? raster::SliceFormat::kGrey16 : raster::SliceFormat::kGrey8;
    }
    options_.flip_x = is_true(axes->value, "flipped_x");
    if (options_.format == raster::SliceFormat::kRgba && raster::shares_a_color(info_))
        return error(messages::kMaterialsOfOneColour);
    return {};
}

bool FolderPrint::take_totals(const JsonValue& manifest) {
    const JsonMember* const materials = manifest.find("materials");
    if (!is_true(manifest, "complete") || materials == nullptr ||
        materials->value.items.size() != info_.materials.size())
        return false;
    constexpr double kMost = 9e18;
    const int32_t slices = info_.slice_end - info_.slice_begin;
    pipeline::PrintTotals totals;
    totals.complete = true;
    totals.voxels_by_code.push_back(int64_t{info_.size.x} * info_.size.y * slices);
    for (const JsonValue& material : materials->value.items) {
        const double voxels = number_of(material, "voxels");
        if (!is_count(voxels, 0, kMost)) return false;
        totals.voxels_by_code.push_back(static_cast<int64_t>(voxels));
        totals.voxels_by_code[0] -= totals.voxels_by_code.back();
        totals.voxels_solid += totals.voxels_by_code.back();
    }
    const std::string hash = text_of(manifest, "hash");
    std::from_chars(hash.data(), hash.data() + hash.size(), totals.hash, 16);
    totals.tight = {{0, 0, info_.slice_begin}, {info_.size.x, info_.size.y, info_.slice_end}};
    const std::lock_guard lock(mutex_);
    totals_ = std::move(totals);
    return true;
}

std::string FolderPrint::slice_path(int32_t z, size_t file) const {
    return path_ + "/" + raster::slice_file_name(z, file, info_, options_);
}

bool FolderPrint::is_grey() const {
    return raster::is_grey(options_.format);
}

std::vector<std::string> FolderPrint::slice_files(int32_t z) const {
    std::vector<std::string> files;
    for (size_t i = 0; i < raster::files_a_slice(info_, options_); ++i)
        files.push_back(slice_path(z, i));
    return files;
}

int32_t FolderPrint::whole_slices() const {
    const std::lock_guard lock(mutex_);
    return found_;
}

std::optional<pipeline::PrintTotals> FolderPrint::totals() const {
    const std::lock_guard lock(mutex_);
    return totals_;
}

bool FolderPrint::look_again() {
    const int32_t planned = info_.slice_end - info_.slice_begin;
    const size_t last = raster::files_a_slice(info_, options_) - 1;
    bool found = false, all = false;
    {
        const std::lock_guard lock(mutex_);
        struct stat there {};
        while (found_ < planned &&
               ::stat(slice_path(info_.slice_begin + found_, last).c_str(), &there) == 0) {
            if (found_ == 0 && ::stat(slice_path(info_.slice_begin, 0).c_str(), &first_) != 0)
                break;
            ++found_;
            found = true;
        }
        all = found_ == planned && !totals_;
    }
    if (!all) return found;
    const Result<JsonValue> manifest = read_manifest();
    return (manifest && take_totals(*manifest)) || found;
}

bool FolderPrint::was_replaced() const {
    const std::lock_guard lock(mutex_);
    if (found_ == 0) return false;
    struct stat there {};
    if (::stat(slice_path(info_.slice_begin, 0).c_str(), &there) != 0) return true;
    return there.st_ino != first_.st_ino || there.st_dev != first_.st_dev ||
           there.st_mtim.tv_sec != first_.st_mtim.tv_sec ||
           there.st_mtim.tv_nsec != first_.st_mtim.tv_nsec;
}

Result<void> FolderPrint::read_slice(int32_t z, SliceBuffers* buffers) const {
    if (z < info_.slice_begin || z - info_.slice_begin >= whole_slices())
        return error(fmt::format(messages::kSliceNotThere, z));
    if (is_grey()) return error(messages::kSlicesOfFractions);
    buffers->frame.clear();
    for (const std::string& name : slice_files(z)) {
        const Result<InputFile> file = InputFile::open(name);
        if (!file) return with_context(file.error(), fmt::format(messages::kCannotOpen, name));
        // An encoder makes no file that is larger than this.
        const int64_t most = int64_t{8} * info_.size.x * info_.size.y + (1 << 20);
        const Result<std::string> bytes = file->read_all(most);
        if (!bytes) return with_context(bytes.error(), fmt::format(messages::kCannotRead, name));
        buffers->frame.insert(buffers->frame.end(), bytes->begin(), bytes->end());
    }
    const bool is_bitmap = options_.format == raster::SliceFormat::kBitmaps;
    buffers->rows = raster::decode_slice(buffers->frame,
                                         with_pitch_of(buffers->frame, is_bitmap, info_), options_);
    if (buffers->rows.empty()) return error(fmt::format(messages::kSliceDamaged, z));
    return {};
}

}  // namespace openfab::prints
