// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/engine/patch_cache.h"

#include <algorithm>
#include <limits>

namespace openfab::nearest {

void append_triangles(const surface::MicroMesh& mesh, int32_t patch,
                      std::vector<InputTriangle>* out) {
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        InputTriangle in{{}, patch, static_cast<int32_t>(t)};
        for (int k = 0; k < 3; ++k)
            in.v[k] = mesh.positions[static_cast<size_t>(mesh.triangles[t][k])];
        out->push_back(in);
    }
}

std::shared_ptr<const PatchTree> PatchCache::get(const surface::Surface& surface,
                                                 int32_t surface_id, int32_t patch) {
    const uint64_t key = static_cast<uint64_t>(surface_id) << 32 | static_cast<uint32_t>(patch);
    if (std::shared_ptr<const PatchTree> found = trees_.find(key)) return found;
    std::vector<InputTriangle> triangles;
    append_triangles(*surface.micro(patch), patch, &triangles);
    auto made = std::make_shared<PatchTree>();
    made->tree = build_tree(triangles, {}, {.diced = true});
    if (!made->tree.nodes.empty()) made->view = made->tree.view();
    return trees_.insert(key, std::move(made));
}

void PatchPins::begin(const TreeSources& sources, bool all) {
    if (sources_.surface_id != sources.surface_id) release();
    sources_ = sources;
    max_bytes_ = all ? std::numeric_limits<size_t>::max() : sources.cache->max_pinned();
    left_out_ = false;
}

bool PatchPins::end() {
    if (bytes_ > kHeldPatchBytes) release();
    return !left_out_;
}

void PatchPins::release() {
    pins_.clear();
    bytes_ = 0;
    std::fill(table_.begin(), table_.end(), 0);
}

const TreeView* PatchPins::fetch(void* context, int32_t id) {
    auto& pins = *static_cast<PatchPins*>(context);
    const LazyTreelets& treelets = *pins.sources_.treelets;
    return treelets.has(id) ? treelets.get(id) : pins.pin(id);
}

const TreeView* PatchPins::pin(int32_t patch) {
    if (table_.size() < 2 * (pins_.size() + 1)) rehash(std::max<size_t>(64, table_.size() * 2));
    const size_t mask = table_.size() - 1;
    size_t slot = static_cast<uint32_t>(patch) * 2654435761u & mask;
    for (; table_[slot] != 0; slot = (slot + 1) & mask) {
        const auto& pin = pins_[table_[slot] - 1];
        if (pin.first == patch) return &pin.second->view;
    }
    if (bytes_ >= max_bytes_) {
        static const TreeView kNothing;
        left_out_ = true;
        return &kNothing;
    }
    const TreeSources& from = sources_;
    pins_.emplace_back(patch, from.cache->get(*from.surface, from.surface_id, patch));
    table_[slot] = static_cast<int32_t>(pins_.size());
    const TreeView& view = pins_.back().second->view;
    bytes_ += pins_.back().second->bytes();
    if (view.nodes != nullptr) from.boxes->put(patch, view.nodes[0]);
    return &view;
}

void PatchPins::rehash(size_t slots) {
    table_.assign(slots, 0);
    for (size_t i = 0; i < pins_.size(); ++i) {
        size_t slot = static_cast<uint32_t>(pins_[i].first) * 2654435761u & (slots - 1);
        while (table_[slot] != 0)
            slot = (slot + 1) & (slots - 1);
        table_[slot] = static_cast<int32_t>(i + 1);
    }
}

}  // namespace openfab::nearest
