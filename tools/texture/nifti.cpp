// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "base/input_file.h"
#include "base/scan_number.h"
#include "texture/nifti_header.h"
#include "texture/nrrd_header.h"
#include "tools/texture/messages.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/scans.h"
#include "tools/texture/stored_grid.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;
using texture::NiftiHeader;

/// The first bytes, decompressed.
struct Head {
    std::string bytes;
    bool packed = false;
};

Result<Head> read_head(const fs::path& path) {
    Result<InputFile> file = InputFile::open(path);
    if (!file) return file.error();
    Head head;
    std::array<char, 2> mark{};
    const Result<size_t> got = file->read(0, mark.data(), mark.size());
    if (!got) return got.error();
    head.packed = *got == 2 && mark[0] == '\x1f' && mark[1] == '\x8b';
    const auto stream =
        head.packed ? open_packed_bytes(std::move(*file), 0) : open_bytes(std::move(*file), 0);
    head.bytes.resize(NiftiHeader::kBytes);
    const Result<size_t> read = stream->next(head.bytes.data(), head.bytes.size());
    if (!read) return read.error();
    head.bytes.resize(*read);
    return head;
}

struct DataType {
    int64_t code;
    NumberFormat::Kind kind;
    int bytes;
    int32_t channels;
    const char* name;  ///< of one that is not read
};

Result<void> set_format(const NiftiHeader& header, StoredGrid* grid, int32_t* channels) {
    using Kind = NumberFormat::Kind;
    constexpr std::array<DataType, 17> kTypes{{
        {2, Kind::kUnsigned, 1, 1, nullptr},
        {4, Kind::kSigned, 2, 1, nullptr},
        {8, Kind::kSigned, 4, 1, nullptr},
        {16, Kind::kFloat, 4, 1, nullptr},
        {64, Kind::kFloat, 8, 1, nullptr},
        {128, Kind::kUnsigned, 1, 3, nullptr},
        {256, Kind::kSigned, 1, 1, nullptr},
        {512, Kind::kUnsigned, 2, 1, nullptr},
        {768, Kind::kUnsigned, 4, 1, nullptr},
        {1024, Kind::kSigned, 8, 1, nullptr},
        {1280, Kind::kUnsigned, 8, 1, nullptr},
        {2304, Kind::kUnsigned, 1, 4, nullptr},
        {1, Kind::kFloat, 0, 0, messages::kSingleBits},
        {32, Kind::kFloat, 0, 0, "complex"},
        {1792, Kind::kFloat, 0, 0, "complex"},
        {2048, Kind::kFloat, 0, 0, "complex"},
        {1536, Kind::kFloat, 0, 0, messages::kFloats128},
    }};
    const auto* const found = std::find_if(kTypes.begin(), kTypes.end(), [&](const DataType& type) {
        return type.code == header.datatype;
    });
    if (found == kTypes.end())
        return user_error(fmt::format(messages::kUnknownNumberCode, header.datatype));
    if (found->name != nullptr)
        return user_error(fmt::format(messages::kNumbersAre, found->name),
                          messages::kNumbersAreHelp);
    grid->format = {found->kind, found->bytes, header.swapped, found->channels == 1};
    *channels = found->channels;
    return {};
}

/// Which of its volumes is read, from 0.
Result<int64_t> chosen_volume(int64_t volumes, const std::string& field) {
    int64_t out = 0;
    if (field.empty() && volumes == 1) return out;
    if (!field.empty() && scan_integer(field, 0, volumes - 1, &out).empty()) return out;
    if (volumes == 1) return user_error(fmt::format(messages::kOneVolume, field));
    return user_error(fmt::format(messages::kVolumesInTime, volumes),
                      fmt::format(messages::kVolumesInTimeHelp, volumes - 1));
}

/// The steps and the first place, before units; nothing where the header gives neither form.
std::optional<GridFrame> frame_of(const NiftiHeader& h) {
    GridFrame frame;
    if (h.sform > 0) {
        for (int row = 0; row < 3; ++row) {
            const auto& of = h.affine[static_cast<size_t>(row)];
            for (size_t i = 0; i < 3; ++i)
                frame.steps[i][row] = of[i];
            frame.first[row] = of[3];
        }
        return frame;
    }
    if (h.qform <= 0) return std::nullopt;
    auto [b, c, d] = h.quaternion;
    const double rest = 1 - (b * b + c * c + d * d);
    // What is left of half a turn, where three units of rounding are no angle: as nibabel has it.
    const double rounding = 3 * (h.is_double ? std::numeric_limits<double>::epsilon()
                                             : double{std::numeric_limits<float>::epsilon()});
    double a = 0;
    if (rest < rounding) {
        const double all = std::sqrt(b * b + c * c + d * d);
        b /= all, c /= all, d /= all;
    } else {
        a = std::sqrt(rest);
    }
    frame.steps[0] = {a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)};
    frame.steps[1] = {2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)};
    frame.steps[2] = {2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - b * b - c * c};
    for (size_t i = 0; i < 3; ++i)
        frame.steps[i] = frame.steps[i] * h.pixdim[i + 1];
    if (h.pixdim[0] < 0) frame.steps[2] = frame.steps[2] * -1.0;
    frame.first = {h.shift[0], h.shift[1], h.shift[2]};
    return frame;
}

double unit_of_header(const NiftiHeader& h, const texture::VolumeOptions& options) {
    if (!options.unit.empty()) return unit_mm(options);
    const int64_t code = h.units & 7;
    return code == 1 ? 1000 : code == 3 ? 1e-3 : 1;  // metres, micrometres
}

/// Leaves out what rounding to 32 bits put along other axes, and converts to mm.
Result<void> settle(double unit, GridFrame* frame) {
    constexpr double kRounding = 1e-5;
    for (Vec3d& step : frame->steps) {
        const double least = kRounding * length(step);
        if (!std::isfinite(least) || !(least > 0))
            return user_error(messages::kAxesWithoutDirections);
        for (int k = 0; k < 3; ++k)
            step[k] = std::abs(step[k]) <= least ? 0 : step[k] * unit;
    }
    frame->first = frame->first * unit;
    return {};
}

}  // namespace

bool is_nifti_file(const fs::path& file) {
    const Result<Head> head = read_head(file);
    return head && texture::is_nifti(head->bytes);
}

MadeReader open_nifti(const fs::path& path, const texture::VolumeOptions& options,
                      const texture::ReadLimits& limits) {
    const Result<Head> head = read_head(path);
    if (!head) return head.error();
    const Result<NiftiHeader> read = texture::read_nifti_header(head->bytes);
    if (!read) return read.error();
    const NiftiHeader& h = *read;
    if (h.dim[0] < 1 || h.dim[0] > 7) return user_error(messages::kHeaderDamaged);
    std::array<int64_t, 8> n{};
    for (size_t i = 1; i < 8; ++i)
        n[i] = static_cast<int64_t>(i) <= h.dim[0] ? h.dim[i] : 1;
    if (n[4] < 1 || n[5] < 1 || n[6] != 1 || n[7] != 1)
        return user_error(fmt::format(messages::kNiftiDimensions, h.dim[0]));
    StoredGrid grid;
    int32_t channels = 1;
    if (Result<void> known = set_format(h, &grid, &channels); !known) return known.error();
    if ((channels > 1 || n[4] > 1) && n[5] > 1) return user_error(messages::kTimeAndComponents);
    // Components lie one volume behind the other, colours texel by texel.
    if (channels == 1) grid.channel_axis = 3;
    if (Result<void> fits = set_sides({n[1], n[2], n[3]}, channels * n[5], &grid); !fits)
        return fits.error();
    const Result<int64_t> volume = chosen_volume(n[4], options.field);
    if (!volume) return volume.error();
    if (std::isfinite(h.slope) && h.slope != 0 && channels == 1) {
        grid.slope = h.slope;
        grid.intercept = std::isfinite(h.intercept) ? h.intercept : 0;
    }
    constexpr double kMostOffset = 1e15;
    const double least = h.detached ? 0 : h.is_double ? 540 : 348;  // behind the header
    if (!(h.offset >= least && h.offset <= kMostOffset && h.offset == std::floor(h.offset)))
        return user_error(messages::kVoxOffsetOutside);
    grid.packed = head->packed;
    Result<InputFile> file = InputFile::open(path);
    if (h.detached) {
        if (head->packed)
            return user_error(messages::kPackedHeaderAlone, messages::kPackedHeaderAloneHelp);
        file = texture::open_data_file(path, texture::nifti_data_file(path.filename().string()),
                                       limits);
    }
    if (!file) return file.error();
    grid.stream =
        grid.packed ? open_packed_bytes(std::move(*file), 0) : open_bytes(std::move(*file), 0);
    grid.skip = static_cast<int64_t>(h.offset) + *volume * grid.bytes();
    grid.goes_on = *volume + 1 < n[4];
    std::optional<GridFrame> frame = frame_of(h);
    const bool is_placed = frame.has_value();
    if (!is_placed) {
        frame.emplace();
        for (size_t i = 0; i < 3; ++i)
            frame->steps[i][static_cast<int>(i)] = std::abs(h.pixdim[i + 1]);
    }
    if (Result<void> settled = settle(unit_of_header(h, options), &*frame); !settled)
        return settled.error();
    MadeReader reader = open_stored_grid(std::move(grid), limits);
    if (!reader) return reader;
    MadeReader placed = place_reader(std::move(*reader), *frame, options, limits);
    if (placed && !is_placed) (*placed)->origin.reset();
    return placed;
}

}  // namespace openfab::tools
