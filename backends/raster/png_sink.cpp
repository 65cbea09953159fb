// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/png_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <system_error>

#include "backends/common/output_file.h"
#include "backends/common/resume_check.h"
#include "backends/common/tee_sink.h"
#include "backends/raster/png_encode.h"
#include "base/check.h"
#include "base/units.h"

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

std::vector<uint8_t> rgba_rows(const pipeline::SliceView& slice, const pipeline::PrintInfo& info,
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

std::vector<uint8_t> index_rows(const pipeline::SliceView& slice, const pipeline::PrintInfo& info,
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

/// Makes the image of a slice without its rows.
PngImage image_of(const pipeline::PrintInfo& info, const PngOptions& options) {
    PngImage image;
    image.width = info.size.x;
    image.height = info.size.y;
    image.color = options.indexed ? PngColor::kIndexed : PngColor::kRgba;
    image.bits = options.indexed ? info.bits : 8;
    if (options.indexed) {
        image.palette.push_back({0, 0, 0, 0});
        for (const pipeline::SliceMaterial& material : info.materials)
            image.palette.push_back(material.key);
    }
    image.pixels_per_metre_x = 1000 / info.pitch_mm.x;
    image.pixels_per_metre_y = 1000 / info.pitch_mm.y;
    return image;
}

/// Codes by colour, in memory byte order; fewer entries than codes if two share a colour.
std::map<uint32_t, uint8_t> codes_by_color(const pipeline::PrintInfo& info) {
    std::map<uint32_t, uint8_t> codes{{0, 0}};
    for (size_t i = 0; i < info.materials.size(); ++i) {
        uint32_t color = 0;
        std::memcpy(&color, info.materials[i].key.data(), 4);
        codes.emplace(color, static_cast<uint8_t>(i + 1));
    }
    return codes;
}

/// Decodes a row of pixels without its filter byte; returns false for a colour of no material.
bool read_rgba(const uint8_t* row, const std::map<uint32_t, uint8_t>& codes,
               std::vector<uint8_t>* out) {
    auto last = codes.begin();
    for (size_t x = 0; x < out->size(); ++x) {
        uint32_t color = 0;
        std::memcpy(&color, row + 4 * x, 4);
        if (color != last->first) last = codes.find(color);
        if (last == codes.end()) return false;
        (*out)[x] = last->second;
    }
    return true;
}

bool read_indices(const uint8_t* row, const pipeline::PrintInfo& info, std::vector<uint8_t>* out) {
    for (size_t x = 0; x < out->size(); ++x) {
        (*out)[x] =
            info.bits == 8 ? row[x] : static_cast<uint8_t>(row[x / 2] >> (x % 2 == 0 ? 4 : 0) & 15);
        if ((*out)[x] > info.materials.size()) return false;
    }
    return true;
}

/// Reads a file; empty where it does not exist, an error where it cannot be read.
Result<std::vector<uint8_t>> read_bytes(const std::filesystem::path& file) {
    std::error_code status;
    if (!std::filesystem::exists(file, status)) return std::vector<uint8_t>();
    std::ifstream in(file, std::ios::binary);
    std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
    if (!in || in.bad()) return outside_error(fmt::format("cannot read `{}`", file.string()));
    return bytes;
}

}  // namespace

std::string slice_file_name(int32_t z, int32_t slices) {
    const size_t digits = std::max<size_t>(4, std::to_string(slices).size());
    return fmt::format("slice_{:0{}}.png", z + 1, digits);
}

bool is_folder_file(const std::string& name) {
    return is_slice_name(name) || name.starts_with(kManifest) || name.starts_with(kHandoff);
}

std::vector<uint8_t> encode_slice(const pipeline::SliceView& slice, const pipeline::PrintInfo& info,
                                  const PngOptions& options) {
    const std::vector<uint8_t> rows = options.indexed ? index_rows(slice, info, options.flip_x)
                                                      : rgba_rows(slice, info, options.flip_x);
    PngImage image = image_of(info, options);
    image.rows = rows;
    return encode_png(image, kDeflateLevel);
}

std::vector<uint8_t> decode_slice(std::span<const uint8_t> file, const pipeline::PrintInfo& info,
                                  const PngOptions& options) {
    const std::vector<uint8_t> pixels = decode_png(file, image_of(info, options));
    if (pixels.empty()) return {};
    const std::map<uint32_t, uint8_t> codes = codes_by_color(info);
    const auto height = static_cast<size_t>(info.size.y);
    const size_t stride = pixels.size() / height;
    const size_t row_bytes = backends::packed_row_bytes(info.size.x, info.bits);
    std::vector<uint8_t> rows(row_bytes * height);
    std::vector<uint8_t> row(static_cast<size_t>(info.size.x));
    for (size_t y = 0; y < height; ++y) {
        const uint8_t* from = pixels.data() + stride * (height - 1 - y);
        if (*from != 0) return {};
        if (!(options.indexed ? read_indices(from + 1, info, &row)
                              : read_rgba(from + 1, codes, &row)))
            return {};
        if (options.flip_x) std::reverse(row.begin(), row.end());
        uint8_t* to = rows.data() + row_bytes * y;
        for (size_t x = 0; x < row.size(); ++x) {
            if (info.bits == 8) {
                to[x] = row[x];
            } else {
                to[x / 2] = static_cast<uint8_t>(to[x / 2] | row[x] << (x % 2 == 0 ? 0 : 4));
            }
        }
    }
    return rows;
}

Result<std::unique_ptr<pipeline::SliceSink>> PngSink::open(const std::filesystem::path& folder,
                                                           PngOptions options, bool reopened) {
    std::error_code status;
    if (std::filesystem::exists(folder, status) && !std::filesystem::is_directory(folder, status)) {
        return user_error(
            fmt::format("`{}` is a file; the output is a folder of slices", folder.string()));
    }
    std::filesystem::create_directories(folder, status);
    if (status) {
        return outside_error(
            fmt::format("cannot create the folder `{}`: {}", folder.string(), status.message()));
    }
    Result<backends::FolderLock> lock = backends::FolderLock::take(folder.string());
    if (!lock) return lock.error();
    std::unique_ptr<PngSink> sink(new PngSink(folder, std::move(options), std::move(*lock)));
    const Result<std::vector<std::filesystem::path>> files = sink->files();
    if (!files) return files.error();
    if (reopened) {
        sink->earlier_ = !files->empty();
    } else if (Result<void> removed = sink->remove(*files); !removed) {
        return removed.error();
    }
    return std::unique_ptr<pipeline::SliceSink>(std::move(sink));
}

Result<std::unique_ptr<pipeline::SliceSink>> PngSink::create(const std::filesystem::path& folder,
                                                             PngOptions options) {
    return open(folder, std::move(options), false);
}

Result<std::unique_ptr<pipeline::SliceSink>> PngSink::reopen(const std::filesystem::path& folder,
                                                             PngOptions options) {
    return open(folder, std::move(options), true);
}

Result<std::vector<std::filesystem::path>> PngSink::files() const {
    std::vector<std::filesystem::path> ours;
    std::error_code status;
    for (std::filesystem::directory_iterator entry(folder_, status), end; !status && entry != end;
         entry.increment(status)) {
        const std::string name = entry->path().filename().string();
        if (!is_folder_file(name)) {
            return user_error(fmt::format(
                "`{}` holds `{}`, which is not part of a print; give an empty folder, or one "
                "with an earlier print",
                folder_.string(), name));
        }
        ours.push_back(entry->path());
    }
    if (status) {
        return outside_error(
            fmt::format("cannot read the folder `{}`: {}", folder_.string(), status.message()));
    }
    return ours;
}

Result<void> PngSink::remove(const std::vector<std::filesystem::path>& files) const {
    for (const std::filesystem::path& file : files) {
        std::error_code status;
        std::filesystem::remove(file, status);
        if (status) {
            return outside_error(
                fmt::format("cannot remove `{}`: {}", file.string(), status.message()));
        }
    }
    return {};
}

Result<void> PngSink::write_notes(const pipeline::PrintTotals& totals) {
    const auto slices = static_cast<int32_t>(written_.size());
    Result<void> written = backends::write_whole_file(
        folder_ / kManifest, manifest_json(info_, totals, slices, options_));
    if (!written) return written;
    return backends::write_whole_file(folder_ / kHandoff,
                                      handoff_text(info_, totals, slices, options_));
}

Result<void> PngSink::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    if (!earlier_) return write_notes({});  // a crash leaves it incomplete
    const Result<std::vector<uint8_t>> manifest = read_bytes(folder_ / kManifest);
    if (!manifest) return manifest.error();
    if (manifest->empty()) {
        const Result<std::vector<std::filesystem::path>> found = files();
        if (!found) return found.error();
        const bool slices = std::any_of(found->begin(), found->end(), [](const auto& file) {
            return is_slice_name(file.filename().string());
        });
        // The print was killed right at its start: nothing is lost by starting over.
        if (!slices) return {};
        return backends::resume_refused(folder_.string(),
                                        fmt::format("it has slices and no {}", kManifest));
    }
    const std::string why =
        manifest_difference({manifest->begin(), manifest->end()}, info_, options_);
    if (!why.empty()) return backends::resume_refused(folder_.string(), why);
    if (!options_.indexed && codes_by_color(info_).size() != info_.materials.size() + 1) {
        return backends::resume_refused(folder_.string(),
                                        "two of its materials look the same in the slices");
    }
    return {};
}

Result<int32_t> PngSink::resume(const std::function<bool(const pipeline::SliceView&)>& show) {
    if (!earlier_) return 0;
    const size_t row_bytes = backends::packed_row_bytes(info_.size.x, info_.bits);
    std::vector<std::filesystem::path> kept;
    for (int32_t z = info_.slice_begin; z < info_.slice_end; ++z) {
        const std::filesystem::path file = folder_ / slice_file_name(z, info_.size.z);
        const Result<std::vector<uint8_t>> bytes = read_bytes(file);
        if (!bytes) return bytes.error();
        const std::vector<uint8_t> rows = decode_slice(*bytes, info_, options_);
        if (rows.empty()) break;
        kept.push_back(file);
        if (!show({z, rows.data(), row_bytes, info_.size.x, info_.size.y})) {
            return Error{ErrorCode::kInterrupted,
                         fmt::format("interrupted while `{}` was read; nothing was changed",
                                     folder_.string())};
        }
    }
    const bool complete = static_cast<int32_t>(kept.size()) == info_.slice_end - info_.slice_begin;
    Result<std::vector<std::filesystem::path>> rest = files();
    if (!rest) return rest.error();
    std::erase_if(*rest, [&](const std::filesystem::path& file) {
        const std::string name = file.filename().string();
        return name == kManifest || name == kHandoff ||
               std::find(kept.begin(), kept.end(), file) != kept.end();
    });
    if (Result<void> removed = remove(*rest); !removed) return removed.error();
    earlier_ = false;
    written_ = std::move(kept);
    // The manifest of a complete print must not stay once slices of it are gone.
    if (!complete) {
        if (Result<void> noted = write_notes({}); !noted) return noted.error();
    }
    return static_cast<int32_t>(written_.size());
}

std::vector<uint8_t> PngSink::encode(const pipeline::SliceView& slice) const {
    return encode_slice(slice, info_, options_);
}

Error PngSink::with_resume_state(const Error& error, size_t slice_bytes) const {
    const auto left = static_cast<double>(info_.slice_end - info_.slice_begin) -
                      static_cast<double>(written_.size());
    return {
        error.code,
        fmt::format("{}; {} whole slices were written before, the rest takes about {}",
                    error.text(), written_.size(),
                    format_bytes(static_cast<int64_t>(left * static_cast<double>(slice_bytes))))};
}

Result<void> PngSink::commit(int32_t z, const std::vector<uint8_t>& bytes) {
    if (bytes.empty()) return internal_error(fmt::format("slice {} could not be compressed", z));
    OPENFAB_CHECK(z >= 0 && z < info_.size.z);
    const std::filesystem::path file = folder_ / slice_file_name(z, info_.size.z);
    if (Result<void> written = backends::write_whole_file(file, bytes); !written) {
        broken_ = true;
        return with_resume_state(written.error(), bytes.size());
    }
    written_.push_back(file);
    return {};
}

Result<void> PngSink::finish(const pipeline::PrintTotals& totals) {
    if (earlier_) return {};  // refused or interrupted before anything was changed
    pipeline::PrintTotals honest = totals;
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
    // An earlier error has been reported already and caused this one, too.
    return broken_ ? Result<void>() : notes;
}

}  // namespace openfab::raster
