// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/process/nozzles/nozzles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/at.h"

#include "abi/fablet_table.h"
#include "runtime/process/nozzles/messages.h"

namespace openfab::process {

namespace {

int64_t floor_divide(int64_t a, int64_t b) {
    return a / b - (a % b < 0 ? 1 : 0);
}

int64_t floor_modulo(int64_t a, int64_t b) {
    return a - floor_divide(a, b) * b;
}

/// Sums of multiples of these, modulo 1, fill any box of voxels evenly: the golden section and the square
/// roots of 2 and 3; and those of 7, 11 and 13.
using Steps = std::array<uint32_t, 3>;
constexpr Steps kOfRows{0x9e3779b9, 0x6a09e667, 0xbb67ae85};
constexpr Steps kOfLayers{0xa54ff53a, 0x510e527f, 0x9b05688c};

/// Whether a voxel lies in more than one row.
bool is_coarse(double rows_a_voxel) {
    return rows_a_voxel > 1 + 1e-6;
}

/// Returns the first and last row of a voxel.
Vec2<int64_t> rows_of(double first, double rows_a_voxel, int32_t voxel) {
    const auto row = [&](double part) {
        return static_cast<int64_t>(std::floor(first + (voxel + part) * rows_a_voxel));
    };
    if (is_coarse(rows_a_voxel)) return {row(0), row(1)};
    // At the machine's own pitch that of the voxel's middle is exactly its own, whatever the last bits.
    return {row(0.5), row(0.5)};
}

/// Returns the row that a voxel counts as: at its middle, or in a draft anywhere in it.
int64_t row_at(double first, double rows_a_voxel, const Vec3i& voxel, int axis,
               const Steps& steps) {
    if (!is_coarse(rows_a_voxel)) return rows_of(first, rows_a_voxel, voxel[axis]).x;
    const uint32_t sum = static_cast<uint32_t>(voxel.x) * steps[0] +
                         static_cast<uint32_t>(voxel.y) * steps[1] +
                         static_cast<uint32_t>(voxel.z) * steps[2];
    return static_cast<int64_t>(std::floor(first + (voxel[axis] + sum * 0x1p-32) * rows_a_voxel));
}

}  // namespace

bool DeadRows::holds(int64_t row, int64_t layer) const {
    const int64_t shifted = row + jog * layer;
    if (pass >= 0 && floor_modulo(shifted, passes) != pass) return false;
    int64_t nozzle = floor_divide(shifted, passes);
    if (head > 0) nozzle = floor_modulo(nozzle, head);
    return std::any_of(nozzles.begin(), nozzles.end(), [&](const Vec2<int32_t>& range) {
        return nozzle >= range.x && nozzle <= range.y;
    });
}

MachineRows MachineRows::of(const Vec3d& origin_mm, const Vec3d& pitch_mm,
                            const Vec3d& own_pitch_mm) {
    return {origin_mm.y / own_pitch_mm.y, pitch_mm.y / own_pitch_mm.y, origin_mm.z / own_pitch_mm.z,
            pitch_mm.z / own_pitch_mm.z};
}

Vec2<int64_t> MachineRows::rows(int32_t y) const {
    return rows_of(first_row, rows_a_voxel, y);
}

Vec2<int64_t> MachineRows::layers(int32_t z) const {
    return rows_of(first_layer, layers_a_voxel, z);
}

int64_t MachineRows::row(const Vec3i& voxel) const {
    return row_at(first_row, rows_a_voxel, voxel, 1, kOfRows);
}

int64_t MachineRows::layer(const Vec3i& voxel) const {
    return row_at(first_layer, layers_a_voxel, voxel, 2, kOfLayers);
}

Nozzles::Nozzles(std::vector<DeadRows> dead, const MachineRows& rows)
    : dead_(std::move(dead)),
      rows_(rows),
      jogs_(std::ranges::any_of(dead_, [](const DeadRows& each) { return each.jog != 0; })) {}

bool Nozzles::map(int64_t row, int64_t layer, CodeMap* map) const {
    for (size_t code = 0; code < map->size(); ++code)
        (*map)[code] = static_cast<uint8_t>(code);
    std::array<uint8_t, 256> next{};  // by code; 0: it is alive
    bool any = false;
    for (const DeadRows& dead : dead_) {
        if (next[dead.material] != 0 || !dead.holds(row, layer)) continue;
        next[dead.material] = dead.substitute;
        any = true;
    }
    if (!any) return false;
    for (size_t code = 1; code < next.size(); ++code) {
        uint8_t to = static_cast<uint8_t>(code);
        for (size_t step = 0; step < dead_.size() && next[to] != 0; ++step)
            to = next[to];
        (*map)[code] = next[to] == 0 ? to : static_cast<uint8_t>(code);
    }
    return true;
}

Result<void> Nozzles::check(const Vec3i& size, const std::vector<std::string>& names) const {
    // Where no chain of substitutes comes back to its beginning, each ends with a material that is alive.
    std::array<std::array<bool, 256>, 256> leads{};
    for (const DeadRows& dead : dead_)
        leads[dead.material][dead.substitute] = true;
    for (size_t by = 0; by < 256; ++by) {
        for (size_t from = 0; from < 256; ++from) {
            for (size_t to = 0; leads[from][by] && to < 256; ++to)
                leads[from][to] |= leads[by][to];
        }
    }
    bool circular = false;
    for (size_t code = 0; code < 256; ++code)
        circular = circular || leads[code][code];
    if (!circular) return {};
    const int64_t first_layer = rows_.layers(0).x;
    const int64_t last_layer = jogs_ ? rows_.layers(size.z - 1).y : first_layer;
    CodeMap found;
    for (int64_t layer = first_layer; layer <= last_layer; ++layer) {
        for (int64_t row = rows_.rows(0).x; row <= rows_.rows(size.y - 1).y; ++row) {
            if (!map(row, layer, &found)) continue;
            for (const DeadRows& dead : dead_) {
                if (found[dead.material] != dead.material || !dead.holds(row, layer)) continue;
                return user_error(
                    fmt::format(messages::kSubstitutesInCircle, row, names[dead.material]));
            }
        }
    }
    return {};
}

/// The maps of the voxels of a row in the slices of a slab. Different ones alone are kept; the first changes nothing.
class Nozzles::RowMaps {
  public:
    using Column = std::array<uint16_t, 8>;  ///< numbers of maps, by slice

    RowMaps(const Nozzles& nozzles, int32_t slab)
        : nozzles_(nozzles),
          rows_(nozzles.rows_),
          slab_(slab),
          alike_(!is_coarse(rows_.rows_a_voxel) &&
                 !(nozzles.jogs_ && is_coarse(rows_.layers_a_voxel))) {
        for (size_t z = 0; z < 8; ++z) {
            layers_[z] = rows_.layers(8 * slab + static_cast<int32_t>(z));
            if (!nozzles.jogs_) layers_[z].y = layers_[z].x;
        }
    }

    /// Takes another row; returns whether any of its voxels may change.
    bool begin(int32_t y) {
        y_ = y;
        of_rows_ = rows_.rows(y);
        maps_.assign(1, identity());
        numbers_.clear();
        CodeMap found;
        for (size_t z = 0; z < 8; ++z) {
            first_[z] = numbers_.size();
            for (int64_t layer = layers_[z].x; layer <= layers_[z].y; ++layer) {
                for (int64_t row = of_rows_.x; row <= of_rows_.y; ++row)
                    numbers_.push_back(nozzles_.map(row, layer, &found) ? number_of(found) : 0);
            }
        }
        column_ = column_at(0);
        return maps_.size() > 1;
    }
    /// Returns the maps of the column of voxels at x.
    const Column& column(int32_t x) {
        if (!alike_) column_ = column_at(x);
        return column_;
    }
    const CodeMap& map(uint16_t number) const { return maps_[number]; }
    void substitute(const Column& numbers, uint8_t* codes) const {
        for (size_t z = 0; z < 8; ++z)
            codes[z] = maps_[numbers[z]][codes[z]];
    }

  private:
    static CodeMap identity() {
        CodeMap map;
        for (size_t code = 0; code < map.size(); ++code)
            map[code] = static_cast<uint8_t>(code);
        return map;
    }
    uint16_t number_of(const CodeMap& map) {
        const auto known = std::find(maps_.begin(), maps_.end(), map);
        const auto number = static_cast<uint16_t>(known - maps_.begin());
        if (known == maps_.end()) maps_.push_back(map);
        return number;
    }
    Column column_at(int32_t x) const {
        Column out;
        const auto rows = static_cast<size_t>(of_rows_.y - of_rows_.x + 1);
        for (size_t z = 0; z < 8; ++z) {
            const Vec3i voxel{x, y_, 8 * slab_ + static_cast<int32_t>(z)};
            const auto row = static_cast<size_t>(rows_.row(voxel) - of_rows_.x);
            const auto layer = layers_[z].x == layers_[z].y
                                   ? size_t{0}
                                   : static_cast<size_t>(rows_.layer(voxel) - layers_[z].x);
            out[z] = numbers_[first_[z] + layer * rows + row];
        }
        return out;
    }

    const Nozzles& nozzles_;
    const MachineRows& rows_;
    const int32_t slab_;
    const bool alike_;  ///< columns of a row, whatever their x
    int32_t y_ = 0;
    Vec2<int64_t> of_rows_{};
    std::array<Vec2<int64_t>, 8> layers_;
    std::vector<CodeMap> maps_;
    std::array<size_t, 8> first_{};  ///< by slice, in numbers_
    std::vector<uint16_t> numbers_;  ///< of maps, by slice, layer and row
    Column column_{};
};

void Nozzles::before_dither(int32_t slab, int32_t height, dither::RowBand* band) const {
    RowMaps maps(*this, slab);
    for (int32_t y = 0; y < std::min(8, height - 8 * band->row); ++y) {
        if (maps.begin(8 * band->row + y)) apply_to_row(y, &maps, band);
    }
}

void Nozzles::after_dither(int32_t slab, int32_t height, dither::RowBand* band) const {
    RowMaps maps(*this, slab);
    for (int32_t y = 0; y < std::min(8, height - 8 * band->row); ++y) {
        if (!maps.begin(8 * band->row + y)) continue;
        for (int32_t x = 8 * band->first_block; x < 8 * band->end_block; ++x)
            maps.substitute(maps.column(x), band->codes_at(x, y));
    }
}

void Nozzles::apply_to_row(int32_t y, RowMaps* maps, dither::RowBand* band) const {
    // Voxels of many rows may share a column of fractions, so each that changes becomes a new one.
    int32_t before = -1, after = -1;
    RowMaps::Column by{};
    uint8_t pure = 0;                // slices of it that have one material now
    std::array<uint8_t, 8> codes{};  // which one
    uint8_t* marks = band->mixed_row(y);
    for (int32_t x = 8 * band->first_block; x < 8 * band->end_block; ++x) {
        const RowMaps::Column& numbers = maps->column(x);
        if (numbers == RowMaps::Column{}) continue;
        maps->substitute(numbers, band->codes_at(x, y));
        if (marks[x] == 0) continue;
        int32_t& column = at(band->columns, y * band->width() + x);
        if (column != before || numbers != by) {
            before = column;
            by = numbers;
            after = band->add_columns(1);
            const uint16_t* from = band->fractions_at(before);
            uint16_t* to = band->fractions_at(after);
            pure = 0;
            for (int32_t z = 0; z < 8; ++z) {
                const CodeMap& map = maps->map(at(numbers, z));
                int32_t materials = 0;
                for (int32_t m = 0; m < band->channels; ++m) {
                    const uint16_t amount = from[8 * m + z];
                    uint16_t& sum = to[8 * at(map, m) + z];
                    if (amount == 0) continue;
                    materials += sum == 0 ? 1 : 0;
                    sum = static_cast<uint16_t>(sum + amount);
                    at(codes, z) = at(map, m);
                }
                pure = static_cast<uint8_t>(pure | (materials <= 1 ? 1 << z : 0));
            }
        }
        column = after;
        const auto turned = static_cast<uint8_t>(marks[x] & pure);
        if (turned == 0) continue;
        uint8_t* out = band->codes_at(x, y);
        for (size_t z = 0; z < 8; ++z)
            out[z] = (turned >> z & 1) != 0 ? codes[z] : out[z];
        marks[x] = static_cast<uint8_t>(marks[x] & ~turned);
    }
}

}  // namespace openfab::process
