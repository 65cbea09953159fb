// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/tree_store.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace openfab::nearest {
namespace {

/// An array that does not fit into the rest of a region starts the next; untouched pages take no
/// memory.
constexpr size_t kRegionBytes = size_t{4} << 20;

}  // namespace

TreeView TreeStore::keep(const Tree& tree) {
    TreeView view = tree.view();
    view.nodes = copy(tree.nodes);
    view.frames = copy(tree.frames);
    view.details = copy(tree.details);
    view.edges = copy(tree.edges);
    view.vertices = copy(tree.vertices);
    view.leaves = copy(tree.leaves);
    view.half_spaces = copy(tree.half_spaces.values);
    view.cones = copy(tree.cones);
    return view;
}

template <typename T>
const T* TreeStore::copy(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= alignof(Line));
    const size_t bytes = values.size() * sizeof(T);
    if (bytes == 0) return nullptr;
    Line* to = take((bytes + sizeof(Line) - 1) / sizeof(Line));
    std::memcpy(to, values.data(), bytes);
    return reinterpret_cast<const T*>(to);
}

TreeStore::Line* TreeStore::take(size_t lines) {
    const std::lock_guard lock(mutex_);
    if (lines > left_) {
        left_ = std::max(lines, kRegionBytes / sizeof(Line));
        regions_.push_back(std::make_unique_for_overwrite<Line[]>(left_));
        next_ = regions_.back().get();
    }
    Line* const taken = next_;
    next_ += lines;
    left_ -= lines;
    return taken;
}

}  // namespace openfab::nearest
