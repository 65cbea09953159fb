// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>

#include "base/scan_number.h"
#include "base/xml.h"
#include "texture/named_length.h"
#include "tools/texture/messages.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/tiff_series.h"

namespace openfab::tools {

namespace {

constexpr int64_t kMostPlanes = 1 << 20;
enum Axis : size_t { kZ, kC, kT };

/// A run of planes, in the order of their dimensions, that lie in pages of a file.
struct TiffData {
    int64_t page = 0;
    bool has_page = false;
    std::array<int64_t, 3> first{};  ///< z, c, t
    int64_t count = -1;              ///< all that there are
    std::string file, id;
};

/// What the first image says; others are counted.
class OmeReader final : public XmlHandler {
  public:
    int images = 0;
    std::string images_named;
    std::string order, type, file_id;
    std::array<int64_t, 3> sizes{1, 1, 1};  ///< z, c, t
    std::array<double, 3> size_mm{};        ///< of a texel; 0: not given
    double unit_mm = 1e-3;
    std::string unknown_unit;
    std::vector<std::string> channel_names;
    int64_t samples = 0;  ///< of all channels
    std::vector<TiffData> data;
    bool elsewhere = false;  ///< all of it lies in another file

    Complaint start(std::string_view name, const XmlAttributes& attributes) override {
        if (name == "Image") {
            ++images;
            const char* const said = attributes.find("Name");
            images_named +=
                fmt::format("{}`{}`", images > 1 ? ", " : "", said == nullptr ? "" : said);
        }
        if (name == "BinaryOnly") elsewhere = true;
        if (name == "OME") file_id = text_of(attributes, "UUID");
        if (images != 1) return {};
        if (name == "Pixels") return take_pixels(attributes);
        if (name == "Channel") {
            channel_names.push_back(text_of(attributes, "Name"));
            samples += integer(attributes, "SamplesPerPixel", 1);
        }
        if (name == "TiffData") return take_data(attributes);
        if (name == "UUID" && !data.empty()) {
            data.back().file = text_of(attributes, "FileName");
            in_id_ = true;
        }
        return {};
    }
    void end(std::string_view name) override {
        if (name == "UUID") in_id_ = false;
    }
    bool wants_text() const override { return in_id_; }
    void text(std::string_view text) override { data.back().id += text; }

  private:
    static std::string text_of(const XmlAttributes& attributes, const char* name) {
        const char* const found = attributes.find(name);
        return found == nullptr ? "" : found;
    }
    static int64_t integer(const XmlAttributes& attributes, const char* name, int64_t otherwise) {
        int64_t value = otherwise;
        const std::string text = text_of(attributes, name);
        if (text.empty() || !scan_integer(text, 0, kMostPlanes, &value).empty()) return otherwise;
        return value;
    }
    Complaint take_pixels(const XmlAttributes& attributes) {
        order = text_of(attributes, "DimensionOrder");
        constexpr std::array<const char*, 3> kSizes{"SizeZ", "SizeC", "SizeT"};
        for (size_t axis = 0; axis < 3; ++axis)
            sizes[axis] = std::max<int64_t>(integer(attributes, kSizes[axis], 1), 1);
        for (size_t a = 0; a < 3; ++a) {
            const std::string name = std::string("PhysicalSize") + "XYZ"[a];
            std::string unit = text_of(attributes, (name + "Unit").c_str());
            if (unit.empty()) unit = "\u00b5m";
            double value = 0;
            const std::optional<double> mm = texture::named_length_mm(unit);
            if (!mm) unknown_unit = unit;
            if (mm && a == 0) unit_mm = *mm;
            if (mm && scan_number(text_of(attributes, name.c_str()), &value).empty())
                size_mm[a] = value * *mm;
        }
        return {};
    }
    Complaint take_data(const XmlAttributes& attributes) {
        TiffData& one = data.emplace_back();
        one.has_page = attributes.find("IFD") != nullptr;
        one.page = integer(attributes, "IFD", 0);
        constexpr std::array<const char*, 3> kFirst{"FirstZ", "FirstC", "FirstT"};
        for (size_t axis = 0; axis < 3; ++axis)
            one.first[axis] = integer(attributes, kFirst[axis], 0);
        one.count = integer(attributes, "PlaneCount", one.has_page ? 1 : -1);
        return {};
    }

    bool in_id_ = false;
};

/// The order in which planes follow each other, the fastest axis first.
bool order_of(const std::string& text, std::array<size_t, 3>* out) {
    const std::string letters = "ZCT";
    if (text.size() != 5 || !text.starts_with("XY")) return false;
    size_t seen = 0;
    for (size_t k = 0; k < 3; ++k) {
        const size_t axis = letters.find(text[k + 2]);
        if (axis == std::string::npos) return false;
        (*out)[k] = axis;
        seen |= size_t{1} << axis;
    }
    return seen == 7;
}

/// Lists the place of each plane. Fails where one has none, or the description does not fit.
Result<void> place_planes(const OmeReader& ome, const std::array<size_t, 3>& order, int64_t pages,
                          const std::string& name, TiffSeries* series) {
    const std::array<int64_t, 3> sizes{series->slices, series->channels, series->frames};
    series->places.resize(static_cast<size_t>(series->planes()));
    std::vector<TiffData> data = ome.data;
    if (data.empty()) data.emplace_back();
    for (const TiffData& one : data) {
        std::array<int64_t, 3> at = one.first;
        const bool own =
            one.file.empty() || one.file == name || (!ome.file_id.empty() && one.id == ome.file_id);
        const int64_t most =
            one.count < 0 ? (own ? pages - one.page : series->planes()) : one.count;
        for (int64_t k = 0; k < most; ++k) {
            for (size_t axis = 0; axis < 3; ++axis) {
                if (at[axis] >= sizes[axis]) return user_error(messages::kTiffDescription);
            }
            const int64_t plane = (at[kT] * sizes[kZ] + at[kZ]) * sizes[kC] + at[kC];
            series->places[static_cast<size_t>(plane)] = {own ? "" : one.file, one.page + k};
            size_t digit = 0;
            while (digit < 3 && ++at[order[digit]] == sizes[order[digit]])
                at[order[digit++]] = 0;
            if (digit == 3) break;
        }
    }
    for (const TiffSeries::Place& place : series->places) {
        if (place.page < 0 || (place.file.empty() && place.page >= pages))
            return user_error(fmt::format(messages::kOmePlaneMissing, series->planes(), pages));
    }
    return {};
}

}  // namespace

Result<TiffSeries> read_ome_series(const TiffDirectory& first, int64_t pages,
                                   const std::string& name) {
    OmeReader ome;
    if (Result<void> read = parse_xml(first.description, name, &ome); !read)
        return user_error(messages::kTiffDescription);
    if (ome.elsewhere) return user_error(messages::kOmeElsewhere, messages::kOmeElsewhereHelp);
    if (ome.images != 1)
        return user_error(fmt::format(messages::kSeveralImages, ome.images, ome.images_named),
                          messages::kOneOfThemHelp);
    std::array<size_t, 3> order{};
    if (!order_of(ome.order, &order)) return user_error(messages::kTiffDescription);
    TiffSeries series;
    series.slices = ome.sizes[kZ];
    series.frames = ome.sizes[kT];
    // A channel of several samples is one page, of colours.
    const int64_t samples = std::max(1, first.samples);
    series.channels =
        ome.sizes[kC] % samples == 0 && ome.sizes[kC] > 1 ? ome.sizes[kC] / samples : ome.sizes[kC];
    for (const int64_t size : {series.slices, series.channels, series.frames, series.planes()}) {
        if (size > kMostPlanes) return user_error(messages::kTiffDescription);
    }
    if (Result<void> placed = place_planes(ome, order, pages, name, &series); !placed)
        return placed.error();
    for (int64_t c = 0; c < series.channels; ++c) {
        const bool named = ome.channel_names.size() == static_cast<size_t>(series.channels) &&
                           !ome.channel_names[static_cast<size_t>(c)].empty();
        series.names.push_back(named ? ome.channel_names[static_cast<size_t>(c)]
                                     : std::to_string(c + 1));
    }
    const auto& [x, y, z] = ome.size_mm;
    if (x > 0 && y > 0 && z > 0) {
        series.spacing_mm = ome.size_mm;
        series.unit_mm = ome.unit_mm;
    } else if (!ome.unknown_unit.empty()) {
        series.notes.push_back(fmt::format(messages::kTiffUnitUnknown, ome.unknown_unit));
    } else if (x > 0 && y > 0) {
        series.notes.push_back(fmt::format(messages::kHeightUnknown, x, y));
    }
    return series;
}

}  // namespace openfab::tools
