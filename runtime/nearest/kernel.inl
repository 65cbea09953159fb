// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The query kernel. Included by kernel_avx2.cpp and kernel_sse41.cpp.
//
// Notation: c the 8 corners of a box of voxel centres, one a lane; a a known surface point (a
// witness); X a set of surface. *Corner domination*: if dist²(c, X) > |c - a|² at all 8 corners, X
// holds the nearest point of no point of the box, because |p - x|² - |p - a|² is linear in p for
// each x, so their least over x is concave. One test decides for the whole box.
//
// Every test errs towards keeping. With delta = 2^-19 of the largest coordinate in play, a squared
// distance r² that something is compared with becomes (r + delta)² (1 + 2^-18) + 2^-40: delta holds
// the float errors of positions, boxes and `closest_point` (RULES.md 15 gives the rest), so what is
// dropped could not have given even equal bits.

#include "runtime/nearest/kernel.h"
#include "runtime/nearest/simd8.h"

namespace openfab::nearest::OPENFAB_NEAREST_ISA {
namespace {

constexpr float kSlack = 1.0f + 0x1p-18f;
constexpr float kSlackMm2 = 0x1p-40f;
/// How far beside the nearest surface point a witness may lie, in half diagonals of its box.
/// Searching on costs more than what a better witness would prune.
constexpr float kWitnessOff = 1.0f;
constexpr float kInfinity = __builtin_inff();

struct Points {
    F8 x, y, z;
};

OPENFAB_INLINE float larger(float a, float b) {
    return a < b ? b : a;
}
OPENFAB_INLINE float magnitude(float a) {
    return a < 0 ? -a : a;
}

/// Everything about one box of voxel centres.
struct BoxOfPoints {
    Points corner;
    float delta;  ///< see above
    float half_diagonal;
};

/// Voxel centres lowest .. lowest + size - 1, grown by a little so that the float centres are
/// inside.
OPENFAB_INLINE BoxOfPoints make_box(const KernelInput& in, const int32_t* lowest,
                                    const int32_t* size) {
    alignas(32) float lanes[3][8];
    const float* f = in.frame;
    double center[3], axis[3][3];
    for (int c = 0; c < 3; ++c)
        center[c] = f[OPENFAB_FRAME_ORIGIN + c];
    double diagonal2 = 0;
    for (int a = 0; a < 3; ++a) {
        const double middle = lowest[a] + 0.5 * size[a];
        double step2 = 0;
        for (int c = 0; c < 3; ++c) {
            axis[a][c] = static_cast<double>(f[a * 3 + c]) * 0.5 * (size[a] - 1);
            center[c] += static_cast<double>(f[a * 3 + c]) * middle;
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
    // the rounding of centres.
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
    BoxOfPoints box;
    box.corner = {load(lanes[0]), load(lanes[1]), load(lanes[2])};
    box.delta = largest * 0x1p-19f;
    box.half_diagonal = static_cast<float>(__builtin_sqrt(diagonal2)) + 2 * box.delta;
    return box;
}

/// Squared distance of each point to the node's box.
OPENFAB_INLINE F8 node_distance2(const Node& n, const Points& p) {
    const F8 zero = set1(0.0f);
    F8 sum;
    for (int k = 0; k < 3; ++k) {
        const F8 u =
            dot3(set1(n.axis[k][0]), set1(n.axis[k][1]), set1(n.axis[k][2]), p.x, p.y, p.z);
        const F8 d = max(absolute(u - set1(n.center[k])) - set1(n.half[k]), zero);
        sum = k == 0 ? d * d : sum + d * d;
    }
    return sum;
}

/// A point in a triangle's frame: distance from the plane, and from the edge lines, positive
/// inwards.
struct InFrame {
    F8 h, s[3];
};

OPENFAB_INLINE InFrame to_frame(const TriangleFrame& t, const Points& p) {
    const F8 wx = p.x - set1(t.v0[0]), wy = p.y - set1(t.v0[1]), wz = p.z - set1(t.v0[2]);
    InFrame f;
    f.h = dot3(set1(t.n[0]), set1(t.n[1]), set1(t.n[2]), wx, wy, wz);
    f.s[0] = dot3(set1(t.m[0][0]), set1(t.m[0][1]), set1(t.m[0][2]), wx, wy, wz);
    f.s[1] = dot3(set1(t.m[1][0]), set1(t.m[1][1]), set1(t.m[1][2]), wx, wy, wz) + set1(t.height0);
    f.s[2] = dot3(set1(t.m[2][0]), set1(t.m[2][1]), set1(t.m[2][2]), wx, wy, wz);
    return f;
}

/// A lower bound of the squared distance: to the plane, and to the farthest edge line that the
/// point is outside of.
OPENFAB_INLINE F8 lower_bound(const InFrame& f) {
    const F8 beyond = min(min(min(f.s[0], f.s[1]), f.s[2]), set1(0.0f));
    return f.h * f.h + beyond * beyond;
}

/// `closest_on_edge` of triangle.cpp; `from_first` is 0 at f and 1 at s.
OPENFAB_INLINE F8 closest_on_edge(const float* f, const float* s, bool swapped, const Points& p,
                                  F8* from_first) {
    const float* a = swapped ? s : f;
    const float* b = swapped ? f : s;
    const float abx = b[0] - a[0], aby = b[1] - a[1], abz = b[2] - a[2];
    const F8 one = set1(1.0f);
    const F8 ex = set1(abx), ey = set1(aby), ez = set1(abz);
    const F8 wx = p.x - set1(a[0]), wy = p.y - set1(a[1]), wz = p.z - set1(a[2]);
    const F8 length2 = set1((abx * abx + aby * aby) + abz * abz);
    // A quotient rounds to 1 or more exactly where `along` is not below `length2`.
    const F8 tau = min(max(dot3(wx, wy, wz, ex, ey, ez) / length2, set1(0.0f)), one);
    F8 qx = wx - tau * ex, qy = wy - tau * ey, qz = wz - tau * ez;
    const F8 at_b = tau == one;
    qx = select(at_b, p.x - set1(b[0]), qx);
    qy = select(at_b, p.y - set1(b[1]), qy);
    qz = select(at_b, p.z - set1(b[2]), qz);
    *from_first = swapped ? one - tau : tau;
    return dot3(qx, qy, qz, qx, qy, qz);
}

struct Closest {
    F8 distance2, bary1, bary2;
};

/// `closest_point` in the lanes of `near`; others get the distance to some point of the triangle,
/// or infinity.
OPENFAB_INLINE Closest closest8(const TriangleFrame& t, const TriangleDetail& d, const Points& p,
                                const InFrame& f, uint32_t near) {
    const F8 margin = set1(d.margin);
    const F8 outside = min(min(f.s[0], f.s[1]), f.s[2]) < margin;
    Closest c;
    c.distance2 = select(outside, set1(kInfinity), f.h * f.h);
    c.bary1 = f.s[2] * set1(d.inv_height1);
    c.bary2 = f.s[0] * set1(d.inv_height2);
    if ((bits(outside) & near) == 0) return c;
    const F8 one = set1(1.0f), zero = set1(0.0f);
    const float* v[4] = {t.v0, d.v1, d.v2, t.v0};
    for (int i = 0; i < 3; ++i) {
        const F8 beyond = f.s[i] < margin;
        if ((bits(beyond) & near) == 0) continue;
        F8 along;
        const F8 e = closest_on_edge(v[i], v[i + 1], (d.flags >> i & 1u) != 0, p, &along);
        const F8 take = (e < c.distance2) & beyond;
        c.distance2 = select(take, e, c.distance2);
        const F8 b1 = i == 0 ? along : i == 1 ? one - along : zero;
        const F8 b2 = i == 0 ? zero : i == 1 ? along : one - along;
        c.bary1 = select(take, b1, c.bary1);
        c.bary2 = select(take, b2, c.bary2);
    }
    return c;
}

/// The nearest surface point known for each corner of a box. It need not be the nearest there is:
/// any surface point is a valid witness, a near one a strong one.
struct Witnesses {
    F8 distance2;
    F8 x, y, z;  ///< meaningful where distance2 was lowered by a point
    uint32_t found;
    F8 enough;  ///< search on only for points that are nearer by this, mm²
};

OPENFAB_INLINE F8 witness_tolerance(const BoxOfPoints& box) {
    const float off = kWitnessOff * box.half_diagonal;
    return set1(off * off);
}

OPENFAB_INLINE void offer_point(float x, float y, float z, const Points& p, Witnesses* w) {
    const F8 px = set1(x), py = set1(y), pz = set1(z);
    const F8 dx = p.x - px, dy = p.y - py, dz = p.z - pz;
    const F8 d2 = dot3(dx, dy, dz, dx, dy, dz);
    const F8 closer = d2 < w->distance2;
    w->distance2 = select(closer, d2, w->distance2);
    w->x = select(closer, px, w->x);
    w->y = select(closer, py, w->y);
    w->z = select(closer, pz, w->z);
    w->found |= bits(closer);
}

OPENFAB_INLINE void offer_triangle(const TriangleFrame& t, const TriangleDetail& d, const Points& p,
                                   Witnesses* w) {
    const InFrame f = to_frame(t, p);
    const uint32_t near = bits(lower_bound(f) < w->distance2);
    if (near == 0) return;
    const Closest c = closest8(t, d, p, f, near);
    const F8 closer = c.distance2 < w->distance2;
    const uint32_t mask = bits(closer);
    if (mask == 0) return;
    const F8 v0[3] = {set1(t.v0[0]), set1(t.v0[1]), set1(t.v0[2])};
    w->x = select(closer,
                  v0[0] + (c.bary1 * (set1(d.v1[0]) - v0[0]) + c.bary2 * (set1(d.v2[0]) - v0[0])),
                  w->x);
    w->y = select(closer,
                  v0[1] + (c.bary1 * (set1(d.v1[1]) - v0[1]) + c.bary2 * (set1(d.v2[1]) - v0[1])),
                  w->y);
    w->z = select(closer,
                  v0[2] + (c.bary1 * (set1(d.v1[2]) - v0[2]) + c.bary2 * (set1(d.v2[2]) - v0[2])),
                  w->z);
    w->distance2 = select(closer, c.distance2, w->distance2);
    w->found |= mask;
}

/// Searches below `start` for points nearer to the corners than those known, near children first.
__attribute__((noinline)) void find_witnesses(const Entry& start, const Points& p,
                                              KernelScratch* scratch, Witnesses* w) {
    const size_t bottom = scratch->stack.size;
    scratch->stack.push(start);
    while (scratch->stack.size > bottom) {
        const Entry e = scratch->stack.data[--scratch->stack.size];
        const Node* node = e.tree->nodes + e.node;
        if (bits(node_distance2(*node, p) < w->distance2 - w->enough) == 0) continue;
        while (!node->is_leaf()) {
            const Node* left = e.tree->nodes + node->child();
            const F8 dl = node_distance2(left[0], p), dr = node_distance2(left[1], p);
            const bool go_left = bits(dl < w->distance2) != 0,
                       go_right = bits(dr < w->distance2) != 0;
            scratch->counts->node_tests += 2;
            if (go_left && go_right) {
                const bool right_first = __builtin_popcount(bits(dr < dl)) > 4;
                scratch->stack.push({e.tree, node->child() + (right_first ? 0u : 1u)});
                node = left + (right_first ? 1 : 0);
            } else if (go_left || go_right) {
                node = left + (go_right ? 1 : 0);
            } else {
                node = nullptr;
                break;
            }
        }
        if (node == nullptr) continue;
        const uint32_t first = node->first();
        if (node->count() == 0) {
            const TreeView* patch =
                scratch->patches.fetch(scratch->patches.context, static_cast<int32_t>(first));
            if (patch->nodes != nullptr) scratch->stack.push({patch, 0});
            continue;
        }
        for (uint32_t i = first; i < first + node->count(); ++i) {
            offer_triangle(e.tree->frames[i], e.tree->details[i], p, w);
        }
        scratch->counts->triangle_tests += node->count();
    }
}

/// One row a witness: what dist²(c, X) must exceed at every corner. Rows that prune most come to
/// the front.
struct Domination {
    alignas(32) float row[17][8];  ///< 8 points, 8 patch boxes, the radius
    int32_t rows = 0;
};

OPENFAB_INLINE float largest_lane(F8 a) {
    alignas(32) float v[8];
    store(v, a);
    float m = v[0];
    for (int i = 1; i < 8; ++i)
        m = larger(m, v[i]);
    return m;
}

/// The slack of a row is one number for all corners, so that it holds everywhere between them.
OPENFAB_INLINE F8 with_slack(F8 r2, float delta) {
    const float far2 = largest_lane(r2);
    const float far = __builtin_sqrtf(far2);
    const float slack = (2 * far + delta) * delta + far2 * (kSlack - 1.0f) + kSlackMm2;
    return r2 + set1(slack);
}

OPENFAB_INLINE void make_rows(const BoxOfPoints& box, const Witnesses& w, float radius,
                              Domination* rows) {
    alignas(32) float x[8], y[8], z[8];
    store(x, w.x);
    store(y, w.y);
    store(z, w.z);
    rows->rows = 0;
    for (int i = 0; i < 8; ++i) {
        if ((w.found >> i & 1u) == 0) continue;
        bool repeated = false;
        for (int j = 0; j < i; ++j) {
            repeated |= (w.found >> j & 1u) != 0 && x[j] == x[i] && y[j] == y[i] && z[j] == z[i];
        }
        if (repeated) continue;
        const F8 dx = box.corner.x - set1(x[i]), dy = box.corner.y - set1(y[i]),
                 dz = box.corner.z - set1(z[i]);
        store(rows->row[rows->rows++], with_slack(dot3(dx, dy, dz, dx, dy, dz), box.delta));
    }
    if (radius < kInfinity) {
        // Each point of the box has a corner within half the diagonal.
        const float reach = radius + box.half_diagonal;
        store(rows->row[rows->rows++], with_slack(set1(reach * reach), box.delta));
    }
}

OPENFAB_INLINE bool dominated(F8 distance2, Domination* d) {
    for (int i = 0; i < d->rows; ++i) {
        if (bits(distance2 <= load(d->row[i])) == 0) {
            if (i > 0) {
                const F8 hit = load(d->row[i]), before = load(d->row[i - 1]);
                store(d->row[i - 1], hit);
                store(d->row[i], before);
            }
            return true;
        }
    }
    return false;
}

/// Appends to the list what is not dominated below `start`: nodes no larger than `stop2` (squared
/// half diagonal) and leaves. Patches are diced, or stand for themselves.
__attribute__((noinline)) void collect(const Entry& start, const Points& p, float stop2, bool dice,
                                       Domination* rows, KernelScratch* scratch) {
    const size_t bottom = scratch->stack.size;
    scratch->stack.push(start);
    while (scratch->stack.size > bottom) {
        const Entry e = scratch->stack.data[--scratch->stack.size];
        const Node& node = e.tree->nodes[e.node];
        const F8 d2 = node_distance2(node, p);
        ++scratch->counts->node_tests;
        if (dominated(d2, rows)) continue;
        if (node.is_leaf()) {
            if (node.count() == 0 && dice) {
                const TreeView* patch = scratch->patches.fetch(scratch->patches.context,
                                                               static_cast<int32_t>(node.first()));
                if (patch->nodes != nullptr) scratch->stack.push({patch, 0});
            } else {
                scratch->list.push(e);
            }
            continue;
        }
        const float size2 = (node.half[0] * node.half[0] + node.half[1] * node.half[1]) +
                            node.half[2] * node.half[2];
        if (size2 <= stop2) {
            scratch->list.push(e);
            continue;
        }
        scratch->stack.push({e.tree, node.child() + 1});
        scratch->stack.push({e.tree, node.child()});
    }
}

/// True if no point of the box is nearest to the triangle: it lies in a half-plane, inwards of one
/// of its edges, that is dominated (a half-plane is a set like any other, and its distance is
/// cheap).
OPENFAB_INLINE bool triangle_dominated(const TriangleFrame& t, const Points& p, Domination* rows) {
    const InFrame f = to_frame(t, p);
    const F8 h2 = f.h * f.h;
    for (const F8& s : f.s) {
        if (bits(s) == 0xff && dominated(h2 + s * s, rows)) return true;
    }
    return false;
}

/// The triangles of the leaves below `start` that are not dominated.
__attribute__((noinline)) void collect_triangles(const Entry& start, F8 start_distance2,
                                                 const Points& p, Domination* rows,
                                                 KernelScratch* scratch) {
    if (dominated(start_distance2, rows)) return;
    const size_t bottom = scratch->stack.size;
    uint32_t at = start.node;
    const TreeView& tree = *start.tree;
    for (;;) {
        const Node& node = tree.nodes[at];
        if (node.is_leaf()) {
            for (uint32_t i = node.first(); i < node.first() + node.count(); ++i) {
                if (triangle_dominated(tree.frames[i], p, rows)) continue;
                scratch->triangles.push({tree.frames + i, tree.details + i});
            }
        } else {
            const uint32_t child = node.child();
            const bool keep0 = !dominated(node_distance2(tree.nodes[child], p), rows);
            const bool keep1 = !dominated(node_distance2(tree.nodes[child + 1], p), rows);
            scratch->counts->node_tests += 2;
            if (keep0) {
                if (keep1) scratch->stack.push({start.tree, child + 1});
                at = child;
                continue;
            }
            if (keep1) {
                at = child + 1;
                continue;
            }
        }
        if (scratch->stack.size == bottom) return;
        at = scratch->stack.data[--scratch->stack.size].node;
    }
}

/// What a packet of 8 voxels has found.
struct PacketBest {
    F8 distance2, bary1, bary2;
    F8 patch, triangle;  ///< as bits; the largest int where there is none
    F8 limit;            ///< distance2 with slack; below zero where the lane does not ask
};

OPENFAB_INLINE F8 packet_limit(F8 distance2, float delta) {
    const F8 r = sqrt(distance2) + set1(delta);
    return r * r * set1(kSlack) + set1(kSlackMm2);
}

OPENFAB_INLINE void improve(const TriangleRef& ref, const InFrame& f, uint32_t near,
                            const Points& p, float delta, PacketBest* best) {
    const Closest c = closest8(*ref.frame, *ref.detail, p, f, near);
    const F8 patch = set1_bits(ref.detail->patch), triangle = set1_bits(ref.detail->triangle);
    const F8 earlier = less_bits(patch, best->patch) |
                       (equal_bits(patch, best->patch) & less_bits(triangle, best->triangle));
    const F8 better =
        (c.distance2 < best->distance2) | ((c.distance2 == best->distance2) & earlier);
    if (bits(better) == 0) return;
    best->distance2 = select(better, c.distance2, best->distance2);
    best->bary1 = select(better, c.bary1, best->bary1);
    best->bary2 = select(better, c.bary2, best->bary2);
    best->patch = select(better, patch, best->patch);
    best->triangle = select(better, triangle, best->triangle);
    // The least of both: below zero stays where the lane does not ask, and a radius is never
    // widened.
    best->limit = min(best->limit, packet_limit(best->distance2, delta));
}

OPENFAB_INLINE Points voxel_centres(const KernelInput& in, const Vec3i& block,
                                    const int32_t* origin) {
    const float* f = in.frame;
    const BlockShape& s = *in.shape;
    const F8 half = set1(0.5f);
    const F8 x = set1(static_cast<float>(block.x + origin[0])) + load(s.lane_offset[0]) + half;
    const F8 y = set1(static_cast<float>(block.y + origin[1])) + load(s.lane_offset[1]) + half;
    const F8 z = set1(static_cast<float>(block.z + origin[2])) + load(s.lane_offset[2]) + half;
    F8 c[3];
    for (int a = 0; a < 3; ++a) {
        c[a] = dot3(x, y, z, set1(f[OPENFAB_FRAME_STEP_I + a]), set1(f[OPENFAB_FRAME_STEP_J + a]),
                    set1(f[OPENFAB_FRAME_STEP_K + a])) +
               set1(f[OPENFAB_FRAME_ORIGIN + a]);
    }
    return {c[0], c[1], c[2]};
}

OPENFAB_INLINE uint32_t demanded(const uint8_t* demand, const int16_t* voxel) {
    if (demand == nullptr) return 0xff;
    uint32_t mask = 0;
    for (int l = 0; l < 8; ++l) {
        mask |= (static_cast<uint32_t>(demand[voxel[l] >> 3]) >> (voxel[l] & 7) & 1u) << l;
    }
    return mask;
}

OPENFAB_INLINE F8 mask_of(uint32_t bits8) {
    alignas(32) float lanes[8];
    for (int l = 0; l < 8; ++l)
        lanes[l] = (bits8 >> l & 1u) != 0 ? -1.0f : 1.0f;
    return load(lanes) < set1(0.0f);
}

OPENFAB_INLINE void write_packet(const PacketBest& best, uint32_t asked, float radius2,
                                 const int16_t* voxel, BlockAnswer* answer) {
    alignas(32) float d2[8], b1[8], b2[8];
    alignas(32) int32_t patch[8], triangle[8];
    store(d2, best.distance2);
    store(b1, best.bary1);
    store(b2, best.bary2);
    store_bits(patch, best.patch);
    store_bits(triangle, best.triangle);
    for (int l = 0; l < 8; ++l) {
        if ((asked >> l & 1u) == 0 || !(d2[l] <= radius2) || d2[l] == kInfinity) continue;
        const int v = voxel[l];
        answer->distance2[v] = d2[l];
        answer->patch[v] = patch[l];
        answer->triangle[v] = triangle[l];
        answer->bary1[v] = b1[l];
        answer->bary2[v] = b2[l];
    }
}

__attribute__((noinline)) void query_packet(const TriangleRef* refs, size_t count, const Points& p,
                                            uint32_t asked, float delta, KernelScratch* scratch,
                                            PacketBest* result) {
    Lanes* bounds = scratch->bounds.data;
    Lanes* framed = scratch->framed.data;
    PacketBest best = *result;
    // First a lower bound for every triangle, without a branch; then the triangle that promises
    // most to each lane; then only those whose bound is still below what was found.
    F8 least = set1(kInfinity), promising = set1_bits(0);
    for (size_t i = 0; i < count; ++i) {
        const InFrame f = to_frame(*refs[i].frame, p);
        const F8 bound = lower_bound(f);
        store(framed[4 * i].v, f.h);
        store(framed[4 * i + 1].v, f.s[0]);
        store(framed[4 * i + 2].v, f.s[1]);
        store(framed[4 * i + 3].v, f.s[2]);
        store(bounds[i].v, bound);
        promising = select(bound < least, set1_bits(static_cast<int32_t>(i)), promising);
        least = min(least, bound);
    }
    const auto try_triangle = [&](size_t i) {
        const uint32_t near = bits(load(bounds[i].v) <= best.limit);
        if (near == 0) return;
        const InFrame f{
            load(framed[4 * i].v),
            {load(framed[4 * i + 1].v), load(framed[4 * i + 2].v), load(framed[4 * i + 3].v)}};
        improve(refs[i], f, near, p, delta, &best);
    };
    alignas(32) int32_t first[8];
    store_bits(first, promising);
    for (int l = 0; l < 8; ++l) {
        const auto i = static_cast<size_t>(first[l]);
        if ((asked >> l & 1u) == 0 || bounds[i].v[0] == kInfinity) continue;
        try_triangle(i);
        store(bounds[i].v, set1(kInfinity));
    }
    for (size_t i = 0; i < count; i += 4) {
        const F8 b0 = load(bounds[i].v), b1 = load(bounds[i + 1].v);
        const F8 b2 = load(bounds[i + 2].v), b3 = load(bounds[i + 3].v);
        if (bits(min(min(b0, b1), min(b2, b3)) <= best.limit) == 0) continue;
        for (size_t j = i; j < i + 4 && j < count; ++j)
            try_triangle(j);
    }
    *result = best;
}

void query_packets(const KernelInput& in, const BlockQuery& q, int sub, float delta,
                   KernelScratch* scratch, BlockAnswer* answer) {
    const BlockShape& shape = *in.shape;
    const TriangleRef* refs = scratch->triangles.data;
    const size_t count = scratch->triangles.size;
    // A lane starts from the radius: what is farther cannot be the answer.
    const float start = q.radius_mm < kInfinity ? q.radius_mm * q.radius_mm : kInfinity;
    // Three more bounds, so that they can be read by fours.
    scratch->framed.reserve(4 * count);
    scratch->bounds.reserve(count + 3);
    for (size_t i = count; i < count + 3; ++i)
        store(scratch->bounds.data[i].v, set1(kInfinity));
    for (int packet = sub * 8; packet < sub * 8 + 8; ++packet) {
        const int16_t* voxel = shape.voxel + packet * 8;
        const uint32_t asked = demanded(q.demand, voxel);
        if (asked == 0) continue;
        const Points p = voxel_centres(in, q.block, shape.packet_origin[packet]);
        PacketBest best;
        best.distance2 = set1(kInfinity);
        best.patch = best.triangle = set1_bits(INT32_MAX);
        best.bary1 = best.bary2 = set1(0.0f);
        best.limit = select(mask_of(asked), packet_limit(set1(start), delta), set1(-1.0f));
        query_packet(refs, count, p, asked, delta, scratch, &best);
        scratch->counts->triangle_tests += static_cast<int64_t>(count);
        write_packet(best, asked, start, voxel, answer);
    }
}

bool any_demanded(const KernelInput& in, const BlockQuery& q, int sub) {
    if (q.demand == nullptr) return true;
    for (int packet = sub * 8; packet < sub * 8 + 8; ++packet) {
        if (demanded(q.demand, in.shape->voxel + packet * 8) != 0) return true;
    }
    return false;
}

__attribute__((noinline)) void query_sub_block(const KernelInput& in, const BlockQuery& q, int sub,
                                               const WarmStart& near, KernelScratch* scratch,
                                               BlockAnswer* answer) {
    const int32_t* origin = in.shape->sub_origin[sub];
    const int32_t lowest[3] = {q.block.x + origin[0], q.block.y + origin[1], q.block.z + origin[2]};
    const BoxOfPoints box = make_box(in, lowest, in.shape->sub_size);
    Witnesses w{set1(kInfinity), set1(0), set1(0), set1(0), 0, witness_tolerance(box)};
    for (int i = 0; i < near.count; ++i)
        offer_point(near.point[0][i], near.point[1][i], near.point[2][i], box.corner, &w);
    const size_t entries = scratch->list.size;
    scratch->list_distance2.reserve(entries);
    Lanes* distance2 = scratch->list_distance2.data;
    F8 least = set1(kInfinity), promising = set1_bits(0);
    for (size_t i = 0; i < entries; ++i) {
        const Entry& e = scratch->list.data[i];
        const F8 d2 = node_distance2(e.tree->nodes[e.node], box.corner);
        store(distance2[i].v, d2);
        promising = select(d2 < least, set1_bits(static_cast<int32_t>(i)), promising);
        least = min(least, d2);
    }
    alignas(32) int32_t first[8];
    store_bits(first, promising);
    for (int l = 0; l < 8; ++l) {
        const auto i = static_cast<size_t>(first[l]);
        if (bits(load(distance2[i].v) < w.distance2 - w.enough) == 0) continue;
        find_witnesses(scratch->list.data[i], box.corner, scratch, &w);
    }
    for (size_t i = 0; i < entries; ++i) {
        if (bits(load(distance2[i].v) < w.distance2 - w.enough) == 0) continue;
        find_witnesses(scratch->list.data[i], box.corner, scratch, &w);
    }
    scratch->counts->node_tests += static_cast<int64_t>(entries);
    Domination rows;
    make_rows(box, w, q.radius_mm, &rows);
    scratch->triangles.size = 0;
    for (size_t i = 0; i < entries; ++i) {
        collect_triangles(scratch->list.data[i], load(distance2[i].v), box.corner, &rows, scratch);
    }
    if (scratch->triangles.size != 0) query_packets(in, q, sub, box.delta, scratch, answer);
}

void keep_warm(const Witnesses& w, WarmStart* warm) {
    alignas(32) float x[8], y[8], z[8];
    store(x, w.x);
    store(y, w.y);
    store(z, w.z);
    warm->count = 0;
    for (int i = 0; i < 8; ++i) {
        if ((w.found >> i & 1u) == 0) continue;
        warm->point[0][warm->count] = x[i];
        warm->point[1][warm->count] = y[i];
        warm->point[2][warm->count] = z[i];
        ++warm->count;
    }
}

void clear(BlockAnswer* answer) {
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->distance2[i] = kInfinity;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->patch[i] = -1;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->triangle[i] = -1;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->bary1[i] = 0;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->bary2[i] = 0;
}

void query(const KernelInput& in, const BlockQuery& q, KernelScratch* scratch,
           BlockAnswer* answer) {
    clear(answer);
    if (in.root.nodes == nullptr) return;
    const int32_t lowest[3] = {q.block.x, q.block.y, q.block.z};
    const int32_t size[3] = {8, 8, 8};
    const BoxOfPoints box = make_box(in, lowest, size);
    const float reach = q.radius_mm + 2 * box.half_diagonal;
    Witnesses w{set1(q.radius_mm < kInfinity ? reach * reach : kInfinity),
                set1(0),
                set1(0),
                set1(0),
                0,
                witness_tolerance(box)};
    const WarmStart& warm = scratch->warm;
    for (int i = 0; i < warm.count; ++i)
        offer_point(warm.point[0][i], warm.point[1][i], warm.point[2][i], box.corner, &w);
    const Entry root{&in.root, 0};
    scratch->stack.size = 0;
    find_witnesses(root, box.corner, scratch, &w);
    Domination rows;
    make_rows(box, w, q.radius_mm, &rows);
    scratch->list.size = 0;
    collect(root, box.corner, 0.0f, true, &rows, scratch);
    WarmStart near;
    keep_warm(w, &near);
    if (near.count != 0) scratch->warm = near;
    if (scratch->list.size == 0) return;
    for (int sub = 0; sub < 8; ++sub) {
        if (any_demanded(in, q, sub)) query_sub_block(in, q, sub, near, scratch, answer);
    }
}

/// Farthest distance² from each point to the node's box.
OPENFAB_INLINE F8 node_far2(const Node& n, const Points& p) {
    F8 sum;
    for (int k = 0; k < 3; ++k) {
        const F8 u =
            dot3(set1(n.axis[k][0]), set1(n.axis[k][1]), set1(n.axis[k][2]), p.x, p.y, p.z);
        const F8 d = absolute(u - set1(n.center[k])) + set1(n.half[k]);
        sum = k == 0 ? d * d : sum + d * d;
    }
    return sum;
}

/// Upper bounds of the distance at the corners without dicing: exact over triangles, and over
/// patches the far end of their boxes.
struct CubeUpper {
    F8 distance2;
    const Node* node[8];  ///< patch box that gave it, or null where a triangle did
};

inline void find_upper(const KernelInput& in, const Points& p, KernelScratch* scratch, Witnesses* w,
                       CubeUpper* upper) {
    scratch->stack.size = 0;
    scratch->stack.push({&in.root, 0});
    for (auto& node : upper->node)
        node = nullptr;
    while (scratch->stack.size != 0) {
        const Entry e = scratch->stack.data[--scratch->stack.size];
        const Node& node = e.tree->nodes[e.node];
        if (bits(node_distance2(node, p) < upper->distance2 - w->enough) == 0) continue;
        if (!node.is_leaf()) {
            const F8 bar = upper->distance2 - w->enough;
            const F8 dl = node_distance2(e.tree->nodes[node.child()], p);
            const F8 dr = node_distance2(e.tree->nodes[node.child() + 1], p);
            const bool go_left = bits(dl < bar) != 0, go_right = bits(dr < bar) != 0;
            const bool right_first = __builtin_popcount(bits(dr < dl)) > 4;
            if (right_first && go_left) scratch->stack.push({e.tree, node.child()});
            if (go_right) scratch->stack.push({e.tree, node.child() + 1});
            if (!right_first && go_left) scratch->stack.push({e.tree, node.child()});
            continue;
        }
        if (node.count() == 0) {
            const F8 far2 = node_far2(node, p);
            const F8 closer = far2 < upper->distance2;
            upper->distance2 = select(closer, far2, upper->distance2);
            const uint32_t mask = bits(closer);
            for (int l = 0; l < 8; ++l) {
                if ((mask >> l & 1u) != 0) upper->node[l] = &node;
            }
            continue;
        }
        for (uint32_t i = node.first(); i < node.first() + node.count(); ++i) {
            offer_triangle(e.tree->frames[i], e.tree->details[i], p, w);
        }
        const F8 closer = w->distance2 < upper->distance2;
        upper->distance2 = select(closer, w->distance2, upper->distance2);
        const uint32_t mask = bits(closer);
        for (int l = 0; l < 8; ++l) {
            if ((mask >> l & 1u) != 0) upper->node[l] = nullptr;
        }
    }
}

OPENFAB_INLINE float least_lane(F8 a) {
    alignas(32) float v[8];
    store(v, a);
    float m = v[0];
    for (int i = 1; i < 8; ++i)
        m = v[i] < m ? v[i] : m;
    return m;
}

/// Least squared distances of a node of the cut; of its triangles where it is a leaf, because the
/// box of a large slanted triangle says little.
struct CutDistance {
    float center2, corner2;
    bool dominated;
};

CutDistance cut_distance(const Entry& e, const Points& middle, const Points& corner,
                         Domination* rows) {
    const Node& node = e.tree->nodes[e.node];
    CutDistance d{kInfinity, kInfinity, true};
    if (!node.is_leaf() || node.count() == 0) {
        return {least_lane(node_distance2(node, middle)), least_lane(node_distance2(node, corner)),
                false};
    }
    for (uint32_t i = node.first(); i < node.first() + node.count(); ++i) {
        const TriangleFrame& t = e.tree->frames[i];
        if (triangle_dominated(t, corner, rows)) continue;
        d.dominated = false;
        const float center2 = least_lane(lower_bound(to_frame(t, middle)));
        const float corner2 = least_lane(lower_bound(to_frame(t, corner)));
        d.center2 = center2 < d.center2 ? center2 : d.center2;
        d.corner2 = corner2 < d.corner2 ? corner2 : d.corner2;
    }
    return d;
}

/// Squared distance between the node's box and the box around the corners in the node's axes. For a
/// large flat node beside a flat cube it is exact, where the centre's distance less half the
/// diagonal tells little.
float separation2(const Node& n, const Points& corner) {
    float sum = 0;
    for (int k = 0; k < 3; ++k) {
        const F8 u = dot3(set1(n.axis[k][0]), set1(n.axis[k][1]), set1(n.axis[k][2]), corner.x,
                          corner.y, corner.z) -
                     set1(n.center[k]);
        const float above = least_lane(u) - n.half[k];
        const float below = least_lane(set1(0.0f) - u) - n.half[k];
        const float gap = larger(larger(above, below), 0.0f);
        sum += gap * gap;
    }
    return sum;
}

float cube(const KernelInput& in, const Vec3i& lowest, int32_t size, KernelScratch* scratch) {
    scratch->list.size = 0;
    scratch->list_least.size = 0;
    if (in.root.nodes == nullptr) return kInfinity;
    const int32_t low[3] = {lowest.x, lowest.y, lowest.z};
    const int32_t sizes[3] = {size, size, size};
    const BoxOfPoints box = make_box(in, low, sizes);
    Witnesses w{set1(kInfinity), set1(0), set1(0), set1(0), 0, witness_tolerance(box)};
    CubeUpper upper{set1(kInfinity), {}};
    find_upper(in, box.corner, scratch, &w, &upper);

    Domination rows;
    make_rows(box, w, kInfinity, &rows);
    float hi2 = kInfinity;
    for (int i = 0; i < rows.rows; ++i) {
        const float far2 = largest_lane(load(rows.row[i]));
        hi2 = far2 < hi2 ? far2 : hi2;
    }
    // Any point of a patch's box may be the one that is on the surface: the row is the farthest of
    // them at each corner.
    for (int l = 0; l < 8; ++l) {
        bool fresh = upper.node[l] != nullptr;
        for (int j = 0; j < l; ++j)
            fresh = fresh && upper.node[j] != upper.node[l];
        if (!fresh) continue;
        const F8 row = with_slack(node_far2(*upper.node[l], box.corner), box.delta);
        store(rows.row[rows.rows++], row);
        const float far2 = largest_lane(row);
        hi2 = far2 < hi2 ? far2 : hi2;
    }
    const float stop = 0.5f * box.half_diagonal;
    collect({&in.root, 0}, box.corner, stop * stop, false, &rows, scratch);

    alignas(32) float center[3];
    center[0] = largest_lane(box.corner.x) * 0.5f - largest_lane(set1(0.0f) - box.corner.x) * 0.5f;
    center[1] = largest_lane(box.corner.y) * 0.5f - largest_lane(set1(0.0f) - box.corner.y) * 0.5f;
    center[2] = largest_lane(box.corner.z) * 0.5f - largest_lane(set1(0.0f) - box.corner.z) * 0.5f;
    const Points middle{set1(center[0]), set1(center[1]), set1(center[2])};
    size_t kept = 0;
    for (size_t i = 0; i < scratch->list.size; ++i) {
        const Entry e = scratch->list.data[i];
        const CutDistance d = cut_distance(e, middle, box.corner, &rows);
        if (d.dominated) continue;
        scratch->list.data[kept++] = e;
        // From the centre no voxel is farther than half the diagonal, and each has a corner within
        // it.
        const float least2 = larger(d.center2, d.corner2);
        const float ball = __builtin_sqrtf(least2) * (1.0f - 0x1p-18f) - box.half_diagonal;
        const float gap =
            __builtin_sqrtf(separation2(e.tree->nodes[e.node], box.corner)) * (1.0f - 0x1p-18f);
        scratch->list_least.push(larger(larger(ball, gap) - 2 * box.delta, 0.0f));
    }
    scratch->list.size = kept;
    return __builtin_sqrtf(hi2) * kSlack + box.delta;
}

}  // namespace

extern const KernelTable kKernels;
const KernelTable kKernels = {query, cube};

}  // namespace openfab::nearest::OPENFAB_NEAREST_ISA
