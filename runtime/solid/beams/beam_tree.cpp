// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/beams/beam_tree.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "base/at.h"
#include "base/infinity.h"

namespace openfab::solid {

namespace {

constexpr size_t kDepth = 64;                  // more than a balanced tree of 2^31 has
constexpr size_t kParallel = size_t{1} << 14;  // beams from which halves are built at once

/// Returns the nodes of a tree over this number of beams: halves differ by one beam at most.
int32_t nodes_of(size_t beams, size_t leaf) {
    if (beams <= leaf) return 1;
    return 1 + nodes_of(beams / 2, leaf) + nodes_of(beams - beams / 2, leaf);
}

float outwards(double x, float to) {
    return std::nextafter(static_cast<float>(x), to);
}

}  // namespace

struct BeamTree::Item {
    Box3f box;
    int32_t number = 0;
    float middle(int axis) const { return box.lo[axis] + box.hi[axis]; }
};

BeamTree::BeamTree(const part::PartBeams& source) {
    const mesh::Beams& from = *source.beams;
    const double s = source.scale;
    const Affine3d map{{s, 0, 0, 0, s, 0, 0, 0, s}, Vec3d{} - source.center_part_mm};
    const size_t n = from.beams.size();
    std::vector<Item> items(n);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, n, 4096), [&](const auto& range) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
            Box3d box;
            mesh::add_beam_box(from, from.beams[i], map, &box);
            for (int a = 0; a < 3; ++a) {
                items[i].box.lo[a] = outwards(box.lo[a], -kInfinity);
                items[i].box.hi[a] = outwards(box.hi[a], kInfinity);
            }
            items[i].number = static_cast<int32_t>(i);
        }
    });
    nodes_.resize(static_cast<size_t>(nodes_of(n, kLeaf)));
    build(items, 0, 0);
    beams_.resize(n);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, n, 4096), [&](const auto& range) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
            const mesh::Beam& beam = from.beams[static_cast<size_t>(items[i].number)];
            beams_[i] = make_record(beam, items[i].number,
                                    map.apply(from.nodes[static_cast<size_t>(beam.nodes[0])]),
                                    map.apply(from.nodes[static_cast<size_t>(beam.nodes[1])]), s);
        }
    });
}

/// Splits in the middle of the longest side of the centres, into halves of equal counts.
void BeamTree::build(std::span<Item> items, int32_t first, int32_t node) {
    Box3f box, centres;
    for (const Item& item : items) {
        box.add(item.box);
        centres.add(Vec3f{item.middle(0), item.middle(1), item.middle(2)});
    }
    Node& to = nodes_[static_cast<size_t>(node)];
    to.box = box;
    if (items.size() <= kLeaf) {
        std::ranges::sort(items, {}, &Item::number);
        to.first = first;
        to.count = static_cast<int32_t>(items.size());
        return;
    }
    const Vec3f size = centres.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const size_t half = items.size() / 2;
    std::nth_element(items.begin(), items.begin() + static_cast<ptrdiff_t>(half), items.end(),
                     [axis](const Item& a, const Item& b) {
                         const float p = a.middle(axis), q = b.middle(axis);
                         return p != q ? p < q : a.number < b.number;
                     });
    const int32_t left = node + 1, right = left + nodes_of(half, kLeaf);
    to.first = right;
    const auto lower = [&] { build(items.first(half), first, left); };
    const auto upper = [&] {
        build(items.subspan(half), first + static_cast<int32_t>(half), right);
    };
    if (items.size() >= kParallel) {
        tbb::parallel_invoke(lower, upper);
    } else {
        lower();
        upper();
    }
}

float BeamTree::slack(const Vec3f& p) const {
    float largest = 0;
    for (int a = 0; a < 3; ++a)
        largest = std::max({largest, std::fabs(p[a]), std::fabs(bounds().lo[a]), bounds().hi[a]});
    return largest * 0x1p-19f;
}

NearestBeam BeamTree::nearest(const Vec3f& p, int32_t start) const {
    NearestBeam best{-1, kInfinity};
    const auto take = [&](int32_t i) {
        const float d = beam_distance(at(beams_, i), p);
        if (d < best.distance ||
            (d == best.distance &&
             (best.beam < 0 ||
              at(beams_, i).number < beams_[static_cast<size_t>(best.beam)].number)))
            best = {i, d};
    };
    if (start >= 0) take(start);
    const float slack = this->slack(p);
    struct Open {
        int32_t node;
        float bound;
    };
    std::array<Open, kDepth> stack;
    size_t open = 0;
    stack[open++] = {0, box_distance(nodes_[0].box, p)};
    while (open > 0) {
        const Open at = stack[--open];
        if (at.bound > best.distance + slack) continue;
        const Node& node = nodes_[static_cast<size_t>(at.node)];
        if (node.count > 0) {
            for (int32_t i = node.first; i < node.first + node.count; ++i)
                take(i);
            continue;
        }
        Open children[2] = {{at.node + 1, 0}, {node.first, 0}};
        for (Open& child : children)
            child.bound = box_distance(nodes_[static_cast<size_t>(child.node)].box, p);
        if (children[0].bound < children[1].bound) std::swap(children[0], children[1]);
        for (const Open& child : children) {
            if (child.bound <= best.distance + slack) stack[open++] = child;
        }
    }
    return best;
}

void BeamTree::collect(const Vec3f& p, float limit, std::vector<int32_t>* out) const {
    const float most = limit + slack(p);
    std::array<int32_t, kDepth> stack;
    size_t open = 0;
    stack[open++] = 0;
    while (open > 0) {
        const int32_t number = stack[--open];
        const Node& node = at(nodes_, number);
        if (box_distance(node.box, p) > most) continue;
        if (node.count == 0) {
            stack[open++] = node.first;
            stack[open++] = number + 1;
            continue;
        }
        for (int32_t i = node.first; i < node.first + node.count; ++i) {
            if (beam_distance(at(beams_, i), p) <= most) out->push_back(i);
        }
    }
}

void BeamTree::collect(const Box3f& box, std::vector<int32_t>* out) const {
    std::array<int32_t, kDepth> stack;
    size_t open = 0;
    stack[open++] = 0;
    while (open > 0) {
        const int32_t number = stack[--open];
        const Node& node = at(nodes_, number);
        if (!node.box.overlaps(box)) continue;
        if (node.count == 0) {
            stack[open++] = node.first;
            stack[open++] = number + 1;
            continue;
        }
        for (int32_t i = node.first; i < node.first + node.count; ++i)
            out->push_back(i);
    }
}

}  // namespace openfab::solid
