// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/process/nozzles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "abi/fablet_table.h"
#include "runtime/process/messages.h"

namespace openfab::process {

namespace {

int64_t floor_divide(int64_t a, int64_t b) {
    return a / b - (a % b < 0 ? 1 : 0);
}

int64_t floor_modulo(int64_t a, int64_t b) {
    return a - floor_divide(a, b) * b;
}

/// The machine's row that the middle of a voxel lies in; at the machine's own pitch exactly that of the
/// voxel, whatever the last bits.
int64_t row_at(double first, double rows_a_voxel, int32_t voxel) {
    return static_cast<int64_t>(std::floor(first + (voxel + 0.5) * rows_a_voxel));
}

void substitute_codes(uint8_t* column, const std::array<Nozzles::CodeMap, 8>& maps) {
    for (size_t z = 0; z < 8; ++z)
        column[z] = maps[z][column[z]];
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

int64_t MachineRows::row(int32_t y) const {
    return row_at(first_row, rows_a_voxel, y);
}

int64_t MachineRows::layer(int32_t z) const {
    return row_at(first_layer, layers_a_voxel, z);
}

bool Nozzles::map(int32_t y, int32_t z, CodeMap* map) const {
    for (size_t code = 0; code < map->size(); ++code)
        (*map)[code] = static_cast<uint8_t>(code);
    std::array<uint8_t, 256> next{};  // by code; 0: it is alive
    const int64_t row = rows_.row(y), layer = rows_.layer(z);
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
    const bool jogs =
        std::any_of(dead_.begin(), dead_.end(), [](const DeadRows& dead) { return dead.jog != 0; });
    const int32_t layers = jogs ? size.z : 1;
    CodeMap found;
    for (int32_t z = 0; z < layers; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            if (!map(y, z, &found)) continue;
            const int64_t row = rows_.row(y), layer = rows_.layer(z);
            for (const DeadRows& dead : dead_) {
                if (found[dead.material] != dead.material || !dead.holds(row, layer)) continue;
                return user_error(
                    fmt::format(messages::kSubstitutesInCircle, row, names[dead.material]));
            }
        }
    }
    return {};
}

bool Nozzles::maps_of_row(int32_t y, int32_t slab, std::array<CodeMap, 8>* maps) const {
    bool any = false;
    for (int32_t z = 0; z < 8; ++z)
        any |= map(y, 8 * slab + z, &(*maps)[static_cast<size_t>(z)]);
    return any;
}

void Nozzles::apply(int32_t slab, int32_t height, dither::RowBand* band) const {
    std::array<CodeMap, 8> maps;
    for (int32_t y = 0; y < std::min(8, height - 8 * band->row); ++y) {
        if (maps_of_row(8 * band->row + y, slab, &maps)) apply_to_row(y, maps, band);
    }
}

void Nozzles::apply_to_codes(int32_t slab, int32_t height, dither::RowBand* band) const {
    std::array<CodeMap, 8> maps;
    for (int32_t y = 0; y < std::min(8, height - 8 * band->row); ++y) {
        if (!maps_of_row(8 * band->row + y, slab, &maps)) continue;
        for (int32_t x = 8 * band->first_block; x < 8 * band->end_block; ++x)
            substitute_codes(band->codes_at(x, y), maps);
    }
}

void Nozzles::apply_to_row(int32_t y, const std::array<CodeMap, 8>& maps,
                           dither::RowBand* band) const {
    // Voxels of many rows may share a column of fractions, so each that changes becomes a new one.
    int32_t before = -1, after = -1;
    uint8_t pure = 0;                // slices of it that have one material now
    std::array<uint8_t, 8> codes{};  // which one
    uint8_t* marks = band->mixed_row(y);
    for (int32_t x = 8 * band->first_block; x < 8 * band->end_block; ++x) {
        substitute_codes(band->codes_at(x, y), maps);
        if (marks[x] == 0) continue;
        int32_t& column = band->columns[static_cast<size_t>(y * band->width() + x)];
        if (column != before) {
            before = column;
            after = band->add_columns(1);
            const uint16_t* from = band->fractions_at(before);
            uint16_t* to = band->fractions_at(after);
            pure = 0;
            for (int32_t z = 0; z < 8; ++z) {
                const CodeMap& map = maps[static_cast<size_t>(z)];
                int32_t materials = 0;
                for (int32_t m = 0; m < band->channels; ++m) {
                    const uint16_t amount = from[8 * m + z];
                    uint16_t& sum = to[8 * map[static_cast<size_t>(m)] + z];
                    if (amount == 0) continue;
                    materials += sum == 0 ? 1 : 0;
                    sum = static_cast<uint16_t>(sum + amount);
                    codes[static_cast<size_t>(z)] = map[static_cast<size_t>(m)];
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
