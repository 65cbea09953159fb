// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The box of a shape under a map, and voxels that no search for it has seen.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "runtime/solid/shape/shape_extent.h"
#include "runtime/solid/shape/shape_field.h"
#include "runtime/surface/transform_box.h"

namespace openfab::solid {

namespace {

// Boxes that are looked at before those within what was found are left out. The number is part of no
// result.
constexpr size_t kBoxesAtOnce = 64;
constexpr size_t kCentresAtOnce = 4096;  // that are evaluated at once

Affine3d inverse_of_rotation(const Affine3d& map) {
    Affine3d out;
    for (size_t row = 0; row < 3; ++row) {
        for (size_t column = 0; column < 3; ++column)
            out.m[3 * row + column] = map.m[3 * column + row];
    }
    out.t = out.apply_vector(map.t) * -1.0;
    return out;
}

bool contains(const Box3d& outer, const Box3d& inner) {
    for (int a = 0; a < 3; ++a) {
        if (inner.lo[a] < outer.lo[a] || inner.hi[a] > outer.hi[a]) return false;
    }
    return true;
}

/// Calls `visit(box)` for the voxels whose centres may lie in a box.
template <typename Visit>
void visit_voxels(const Box3d& box, const Vec3d& pitch_mm, const Visit& visit) {
    Vec3d lo, hi;
    for (int a = 0; a < 3; ++a) {
        lo[a] = std::ceil(box.lo[a] / pitch_mm[a] - 0.5 - 1e-6);
        hi[a] = std::floor(box.hi[a] / pitch_mm[a] - 0.5 + 1e-6);
    }
    for (double z = lo.z; z <= hi.z; ++z) {
        for (double y = lo.y; y <= hi.y; ++y) {
            for (double x = lo.x; x <= hi.x; ++x) {
                Box3d voxel;
                const Vec3d at{x, y, z};
                for (int a = 0; a < 3; ++a) {
                    voxel.lo[a] = at[a] * pitch_mm[a];
                    voxel.hi[a] = (at[a] + 1) * pitch_mm[a];
                }
                visit(voxel);
            }
        }
    }
}

}  // namespace

const ShapeExtent& ShapeField::extent(const std::array<double, 9>& turn) const {
    {
        const std::lock_guard lock(extents_mutex_);
        if (const auto at = extents_.find(turn); at != extents_.end()) return at->second;
    }
    // Without the lock: a thread that waits for its tasks may take up one that needs it.
    ShapeExtent found = find_extent(*this, turn);
    const std::lock_guard lock(extents_mutex_);
    return extents_.try_emplace(turn, std::move(found)).first->second;
}

Box3d ShapeField::exact_box(const Affine3d& local_to_other) const {
    Box3d out = extent(local_to_other.m).box;
    if (out.empty()) return out;
    return {out.lo + local_to_other.t, out.hi + local_to_other.t};
}

Box3d ShapeField::voxels_beyond(const Affine3d& local_to_other, const Vec3d& pitch_mm,
                                const Box3d& known) const {
    const std::vector<Box3f>& open = extent(local_to_other.m).open;
    const Affine3d back = inverse_of_rotation(local_to_other);
    Box3d all = known, out;
    for (size_t first = 0; first < open.size(); first += kBoxesAtOnce) {
        const size_t count = std::min(kBoxesAtOnce, open.size() - first);
        std::vector<Box3d> found(count);
        tbb::parallel_for(size_t{0}, count, [&](size_t i) {
            const Box3d box = surface::transform_box(local_to_other, open[first + i]);
            if (contains(all, box)) return;
            ShapeCalls* calls = take();
            ShapePoints points;
            std::vector<Box3d> voxels;
            std::vector<float> values;
            const auto evaluate = [&] {
                if (const abi::KernelStatus status = calls->values(points, &values); !status.ok())
                    note(status);
                for (size_t k = 0; k < voxels.size(); ++k) {
                    if (values[k] < 0) found[i].add(voxels[k]);
                }
                points.clear();
                voxels.clear();
            };
            visit_voxels(box, pitch_mm, [&](const Box3d& voxel) {
                if (contains(all, voxel)) return;
                const Vec3f p = vec_cast<float>(back.apply(voxel.center()));
                for (int a = 0; a < 3; ++a) {
                    if (p[a] < box_.lo[a] || p[a] > box_.hi[a]) return;
                }
                points.push_back(p);
                voxels.push_back(voxel);
                if (voxels.size() == kCentresAtOnce) evaluate();
            });
            evaluate();
            give(calls);
        });
        for (const Box3d& box : found)
            all.add(box), out.add(box);
    }
    return out;
}

}  // namespace openfab::solid
