// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/read/gcvf_print.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string_view>

#include "backends/common/tee_sink.h"
#include "backends/raster/png_slice.h"
#include "backends/read/messages.h"
#include "backends/read/png_pixels.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "base/xml.h"

namespace openfab::prints {

namespace {

using Rgba = std::array<uint8_t, 4>;

constexpr const char* kConfig = "ConfigFile.xml";
constexpr int64_t kMostConfigBytes = 1 << 20;
constexpr double kMostVoxels = 1 << 24;  ///< along an axis
constexpr size_t kMostMaterials = 254;
constexpr double kMillimetresAnInch = 25.4, kNanometresAMillimetre = 1e6;

struct Material {
    std::string name, rgba, voxels;
};

/// Takes the text of each element by its name, and of materials one after the other.
class Config final : public XmlHandler {
  public:
    std::map<std::string, std::string, std::less<>> texts;
    std::vector<Material> materials;

    Complaint start(std::string_view name, const XmlAttributes&) override {
        if (name == "Material") materials.emplace_back(), in_material_ = true;
        text_.clear();
        return {};
    }
    void end(std::string_view name) override {
        const std::string_view words = trimmed(text_);
        if (name == "Material") {
            in_material_ = false;
        } else if (!in_material_) {
            texts.try_emplace(std::string(name), words);
        } else if (name == "Name") {
            materials.back().name = words;
        } else if (name == "RGBA") {
            materials.back().rgba = words;
        } else if (name == "VoxelCount") {
            materials.back().voxels = words;
        }
        text_.clear();
    }
    bool wants_text() const override { return true; }
    void text(std::string_view piece) override { text_ += piece; }

    std::string_view find(std::string_view name) const {
        const auto at = texts.find(name);
        return at == texts.end() ? std::string_view() : at->second;
    }

  private:
    static std::string_view trimmed(std::string_view text) {
        constexpr std::string_view kBlanks = " \t\r\n";
        text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
        return text.substr(0, text.find_last_not_of(kBlanks) + 1);
    }

    std::string text_;
    bool in_material_ = false;
};

/// Reads the comment of ours in a configuration; none in those of others.
std::optional<PrintFile::Note> read_note(const std::string& config) {
    const size_t at = config.find("<!-- openfab ");
    if (at == std::string::npos) return {};
    PrintFile::Note note;
    int flipped = 0;
    const int read = std::sscanf(
        config.c_str() + at,
        "<!-- openfab slices=\"%d:%d\" of=\"%d\" flipped=\"%d\" hash=\"%" SCNx64 "\" -->",
        &note.slice_begin, &note.slice_end, &note.slices_of_whole, &flipped, &note.hash);
    note.flipped_x = flipped != 0;
    const bool fits = note.slice_begin >= 0 && note.slice_end > note.slice_begin &&
                      note.slices_of_whole >= note.slice_end;
    constexpr int kFields = 5;
    return read == kFields && fits ? std::optional(note) : std::nullopt;
}

/// Reads `r g b a`.
bool read_color(std::string_view text, Rgba* out) {
    const char* at = text.data();
    const char* const end = at + text.size();
    for (uint8_t& value : *out) {
        while (at != end && *at == ' ')
            ++at;
        const auto [next, failed] = std::from_chars(at, end, value);
        if (failed != std::errc{}) return false;
        at = next;
    }
    return at == end;
}

bool read_number(std::string_view text, double least, double most, double* out) {
    return scan_number(text, out).empty() && *out >= least && *out <= most;
}

bool read_count(std::string_view text, double least, double most, double* out) {
    return read_number(text, least, most, out) && *out == std::floor(*out);
}

/// Finds the code of a colour; pictures without opacity tell colours alone. Nothing for that of no material.
class Codes {
  public:
    Codes(const pipeline::PrintInfo& info, const Rgba& background, bool has_alpha)
        : info_(info), background_(background), compared_(has_alpha ? 4 : 3) {}

    std::optional<uint8_t> of(const uint8_t* rgba) const {
        for (size_t m = 0; m < info_.materials.size(); ++m) {
            if (std::equal(rgba, rgba + compared_, info_.materials[m].key.begin()))
                return static_cast<uint8_t>(m + 1);
        }
        constexpr size_t kAlpha = 3;
        if (std::equal(rgba, rgba + compared_, background_.begin()) || rgba[kAlpha] == 0) return 0;
        return {};
    }

  private:
    const pipeline::PrintInfo& info_;
    const Rgba& background_;
    std::ptrdiff_t compared_;
};

}  // namespace

bool is_gcvf(const std::string& path) {
    return lower_ascii(std::filesystem::path(path).extension().string()) == ".gcvf";
}

Result<std::unique_ptr<PrintFile>> GcvfPrint::open(const std::string& path, int64_t memory_bytes) {
    std::unique_ptr<GcvfPrint> print(new GcvfPrint(path));
    if (Result<void> mapped = print->map_file(); !mapped) return mapped.error();
    if (Result<void> read = print->read_config(); !read) return read.error();
    // A picture and its file, its pixels in four bytes, and packed rows.
    constexpr int64_t kBytesAPixel = 4 + 4 + 1;
    const int64_t pixels = int64_t{print->info_.size.x} * print->info_.size.y;
    if (Result<void> fits = print->check_memory(pixels * kBytesAPixel, memory_bytes); !fits)
        return fits.error();
    const int32_t planned = print->info_.size.z;
    while (print->whole_ < planned && print->zip_->has(print->slice_name(print->whole_)))
        ++print->whole_;
    if (print->totals_ && print->whole_ < planned) print->totals_.reset();
    return std::unique_ptr<PrintFile>(std::move(print));
}

GcvfPrint::~GcvfPrint() {
    if (!bytes_.empty()) ::munmap(const_cast<char*>(bytes_.data()), bytes_.size());
}

Result<void> GcvfPrint::map_file() {
    Result<InputFile> file = InputFile::open(path_);
    if (!file) return with_context(file.error(), fmt::format(messages::kCannotOpen, path_));
    file_.emplace(std::move(*file));
    const auto size = static_cast<size_t>(file_->bytes());
    void* const mapping =
        size == 0 ? MAP_FAILED
                  : ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file_->descriptor(), 0);
    if (mapping == MAP_FAILED)
        return error(fmt::format(messages::kNoGcvf, messages::kConfigMissing));
    bytes_ = {static_cast<const char*>(mapping), size};
    Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes_, path_);
    if (!zip) return zip.error();
    zip_.emplace(std::move(*zip));
    return {};
}

Result<void> GcvfPrint::read_config() {
    if (!zip_->has(kConfig)) return error(fmt::format(messages::kNoGcvf, messages::kConfigMissing));
    const Result<std::string> text = zip_->read(kConfig, kMostConfigBytes);
    if (!text) return text.error();
    Config config;
    if (Result<void> parsed = parse_xml(*text, path_ + "/" + kConfig, &config); !parsed)
        return parsed;
    const auto lacks = [&](const char* name) {
        return error(fmt::format(messages::kNoGcvf, fmt::format(messages::kConfigLacks, name)));
    };
    std::array<double, 3> size{}, resolution{};
    constexpr std::array kSizes{"SliceWidth", "SliceHeight", "NumberOfSlices"};
    constexpr std::array kResolutions{"XDpi", "YDpi", "SliceThicknessNanoMeter"};
    constexpr double kFinest = 1e6;  // dpi; and nanometres of the thickest layer
    for (size_t a = 0; a < 3; ++a) {
        if (!read_count(config.find(kSizes[a]), 1, kMostVoxels, &size[a])) return lacks(kSizes[a]);
        if (!read_number(config.find(kResolutions[a]), 1, 100 * kFinest, &resolution[a]))
            return lacks(kResolutions[a]);
    }
    double first = 0;
    if (!config.find("StartIndex").empty() &&
        !read_count(config.find("StartIndex"), 0, kMostVoxels, &first))
        return lacks("StartIndex");
    const std::string_view kind = config.find("DataSemantics");
    if (!kind.empty() && kind != "Materials")
        return error(fmt::format(messages::kNotOfMaterials, printable(kind)));
    if (!config.find("BackGroundMaterialRGBA").empty() &&
        !read_color(config.find("BackGroundMaterialRGBA"), &background_))
        return lacks("BackGroundMaterialRGBA");
    info_.size = {static_cast<int32_t>(size[0]), static_cast<int32_t>(size[1]),
                  static_cast<int32_t>(size[2])};
    info_.pitch_mm = {kMillimetresAnInch / resolution[0], kMillimetresAnInch / resolution[1],
                      resolution[2] / kNanometresAMillimetre};
    info_.slice_end = info_.size.z;
    note_ = read_note(*text);
    if (note_ && note_->slice_end - note_->slice_begin != info_.size.z)
        return lacks("NumberOfSlices");
    info_.title = std::filesystem::path(path_).stem().string();
    first_name_ = static_cast<int32_t>(first);
    prefix_ = config.find("ImageFilePrefix");
    if (config.materials.size() > kMostMaterials) return lacks("MaterialList");
    pipeline::PrintTotals totals;
    totals.complete = true;
    totals.voxels_by_code = {int64_t{info_.size.x} * info_.size.y * info_.size.z};
    bool counted = true;
    for (const Material& material : config.materials) {
        pipeline::SliceMaterial& made = info_.materials.emplace_back();
        made.name = material.name;
        if (!read_color(material.rgba, &made.key)) return lacks("RGBA");
        made.preview = made.key;
        constexpr double kMostCounted = 9e15;
        double voxels = 0;
        counted = counted && read_count(material.voxels, 0, kMostCounted, &voxels);
        totals.voxels_by_code.push_back(static_cast<int64_t>(voxels));
        totals.voxels_by_code[0] -= totals.voxels_by_code.back();
        totals.voxels_solid += totals.voxels_by_code.back();
    }
    if (raster::shares_a_color(info_)) return error(messages::kMaterialsOfOneColour);
    totals.tight = {{0, 0, 0}, info_.size};
    if (counted) totals_ = std::move(totals);
    constexpr size_t kMostOfFourBits = 15;
    info_.bits = info_.materials.size() > kMostOfFourBits ? 8 : 4;
    row_bytes_ = backends::packed_row_bytes(info_.size.x, info_.bits);
    return {};
}

std::string GcvfPrint::slice_name(int32_t z) const {
    return fmt::format("{}{}.png", prefix_, first_name_ + z);
}

bool GcvfPrint::was_replaced() const {
    struct stat there {
    }, opened{};
    if (::stat(path_.c_str(), &there) != 0 || ::fstat(file_->descriptor(), &opened) != 0)
        return true;
    return there.st_ino != opened.st_ino || there.st_dev != opened.st_dev;
}

Result<void> GcvfPrint::read_slice(int32_t z, SliceBuffers* buffers) const {
    if (z < 0 || z >= whole_) return error(fmt::format(messages::kSliceNotThere, z));
    // No picture of so many pixels is larger: they are deflated, or stored.
    const int64_t most = int64_t{8} * info_.size.x * info_.size.y + (1 << 20);
    const Result<std::string> file = zip_->read(slice_name(z), most);
    if (!file) return error(fmt::format(messages::kSliceIsNoPicture, z, file.error().message));
    const Result<PngPixels> picture = read_png_pixels(*file, {info_.size.x, info_.size.y});
    if (!picture)
        return error(fmt::format(messages::kSliceIsNoPicture, z, picture.error().message));
    const Codes codes(info_, background_, picture->has_alpha);
    buffers->rows.assign(row_bytes_ * static_cast<size_t>(info_.size.y), 0);
    const uint8_t* pixel = picture->rgba.data();
    const uint8_t* known = nullptr;  // the pixel before, whose code is `code`
    uint8_t code = 0;
    std::vector<uint8_t> row(static_cast<size_t>(info_.size.x));
    for (int32_t y = 0; y < info_.size.y; ++y) {
        for (int32_t x = 0; x < info_.size.x; ++x, pixel += 4) {
            if (known == nullptr || !std::equal(pixel, pixel + 4, known)) {
                const std::optional<uint8_t> other = codes.of(pixel);
                if (!other)
                    return error(fmt::format(messages::kColourOfNoMaterial, z, pixel[0], pixel[1],
                                             pixel[2], pixel[3], x, y));
                code = *other;
            }
            known = pixel;
            row[static_cast<size_t>(x)] = code;
        }
        // Pictures have their highest row first.
        const auto from_below = static_cast<size_t>(info_.size.y - 1 - y);
        backends::pack_row(row, info_.bits, buffers->rows.data() + row_bytes_ * from_below);
    }
    return {};
}

}  // namespace openfab::prints
