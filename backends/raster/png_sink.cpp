// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/png_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <system_error>

#include "backends/common/output_file.h"
#include "backends/common/tee_sink.h"
#include "backends/raster/png_encode.h"

namespace openfab::raster {

namespace {

constexpr const char* kManifest = "manifest.json";
constexpr const char* kHandoff = "HANDOFF.txt";

bool is_slice_name(const std::string& name) {
    constexpr std::string_view kPrefix = "slice_";
    constexpr std::string_view kSuffix = ".png";
    if (name.size() <= kPrefix.size() + kSuffix.size() || !name.starts_with(kPrefix)) return false;
    const std::string rest = name.substr(kPrefix.size());
    const size_t digits = rest.find_first_not_of("0123456789");
    // `.part` is what an interrupted write leaves.
    return digits > 0 && digits != std::string::npos &&
           (rest.substr(digits) == kSuffix || rest.substr(digits) == ".png.part");
}

std::vector<uint8_t> rgba_rows(const backends::SliceView& slice, const backends::PrintInfo& info,
                               bool flip_x) {
    std::array<uint32_t, 256> colors{};
    for (size_t i = 0; i < info.materials.size(); ++i) {
        std::memcpy(&colors[i + 1], info.materials[i].key.data(), 4);
    }
    const auto width = static_cast<size_t>(slice.width);
    const size_t stride = 1 + width * 4;
    std::vector<uint8_t> rows(stride * static_cast<size_t>(slice.height));
    std::vector<uint8_t> codes(width);
    for (int32_t y = 0; y < slice.height; ++y) {
        backends::unpack_row(slice, y, info.bits, codes.data());
        if (flip_x) std::reverse(codes.begin(), codes.end());
        uint8_t* row = rows.data() + stride * static_cast<size_t>(slice.height - 1 - y) + 1;
        for (size_t x = 0; x < width; ++x)
            std::memcpy(row + 4 * x, &colors[codes[x]], 4);
    }
    return rows;
}

std::vector<uint8_t> index_rows(const backends::SliceView& slice, const backends::PrintInfo& info,
                                bool flip_x) {
    const auto width = static_cast<size_t>(slice.width);
    const size_t row_bytes = backends::packed_row_bytes(slice.width, info.bits);
    std::vector<uint8_t> rows((1 + row_bytes) * static_cast<size_t>(slice.height));
    std::vector<uint8_t> codes(width + 1);  // one more, void, for the unused half of an odd row
    for (int32_t y = 0; y < slice.height; ++y) {
        backends::unpack_row(slice, y, info.bits, codes.data());
        if (flip_x) std::reverse(codes.begin(), codes.end() - 1);
        uint8_t* row =
            rows.data() + (1 + row_bytes) * static_cast<size_t>(slice.height - 1 - y) + 1;
        if (info.bits == 8) {
            std::copy(codes.begin(), codes.end() - 1, row);
            continue;
        }
        for (size_t i = 0; i < row_bytes; ++i) {
            row[i] = static_cast<uint8_t>(codes[2 * i] << 4 | codes[2 * i + 1]);
        }
    }
    return rows;
}

}  // namespace

std::string slice_file_name(int32_t z, int32_t slices) {
    const size_t digits = std::max<size_t>(4, std::to_string(slices).size());
    return fmt::format("slice_{:0{}}.png", z + 1, digits);
}

std::vector<uint8_t> encode_slice(const backends::SliceView& slice, const backends::PrintInfo& info,
                                  const PngOptions& options) {
    const std::vector<uint8_t> rows = options.indexed ? index_rows(slice, info, options.flip_x)
                                                      : rgba_rows(slice, info, options.flip_x);
    PngImage image;
    image.width = slice.width;
    image.height = slice.height;
    image.color = options.indexed ? PngColor::kIndexed : PngColor::kRgba;
    image.bits = options.indexed ? info.bits : 8;
    image.rows = rows;
    if (options.indexed) {
        image.palette.push_back({0, 0, 0, 0});
        for (const backends::SliceMaterial& material : info.materials)
            image.palette.push_back(material.key);
    }
    image.pixels_per_metre_x = 1000 / info.pitch_mm.x;
    image.pixels_per_metre_y = 1000 / info.pitch_mm.y;
    return encode_png(image, kDeflateLevel);
}

Result<std::unique_ptr<backends::SliceSink>> PngSink::create(const std::filesystem::path& folder,
                                                             PngOptions options) {
    std::error_code status;
    if (std::filesystem::exists(folder, status) && !std::filesystem::is_directory(folder, status)) {
        return user_error(fmt::format("`{}` is a file; a folder of slices is to be written there",
                                      folder.string()));
    }
    std::filesystem::create_directories(folder, status);
    if (status) {
        return outside_error(
            fmt::format("cannot create the folder `{}`: {}", folder.string(), status.message()));
    }
    std::unique_ptr<PngSink> sink(new PngSink(folder, std::move(options)));
    if (Result<void> removed = sink->remove_earlier_print(); !removed) return removed.error();
    return std::unique_ptr<backends::SliceSink>(std::move(sink));
}

Result<void> PngSink::remove_earlier_print() {
    std::vector<std::filesystem::path> ours;
    std::error_code status;
    for (std::filesystem::directory_iterator entry(folder_, status), end; !status && entry != end;
         entry.increment(status)) {
        const std::string name = entry->path().filename().string();
        if (!is_slice_name(name) && !name.starts_with(kManifest) && !name.starts_with(kHandoff)) {
            return user_error(fmt::format(
                "`{}` holds `{}`, which is no part of a print; give an empty folder, or one "
                "with an earlier print",
                folder_.string(), name));
        }
        ours.push_back(entry->path());
    }
    for (const std::filesystem::path& file : ours) {
        if (!status) std::filesystem::remove(file, status);
    }
    if (status) {
        return outside_error(
            fmt::format("cannot empty the folder `{}`: {}", folder_.string(), status.message()));
    }
    return {};
}

Result<void> PngSink::write_notes(const backends::PrintTotals& totals) {
    const auto slices = static_cast<int32_t>(written_.size());
    Result<void> written = backends::write_whole_file(
        folder_ / kManifest, manifest_json(info_, totals, slices, options_));
    if (!written) return written;
    return backends::write_whole_file(folder_ / kHandoff,
                                      handoff_text(info_, totals, slices, options_));
}

Result<void> PngSink::begin(const backends::PrintInfo& info) {
    info_ = info;
    // From the start, so that a folder that a crash left says that it is not complete.
    return write_notes({});
}

std::vector<uint8_t> PngSink::encode(const backends::SliceView& slice) const {
    return encode_slice(slice, info_, options_);
}

Result<void> PngSink::commit(int32_t z, const std::vector<uint8_t>& bytes) {
    if (bytes.empty()) return internal_error(fmt::format("slice {} could not be compressed", z));
    const std::filesystem::path file = folder_ / slice_file_name(z, info_.size.z);
    if (Result<void> written = backends::write_whole_file(file, bytes); !written) {
        broken_ = true;
        return Error{written.error().code, fmt::format("{}; {} whole slices were written before",
                                                       written.error().message, written_.size())};
    }
    written_.push_back(file);
    return {};
}

Result<void> PngSink::finish(const backends::PrintTotals& totals) {
    backends::PrintTotals honest = totals;
    honest.complete = totals.complete && !broken_;
    for (const std::filesystem::path& file : written_) {
        Result<void> synced = backends::sync_file(file);
        if (synced) continue;
        if (!broken_) return synced;
        break;
    }
    Result<void> notes = write_notes(honest);
    if (notes) notes = backends::sync_file(folder_ / kManifest);
    if (notes) notes = backends::sync_file(folder_);
    // What went wrong before has been reported already, and is the reason for this too.
    return broken_ ? Result<void>() : notes;
}

}  // namespace openfab::raster
