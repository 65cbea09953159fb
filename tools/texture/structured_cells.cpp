// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/structured_cells.h"

#include <fmt/format.h>

#include "tools/texture/check_memory.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

Result<int64_t> structured_points(const std::array<int64_t, 3>& points_along) {
    const auto [nx, ny, nz] = points_along;
    int64_t points = 1;
    for (const int64_t n : points_along) {
        if (n < 2) return user_error(fmt::format(messages::kNoCellBetweenPoints, nx, ny, nz));
        if (n > INT32_MAX / points)
            return user_error(fmt::format(messages::kMoreThanPoints, INT32_MAX));
        points *= n;
    }
    return points;
}

Result<CellMesh> structured_cells(const std::array<int64_t, 3>& points_along, int32_t channels,
                                  bool of_points, const texture::ReadLimits& limits) {
    const Result<int64_t> counted = structured_points(points_along);
    if (!counted) return counted.error();
    const auto [nx, ny, nz] = points_along;
    const int64_t points = *counted, cells = (nx - 1) * (ny - 1) * (nz - 1);
    constexpr int64_t kCorners = 8, kBytesOfPoint = 24, kBytesOfCell = 4 * kCorners + 1;
    const int64_t values = (of_points ? points : cells) * channels;
    if (Result<void> fits = check_memory(points * kBytesOfPoint + cells * kBytesOfCell + 4 * values,
                                         limits.memory_bytes);
        !fits)
        return fits.error();
    CellMesh mesh;
    mesh.channels = channels;
    mesh.of_points = of_points;
    mesh.types.assign(static_cast<size_t>(cells), CellType::kHexahedron);
    mesh.corners.reserve(static_cast<size_t>(cells * kCorners));
    for (int64_t z = 0; z + 1 < nz; ++z) {
        for (int64_t y = 0; y + 1 < ny; ++y) {
            for (int64_t x = 0; x + 1 < nx; ++x) {
                const auto low = static_cast<int32_t>((z * ny + y) * nx + x);
                const auto row = static_cast<int32_t>(nx), layer = static_cast<int32_t>(nx * ny);
                for (const int32_t base : {low, low + layer}) {
                    for (const int32_t corner : {base, base + 1, base + row + 1, base + row})
                        mesh.corners.push_back(corner);
                }
            }
        }
    }
    return mesh;
}

}  // namespace openfab::tools
