// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "base/scan_number.h"
#include "texture/data_files.h"
#include "texture/meta_header.h"
#include "texture/named_length.h"
#include "texture/nrrd_header.h"
#include "tools/texture/messages.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/scans.h"
#include "tools/texture/stored_grid.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;
using texture::MetaHeader;

bool is_true(const std::string& value) {
    return !value.empty() && (value[0] == 'T' || value[0] == 't' || value[0] == '1');
}

/// Parses as many numbers.
bool take_numbers(std::string_view text, double* out, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        if (!scan_number(take_word(&text), out++).empty()) return false;
    }
    return take_word(&text).empty();
}

Result<void> set_format(const MetaHeader& header, StoredGrid* grid) {
    using Kind = NumberFormat::Kind;
    struct Type {
        std::string_view name;
        Kind kind;
        int bytes;
    };
    constexpr std::array<Type, 14> kTypes{{
        {"MET_CHAR", Kind::kSigned, 1},
        {"MET_UCHAR", Kind::kUnsigned, 1},
        {"MET_SHORT", Kind::kSigned, 2},
        {"MET_USHORT", Kind::kUnsigned, 2},
        {"MET_INT", Kind::kSigned, 4},
        {"MET_UINT", Kind::kUnsigned, 4},
        {"MET_LONG", Kind::kSigned, 4},
        {"MET_ULONG", Kind::kUnsigned, 4},
        {"MET_LONG_LONG", Kind::kSigned, 8},
        {"MET_ULONG_LONG", Kind::kUnsigned, 8},
        {"MET_FLOAT", Kind::kFloat, 4},
        {"MET_DOUBLE", Kind::kFloat, 8},
        {"MET_INT64", Kind::kSigned, 8},
        {"MET_UINT64", Kind::kUnsigned, 8},
    }};
    const std::string name = header.field("ElementType");
    const auto* const found = std::find_if(kTypes.begin(), kTypes.end(),
                                           [&](const Type& type) { return type.name == name; });
    if (found == kTypes.end()) return user_error(fmt::format(messages::kUnknownNumberType, name));
    const bool big = is_true(header.field("BinaryDataByteOrderMSB", "ElementByteOrderMSB"));
    grid->format = {found->kind, found->bytes, big, true};
    return {};
}

Result<void> set_size(const MetaHeader& header, StoredGrid* grid) {
    int64_t dimensions = 0, channels = 1;
    const std::string many = header.field("ElementNumberOfChannels");
    if (!scan_integer(header.field("NDims"), 3, 4, &dimensions).empty())
        return user_error(fmt::format(messages::kVolumeDimensions, header.field("NDims")));
    if (!many.empty() && !scan_integer(many, 1, 4, &channels).empty())
        return user_error(fmt::format(messages::kImageChannels, many));
    std::array<int64_t, 3> sides{};
    const std::string text = header.field("DimSize");
    std::string_view left = text;
    for (int64_t& side : sides) {
        if (!scan_integer(take_word(&left), 1, INT32_MAX, &side).empty())
            return user_error(messages::kDimSizeMalformed);
    }
    // A step of time, or what a filter has left of a fourth axis.
    int64_t last = 1;
    if (dimensions == 4 && !scan_integer(take_word(&left), 1, INT32_MAX, &last).empty())
        return user_error(messages::kDimSizeMalformed);
    if (last > 1)
        return user_error(fmt::format(messages::kVolumesInTime, last), messages::kOneOfThemHelp);
    return set_sides(sides, channels, grid);
}

Result<GridFrame> frame_of(const MetaHeader& header, double unit) {
    const size_t n = header.field("NDims") == "4" ? 4 : 3;  // axes, of which three lie in space
    std::array<double, 16> ways{};
    std::array<double, 4> spacing{1, 1, 1, 1}, first{};
    for (size_t i = 0; i < n; ++i)
        ways[i * n + i] = 1;
    const auto read = [](const std::string& text, double* out, size_t count) {
        return text.empty() || take_numbers(text, out, count);
    };
    if (!read(header.field("TransformMatrix", "Rotation", "Orientation"), ways.data(), n * n) ||
        !read(header.field("ElementSpacing", "ElementSize"), spacing.data(), n) ||
        !read(header.field("Offset", "Position", "Origin"), first.data(), n))
        return user_error(messages::kTransformMalformed);
    GridFrame frame;
    frame.first = Vec3d{first[0], first[1], first[2]} * unit;
    for (size_t i = 0; i < 3; ++i) {
        // Each row is the way along an index, with the rounding of six digits.
        constexpr double kRounding = 1e-6;
        Vec3d way{ways[n * i], ways[n * i + 1], ways[n * i + 2]};
        const double least = kRounding * length(way);
        for (int k = 0; k < 3; ++k)
            way[k] = std::abs(way[k]) <= least ? 0 : way[k];
        frame.steps[i] = way * (spacing[i] * unit);
    }
    return frame;
}

/// The unit of its lengths, which is millimetres where nothing is said.
Result<double> header_unit_mm(const MetaHeader& header, const texture::VolumeOptions& options) {
    const std::string name = header.field("DistanceUnits");
    if (!options.unit.empty() || name.empty() || name == "?") return unit_mm(options);
    const std::optional<double> mm = texture::named_length_mm(name);
    if (mm) return *mm;
    return user_error(fmt::format(messages::kUnknownUnit, name), messages::kUnknownUnitHelp);
}

/// The function of stored numbers that intensities are.
Result<void> set_intensity(const MetaHeader& header, StoredGrid* grid) {
    const auto read = [&](const char* name, double* out) {
        const std::string text = header.field(name);
        return text.empty() || (take_numbers(text, out, 1) && std::isfinite(*out));
    };
    if (!read("ElementToIntensityFunctionSlope", &grid->slope) ||
        !read("ElementToIntensityFunctionOffset", &grid->intercept))
        return user_error(messages::kIntensityMalformed);
    return {};
}

/// Opens the numbers, behind the header or in files of their own.
Result<void> open_numbers(InputFile source, const fs::path& path, const MetaHeader& header,
                          const texture::ReadLimits& limits, StoredGrid* grid) {
    const std::string binary = header.field("BinaryData");
    grid->text = !binary.empty() && !is_true(binary);
    grid->packed = is_true(header.field("CompressedData"));
    int64_t skip = 0;
    if (const std::string size = header.field("HeaderSize");
        !size.empty() && !scan_integer(size, -1, INT64_MAX / 4, &skip).empty())
        return user_error(fmt::format(messages::kHeaderSizeIs, size));
    if (grid->packed && skip > 0)
        return user_error(messages::kPackedBehindHeader, messages::kPackedBehindHeaderHelp);
    const std::string name = header.data_file();
    const Result<std::vector<std::string>> names = texture::read_data_files(name, header.listed);
    if (!names) return names.error();
    const int64_t share = grid->bytes() / static_cast<int64_t>(names->size());
    const auto open = [skip, share, packed = grid->packed](InputFile data, int64_t begin) {
        const int64_t before = skip < 0 ? std::max<int64_t>(data.bytes() - begin - share, 0) : skip;
        return packed ? open_packed_bytes(std::move(data), begin)
                      : open_bytes(std::move(data), begin + before);
    };
    if (names->size() > 1 || texture::is_file_list(name)) {
        return chain_data_files(
            path, std::move(source), *names, limits,
            [open](InputFile data) -> Result<std::unique_ptr<ByteStream>> {
                return open(std::move(data), 0);
            },
            grid);
    }
    if (!name.empty()) {
        Result<InputFile> data = texture::open_data_file(path, names->front(), limits);
        if (!data) return data.error();
        source = std::move(*data);
    }
    grid->stream = open(std::move(source), name.empty() ? header.begin : 0);
    return {};
}

}  // namespace

MadeReader open_meta(const fs::path& path, const texture::VolumeOptions& options,
                     const texture::ReadLimits& limits) {
    Result<InputFile> source = InputFile::open(path);
    if (!source) return source.error();
    const Result<MetaHeader> header = texture::read_meta_header(*source);
    if (!header) return header.error();
    StoredGrid grid;
    if (Result<void> known = set_format(*header, &grid); !known) return known.error();
    if (Result<void> sized = set_size(*header, &grid); !sized) return sized.error();
    if (Result<void> read = set_intensity(*header, &grid); !read) return read.error();
    const Result<double> unit = header_unit_mm(*header, options);
    if (!unit) return unit.error();
    const Result<GridFrame> frame = frame_of(*header, *unit);
    if (!frame) return frame.error();
    if (Result<void> opened = open_numbers(std::move(*source), path, *header, limits, &grid);
        !opened)
        return opened.error();
    MadeReader reader = open_stored_grid(std::move(grid), limits);
    if (!reader) return reader;
    return place_reader(std::move(*reader), *frame, options, limits);
}

}  // namespace openfab::tools
