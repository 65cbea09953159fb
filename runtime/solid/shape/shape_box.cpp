// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The box of a shape under a map, voxels that no search for it has seen, and on which side of it boxes are.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

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

/// A shape for the search of its extent. A kernel that fails is noted; what it leaves is inside nowhere.
class ShapeValue final : public SolidValue {
  public:
    explicit ShapeValue(const ShapeField& field) : field_(field) {}

    Box3f box() const override { return field_.bounds(); }
    void values(std::span<const Vec3f> points, float* out) const override {
        ask_at(&ShapeCalls::values, points, out);
    }
    void signs(std::span<const Vec3f> points, float* out) const override {
        ask_at(&ShapeCalls::signs, points, out);
    }
    void lower_bounds(std::span<const Box3f> boxes, float* out) const override {
        ShapePoints lo, hi;
        for (const Box3f& box : boxes)
            lo.push_back(box.lo), hi.push_back(box.hi);
        std::vector<float> value_lo, value_hi;
        ask([&](ShapeCalls* calls) { return calls->sign_bounds(lo, hi, &value_lo, &value_hi); },
            boxes.size(), &value_lo);
        std::copy_n(value_lo.begin(), boxes.size(), out);
    }

  private:
    using AtPoints = abi::KernelStatus (ShapeCalls::*)(const ShapePoints&, std::vector<float>*);
    void ask_at(AtPoints call, std::span<const Vec3f> points, float* out) const {
        ShapePoints some;
        for (const Vec3f& p : points)
            some.push_back(p);
        std::vector<float> found;
        ask([&](ShapeCalls* calls) { return (calls->*call)(some, &found); }, points.size(), &found);
        std::copy_n(found.begin(), points.size(), out);
    }
    template <typename Call>
    void ask(const Call& call, size_t count, std::vector<float>* out) const {
        ShapeCalls* calls = field_.take();
        if (const abi::KernelStatus status = call(calls); !status.ok()) {
            field_.note(status);
            out->assign(count, 0);
        }
        field_.give(calls);
    }
    const ShapeField& field_;
};

}  // namespace

const Extent& ShapeField::extent(const std::array<double, 9>& turn,
                                 std::span<const pieces::Side> sides) const {
    std::pair<std::array<double, 9>, std::vector<double>> key{turn, {}};
    for (const pieces::Side& side : sides) {
        const double sign = side.front ? -1 : 1;
        for (int a = 0; a < 3; ++a)
            key.second.push_back(sign * side.normal[a]);
        key.second.push_back(sign * side.offset);
    }
    {
        const std::lock_guard lock(extents_mutex_);
        if (const auto at = extents_.find(key); at != extents_.end()) return at->second;
    }
    // Without the lock: a thread that waits for its tasks may take up one that needs it.
    Extent found = find_extent(ShapeValue(*this), turn, sides);
    const std::lock_guard lock(extents_mutex_);
    return extents_.try_emplace(std::move(key), std::move(found)).first->second;
}

Box3d ShapeField::exact_box(const Affine3d& local_to_other,
                            std::span<const pieces::Side> sides) const {
    Box3d out = extent(local_to_other.m, sides).box;
    if (out.empty()) return out;
    return {out.lo + local_to_other.t, out.hi + local_to_other.t};
}

void ShapeField::sides(const std::array<const float*, 3>& lo, const std::array<const float*, 3>& hi,
                       size_t n, int8_t* out) const {
    ShapePoints points, from, to;
    std::vector<int8_t*> of_point, of_box;
    std::vector<bool> within;
    for (size_t i = 0; i < n; ++i) {
        Box3f box;
        bool meets = true, is_point = true, holds = true;
        for (size_t a = 0; a < 3; ++a) {
            const int axis = static_cast<int>(a);
            meets = meets && hi[a][i] >= box_.lo[axis] && lo[a][i] <= box_.hi[axis];
            holds = holds && lo[a][i] >= box_.lo[axis] && hi[a][i] <= box_.hi[axis];
            is_point = is_point && lo[a][i] == hi[a][i];
            box.lo[axis] = std::max(lo[a][i], box_.lo[axis]);
            box.hi[axis] = std::min(hi[a][i], box_.hi[axis]);
        }
        out[i] = 1;
        if (!meets) continue;
        if (is_point) {
            points.push_back(box.lo);
            of_point.push_back(&out[i]);
        } else {
            from.push_back(box.lo);
            to.push_back(box.hi);
            of_box.push_back(&out[i]);
            within.push_back(holds);
        }
    }
    ShapeCalls* calls = take();
    std::vector<float> values, value_lo, value_hi;
    abi::KernelStatus status;
    if (points.size() > 0) status = calls->signs(points, &values);
    if (status.ok() && from.size() > 0) status = calls->sign_bounds(from, to, &value_lo, &value_hi);
    give(calls);
    if (!status.ok()) note(status);
    for (size_t k = 0; k < of_point.size(); ++k)
        *of_point[k] = !status.ok() ? int8_t{0} : values[k] < 0 ? int8_t{-1} : int8_t{1};
    for (size_t k = 0; k < of_box.size(); ++k) {
        const bool known = status.ok() && (value_lo[k] >= 0 || (value_hi[k] < 0 && within[k]));
        *of_box[k] = !known ? int8_t{0} : value_hi[k] < 0 ? int8_t{-1} : int8_t{1};
    }
}

Box3d ShapeField::voxels_beyond(const Affine3d& local_to_other, std::span<const pieces::Side> sides,
                                const Vec3d& pitch_mm, const Box3d& known) const {
    const std::vector<Box3f>& open = extent(local_to_other.m, sides).open;
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
                if (const abi::KernelStatus status = calls->signs(points, &values); !status.ok())
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
                for (const pieces::Side& side : sides) {
                    if (side.depth(vec_cast<double>(p)) < 0) return;
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
