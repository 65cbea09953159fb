// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/boundary/mesh_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mesh/read/threemf.h"

namespace openfab::testing {

namespace {

uint8_t code_of(const mesh::MeshSource& source, size_t triangle, const pipeline::PrintInfo& info) {
    const std::string& material = source.groups[source.face_groups[triangle]].material;
    uint8_t code = 1;
    while (code < info.materials.size() && info.materials[code - 1u].name != material)
        ++code;
    return code;
}

/// As the build places the mesh: the lowest slice at 0, and nothing below x and y of 0.
pipeline::PrintInfo placed(pipeline::PrintInfo info) {
    info.origin_mm.x = std::max(0.0, info.origin_mm.x);
    info.origin_mm.y = std::max(0.0, info.origin_mm.y);
    info.origin_mm.z = -info.slice_begin * info.pitch_mm.z;
    return info;
}

}  // namespace

Vec3i half_voxels(const Vec3d& mm, const pipeline::PrintInfo& info) {
    Vec3i p;
    for (int a = 0; a < 3; ++a)
        p[a] =
            static_cast<int32_t>(std::lround((mm[a] - info.origin_mm[a]) * 2 / info.pitch_mm[a]));
    return p;
}

CollectedMeshes read_threemf_meshes(const std::string& bytes, const pipeline::PrintInfo& print) {
    const pipeline::PrintInfo info = placed(print);
    const Result<mesh::MeshSource> source = mesh::parse_threemf(bytes, "print.3mf");
    if (!source) {
        ADD_FAILURE() << source.error().text();
        return {};
    }
    CollectedMeshes meshes;
    std::map<uint8_t, std::map<int32_t, uint32_t>> numbers;
    for (size_t t = 0; t < source->mesh.triangles.size(); ++t) {
        const uint8_t code = code_of(*source, t, info);
        std::array<uint32_t, 3> corners{};
        for (size_t c = 0; c < 3; ++c) {
            const int32_t v = source->mesh.triangles[t][c];
            auto& points = meshes[code].points;
            const auto [it, fresh] =
                numbers[code].try_emplace(v, static_cast<uint32_t>(points.size()));
            if (fresh) points.push_back(half_voxels(source->mesh.positions[v], info));
            corners[c] = it->second;
        }
        meshes[code].triangles.push_back(corners);
    }
    return meshes;
}

PaintedMesh read_painted_threemf(const std::string& bytes, const pipeline::PrintInfo& info) {
    const Result<mesh::MeshSource> source = mesh::parse_threemf(bytes, "print.3mf");
    if (!source) {
        ADD_FAILURE() << source.error().text();
        return {};
    }
    PaintedMesh painted;
    for (const Vec3d& p : source->mesh.positions)
        painted.mesh.points.push_back(half_voxels(p, info));
    for (size_t t = 0; t < source->mesh.triangles.size(); ++t) {
        const auto& corners = source->mesh.triangles[t];
        painted.mesh.triangles.push_back({static_cast<uint32_t>(corners[0]),
                                          static_cast<uint32_t>(corners[1]),
                                          static_cast<uint32_t>(corners[2])});
        painted.codes.push_back(code_of(*source, t, info));
    }
    return painted;
}

}  // namespace openfab::testing
