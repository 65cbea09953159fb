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

/// The pixels of every byte of packed rows at 4 bits, the left one first.
using PixelPairs = std::array<std::array<uint32_t, 2>, 256>;

/// Writes the rows of slices as pixels, the largest y first.
class PixelRows {
  public:
    PixelRows(const pipeline::SliceView& slice, const pipeline::PrintInfo& info,
              const PngOptions& options)
        : slice_(slice),
          options_(options),
          bits_(info.bits),
          codes_(static_cast<size_t>(slice.width) + 1) {
        for (size_t i = 0; i < info.materials.size(); ++i)
            std::memcpy(&colors_[i + 1], info.materials[i].key.data(), 4);
        for (size_t byte = 0; byte < pairs_.size(); ++byte)
            pairs_[byte] = {colors_[byte & 15], colors_[byte >> 4]};
    }

    void put(int32_t row, uint8_t* out) {
        const int32_t y = slice_.height - 1 - row;
        const uint8_t* packed = slice_.data + static_cast<size_t>(y) * slice_.row_bytes;
        if (bits_ == 4 && !options_.flip_x) {
            options_.indexed ? swap_halves(packed, out) : put_pairs(packed, out);
            return;
        }
        backends::unpack_row(slice_, y, bits_, codes_.data());
        if (options_.flip_x) std::reverse(codes_.begin(), codes_.end() - 1);
        options_.indexed ? put_indices(out) : put_colors(out);
    }

  private:
    // Most of a slice repeats, 16 pixels at a time.
    void put_pairs(const uint8_t* packed, uint8_t* out) const {
        constexpr size_t kBytes = 8, kPixelBytes = 2 * sizeof(uint32_t) * kBytes;
        const auto width = static_cast<size_t>(slice_.width);
        size_t i = 0;
        while (i + kBytes <= width / 2) {
            for (size_t k = 0; k < kBytes; ++k)
                std::memcpy(out + 8 * k, pairs_[packed[i + k]].data(), 8);
            uint64_t these = 0, next = 0;
            std::memcpy(&these, packed + i, kBytes);
            size_t repeats = 0;
            for (i += kBytes; i + kBytes <= width / 2; i += kBytes, ++repeats) {
                std::memcpy(&next, packed + i, kBytes);
                if (next != these) break;
            }
            repeat(out, kPixelBytes, repeats);
            out += kPixelBytes * (1 + repeats);
        }
        for (; i < width / 2; ++i, out += 8)
            std::memcpy(out, pairs_[packed[i]].data(), 8);
        if (width % 2 != 0) std::memcpy(out, pairs_[packed[i]].data(), 4);
    }
    /// Repeats the first `bytes` so many times more.
    static void repeat(uint8_t* out, size_t bytes, size_t times) {
        const size_t all = bytes * (1 + times);
        for (size_t have = bytes; have < all;) {
            const size_t more = std::min(have, all - have);
            std::memcpy(out + have, out, more);
            have += more;
        }
    }
    /// The first pixel of a byte is in its low half in packed rows and in its high one in PNGs.
    void swap_halves(const uint8_t* packed, uint8_t* out) const {
        constexpr uint64_t kLow = 0x0f0f0f0f0f0f0f0f;
        size_t i = 0;
        for (; i + 8 <= slice_.row_bytes; i += 8) {
            uint64_t eight = 0;
            std::memcpy(&eight, packed + i, 8);
            eight = (eight & kLow) << 4 | (eight >> 4 & kLow);
            std::memcpy(out + i, &eight, 8);
        }
        for (; i < slice_.row_bytes; ++i)
            out[i] = static_cast<uint8_t>(packed[i] << 4 | packed[i] >> 4);
    }
    void put_colors(uint8_t* out) const {
        for (size_t x = 0; x + 1 < codes_.size(); ++x)
            std::memcpy(out + 4 * x, &colors_[codes_[x]], 4);
    }
    void put_indices(uint8_t* out) const {
        if (bits_ == 8) {
            std::copy(codes_.begin(), codes_.end() - 1, out);
            return;
        }
        for (size_t i = 0; i < slice_.row_bytes; ++i)
            out[i] = static_cast<uint8_t>(codes_[2 * i] << 4 | codes_[2 * i + 1]);
    }

    const pipeline::SliceView& slice_;
    const PngOptions& options_;
    int32_t bits_;
    std::array<uint32_t, 256> colors_{};  ///< as bytes lie in memory; void is 0
    PixelPairs pairs_{};
    std::vector<uint8_t> codes_;  ///< of a row, and a void one for the unused half of an odd row
};

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
    PixelRows pixels(slice, info, options);
    return encode_png_rows(image_of(info, options),
                           [&](int32_t row, uint8_t* out) { pixels.put(row, out); });
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
    Result<backends::OutputFolder> opened = backends::OutputFolder::open(folder);
    if (!opened) return opened.error();
    std::unique_ptr<PngSink> sink(new PngSink(std::move(*opened), std::move(options)));
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
    for (std::filesystem::directory_iterator entry(folder_.path(), status), end;
         !status && entry != end; entry.increment(status)) {
        const std::string name = entry->path().filename().string();
        if (!is_folder_file(name)) {
            return user_error(fmt::format(
                "`{}` holds `{}`, which is not part of a print; give an empty folder, or one "
                "with an earlier print",
                folder_.path().string(), name));
        }
        ours.push_back(entry->path());
    }
    if (status) {
        return outside_error(fmt::format("cannot read the folder `{}`: {}", folder_.path().string(),
                                         status.message()));
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
    const auto write = [this](const char* name, const std::string& text) {
        return folder_.write(name, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    };
    Result<void> written = write(kManifest, manifest_json(info_, totals, written_, options_));
    return written ? write(kHandoff, handoff_text(info_, totals, written_, options_)) : written;
}

Result<void> PngSink::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    if (!earlier_) return write_notes({});  // a crash leaves it incomplete
    const Result<std::vector<uint8_t>> manifest = read_bytes(folder_.path() / kManifest);
    if (!manifest) return manifest.error();
    if (manifest->empty()) {
        const Result<std::vector<std::filesystem::path>> found = files();
        if (!found) return found.error();
        const bool slices = std::any_of(found->begin(), found->end(), [](const auto& file) {
            return is_slice_name(file.filename().string());
        });
        // The print was killed right at its start: nothing is lost by starting over.
        if (!slices) return {};
        return backends::resume_refused(folder_.path().string(),
                                        fmt::format("it has slices and no {}", kManifest));
    }
    const std::string why =
        manifest_difference({manifest->begin(), manifest->end()}, info_, options_);
    if (!why.empty()) return backends::resume_refused(folder_.path().string(), why);
    if (!options_.indexed && codes_by_color(info_).size() != info_.materials.size() + 1) {
        return backends::resume_refused(folder_.path().string(),
                                        "two of its materials look the same in the slices");
    }
    return {};
}

Result<int32_t> PngSink::resume(const std::function<bool(const pipeline::SliceView&)>& show) {
    if (!earlier_) return 0;
    const size_t row_bytes = backends::packed_row_bytes(info_.size.x, info_.bits);
    std::vector<std::filesystem::path> kept;
    for (int32_t z = info_.slice_begin; z < info_.slice_end; ++z) {
        const std::filesystem::path file = folder_.path() / slice_file_name(z, info_.size.z);
        const Result<std::vector<uint8_t>> bytes = read_bytes(file);
        if (!bytes) return bytes.error();
        const std::vector<uint8_t> rows = decode_slice(*bytes, info_, options_);
        if (rows.empty()) break;
        kept.push_back(file);
        if (!show({z, rows.data(), row_bytes, info_.size.x, info_.size.y})) {
            return Error{ErrorCode::kInterrupted,
                         fmt::format("interrupted while `{}` was read; nothing was changed",
                                     folder_.path().string())};
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
    written_ = static_cast<int32_t>(kept.size());
    // The manifest of a complete print must not stay once slices of it are gone.
    if (!complete) {
        if (Result<void> noted = write_notes({}); !noted) return noted.error();
    }
    return written_;
}

std::vector<uint8_t> PngSink::encode(const pipeline::SliceView& slice) const {
    return encode_slice(slice, info_, options_);
}

Error PngSink::with_resume_state(const Error& error, size_t slice_bytes) const {
    const double left = info_.slice_end - info_.slice_begin - written_;
    return {
        error.code,
        fmt::format("{}; {} whole slices were written before, the rest takes about {}",
                    error.text(), written_,
                    format_bytes(static_cast<int64_t>(left * static_cast<double>(slice_bytes))))};
}

Result<void> PngSink::commit(int32_t z, const std::vector<uint8_t>& bytes) {
    if (bytes.empty()) return internal_error(fmt::format("slice {} could not be compressed", z));
    OPENFAB_CHECK(z >= 0 && z < info_.size.z);
    const std::string file = slice_file_name(z, info_.size.z);
    if (Result<void> written = folder_.write(file, bytes); !written) {
        broken_ = true;
        return with_resume_state(written.error(), bytes.size());
    }
    ++written_;
    return {};
}

Result<void> PngSink::finish(const pipeline::PrintTotals& totals) {
    if (earlier_) return {};  // refused or interrupted before anything was changed
    pipeline::PrintTotals honest = totals;
    honest.complete = totals.complete && !broken_;
    // The notes after the slices: a manifest that says that all are there must be true, whenever
    // the power fails. Those of an interrupted print that were kept are synced with the others.
    Result<void> done = folder_.sync();
    if (done || broken_) done = write_notes(honest);
    if (done) done = folder_.sync();
    // An earlier error has been reported already, and is the cause of this one, too.
    return broken_ ? Result<void>() : done;
}

}  // namespace openfab::raster
