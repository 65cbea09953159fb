// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/exr_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

/// Behind the magic number and the version.
constexpr int64_t kFirst = 8;
/// Of the version: a file of several parts, each of which has a header.
constexpr uint8_t kManyParts = 0x10;
/// Of name and type each, with the zero at its end.
constexpr size_t kLongestName = 256;

int32_t int_at(const char* bytes) {
    int32_t value = 0;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

/// Takes a text that ends with a zero off the front.
std::optional<std::string_view> take_text(std::string_view* bytes) {
    const size_t end = bytes->substr(0, kLongestName).find('\0');
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view text = bytes->substr(0, end);
    bytes->remove_prefix(end + 1);
    return text;
}

struct Part {
    double width = 0, height = 0;
    double tile_width = 0, tile_height = 0;  ///< 0 for lines
    double pixel_bytes = 0;
    double lines = 1;  ///< that are packed together
    int compression = 0;

    double bytes() const { return table_bytes() + kBuffers * width * pixel_bytes * lines; }

  private:
    /// Of lines that are packed together: unpacked, and twice what unpacking takes.
    static constexpr double kBuffers = 3;

    double table_bytes() const {
        // The offset of each, and two sizes of a line; levels of tiles are four times as many at
        // most.
        constexpr double kLine = 24, kTile = 4 * 8;
        if (tile_width < 1 || tile_height < 1) return height * kLine;
        return (width / tile_width + 1) * (height / tile_height + 1) * kTile;
    }
};

void read_attribute(std::string_view name, std::string_view value, Part* part) {
    if (name == "dataWindow" && value.size() >= 16) {
        const auto side = [&](size_t low) {
            const double last = int_at(value.data() + low + 8), first = int_at(value.data() + low);
            return std::max(last - first + 1, 0.0);
        };
        part->width = side(0);
        part->height = side(4);
    } else if (name == "compression" && !value.empty()) {
        constexpr std::array<double, 10> kLines{1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
        const auto how = static_cast<uint8_t>(value[0]);
        part->compression = how;
        part->lines = how < kLines.size() ? kLines[how] : kLines.back();
    } else if (name == "tiles" && value.size() >= 8) {
        part->tile_width = int_at(value.data());
        part->tile_height = int_at(value.data() + 4);
    }
}

/// The bytes of a value that has always as many. OpenEXR reads these whatever the file says, and takes what is behind
/// them for the next attribute.
struct FixedSize {
    std::string_view type;
    int64_t bytes;
};
constexpr FixedSize kFixedSizes[] = {{"box2f", 16},
                                     {"box2i", 16},
                                     {"chromaticities", 32},
                                     {"compression", 1},
                                     {"deepImageState", 1},
                                     {"double", 8},
                                     {"envmap", 1},
                                     {"float", 4},
                                     {"int", 4},
                                     {"keycode", 28},
                                     {"lineOrder", 1},
                                     {"m33d", 72},
                                     {"m33f", 36},
                                     {"m44d", 128},
                                     {"m44f", 64},
                                     {"rational", 8},
                                     {"tiledesc", 9},
                                     {"timecode", 8},
                                     {"v2d", 16},
                                     {"v2f", 8},
                                     {"v2i", 8},
                                     {"v3d", 24},
                                     {"v3f", 12},
                                     {"v3i", 12}};

/// Whether a list of channels ends where it should: it is read up to an empty name.
bool ends_as_channels(std::string_view value) {
    constexpr size_t kNumbers = 16;
    for (;;) {
        const auto name = take_text(&value);
        if (!name) return false;
        if (name->empty()) return value.empty();
        if (value.size() < kNumbers) return false;
        value.remove_prefix(kNumbers);
    }
}

bool ends_as_texts(std::string_view value) {
    while (value.size() >= sizeof(int32_t)) {
        const int32_t bytes = int_at(value.data());
        value.remove_prefix(sizeof(int32_t));
        if (bytes < 0 || static_cast<size_t>(bytes) > value.size()) return false;
        value.remove_prefix(static_cast<size_t>(bytes));
    }
    return value.empty();
}

bool ends_as_preview(std::string_view value) {
    constexpr size_t kSides = 8, kPixel = 4;
    if (value.size() < kSides) return false;
    const auto side = [&](size_t at) {
        return static_cast<double>(static_cast<uint32_t>(int_at(value.data() + at)));
    };
    const double pixels = side(0) * side(4);
    return pixels * kPixel == static_cast<double>(value.size() - kSides);
}

/// Whether a value of a type is as long as the file says.
Result<bool> ends_as_it_says(const InputFile& file, int64_t at, int64_t size,
                             std::string_view type) {
    for (const FixedSize& fixed : kFixedSizes) {
        if (type == fixed.type) return size == fixed.bytes;
    }
    const auto ends = type == "chlist"         ? ends_as_channels
                      : type == "stringvector" ? ends_as_texts
                      : type == "preview"      ? ends_as_preview
                                               : nullptr;
    if (ends == nullptr) return true;
    constexpr int64_t kLongest = 16 << 20;
    if (size > kLongest) return false;
    std::string value(static_cast<size_t>(size), '\0');
    const Result<size_t> got = file.read(at, value.data(), value.size());
    if (!got) return got.error();
    return *got == value.size() && ends(value);
}

}  // namespace

Result<ExrHeader> read_exr_header(const InputFile& file) {
    const Error damaged = user_error(messages::kHeaderDamaged);
    uint8_t flags = 0;
    const Result<size_t> version = file.read(kFirst - 3, &flags, 1);
    if (!version) return version.error();
    double total = 0;
    ExrHeader header;
    Part part;
    bool first_of_part = true;
    for (int64_t at = kFirst;;) {
        std::array<char, 2 * kLongestName + 64> buffer{};
        const Result<size_t> got = file.read(at, buffer.data(), buffer.size());
        if (!got) return got.error();
        std::string_view rest(buffer.data(), *got);
        const auto name = take_text(&rest);
        if (!name) return damaged;
        if (name->empty()) {
            total += part.bytes();
            header.compression = std::max(header.compression, part.compression);
            part = {};
            at += 1;
            // Headers of several parts end with an empty one.
            if ((flags & kManyParts) == 0 || first_of_part) break;
            first_of_part = true;
            continue;
        }
        first_of_part = false;
        const auto type = take_text(&rest);
        if (!type || rest.size() < sizeof(int32_t)) return damaged;
        const int64_t size = int_at(rest.data());
        rest.remove_prefix(sizeof(int32_t));
        at += rest.data() - buffer.data();
        if (size < 0 || size > file.bytes() - at) return damaged;
        const Result<bool> ends = ends_as_it_says(file, at, size, *type);
        if (!ends) return ends.error();
        if (!*ends) return damaged;
        // A channel is a name of a letter at least, and 16 bytes; its numbers take 4 at most.
        constexpr int64_t kChannel = 18, kNumber = 4;
        if (*name == "channels") part.pixel_bytes = static_cast<double>(size / kChannel * kNumber);
        read_attribute(*name, rest.substr(0, static_cast<size_t>(size)), &part);
        at += size;
    }
    constexpr double kMost = 1e18;
    header.table_bytes = static_cast<int64_t>(std::min(total, kMost));
    return header;
}

std::string_view newer_exr_compression(int number) {
    constexpr int kFirst = 10;
    constexpr std::array<std::string_view, 4> kNames = {"HTJ2K256", "HTJ2K32", "LJ2K", "ZSTD"};
    if (number < kFirst) return {};
    const auto at = static_cast<size_t>(number - kFirst);
    return at < kNames.size() ? kNames[at] : "unknown";
}

}  // namespace openfab::tools
