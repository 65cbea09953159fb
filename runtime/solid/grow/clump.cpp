// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/clump.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/infinity.h"

namespace openfab::solid {

namespace {

constexpr int32_t kLeaf = 6;

}  // namespace

uint64_t child_id(uint64_t node, int32_t child) {
    // The finalizer of SplitMix64.
    uint64_t x = node + 0x9e3779b97f4a7c15u * (static_cast<uint64_t>(child) + 1);
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

Box3f box_of(const GrownBeam& beam) {
    Box3f box;
    for (size_t e = 0; e < 2; ++e) {
        for (int a = 0; a < 3; ++a) {
            const float at = beam.end[e][a], r = beam.radius[e];
            box.lo[a] = std::min(box.lo[a], std::nextafter(at - r, -kInfinity));
            box.hi[a] = std::max(box.hi[a], std::nextafter(at + r, kInfinity));
        }
    }
    return box;
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
    std::vector<Box3f> boxes;
    boxes.reserve(beams.size() + buds.size());
    for (const GrownBeam& beam : beams)
        boxes.push_back(box_of(beam));
    for (const Bud& bud : buds)
        boxes.push_back(bud.bound);
    items_.resize(boxes.size());
    std::iota(items_.begin(), items_.end(), 0);
    std::vector<Vec3f> centres;
    centres.reserve(boxes.size());
    for (const Box3f& box : boxes)
        centres.push_back(box.center());
    if (!boxes.empty()) build(boxes, centres, 0, static_cast<int32_t>(boxes.size()));
    beams.shrink_to_fit();
    floats.shrink_to_fit();
    ints.shrink_to_fit();
    bodies.shrink_to_fit();
    buds.shrink_to_fit();
    states.shrink_to_fit();
    nodes_.shrink_to_fit();
}

/// Splits in the middle of the longest side of the centres.
void Clump::build(std::span<const Box3f> boxes, std::span<const Vec3f> centres, int32_t first,
                  int32_t count) {
    const std::span<int32_t> items(items_.data() + first, static_cast<size_t>(count));
    Box3f box, middle;
    for (const int32_t i : items) {
        box.add(boxes[static_cast<size_t>(i)]);
        middle.add(centres[static_cast<size_t>(i)]);
    }
    const size_t node = nodes_.size();
    nodes_.push_back({box, first, count});
    if (count <= kLeaf) return;
    const Vec3f size = middle.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int32_t half = count / 2;
    std::nth_element(items.begin(), items.begin() + half, items.end(), [&](int32_t a, int32_t b) {
        const float p = centres[static_cast<size_t>(a)][axis];
        const float q = centres[static_cast<size_t>(b)][axis];
        return p != q ? p < q : a < b;
    });
    build(boxes, centres, first, half);
    nodes_[node].first = static_cast<int32_t>(nodes_.size());
    nodes_[node].count = 0;
    build(boxes, centres, first + half, count - half);
}

size_t Clump::bytes() const {
    const auto of = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
    return sizeof *this + of(beams) + of(floats) + of(ints) + of(bodies) + of(buds) + of(states) +
           of(nodes_) + of(items_) + own_bytes;
}

}  // namespace openfab::solid
