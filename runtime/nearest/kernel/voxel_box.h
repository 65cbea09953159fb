// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A box of voxel centers: witnesses and pruning by corner domination.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/packet.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// Tolerance of witnesses, in half diagonals of the box: finding one nearer than that costs more
/// than it would prune.
constexpr float kWitnessTolerance = 1.0f;

/// A box of voxel centers in part space.
struct VoxelBox {
    Points corner;
    float center[3];
    float half[3][3];  ///< from the center to the upper ends of its axes
    float delta;       ///< see kernel_table.h
    float half_diagonal;
};

/// Makes the box of voxel centers lowest .. lowest + size - 1, grown slightly so that it holds the
/// centers as rounded to float.
OPENFAB_INLINE VoxelBox make_box(const KernelInput& in, const int32_t* lowest,
                                 const int32_t* size) {
    alignas(32) float lanes[3][8];
    const float* f = in.frame;
    double center[3], axis[3][3];
    for (int c = 0; c < 3; ++c)
        center[c] = f[OPENFAB_FRAME_ORIGIN + c];
    double diagonal2 = 0;
    for (int a = 0; a < 3; ++a) {
        const double index = lowest[a] + 0.5 * size[a];
        double step2 = 0;
        for (int c = 0; c < 3; ++c) {
            axis[a][c] = static_cast<double>(f[a * 3 + c]) * 0.5 * (size[a] - 1);
            center[c] += static_cast<double>(f[a * 3 + c]) * index;
            step2 += axis[a][c] * axis[a][c];
        }
        diagonal2 += step2;
    }
    float largest = in.largest_coordinate;
    for (int c = 0; c < 3; ++c) {
        const double reach =
            __builtin_fabs(axis[0][c]) + __builtin_fabs(axis[1][c]) + __builtin_fabs(axis[2][c]);
        largest = larger(largest, static_cast<float>(__builtin_fabs(center[c]) + reach));
    }
    // Growing every corner by `grow` along each axis of the box, whose steps are orthogonal, holds
    // the rounding of centers.
    const double grow = static_cast<double>(largest) * 0x1p-20;
    for (int a = 0; a < 3; ++a) {
        const float* step = f + a * 3;
        const double length = __builtin_sqrt(static_cast<double>(step[0]) * step[0] +
                                             static_cast<double>(step[1]) * step[1] +
                                             static_cast<double>(step[2]) * step[2]);
        for (int c = 0; c < 3; ++c)
            axis[a][c] += grow / length * step[c];
    }
    for (int l = 0; l < 8; ++l) {
        for (int c = 0; c < 3; ++c) {
            lanes[c][l] = static_cast<float>(center[c] + ((l & 1) != 0 ? axis[0][c] : -axis[0][c]) +
                                             ((l & 2) != 0 ? axis[1][c] : -axis[1][c]) +
                                             ((l & 4) != 0 ? axis[2][c] : -axis[2][c]));
        }
    }
    VoxelBox box;
    for (int c = 0; c < 3; ++c) {
        box.center[c] = static_cast<float>(center[c]);
        for (int a = 0; a < 3; ++a)
            box.half[a][c] = static_cast<float>(axis[a][c]);
    }
    box.corner = {Floats8::load(lanes[0]), Floats8::load(lanes[1]), Floats8::load(lanes[2])};
    box.delta = largest * 0x1p-19f;
    box.half_diagonal = static_cast<float>(__builtin_sqrt(diagonal2)) + 2 * box.delta;
    return box;
}

/// Makes the box around those parts of a block whose bits are set; part i is `size` voxels from
/// origin_of(i) on.
template <typename OriginOf>
OPENFAB_INLINE VoxelBox box_around_parts(const KernelInput& in, const Vec3i& block, uint32_t parts,
                                         const int32_t* size, const OriginOf& origin_of) {
    int32_t low[3] = {8, 8, 8}, high[3] = {0, 0, 0};
    for (uint32_t left = parts; left != 0; left &= left - 1) {
        const int32_t* origin = origin_of(__builtin_ctz(left));
        for (int a = 0; a < 3; ++a) {
            const int32_t end = origin[a] + size[a];
            low[a] = origin[a] < low[a] ? origin[a] : low[a];
            high[a] = high[a] < end ? end : high[a];
        }
    }
    const int32_t lowest[3] = {block.x + low[0], block.y + low[1], block.z + low[2]};
    const int32_t sides[3] = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
    return make_box(in, lowest, sides);
}
/// Makes the box around the sub-blocks in `subs`.
inline VoxelBox box_around(const KernelInput& in, const Vec3i& block, uint32_t subs) {
    return box_around_parts(in, block, subs, in.shape->sub_size,
                            [&](int s) { return in.shape->sub_origin[s]; });
}
/// Makes the box around the quarters in `quarters`.
inline VoxelBox box_around_quarters(const KernelInput& in, const Vec3i& block, uint32_t quarters) {
    int32_t size[3];
    for (int a = 0; a < 3; ++a)
        size[a] = static_cast<int32_t>(2 * in.shape->quarter_reach[a]) + 1;
    return box_around_parts(in, block, quarters, size,
                            [&](int q) { return in.shape->packet_origin[2 * q]; });
}

/// The nearest surface point known for each corner of a box. It need not be the nearest there is:
/// any surface point is a valid witness, a near one a strong one.
struct Witnesses {
    Floats8 distance2;
    Floats8 x, y, z;  ///< meaningful where distance2 was lowered by a point
    uint32_t found;
    Floats8 tolerance2;  ///< only points nearer by at least this are searched for, mm²
    /// The same for what has to be diced for it, in lanes that have a point; not below tolerance2 in effect.
    Floats8 undiced2 = Floats8(0.0f);
    Floats8 passed2 = Floats8(kInfinity);  ///< squared distance to the nearest that was not diced
};

OPENFAB_INLINE Floats8 witness_tolerance(const VoxelBox& box) {
    const float off = kWitnessTolerance * box.half_diagonal;
    return Floats8(off * off);
}

/// Updates each lane with a surface point of its own; infinite coordinates where there is none.
OPENFAB_INLINE void update_witness_points(const Points& of_surface, const Points& p, Witnesses* w) {
    const Floats8 dx = p.x - of_surface.x, dy = p.y - of_surface.y, dz = p.z - of_surface.z;
    const Floats8 d2 = dot3(dx, dy, dz, dx, dy, dz);
    const Mask8 closer = d2 < w->distance2;
    w->distance2 = select(closer, d2, w->distance2);
    w->x = select(closer, of_surface.x, w->x);
    w->y = select(closer, of_surface.y, w->y);
    w->z = select(closer, of_surface.z, w->z);
    w->found |= bits(closer);
}

OPENFAB_INLINE void update_witness_point(float x, float y, float z, const Points& p, Witnesses* w) {
    update_witness_points({Floats8(x), Floats8(y), Floats8(z)}, p, w);
}

OPENFAB_INLINE void update_witness_triangle(const TriangleFrame& t, const TriangleDetail& d,
                                            const Points& p, Witnesses* w) {
    const InFrame f = to_frame(t, p);
    const uint32_t near = bits(lower_bound(f) < w->distance2 - w->tolerance2);
    if (near == 0) return;
    const Closest c = closest_about(t, d, p, f, near);
    const Mask8 closer = c.distance2 < w->distance2;
    const uint32_t mask = bits(closer);
    if (mask == 0) return;
    const Floats8 v0[3] = {Floats8(t.v0[0]), Floats8(t.v0[1]), Floats8(t.v0[2])};
    w->x = select(
        closer,
        v0[0] + (c.bary1 * (Floats8(d.v1[0]) - v0[0]) + c.bary2 * (Floats8(d.v2[0]) - v0[0])),
        w->x);
    w->y = select(
        closer,
        v0[1] + (c.bary1 * (Floats8(d.v1[1]) - v0[1]) + c.bary2 * (Floats8(d.v2[1]) - v0[1])),
        w->y);
    w->z = select(
        closer,
        v0[2] + (c.bary1 * (Floats8(d.v1[2]) - v0[2]) + c.bary2 * (Floats8(d.v2[2]) - v0[2])),
        w->z);
    w->distance2 = select(closer, c.distance2, w->distance2);
    w->found |= mask;
}

/// Returns whether the leaf stands for a treelet.
OPENFAB_INLINE bool is_treelet(const PatchSource& patches, const Node& leaf) {
    return leaf.count() == 0 && static_cast<int32_t>(leaf.first()) >= patches.first_treelet;
}

/// Returns the cached box of the patch a leaf stands for; null if it was never diced.
OPENFAB_INLINE const Node* cached_box(const PatchSource& patches, const Node& leaf) {
    const uint32_t id = leaf.first();
    if (static_cast<int32_t>(id) >= patches.first_treelet) return nullptr;
    const BoxPage* page = __atomic_load_n(patches.pages + id / BoxPage::kSize, __ATOMIC_ACQUIRE);
    if (page == nullptr) return nullptr;
    const uint32_t slot = id % BoxPage::kSize;
    const bool ready = __atomic_load_n(page->state + slot, __ATOMIC_ACQUIRE) == BoxPage::kReady;
    return ready ? page->box + slot : nullptr;
}

/// Returns whether what is at these squared distances, and not diced, need not be: no lane would get
/// a point that is nearer by `undiced2`. Notes that it was passed by.
OPENFAB_INLINE bool pass_by(Floats8 distance2, Witnesses* w) {
    const Floats8 tolerance2 =
        select(Mask8::from_bits(w->found), max(w->tolerance2, w->undiced2), w->tolerance2);
    if (bits(distance2 < w->distance2 - tolerance2) != 0) return false;
    w->passed2 = min(w->passed2, distance2);
    return true;
}

/// Searches below `start` for points nearer to the corners than the witnesses, near children first.
__attribute__((noinline)) void find_witnesses(const NodeRef& start, const Points& p,
                                              KernelScratch* scratch, Witnesses* w) {
    const size_t bottom = scratch->stack.size;
    scratch->stack.push(start);
    while (scratch->stack.size > bottom) {
        const NodeRef e = scratch->stack.data[--scratch->stack.size];
        const Node* node = e.tree->nodes + e.node;
        if (bits(node_distance2(*node, p) < w->distance2 - w->tolerance2) == 0) continue;
        while (node != nullptr && !node->is_leaf()) {
            Floats8 of_child[kMaxChildren];
            const uint32_t near =
                test_children(*e.tree, *node, p, w->distance2 - w->tolerance2, of_child);
            scratch->counts->node_tests += node->children();
            const uint32_t child = node->child(), nearest = nearest_child(of_child);
            each_other_child(near, nearest, [&](uint32_t i) OPENFAB_INLINE_LAMBDA {
                scratch->stack.push({e.tree, child + i});
            });
            node = (near >> nearest & 1u) != 0 ? e.tree->nodes + child + nearest : nullptr;
        }
        if (node == nullptr) continue;
        const uint32_t first = node->first();
        if (node->count() == 0) {
            const Node* box = cached_box(scratch->patches, *node);
            if (box != nullptr && bits(node_distance2(*box, p) < w->distance2 - w->tolerance2) == 0)
                continue;
            // A known point of a piece mostly is near enough, and the piece need not be built.
            const LeafFeatures& known = e.tree->leaves[node - e.tree->nodes];
            if (known.vertices > 0) {
                const VertexFeature* points = e.tree->vertices + known.first_vertex;
                for (uint32_t i = 0; i < known.vertices; ++i)
                    update_witness_point(points[i].v[0], points[i].v[1], points[i].v[2], p, w);
                if (pass_by(node_distance2(*node, p), w)) continue;
            } else if (box == nullptr && !is_treelet(scratch->patches, *node) &&
                       pass_by(node_distance2(*node, p), w)) {
                continue;
            }
            const TreeView* patch =
                scratch->patches.fetch(scratch->patches.context, static_cast<int32_t>(first));
            if (patch->nodes != nullptr) scratch->stack.push({patch, 0});
            continue;
        }
        for (uint32_t i = first; i < first + node->count(); ++i) {
            update_witness_triangle(e.tree->frames[i], e.tree->details[i], p, w);
        }
        scratch->counts->triangle_tests += node->count();
    }
}

/// Corner domination: X is pruned if dist²(c, X) exceeds some bound[i] at all 8 corners c. Bounds
/// that prune most move to the front.
struct PruneBounds {
    alignas(32) float bound[17][8];  ///< 8 points, 8 patch boxes, the radius
    int32_t count = 0;
    /// X is pruned, too, if it is farther than this from the whole box, squared, mm².
    float reach2 = kInfinity;
};

OPENFAB_INLINE float bound_slack(float distance2, float delta) {
    const float distance = __builtin_sqrtf(distance2);
    return (2 * distance + delta) * delta + distance2 * (kSlack - 1.0f) + kSlackMm2;
}

/// Adds slack to a bound; the same at all corners, so that it holds everywhere between them.
OPENFAB_INLINE Floats8 with_slack(Floats8 r2, float delta) {
    return r2 + Floats8(bound_slack(largest_lane(r2), delta));
}

OPENFAB_INLINE void add_point_bound(const VoxelBox& box, float x, float y, float z,
                                    PruneBounds* bounds) {
    const Floats8 dx = box.corner.x - Floats8(x), dy = box.corner.y - Floats8(y),
                  dz = box.corner.z - Floats8(z);
    store(bounds->bound[bounds->count++], with_slack(dot3(dx, dy, dz, dx, dy, dz), box.delta));
}

OPENFAB_INLINE void add_radius_bound(const VoxelBox& box, float radius, PruneBounds* bounds) {
    if (!(radius < kInfinity)) return;
    bounds->reach2 = radius * radius + bound_slack(radius * radius, 3 * box.delta);
    // Each point of the box has a corner within half the diagonal.
    const float reach = radius + box.half_diagonal;
    store(bounds->bound[bounds->count++], with_slack(Floats8(reach * reach), box.delta));
}

OPENFAB_INLINE void make_prune_bounds(const VoxelBox& box, const Witnesses& w,
                                      PruneBounds* bounds) {
    alignas(32) float x[8], y[8], z[8];
    store(x, w.x);
    store(y, w.y);
    store(z, w.z);
    bounds->count = 0;
    for (int i = 0; i < 8; ++i) {
        if ((w.found >> i & 1u) == 0) continue;
        bool repeated = false;
        for (int j = 0; j < i; ++j) {
            repeated |= (w.found >> j & 1u) != 0 && x[j] == x[i] && y[j] == y[i] && z[j] == z[i];
        }
        if (repeated) continue;
        add_point_bound(box, x[i], y[i], z[i], bounds);
    }
}

OPENFAB_INLINE bool can_prune(Floats8 distance2, PruneBounds* d) {
    for (int i = 0; i < d->count; ++i) {
        if (!any(distance2 <= Floats8::load(d->bound[i]))) {
            if (i > 0) {
                const Floats8 hit = Floats8::load(d->bound[i]),
                              before = Floats8::load(d->bound[i - 1]);
                store(d->bound[i - 1], hit);
                store(d->bound[i], before);
            }
            return true;
        }
    }
    return false;
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
