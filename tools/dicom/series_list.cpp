// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/series_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

#include "tools/dicom/messages.h"

namespace openfab::tools {

namespace {

/// Slices of a series that have the same grid.
struct Part {
    std::vector<DicomSlice> slices;
    size_t number = 1;  ///< among those of its series
    size_t of = 1;

    const DicomImage& image() const { return *slices.front().image; }
    std::string series_number() const {
        return image().series_number ? std::to_string(*image().series_number) : std::string();
    }
};

bool is_alike(const DicomSlice& a, const DicomSlice& b) {
    if (a.image->width != b.image->width || a.image->height != b.image->height) return false;
    // Of a length in mm: what the decimals of a file leave open.
    constexpr double kRounding_mm = 0.01;
    // Far corners of both, in the same place of the plane.
    const double far = length((a.across - b.across) * static_cast<double>(a.image->width)) +
                       length((a.down - b.down) * static_cast<double>(a.image->height));
    return far <= kRounding_mm;
}

/// Each slice is compared with one of each part.
constexpr size_t kMostParts = 1000;

Result<std::vector<Part>> parts_of(std::vector<DicomSlice> slices) {
    std::vector<Part> parts;
    for (DicomSlice& slice : slices) {
        const auto found = std::find_if(parts.begin(), parts.end(), [&](const Part& part) {
            return part.image().series == slice.image->series &&
                   part.slices.front().stack == slice.stack && is_alike(part.slices.front(), slice);
        });
        Part& part = found == parts.end() ? parts.emplace_back() : *found;
        part.slices.push_back(std::move(slice));
        if (parts.size() > kMostParts) {
            return user_error(fmt::format(messages::kTooManySeries, kMostParts),
                              messages::kTooManySeriesHelp);
        }
    }
    for (size_t i = 0; i < parts.size(); ++i) {
        const auto same = [&](const Part& other) {
            return other.image().series == parts[i].image().series;
        };
        const auto here = parts.begin() + static_cast<std::ptrdiff_t>(i);
        parts[i].of = static_cast<size_t>(std::count_if(parts.begin(), parts.end(), same));
        parts[i].number = static_cast<size_t>(std::count_if(parts.begin(), here, same)) + 1;
    }
    return parts;
}

/// How the slices lie in a body.
std::string orientation(const DicomSlice& slice) {
    constexpr std::array<const char*, 3> kNames{"sagittal", "coronal", "axial"};
    const Vec3d normal = cross(slice.across, slice.down);
    int along = 0;
    for (int a = 1; a < 3; ++a)
        along = std::abs(normal[a]) > std::abs(normal[along]) ? a : along;
    constexpr double kStraight = 1e-4;
    const bool tilted = std::abs(normal[along]) < (1 - kStraight) * length(normal);
    return std::string(tilted ? "tilted " : "") + kNames[static_cast<size_t>(along)];
}

std::string describe(const Part& part, const std::string& name) {
    const DicomSlice& first = part.slices.front();
    const size_t count = part.slices.size();
    std::string made = part.image().modality;
    if (const std::string& date = part.image().date; !date.empty())
        made += fmt::format("{}{}-{}-{}", made.empty() ? "" : " of ", date.substr(0, 4),
                            date.substr(4, 2), date.substr(6, 2));
    if (!made.empty()) made += ", ";
    std::string out = fmt::format(messages::kSeriesLine, name, made, part.image().width,
                                  part.image().height, length(first.across), length(first.down),
                                  orientation(first), count, count == 1 ? "" : "s");
    if (count == 1) out += " " + first.name();
    if (!part.image().description.empty()) out += fmt::format(", `{}`", part.image().description);
    return out + ")";
}

/// Lists parts by their series' numbers, or identifiers where numbers do not tell them apart.
std::string list(const std::vector<Part>& parts) {
    std::set<std::string> series;
    std::set<std::string> numbers;
    for (const Part& part : parts) {
        series.insert(part.image().series);
        numbers.insert(part.series_number());
    }
    const bool clear = series.size() == numbers.size() && !numbers.contains("");
    std::vector<std::string> out;
    for (const Part& part : parts) {
        std::string name = clear ? part.series_number() : part.image().series;
        if (part.of > 1) name += fmt::format("/{}", part.number);
        out.push_back(describe(part, name));
    }
    constexpr size_t kMost = 24;
    const size_t more = out.size() - std::min(out.size(), kMost);
    out.resize(out.size() - more);
    return fmt::format("{}{}", fmt::join(out, ", "),
                       more > 0 ? fmt::format(" and {} more", more) : std::string());
}

/// Whether a field names a part, or its whole series, by one of its series' names.
bool is_named(const Part& part, const std::string& series_name, const std::string& field) {
    if (series_name.empty()) return false;
    return field == series_name || field == fmt::format("{}/{}", series_name, part.number);
}

/// The parts that a field names: numbers come before identifiers, these before descriptions.
std::vector<Part> named(const std::vector<Part>& parts, const std::string& field) {
    for (int kind = 0; kind < 3; ++kind) {
        std::vector<Part> found;
        for (const Part& part : parts) {
            const std::string name = kind == 0   ? part.series_number()
                                     : kind == 1 ? part.image().series
                                                 : part.image().description;
            if (is_named(part, name, field)) found.push_back(part);
        }
        if (!found.empty()) return found;
    }
    return {};
}

}  // namespace

Result<std::vector<DicomSlice>> choose_series(std::vector<DicomSlice> slices,
                                              const std::string& field) {
    Result<std::vector<Part>> all = parts_of(std::move(slices));
    if (!all) return all.error();
    std::vector<Part> parts = std::move(*all);
    if (!field.empty()) {
        std::vector<Part> found = named(parts, field);
        if (found.empty())
            return user_error(fmt::format(messages::kNoSuchSeries, field, list(parts)));
        parts = std::move(found);
    }
    if (parts.size() == 1) return std::move(parts.front().slices);
    const bool one_series = std::all_of(parts.begin(), parts.end(), [&](const Part& part) {
        return part.image().series == parts.front().image().series;
    });
    return user_error(
        fmt::format(messages::kNotOfOneSeries, one_series ? "grid" : "series", list(parts)),
        one_series ? messages::kNotOfOneSeriesBrackets : messages::kNotOfOneSeriesIdentifier);
}

bool names_series(const std::vector<DicomSlice>& slices, const std::string& field) {
    const std::string series = field.substr(0, field.rfind('/'));
    return std::any_of(slices.begin(), slices.end(), [&](const DicomSlice& slice) {
        const DicomImage& image = *slice.image;
        const std::string number =
            image.series_number ? std::to_string(*image.series_number) : std::string();
        for (const std::string* name : {&number, &image.series, &image.description}) {
            if (!name->empty() && (field == *name || series == *name)) return true;
        }
        return false;
    });
}

std::string list_some(const std::vector<std::string>& names) {
    constexpr size_t kMost = 5;
    const size_t shown = std::min(names.size(), kMost);
    std::string out = fmt::format(
        "{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "));
    if (names.size() > shown) out += fmt::format(" and {} more", names.size() - shown);
    return out;
}

}  // namespace openfab::tools
