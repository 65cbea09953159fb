// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/crossed_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/at.h"
#include "tools/texture/cell_field.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/messages.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/structured_cells.h"

namespace openfab::tools {

namespace {

/// Where the centre of a texel lies along one axis.
struct Place {
    int64_t cell = 0;
    double part = 0;  ///< of the cell; below 0 or above 1 just outside of all
};

/// Finds the first cell that holds a place, else the nearest. Cells of no width hold none.
Place place_of(const std::vector<double>& axis, double where) {
    constexpr double kOnFace = 1e-9;  // of a cell, as that of cell_field.cpp
    const double sign = axis.back() < axis.front() ? -1 : 1;
    const auto cells = static_cast<int64_t>(axis.size()) - 1;
    const auto width = [&](int64_t i) { return sign * (at(axis, i + 1) - at(axis, i)); };
    int64_t low = 0, high = cells - 1;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        const double end = sign * at(axis, middle + 1);
        if (end + kOnFace * width(middle) < sign * where) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    while (low + 1 < cells && width(low) == 0)
        ++low;
    while (low > 0 && width(low) == 0)
        --low;
    return {low, sign * (where - at(axis, low)) / width(low)};
}

class CrossedReader final : public VolumeReader {
  public:
    CrossedReader(CrossedField field, const ResampledBox& box) : field_(std::move(field)) {
        box.place(this);
        channels = field_.channels;
        for (int a = 0; a < 3; ++a) {
            for (int32_t i = 0; i < size[a]; ++i) {
                const Vec3d center = box.center(i, i, i);
                places_[static_cast<size_t>(a)].push_back(
                    place_of(field_.axes[static_cast<size_t>(a)], center[a]));
            }
        }
        const auto width = static_cast<size_t>(channels);
        lows_.assign(width, std::numeric_limits<float>::max());
        highs_.assign(width, std::numeric_limits<float>::lowest());
        for (size_t i = 0; i < field_.values.size(); ++i) {
            lows_[i % width] = std::min(lows_[i % width], field_.values[i]);
            highs_[i % width] = std::max(highs_[i % width], field_.values[i]);
        }
        line_.resize(width * field_.axes[0].size());
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const Place& high = places_[2][static_cast<size_t>(z)];
        for (int32_t y = 0; y < size.y; ++y) {
            const Place& across = places_[1][static_cast<size_t>(y)];
            if (field_.of_points) {
                row_of_points(across, high, out);
            } else {
                row_of_cells(across.cell, high.cell, out);
            }
            out += row_floats();
            wrote(4 * row_floats());
        }
        return {};
    }

  private:
    /// Returns the first value of a row of points or cells.
    const float* row(int64_t y, int64_t z) const {
        const int64_t less = field_.of_points ? 0 : 1;
        const int64_t nx = static_cast<int64_t>(field_.axes[0].size()) - less;
        const int64_t ny = static_cast<int64_t>(field_.axes[1].size()) - less;
        return field_.values.data() + (z * ny + y) * nx * channels;
    }

    void row_of_cells(int64_t y, int64_t z, float* out) const {
        const float* const from = row(y, z);
        for (const Place& place : places_[0])
            out = std::copy_n(from + place.cell * channels, channels, out);
    }

    /// Interpolates along y and z between the points of the grid, then along x.
    void row_of_points(const Place& y, const Place& z, float* out) {
        std::fill(line_.begin(), line_.end(), 0.0);
        for (int corner = 0; corner < 4; ++corner) {
            const bool back = (corner & 1) != 0, up = (corner & 2) != 0;
            const double weight = (back ? y.part : 1 - y.part) * (up ? z.part : 1 - z.part);
            const float* const from = row(y.cell + (back ? 1 : 0), z.cell + (up ? 1 : 0));
            for (size_t i = 0; i < line_.size(); ++i)
                line_[i] += weight * static_cast<double>(from[i]);
        }
        for (const Place& x : places_[0]) {
            const double* const at = line_.data() + x.cell * channels;
            for (int32_t c = 0; c < channels; ++c) {
                const double value = (1 - x.part) * at[c] + x.part * at[c + channels];
                const auto k = static_cast<size_t>(c);
                *out++ = std::clamp(static_cast<float>(value), lows_[k], highs_[k]);
            }
        }
    }

    CrossedField field_;
    std::array<std::vector<Place>, 3> places_;
    std::vector<float> lows_, highs_;
    std::vector<double> line_;  ///< values at the points of a row, channels innermost
};

}  // namespace

Result<int64_t> crossed_items(const std::array<int64_t, 3>& points_along, int32_t channels,
                              bool of_points, const texture::ReadLimits& limits) {
    const Result<int64_t> points = structured_points(points_along);
    if (!points) return points.error();
    int64_t items = 1, places = 0;
    for (const int64_t n : points_along) {
        items *= of_points ? n : n - 1;
        places += n;
    }
    // The values, the places, and a row of values.
    const int64_t needed = 4 * items * channels + (8 + 8 * channels) * places;
    if (Result<void> fits = check_memory(needed, limits.memory_bytes); !fits) return fits.error();
    return items;
}

MadeReader open_crossed_field(CrossedField field, const texture::VolumeOptions& options) {
    if (Result<void> fine = settle_field_values(options.outside, &field.values); !fine)
        return fine.error();
    Box3d bounds;
    double cells = 1;
    for (int a = 0; a < 3; ++a) {
        const std::vector<double>& axis = field.axes[static_cast<size_t>(a)];
        if (!std::all_of(axis.begin(), axis.end(), [](double at) { return std::isfinite(at); }))
            return user_error(fmt::format(messages::kPlaceNotFinite, "xyz"[a]));
        if (!std::is_sorted(axis.begin(), axis.end()) &&
            !std::is_sorted(axis.rbegin(), axis.rend()))
            return user_error(fmt::format(messages::kPlacesNotMonotonic, "xyz"[a]));
        const auto [low, high] = std::minmax(axis.front(), axis.back());
        bounds.lo[a] = low;
        bounds.hi[a] = high;
        cells *= static_cast<double>(axis.size() - 1);
    }
    const Result<ResampledBox> box = cell_box(bounds, cells, options);
    if (!box) return box.error();
    return std::unique_ptr<VolumeReader>(std::make_unique<CrossedReader>(std::move(field), *box));
}

}  // namespace openfab::tools
