// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/tiff_series.h"
#include "texture/named_length.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string_view>

#include "base/json.h"
#include "base/scan_number.h"
#include "texture/data_files.h"
#include "tools/texture/messages.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/tiff_makers.h"

namespace openfab::tools {

namespace {

constexpr int64_t kMostPlanes = 1 << 20;

std::vector<std::string> numbers_from_1(int64_t count) {
    std::vector<std::string> out;
    for (int64_t i = 1; i <= count; ++i)
        out.push_back(std::to_string(i));
    return out;
}

// ImageJ: lines `key=value`, channels fastest, then slices, then frames.

using Lines = std::map<std::string, std::string>;

Lines imagej_lines(const std::string& description) {
    Lines out;
    for (const std::string& line : texture::lines_of(description)) {
        const size_t sign = line.find('=');
        if (sign != std::string::npos) out.emplace(line.substr(0, sign), line.substr(sign + 1));
    }
    return out;
}

double real(const Lines& lines, const char* key, double otherwise) {
    const auto found = lines.find(key);
    double value = 0;
    if (found == lines.end() || !scan_number(found->second, &value).empty()) return otherwise;
    return value;
}

/// The pixels' size is that of the resolution, in the unit that the description names.
void set_imagej_spacing(const Lines& lines, const TiffDirectory& first, TiffSeries* series) {
    const auto unit = lines.find("unit");
    if (unit == lines.end() || unit->second == "pixel" || unit->second == "pixels") return;
    const std::optional<double> mm = texture::named_length_mm(unit->second);
    if (!mm) {
        series->notes.push_back(fmt::format(messages::kTiffUnitUnknown, unit->second));
        return;
    }
    const auto [x, y] = first.resolution;
    const double step = std::abs(real(lines, "spacing", 1));
    if (!(x > 0 && y > 0 && step > 0)) return;
    series->spacing_mm = {*mm / x, *mm / y, *mm * step};
    series->unit_mm = *mm;
}

Result<TiffSeries> imagej_series(const TiffDirectory& first, int64_t pages) {
    const Lines lines = imagej_lines(first.description);
    TiffSeries series;
    const auto count = [&](const char* key, int64_t otherwise, int64_t* out) {
        const auto found = lines.find(key);
        if (found == lines.end()) return *out = otherwise, true;
        return scan_integer(found->second, 1, kMostPlanes, out).empty();
    };
    int64_t images = 1;
    const bool known = count("channels", 1, &series.channels) &&
                       count("slices", 1, &series.slices) && count("frames", 1, &series.frames);
    if (!known || !count("images", series.planes(), &images))
        return user_error(messages::kTiffDescription);
    if (series.planes() == 1) series.slices = images;
    // RGB of 48 bits is a composite of channels in samples.
    if (series.channels == first.samples && series.planes() == images * first.samples)
        series.channels = 1;
    if (series.planes() != images)
        return user_error(fmt::format(messages::kImagesContradict, images, series.channels,
                                      series.slices, series.frames));
    if (pages != images && pages != 1)
        return user_error(fmt::format(messages::kPagesContradict, images, pages));
    series.strides = {1, series.channels, series.channels * series.slices};
    series.names = numbers_from_1(series.channels);
    set_imagej_spacing(lines, first, &series);
    if (lines.contains("c0") && (real(lines, "c0", 0) != 0 || real(lines, "c1", 1) != 1)) {
        series.notes.push_back(
            fmt::format(messages::kCalibrationLeftOut, real(lines, "c0", 0), real(lines, "c1", 1)));
    }
    return series;
}

// tifffile: {"shape": [8, 16, 16], "axes": "ZYX"}.

/// Returns how many axes of the shape run over pages; negative where it does not fit them.
int leading_axes(const std::vector<int64_t>& shape, const TiffDirectory& first) {
    int64_t left = int64_t{first.width} * first.height * first.depth * first.samples;
    size_t axis = shape.size();
    while (axis > 0 && left > 1) {
        if (left % shape[axis - 1] != 0) return -1;
        left /= shape[--axis];
    }
    return left == 1 ? static_cast<int>(axis) : -1;
}

/// What an axis over pages is, by its letter; those without one are slices.
int64_t* count_of(char letter, TiffSeries* series) {
    if (letter == 'C' || letter == 'S') return &series->channels;
    return letter == 'T' ? &series->frames : &series->slices;
}

Result<TiffSeries> shaped_series(const TiffDirectory& first, int64_t pages) {
    TiffSeries series;
    series.slices = pages;
    const Result<JsonValue> json = parse_json(first.description, "");
    const JsonMember* const member =
        json && json->is(JsonValue::Kind::kObject) ? json->find("shape") : nullptr;
    if (member == nullptr || !member->value.is(JsonValue::Kind::kArray)) return series;
    std::vector<int64_t> shape;
    for (const JsonValue& side : member->value.items) {
        if (!(side.number >= 1 && side.number < 1e9)) return series;
        shape.push_back(static_cast<int64_t>(side.number));
    }
    const JsonMember* const axes = json->find("axes");
    const std::string letters = axes == nullptr ? "" : axes->value.text;
    const int leading = leading_axes(shape, first);
    if (leading < 0) return series;
    TiffSeries said;
    int64_t stride = 1;
    int over = 0;  // axes of more than one
    for (int axis = leading; axis-- > 0;) {
        const auto a = static_cast<size_t>(axis);
        if (shape[a] == 1) continue;
        const char letter = letters.size() == shape.size() ? letters[a] : '?';
        // What they are by tifffile's letters; a sequence of unknown pictures (Q, I) is one of slices.
        constexpr std::string_view kOthers = "APRHELVMB";
        if (kOthers.find(letter) != std::string_view::npos)
            return user_error(fmt::format(messages::kAxisOfPages, shape[a], letter),
                              messages::kWriteAsPagesHelp);
        int64_t* const count = count_of(letter, &said);
        // Two that nobody names would be a guess.
        if (*count > 1 || (over > 0 && letter == '?'))
            return user_error(fmt::format(messages::kShapeOfMoreAxes, fmt::join(shape, " x ")));
        *count = shape[a];
        const auto which = static_cast<size_t>(count == &said.channels ? 0
                                               : count == &said.slices ? 1
                                                                       : 2);
        said.strides[which] = stride;
        stride *= shape[a];
        ++over;
    }
    if (said.planes() > kMostPlanes) return series;
    if (pages != said.planes() && pages != 1 && said.planes() != 1)
        return user_error(fmt::format(messages::kPagesContradict, said.planes(), pages));
    if (pages != said.planes() && pages != 1) return series;
    said.names = numbers_from_1(said.channels);
    return said;
}

/// MetaMorph's stacks have one directory, and say with it what each plane is.
Result<TiffSeries> stk_series(const TiffDirectory& first, int64_t pages) {
    if (first.stk_planes > 1)
        return user_error(fmt::format(messages::kStkPlanes, first.stk_planes),
                          messages::kWriteAsPagesHelp);
    TiffSeries series;
    series.slices = pages;
    return series;
}

/// Zeiss microscopes: the sides, channels and times of the whole file, and a voxel's sides in metres, in the
/// order of bytes of the first processors for them. Pages are slices, then times; channels are samples.
Result<TiffSeries> lsm_series(const TiffDirectory& first, int64_t pages) {
    constexpr size_t kSlices = 16, kTimes = 24, kVoxel = 40, kLeast = 64;
    TiffSeries series;
    if (first.lsm.size() < kLeast) return user_error(messages::kTiffDescription);
    const auto number = [&](size_t at, auto* out) {
        std::memcpy(out, first.lsm.data() + at, sizeof *out);
    };
    int32_t slices = 0, times = 0;
    number(kSlices, &slices);
    number(kTimes, &times);
    if (slices < 1 || times < 1 || int64_t{slices} * times != pages)
        return user_error(fmt::format(messages::kLsmPages, slices, times, pages),
                          messages::kWriteAsPagesHelp);
    series.slices = slices;
    series.frames = times;
    std::array<double, 3> metres{};
    number(kVoxel, &metres);
    constexpr double kMillimetres = 1000;
    if (std::all_of(metres.begin(), metres.end(), [](double side) { return side > 0; }))
        series.spacing_mm = {metres[0] * kMillimetres, metres[1] * kMillimetres,
                             metres[2] * kMillimetres};
    series.unit_mm = kMillimetres;
    return series;
}

/// Says what a resolution would make of the texels, which a picture's own does not.
void tell_resolution(const TiffDirectory& first, TiffSeries* series) {
    const auto [x, y] = first.resolution;
    if (series->spacing_mm || !series->notes.empty() || !(x > 0 && y > 0)) return;
    if (first.resolution_unit != 2 && first.resolution_unit != 3) return;
    const double mm = first.resolution_unit == 2 ? 25.4 : 10;
    series->notes.push_back(fmt::format(messages::kResolutionLeftOut, mm / x, mm / y));
}

/// What GDAL says of the numbers, which are read as they are stored.
void tell_meaning(const TiffDirectory& first, TiffSeries* series) {
    const std::string no_data = first.no_data.substr(0, first.no_data.find('\0'));
    if (!no_data.empty()) series->notes.push_back(fmt::format(messages::kNoDataAsStored, no_data));
    if (first.scaling.find("role=\"scale\"") != std::string::npos ||
        first.scaling.find("role=\"offset\"") != std::string::npos)
        series->notes.emplace_back(messages::kScalingLeftOut);
}

}  // namespace

Result<TiffSeries> read_tiff_series(const TiffDirectory& first, int64_t pages,
                                    const std::string& name) {
    const std::string_view text = first.description;
    Result<TiffSeries> series = TiffSeries();
    if (text.starts_with("ImageJ=") || text.starts_with("SCIFIO=")) {
        series = imagej_series(first, pages);
    } else if (text.starts_with('{')) {
        series = shaped_series(first, pages);
    } else if (text.find("<OME") != std::string_view::npos) {
        series = read_ome_series(first, pages, name);
    } else if (first.stk_planes > 0) {
        series = stk_series(first, pages);
    } else if (!first.lsm.empty()) {
        series = lsm_series(first, pages);
    } else {
        if (Result<void> plain = check_maker(first, pages); !plain) return plain.error();
        series->slices = pages;
    }
    if (series) tell_meaning(first, &*series);
    if (series && first.orientation > 1)
        series->notes.push_back(fmt::format(messages::kOrientationLeftOut, first.orientation));
    if (series) tell_resolution(first, &*series);
    return series;
}

}  // namespace openfab::tools
