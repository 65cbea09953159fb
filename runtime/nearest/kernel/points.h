// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Queries of arbitrary points, 8 at a time.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/best.h"
#include "runtime/nearest/kernel/cube.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/search.h"
#include "runtime/nearest/kernel/voxel_box.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

OPENFAB_INLINE void clear(PointAnswer* answer) {
    store(answer->distance2, Floats8(kInfinity));
    store(answer->item, Floats8::Ints(-1));
    store(answer->in_patch.triangle, Floats8::Ints(0));
    store(answer->in_patch.bary1, Floats8(0.0f));
    store(answer->in_patch.bary2, Floats8(0.0f));
}

/// Queries packets of eight points: sixteen lie so far apart that the lanes of a wide packet would
/// share too little of the traversal.
void query_points(const KernelInput& in, const PointPacket* packets, size_t count, float radius,
                  KernelScratch* scratch, PointAnswer* answers) {
    const Floats8 radius2 = Floats8(radius < kInfinity ? radius * radius : kInfinity);
    const Floats8 far = Floats8(kMaxCoordinate);
    const NodeRef root{&in.root, 0};
    for (size_t g = 0; g < count; ++g) {
        PointAnswer& answer = answers[g];
        clear(&answer);
        SearchOf<Floats8> s;
        s.p = {Floats8::load(packets[g].p[0]), Floats8::load(packets[g].p[1]),
               Floats8::load(packets[g].p[2])};
        const Floats8 ax = absolute(s.p.x), ay = absolute(s.p.y), az = absolute(s.p.z);
        const Mask8 finite = (ax < far) & (ay < far) & (az < far);
        const uint32_t active = in.root.nodes == nullptr ? 0 : packets[g].mask & bits(finite);
        if (active == 0) continue;
        const Floats8 delta =
            max(max(max(ax, ay), az), Floats8(in.largest_coordinate)) * Floats8(0x1p-19f);
        // The surface is no farther than the far end of the box around it.
        const Floats8 start2 = min(radius2, max_distance2(in.root.nodes[0], s.p));
        begin_search(active, warm_distance2(scratch->warm_points, s.p, start2), delta, scratch, &s);
        search(&root, 1, scratch, &s);
        const uint32_t found = active & found_within(s.best, radius2);
        if (found == 0) continue;
        const FeaturesOfLeaves leaves{*scratch};
        if ((bits(s.best.tied) & found) != 0) break_ties(leaves, s.p, found, &s.best);
        scratch->warm_points.count = 0;
        each_found(leaves, s.best, found,
                   [&](int l, int32_t index, const FeatureAnswer& a, float distance2, float bary1,
                       float bary2) {
                       answer.distance2[l] = distance2;
                       answer.item[l] = a.patch;
                       answer.in_patch.triangle[l] = a.triangle;
                       answer.in_patch.bary1[l] = bary1;
                       answer.in_patch.bary2[l] = bary2;
                       keep_point(leaves.feature(index), bary1, bary2, &scratch->warm_points);
                   });
    }
}

/// Bounds the distances of packets, by the search used for corners of blocks (corner_cache.h).
void bound_points(const KernelInput& in, const PointPacket* packets, const PointPacket* hints,
                  size_t count, float tolerance_mm, KernelScratch* scratch, PointBounds* bounds) {
    const Floats8 zero = Floats8(0.0f), infinity = Floats8(kInfinity);
    for (size_t g = 0; g < count; ++g) {
        PointBounds& out = bounds[g];
        store(out.low, infinity);
        store(out.high, infinity);
        for (auto& coordinate : out.point)
            store(coordinate, zero);
        if (in.root.nodes == nullptr) continue;
        const Points p{Floats8::load(packets[g].p[0]), Floats8::load(packets[g].p[1]),
                       Floats8::load(packets[g].p[2])};
        Witnesses w{infinity, zero, zero, zero, 0, zero};
        WarmStart& warm = scratch->warm_points;
        for (int i = 0; i < warm.count; ++i)
            update_witness_point(warm.point[0][i], warm.point[1][i], warm.point[2][i], p, &w);
        if (hints != nullptr)
            update_witness_points({Floats8::load(hints[g].p[0]), Floats8::load(hints[g].p[1]),
                                   Floats8::load(hints[g].p[2])},
                                  p, &w);
        // If distances differ by `tolerance_mm`, their squares differ by at most this.
        const Floats8 most2 = min(w.distance2, max_distance2(in.root.nodes[0], p));
        w.tolerance2 = Floats8(2 * tolerance_mm) * sqrt(most2);
        find_witnesses({&in.root, 0}, p, scratch, &w);
        const Floats8 largest = max(max(absolute(p.x), absolute(p.y)),
                                    max(absolute(p.z), Floats8(in.largest_coordinate)));
        const Floats8 rounded = largest * Floats8(0x1p-18f);
        const Floats8 least =
            sqrt(max(w.distance2 - w.tolerance2, zero)) * Floats8(1.0f - 0x1p-18f);
        store(out.low, max(least - rounded, zero));
        store(out.high, sqrt(w.distance2) * Floats8(1.0f + 0x1p-18f) + rounded);
        store(out.point[0], w.x);
        store(out.point[1], w.y);
        store(out.point[2], w.z);
        __builtin_memcpy(warm.point, out.point, sizeof(warm.point));
        warm.count = 8;
    }
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
