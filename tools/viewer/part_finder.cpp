// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/part_finder.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/affine.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

Vec3d solve(const Affine3d& transform, const Vec3d& to) {
    const Affine3d c = cofactors(transform);
    const double det = determinant(transform);
    const Vec3d d = to - transform.t;
    // The inverse is the transposed cofactors over the determinant.
    return {(c.m[0] * d.x + c.m[3] * d.y + c.m[6] * d.z) / det,
            (c.m[1] * d.x + c.m[4] * d.y + c.m[7] * d.z) / det,
            (c.m[2] * d.x + c.m[5] * d.y + c.m[8] * d.z) / det};
}

/// How often a closed mesh winds around a point: signed crossings of a ray upwards.
int winding_number(const mesh::Mesh& mesh, const Vec3d& p) {
    int winding = 0;
    for (const std::array<int32_t, 3>& triangle : mesh.triangles) {
        const Vec3d& a = mesh.positions[static_cast<size_t>(triangle[0])];
        const Vec3d& b = mesh.positions[static_cast<size_t>(triangle[1])];
        const Vec3d& c = mesh.positions[static_cast<size_t>(triangle[2])];
        if (std::max({a.z, b.z, c.z}) < p.z) continue;
        const auto side = [&](const Vec3d& u, const Vec3d& v) {
            return (u.x - p.x) * (v.y - p.y) - (u.y - p.y) * (v.x - p.x);
        };
        const double ab = side(a, b);
        const double bc = side(b, c);
        const double ca = side(c, a);
        const bool up = ab > 0 && bc > 0 && ca > 0;
        if (!up && !(ab < 0 && bc < 0 && ca < 0)) continue;
        const double z = (a.z * bc + b.z * ca + c.z * ab) / (ab + bc + ca);
        if (z > p.z) winding += up ? 1 : -1;
    }
    return winding;
}

}  // namespace

PartFinder::PartFinder(std::shared_ptr<const world::World> world) : world_(std::move(world)) {
    for (const mesh::Mesh& mesh : world_->meshes) {
        Box3d box;
        for (const Vec3d& p : mesh.positions)
            box.add(p);
        boxes_.push_back(box);
    }
}

std::string PartFinder::at(const Vec3d& point_mm) const {
    const world::Placement* found = nullptr;
    const auto priority = [&](const world::Placement& placement) {
        return world_->objects[static_cast<size_t>(placement.object)].priority;
    };
    for (const world::Placement& placement : world_->build) {
        if (found != nullptr && priority(placement) < priority(*found)) continue;
        const auto mesh =
            static_cast<size_t>(world_->objects[static_cast<size_t>(placement.object)].mesh);
        Vec3d p = solve(placement.transform, point_mm);
        const Box3d& box = boxes_[mesh];
        // Edges of a mesh like to lie on round numbers, where a ray must not run.
        const Vec3d size = box.size();
        p.x += size.x * 1.37e-7;
        p.y += size.y * 2.11e-7;
        bool beside = box.empty();
        for (int a = 0; a < 3; ++a)
            beside = beside || !(p[a] >= box.lo[a] && p[a] <= box.hi[a]);
        if (!beside && winding_number(world_->meshes[mesh], p) != 0) found = &placement;
    }
    if (found == nullptr) return {};
    const std::string& name = world_->objects[static_cast<size_t>(found->object)].name;
    const auto same = [&](const world::Placement& other) { return other.object == found->object; };
    const auto all = std::count_if(world_->build.begin(), world_->build.end(), same);
    if (all == 1) return name;
    const auto place = world_->build.begin() + (found - world_->build.data());
    return fmt::format(messages::kPlacementOf, name,
                       std::count_if(world_->build.begin(), place, same) + 1, all);
}

}  // namespace openfab::viewer
