// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/packed_tree.h"

#include <cstdlib>
#include <cstring>
#include <new>

namespace openfab::nearest {
namespace {

constexpr size_t kLine = 64;
// Blocks have few sizes, so that one that was freed fits the next; the allocator does not reuse
// aligned ones as well, and aligns them by more than it needs.
constexpr size_t kBlockUnit = 1024;

template <typename T>
size_t lines(const std::vector<T>& values) {
    return (values.size() * sizeof(T) + kLine - 1) / kLine * kLine;
}

/// Cones of trees whose cones are not known: the same for all of up to `nodes` nodes.
const NodeCone* unknown_cones(size_t nodes) {
    static const std::vector<NodeCone> cones(8192);
    return nodes <= cones.size() ? cones.data() : nullptr;
}

}  // namespace

void PackedTree::Free::operator()(std::byte* block) const {
    std::free(block);
}

template <typename T>
const T* PackedTree::put(const std::vector<T>& values, std::byte** next) {
    if (values.empty()) return nullptr;
    std::memcpy(*next, values.data(), values.size() * sizeof(T));
    const auto* at = reinterpret_cast<const T*>(*next);
    *next += lines(values);
    return at;
}

PackedTree::PackedTree(const Tree& tree) {
    if (tree.nodes.empty()) return;
    nodes_ = tree.nodes.size();
    triangles_ = tree.frames.size();
    const NodeCone* unknown = unknown_cones(tree.nodes.size());
    const std::vector<NodeCone> own(unknown == nullptr ? tree.nodes.size() : 0);
    bytes_ = lines(tree.nodes) + lines(tree.frames) + lines(tree.details) + lines(tree.edges) +
             lines(tree.vertices) + lines(tree.leaves) + lines(tree.half_spaces.values) +
             lines(own) + kLine;
    bytes_ = (bytes_ + kBlockUnit - 1) / kBlockUnit * kBlockUnit;
    block_.reset(static_cast<std::byte*>(std::malloc(bytes_)));
    if (block_ == nullptr) throw std::bad_alloc();
    void* line = block_.get();
    size_t room = bytes_;
    auto* next = static_cast<std::byte*>(std::align(kLine, bytes_ - kLine, line, room));
    view_.nodes = put(tree.nodes, &next);
    view_.frames = put(tree.frames, &next);
    view_.details = put(tree.details, &next);
    view_.edges = put(tree.edges, &next);
    view_.vertices = put(tree.vertices, &next);
    view_.leaves = put(tree.leaves, &next);
    view_.half_spaces = put(tree.half_spaces.values, &next);
    view_.cones = unknown != nullptr ? unknown : put(own, &next);
    view_.spacing = tree.spacing;
    view_.longest_edge = tree.longest_edge;
}

}  // namespace openfab::nearest
