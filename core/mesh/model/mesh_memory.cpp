// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/model/mesh_memory.h"

#include <fmt/format.h>

#include "mesh/model/messages.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kMegabyte = 1'000'000;

int64_t as_count(size_t n) {
    return static_cast<int64_t>(n);
}

}  // namespace

MeshCounts counts_of(const Mesh& mesh) {
    MeshCounts counts;
    counts.vertices = as_count(mesh.positions.size());
    counts.triangles = as_count(mesh.triangles.size());
    for (const MeshAttribute& a : mesh.attributes) {
        counts.values += as_count(a.values.size() + a.faces.size());
        counts.attributes += a.is_int ? 0 : 1;
    }
    return counts;
}

MeshCounts counts_of(const MeshSource& source) {
    MeshCounts counts = counts_of(source.mesh);
    counts.group_bytes = source.group_bytes();
    return counts;
}

int64_t mesh_bytes(const MeshCounts& counts) {
    constexpr int64_t kVertex = sizeof(Vec3d) + sizeof(int32_t);  // and its part
    constexpr int64_t kTriangle =
        sizeof(std::array<int32_t, 3>) + 2 * sizeof(int32_t);  // group, line
    constexpr int64_t kCorners = sizeof(std::array<int32_t, 3>);
    constexpr int64_t kValue = sizeof(float);
    return counts.vertices * kVertex +
           counts.triangles * (kTriangle + counts.attributes * kCorners) + counts.values * kValue +
           counts.group_bytes;
}

int64_t preparing_bytes(const MeshCounts& counts) {
    // Edges (48 bytes a triangle) beside either the table of equal vertices, the keys of equal
    // triangles, or the tree of boxes; reading_memory_test measures that this is enough.
    constexpr int64_t kVertex = 45;
    constexpr int64_t kTriangle = 160;
    return mesh_bytes(counts) + counts.vertices * kVertex + counts.triangles * kTriangle +
           counts.group_bytes;
}

int64_t growing_bytes(int64_t held) {
    return 3 * held;
}

Error too_large_to_read(const std::string& file, int64_t triangles, int64_t needed,
                        int64_t allowed) {
    return user_error(fmt::format(messages::kTooLargeToRead, file, triangles,
                                  needed / kMegabyte + 1, allowed / kMegabyte));
}

}  // namespace openfab::mesh
