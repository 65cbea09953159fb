// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/crossings/voxels.h"

#include <fmt/format.h>
#include <rapidjson/document.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/support/process/process.h"

namespace openfab::testing {

int64_t Voxels::solid() const {
    return std::count_if(codes.begin(), codes.end(), [](uint8_t code) { return code != 0; });
}

Voxels read_voxels(const std::filesystem::path& npy) {
    constexpr size_t kHeaderBytes = 128;
    Voxels out;
    const std::string bytes = read_file(npy);
    const size_t at = bytes.find("'shape': (");
    rapidjson::Document document;
    document.Parse(read_file(npy.string() + ".json").c_str());
    if (at == std::string::npos || document.HasParseError() ||
        std::sscanf(bytes.c_str() + at + 10, "%d, %d, %d", &out.size[2], &out.size[1],
                    &out.size[0]) != 3)
        return {};
    for (rapidjson::SizeType a = 0; a < 3; ++a) {
        out.origin_mm[a] = document["origin_mm"][a].GetDouble();
        out.pitch_mm[a] = document["pitch_mm"][a].GetDouble();
    }
    out.codes.assign(bytes.begin() + kHeaderBytes, bytes.end());
    const auto voxels = static_cast<size_t>(out.size[0]) * static_cast<size_t>(out.size[1]) *
                        static_cast<size_t>(out.size[2]);
    return out.codes.size() == voxels ? out : Voxels();
}

std::string Difference::text() const {
    const std::string grids =
        fmt::format("grids apart by {:.3f} {:.3f} {:.3f} voxels", apart[0], apart[1], apart[2]);
    if (!same_grid) return "other voxels, " + grids;
    return fmt::format("{} of {} voxels at borders differ, and {} others; {}", at_border, border,
                       elsewhere, grids);
}

Difference compare(const Voxels& one, const Voxels& other) {
    Difference out;
    std::array<int, 3> shift{}, least{}, most{};
    out.same_grid = true;
    for (size_t a = 0; a < 3; ++a) {
        const double steps = (one.origin_mm[a] - other.origin_mm[a]) / other.pitch_mm[a];
        shift[a] = static_cast<int>(std::lround(steps));
        out.apart[a] = steps - shift[a];
        out.same_grid = out.same_grid && std::fabs(steps - shift[a]) < 0.05 &&
                        std::fabs(one.pitch_mm[a] / other.pitch_mm[a] - 1) < 1e-9;
        least[a] = std::min(0, shift[a]);
        most[a] = std::max(other.size[a], one.size[a] + shift[a]);
    }
    if (!out.same_grid) return out;
    for (int z = least[2]; z < most[2]; ++z) {
        for (int y = least[1]; y < most[1]; ++y) {
            for (int x = least[0]; x < most[0]; ++x) {
                const uint8_t is = one.at(x - shift[0], y - shift[1], z - shift[2]),
                              expected = other.at(x, y, z);
                bool border = false, as_neighbour = false;
                for (int n = 0; n < 27; ++n) {
                    const int dx = n % 3 - 1, dy = n / 3 % 3 - 1, dz = n / 9 - 1;
                    const uint8_t there = other.at(x + dx, y + dy, z + dz);
                    as_neighbour = as_neighbour || there == is;
                    if (std::abs(dx) + std::abs(dy) + std::abs(dz) == 1)
                        border = border || there != expected;
                }
                out.border += border ? 1 : 0;
                if (is == expected) continue;
                ++(as_neighbour ? out.at_border : out.elsewhere);
            }
        }
    }
    return out;
}

}  // namespace openfab::testing
