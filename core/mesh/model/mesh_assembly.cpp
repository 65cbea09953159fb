// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/model/mesh_assembly.h"

#include "base/check.h"
#include "base/scan_number.h"

namespace openfab::mesh {
namespace {

constexpr std::array<int32_t, 3> kNone{-1, -1, -1};

}  // namespace

void MeshAssembly::reserve(const MeshCounts& counts) {
    reserved_ = counts;
    source_.mesh.positions.reserve(static_cast<size_t>(counts.vertices));
    source_.part_of_vertex.reserve(static_cast<size_t>(counts.vertices));
    source_.mesh.triangles.reserve(static_cast<size_t>(counts.triangles));
    source_.face_groups.reserve(static_cast<size_t>(counts.triangles));
}

int32_t MeshAssembly::add_vertex(const Vec3d& position) {
    source_.mesh.positions.push_back(position);
    source_.part_of_vertex.push_back(part_);
    return static_cast<int32_t>(source_.mesh.positions.size() - 1);
}

std::optional<size_t> MeshAssembly::attribute(const std::string& name, int32_t components) {
    std::vector<MeshAttribute>& all = source_.mesh.attributes;
    for (size_t i = 0; i < all.size(); ++i) {
        if (all[i].name != name) continue;
        return all[i].components == components ? std::optional(i) : std::nullopt;
    }
    if (all.size() == kMaxAttributes) return {};
    all.push_back({});
    all.back().name = name;
    all.back().components = components;
    all.back().corners.reserve(static_cast<size_t>(reserved_.triangles));
    return all.size() - 1;
}

int32_t MeshAssembly::add_value(size_t attribute, const double* components) {
    OPENFAB_CHECK_LT(attribute, source_.mesh.attributes.size());
    MeshAttribute& a = source_.mesh.attributes[attribute];
    const auto n = static_cast<size_t>(a.components);
    for (size_t c = 0; c < n; ++c) {
        if (!is_position(components[c], 0, 0)) return -1;
    }
    for (size_t c = 0; c < n; ++c)
        a.values.push_back(static_cast<float>(components[c]));
    return static_cast<int32_t>(a.values.size() / n - 1);
}

void MeshAssembly::add_triangle(const std::array<int32_t, 3>& vertices, int32_t group) {
    source_.mesh.triangles.push_back(vertices);
    source_.face_groups.push_back(group);
}

void MeshAssembly::set_corners(size_t attribute, const std::array<int32_t, 3>& values) {
    OPENFAB_CHECK_LT(attribute, source_.mesh.attributes.size());
    OPENFAB_CHECK_GT(triangles(), 0u);  // they are those of the last triangle
    MeshAttribute& a = source_.mesh.attributes[attribute];
    a.corners.resize(triangles(), kNone);
    a.corners.back() = values;
}

MeshSource MeshAssembly::finish(const std::string& file, double unit_mm) {
    for (MeshAttribute& a : source_.mesh.attributes)
        a.corners.resize(triangles(), kNone);
    source_.origin.file = file;
    source_.unit_mm = unit_mm;
    return std::move(source_);
}

}  // namespace openfab::mesh
