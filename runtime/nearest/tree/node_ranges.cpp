// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/node_ranges.h"

#include <algorithm>
#include <limits>

#include "base/infinity.h"
#include "runtime/nearest/tree/patch_units.h"
#include "runtime/nearest/tree/treelets.h"

namespace openfab::nearest {

NodeRanges::NodeRanges(const Tree& tree, const surface::PatchRanges& r,
                       const LazyTreelets* treelets, const PatchUnits* units)
    : floats_(static_cast<size_t>(r.float_components)),
      ints_(static_cast<size_t>(r.int_components)) {
    if (floats_ + ints_ == 0) return;
    const size_t nodes = tree.nodes.size();
    float_lo_.assign(nodes * floats_, kInfinity);
    float_hi_.assign(nodes * floats_, -kInfinity);
    int_lo_.assign(nodes * ints_, std::numeric_limits<int32_t>::max());
    int_hi_.assign(nodes * ints_, std::numeric_limits<int32_t>::lowest());
    // Children come after their parents, so one pass backwards carries leaves up to the root.
    for (size_t n = nodes; n-- > 0;) {
        const Node& node = tree.nodes[n];
        const auto id = static_cast<int32_t>(node.first());
        if (!node.is_leaf()) {
            for (size_t c = node.child(); c < node.child() + node.children(); ++c) {
                add(n, float_lo_.data() + c * floats_, float_hi_.data() + c * floats_,
                    int_lo_.data() + c * ints_, int_hi_.data() + c * ints_);
            }
        } else if (node.count() != 0) {
            for (size_t t = node.first(); t < node.first() + node.count(); ++t)
                add_patch(n, tree.details[t].patch, r);
        } else if (treelets != nullptr && treelets->has(id)) {
            for (const int32_t patch : treelets->patches(id))
                add_patch(n, patch, r);
        } else {
            for (const int32_t patch : units->patches(id))
                add_patch(n, patch, r);
        }
    }
}

void NodeRanges::add(size_t node, const float* float_lo, const float* float_hi,
                     const int32_t* int_lo, const int32_t* int_hi) {
    for (size_t c = 0; c < floats_; ++c) {
        float_lo_[node * floats_ + c] = std::min(float_lo_[node * floats_ + c], float_lo[c]);
        float_hi_[node * floats_ + c] = std::max(float_hi_[node * floats_ + c], float_hi[c]);
    }
    for (size_t c = 0; c < ints_; ++c) {
        int_lo_[node * ints_ + c] = std::min(int_lo_[node * ints_ + c], int_lo[c]);
        int_hi_[node * ints_ + c] = std::max(int_hi_[node * ints_ + c], int_hi[c]);
    }
}

void NodeRanges::add_patch(size_t node, int32_t patch, const surface::PatchRanges& r) {
    const auto p = static_cast<size_t>(patch);
    add(node, r.float_lo.data() + p * floats_, r.float_hi.data() + p * floats_,
        r.int_lo.data() + p * ints_, r.int_hi.data() + p * ints_);
}

void NodeRanges::add_case(size_t node, float distance_lo, BoxBounds* out) const {
    out->add(distance_lo, {float_lo_.data() + node * floats_, floats_},
             {float_hi_.data() + node * floats_, floats_}, {int_lo_.data() + node * ints_, ints_},
             {int_hi_.data() + node * ints_, ints_});
}

size_t NodeRanges::bytes() const {
    return (float_lo_.capacity() + float_hi_.capacity()) * sizeof(float) +
           (int_lo_.capacity() + int_hi_.capacity()) * sizeof(int32_t) + sizeof(NodeRanges);
}

}  // namespace openfab::nearest
