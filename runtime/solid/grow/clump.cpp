// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/clump.h"

#include <algorithm>
#include <cmath>

namespace openfab::solid {

namespace {

constexpr int32_t kLeaf = 16;

}  // namespace

uint64_t child_id(uint64_t node, int32_t child) {
    // The finalizer of SplitMix64.
    uint64_t x = node + 0x9e3779b97f4a7c15u * (static_cast<uint64_t>(child) + 1);
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

void Clump::add_body(GrownBody body, uint64_t id, int32_t level, const Box3f& within) {
    GrownBeam place;
    // Its box is wider than it is.
    Box3f box = body.box();
    for (int a = 0; a < 3; ++a) {
        box.lo[a] = std::max(box.lo[a], within.lo[a]);
        box.hi[a] = std::min(box.hi[a], within.hi[a]);
    }
    place.end = {box.lo, box.hi};
    place.id = id;
    place.level = level;
    place.body = static_cast<int32_t>(bodies.size());
    beams.push_back(place);
    bodies.push_back(std::move(body));
}

void Clump::finish() {
    // A thread makes a clump at a time, a small one mostly.
    static thread_local std::vector<Item> items;
    items.clear();
    const auto add = [&](const Box3f& box) {
        items.push_back({box, box.center(), static_cast<int32_t>(items.size())});
    };
    for (const GrownBeam& beam : beams)
        add(box_of(beam));
    for (const Bud& bud : buds)
        add(bud.bound);
    nodes_.clear();
    if (!items.empty()) build(items, 0);
    items_.clear();
    for (const Item& item : items)
        items_.push_back(item.number);
    constexpr size_t kKept = 4096;
    if (items.capacity() > kKept) std::vector<Item>().swap(items);
}

void Clump::clear() {
    beams.clear();
    floats.clear();
    ints.clear();
    bodies.clear();
    buds.clear();
    states.clear();
    nodes_.clear();
    items_.clear();
    own_bytes = 0;
    empty = 0;
}

/// Splits in the middle of the longest side of the centres.
void Clump::build(std::span<Item> items, int32_t first) {
    Box3f box, middle;
    for (const Item& item : items) {
        box.add(item.box);
        middle.add(item.centre);
    }
    const size_t node = nodes_.size();
    const auto count = static_cast<int32_t>(items.size());
    nodes_.push_back({box, first, count});
    if (count <= kLeaf) return;
    const Vec3f size = middle.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int32_t half = count / 2;
    std::nth_element(items.begin(), items.begin() + half, items.end(),
                     [axis](const Item& a, const Item& b) {
                         const float p = a.centre[axis], q = b.centre[axis];
                         return p != q ? p < q : a.number < b.number;
                     });
    build(items.first(static_cast<size_t>(half)), first);
    nodes_[node].first = static_cast<int32_t>(nodes_.size());
    nodes_[node].count = 0;
    build(items.subspan(static_cast<size_t>(half)), first + half);
}

size_t Clump::bytes() const {
    const auto of = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
    return sizeof *this + of(beams) + of(floats) + of(ints) + of(bodies) + of(buds) + of(states) +
           of(nodes_) + of(items_) + own_bytes;
}

}  // namespace openfab::solid
