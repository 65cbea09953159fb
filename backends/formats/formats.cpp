// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/formats/formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "backends/boundary/formats.h"
#include "backends/gcvf/format.h"
#include "backends/ofr/ofr_format.h"
#include "backends/raster/formats.h"
#include "backends/zarr/format.h"

namespace openfab::backends {

namespace {

constexpr std::array kFormats{
    &ofr::kOfrFormat,          &raster::kPngFormat,     &raster::kBmpFormat,
    &gcvf::kGcvfFormat,        &raster::kGreyFormat,    &raster::kGrey16Format,
    &raster::kTiffFormat,      &raster::kTiff16Format,  &raster::kNpyFormat,
    &boundary::kThreemfFormat, &boundary::kApartFormat, &boundary::kFilamentFormat,
    &boundary::kMixedFormat,   &boundary::kStlFormat,   &zarr::kZarrFormat,
};

}  // namespace

std::span<const Format* const> formats() {
    return kFormats;
}

const Format* find_format(std::string_view name) {
    for (const Format* format : kFormats) {
        if (format->name == name) return format;
    }
    return nullptr;
}

std::string format_names(std::string_view last_joint,
                         const std::function<bool(const Format&)>& holds) {
    std::vector<std::string_view> names;
    for (const Format* format : kFormats) {
        if (holds(*format)) names.push_back(format->name);
    }
    std::string text;
    for (size_t i = 0; i < names.size(); ++i) {
        const bool is_last = i + 1 == names.size() && last_joint != ",";
        if (i > 0) text += is_last ? fmt::format(" {} ", last_joint) : ", ";
        text += names[i];
    }
    return text;
}

std::string file_extensions() {
    std::vector<std::string_view> known;
    for (const Format* format : kFormats) {
        if (format->kind != FormatKind::kFolder &&
            std::find(known.begin(), known.end(), format->extension) == known.end())
            known.push_back(format->extension);
    }
    return fmt::format("{}", fmt::join(known, ", "));
}

}  // namespace openfab::backends
