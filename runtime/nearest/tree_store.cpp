// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree_store.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>
#include <type_traits>

namespace openfab::nearest {
namespace {

constexpr size_t kLine = 64;
/// What does not fit in the rest of a region begins the next; pages that nothing is in take no
/// memory.
constexpr size_t kRegion = size_t{4} << 20;

size_t round_up(size_t bytes, size_t to) {
    return (bytes + to - 1) / to * to;
}

}  // namespace

void TreeStore::Free::operator()(std::byte* region) const {
    std::free(region);
}

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
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kLine);
    const size_t bytes = values.size() * sizeof(T);
    if (bytes == 0) return nullptr;
    std::byte* to = take(round_up(bytes, kLine));
    std::memcpy(to, values.data(), bytes);
    return reinterpret_cast<const T*>(to);
}

std::byte* TreeStore::take(size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (bytes > left_) {
        const size_t region = round_up(std::max(bytes, kRegion), kLine);
        auto* fresh = static_cast<std::byte*>(std::aligned_alloc(kLine, region));
        if (fresh == nullptr) throw std::bad_alloc();
        regions_.emplace_back(fresh);
        next_ = fresh;
        left_ = region;
    }
    std::byte* const taken = next_;
    next_ += bytes;
    left_ -= bytes;
    return taken;
}

}  // namespace openfab::nearest
