// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/patch_units.h"

#include <algorithm>
#include <cmath>

#include "runtime/nearest/tree/oriented.h"
#include "runtime/nearest/tree/split.h"

namespace openfab::nearest {
namespace {

/// Patches of more micropolygons are no part of a unit.
constexpr uint32_t kSmall = 128;
/// Most micropolygons of a unit. A block has some 128 below it; larger units make more for nothing.
constexpr size_t kUnitTriangles = 384;
/// Units are at most this long, relative to the surface: bounds of cubes come from their boxes.
constexpr float kLongest = 1.0f / 8;

/// The number of micropolygons of a lattice patch, without those left out.
uint32_t triangles_of(const surface::Patch& patch) {
    const auto [a0, b0, a1, b1] = patch.lattice;
    uint32_t count = 0;
    for (int32_t b = b0; b < b1; ++b) {
        const int32_t end = std::min(a1, patch.factor - b),
                      over = std::min(a1, patch.factor - b - 1);
        count += static_cast<uint32_t>((end - a0) + (std::min(end, over) - a0));
    }
    return count;
}

}  // namespace

PatchUnits::PatchUnits(const surface::Surface& surface, std::vector<InputPatch>* boxes)
    : all_(surface.patches()) {
    std::vector<Item> items;
    std::vector<InputPatch> kept;
    Box3f whole;
    for (const InputPatch& box : *boxes)
        whole.add(box.bounds);
    for (const InputPatch& box : *boxes) {
        const auto id = static_cast<size_t>(box.patch);
        const bool lattice = id < all_.size() && all_[id].kind == surface::PatchKind::kLattice &&
                             all_[id].factor > 0 && !box.bounds.empty();
        const uint32_t triangles = lattice ? triangles_of(all_[id]) : 0;
        if (lattice && triangles <= kSmall) {
            items.push_back({box.bounds.lo, box.patch, box.bounds.hi, triangles});
        } else {
            kept.push_back(box);
        }
    }
    if (items.size() < 2) return;
    units_.assign(all_.size(), kNone);
    const float longest = kLongest * whole.longest_side();
    struct Span {
        size_t first, end;
        Extent extent;
        bool in_unit;
    };
    std::vector<Span> left{{0, items.size(), extent_of(items, 0, items.size()), false}};
    order_.reserve(items.size());
    while (!left.empty()) {
        const Span span = left.back();
        left.pop_back();
        const bool unit = !span.in_unit && span.extent.weight <= kUnitTriangles &&
                          span.extent.boxes.box().longest_side() <= longest;
        if (span.end - span.first == 1) {
            if (!span.in_unit) first_.push_back(static_cast<uint32_t>(order_.size()) + 1);
            order_.push_back(items[span.first].index);
            continue;
        }
        if (unit) first_.push_back(static_cast<uint32_t>(order_.size() + span.end - span.first));
        Extent sides[2];
        const size_t middle = split_items(span.extent, span.first, span.end, &items, sides);
        left.push_back({middle, span.end, sides[1], span.in_unit || unit});
        left.push_back({span.first, middle, sides[0], span.in_unit || unit});
    }
    corners_.resize(first_.size() - 1);
    for (uint32_t u = 0; u + 1 < first_.size(); ++u) {
        units_[static_cast<size_t>(order_[first_[u]])] = u;
        kept.push_back(box_of(patches(order_[first_[u]]), &corners_[u]));
    }
    *boxes = std::move(kept);
}

/// Fits a box around a unit, in its principal axes.
InputPatch PatchUnits::box_of(std::span<const int32_t> unit, std::array<Vec3f, 8>* corners) const {
    InputPatch out{{}, unit[0]};
    Moments moments;
    float largest = 0;
    for (const int32_t patch : unit) {
        const Box3f& box = all_[static_cast<size_t>(patch)].bounds;
        out.bounds.add(box);
        moments.add_point(vec_cast<double>(box.center()), 1);
        for (int a = 0; a < 3; ++a)
            largest = std::max({largest, std::abs(box.lo[a]), std::abs(box.hi[a])});
    }
    if (unit.size() < 2) return out;
    const PrincipalFrame frame(moments);
    Range spread;
    for (const int32_t patch : unit) {
        for (int c = 0; c < 8; ++c)
            spread.add(frame.coordinates(corner_of(all_[static_cast<size_t>(patch)].bounds, c)));
    }
    // Holds the rounding of axes and corners, as for a node of the hierarchy.
    *corners = frame.box(spread).grown(std::ldexp(static_cast<double>(largest), -21)).corners();
    out.corners = corners->data();
    return out;
}

}  // namespace openfab::nearest
