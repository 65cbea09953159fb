// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The box of a shape's micropolygons under a map, by branch and bound.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

#include "base/infinity.h"
#include "runtime/solid/shape/shape_field.h"

namespace openfab::solid {

namespace {

// Nodes that are looked at together. The number is part of the result, which is to be the same for any
// number of threads.
constexpr size_t kTogether = 32;
// What a side of the box may lack of the micropolygons, in cells. Without it a face that is flat along
// the side, where bounds of the value end at 0 exactly, would be diced whole.
constexpr double kSlackCells = 0x1p-10;

/// Returns the box under an affine map.
Box3d moved(const Affine3d& map, const Box3f& box) {
    Box3d out;
    for (int32_t c = 0; c < 8; ++c) {
        out.add(map.apply({static_cast<double>((c & 1) != 0 ? box.hi.x : box.lo.x),
                           static_cast<double>((c & 2) != 0 ? box.hi.y : box.lo.y),
                           static_cast<double>((c & 4) != 0 ? box.hi.z : box.lo.z)}));
    }
    return out;
}

/// Returns the only axis that a coordinate of the map depends on, or -1.
int only_axis(const Affine3d& map, int axis) {
    int found = -1;
    for (int b = 0; b < 3; ++b) {
        if (map.m[static_cast<size_t>(3 * axis + b)] == 0) continue;
        if (found >= 0) return -1;
        found = b;
    }
    return found;
}

}  // namespace

/// Returns what of the lattice may lie beyond `reach` (the greatest of `sign` times the mapped
/// coordinate that is known), as a box.
Box3f ShapeField::beyond(const Affine3d& map, int axis, double sign, double reach) const {
    Box3f out = bounds();
    const int from = only_axis(map, axis);
    if (from < 0 || !std::isfinite(reach)) return out;
    const double slope = map.m[static_cast<size_t>(3 * axis + from)];
    const double at = (sign * reach - map.t[axis]) / slope;
    const double slack = kSlackCells * cell_mm_ + 0x1p-21 * std::fabs(at);
    if (sign * slope > 0) {
        out.lo[from] = std::max(out.lo[from], static_cast<float>(at + slack));
    } else {
        out.hi[from] = std::min(out.hi[from], static_cast<float>(at - slack));
    }
    return out;
}

void ShapeField::search_side(const Affine3d& map, int axis, double sign, Box3d* box) const {
    const auto reach_of = [&](const Box3d& some) {
        return sign > 0 ? some.hi[axis] : -some.lo[axis];
    };
    struct Entry {
        double reach;
        Node node;
        // What is left is a total order, so that the same blocks are diced in each run.
        bool operator<(const Entry& o) const {
            return std::tie(reach, o.node.lowest.z, o.node.lowest.y, o.node.lowest.x) <
                   std::tie(o.reach, node.lowest.z, node.lowest.y, node.lowest.x);
        }
    };
    const auto entry = [&](const Node& node) {
        return Entry{reach_of(moved(map, box_of(node))), node};
    };
    struct Looked {
        std::vector<Node> parts;
        Box3d box;
    };
    std::priority_queue<Entry> queue;
    queue.push(entry(root()));
    std::vector<Node> together;
    std::vector<Looked> looked(kTogether);
    while (!queue.empty()) {
        const double reach = box->empty() ? -kInfinity : reach_of(*box);
        const Box3f within = beyond(map, axis, sign, reach);
        together.clear();
        for (; !queue.empty() && together.size() < kTogether && queue.top().reach > reach;
             queue.pop())
            together.push_back(queue.top().node);
        if (together.empty()) return;
        tbb::parallel_for(size_t{0}, together.size(), [&](size_t i) {
            looked[i].parts.clear();
            looked[i].box = {};
            look(together[i], within, map, &looked[i].parts, &looked[i].box);
        });
        for (size_t i = 0; i < together.size(); ++i) {
            for (const Node& part : looked[i].parts)
                queue.push(entry(part));
            box->add(looked[i].box);
        }
    }
}

bool ShapeField::undecided(const Node& node, const Box3f& within, ShapeCalls* calls) const {
    const Box3f box = common(box_of(node), within);
    if (box.empty()) return false;
    ShapePoints lo, hi;
    lo.push_back(box.lo);
    hi.push_back(box.hi);
    std::vector<float> value_lo, value_hi;
    if (const abi::KernelStatus status = calls->bounds(lo, hi, &value_lo, &value_hi);
        !status.ok()) {
        note(status);
        return false;
    }
    return !(value_lo[0] >= 0) && !(value_hi[0] < 0);
}

/// Splits a node, or dices a block, unless bounds say that there is nothing beyond.
void ShapeField::look(const Node& node, const Box3f& within, const Affine3d& map,
                      std::vector<Node>* parts, Box3d* box) const {
    ShapeCalls* calls = take();
    if (node.size > kPatchCells) {
        split(node, within, calls, parts);
    } else if (undecided(node, within, calls)) {
        surface::MicroMesh mesh;
        dice(node.lowest, &mesh);
        for (const auto& triangle : mesh.triangles) {
            for (const int32_t v : triangle)
                box->add(map.apply(vec_cast<double>(mesh.positions[static_cast<size_t>(v)])));
        }
    }
    give(calls);
}

Box3d ShapeField::exact_box(const Affine3d& local_to_other) const {
    Box3d exact;
    for (int side = 0; side < 6 && (side == 0 || !exact.empty()); ++side)
        search_side(local_to_other, side / 2, side % 2 == 0 ? -1 : 1, &exact);
    return exact;
}

}  // namespace openfab::solid
