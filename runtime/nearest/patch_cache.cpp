// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/patch_cache.h"

#include <algorithm>

namespace openfab::nearest {

void append_triangles(const surface::MicroMesh& mesh, int32_t patch,
                      std::vector<InputTriangle>* out) {
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        InputTriangle in{{}, patch, static_cast<int32_t>(t)};
        for (int k = 0; k < 3; ++k)
            in.v[k] =
                mesh.positions[static_cast<size_t>(mesh.triangles[t][static_cast<size_t>(k)])];
        out->push_back(in);
    }
}

std::shared_ptr<const PatchTree> PatchCache::get(int32_t patch) {
    {
        const std::lock_guard lock(mutex_);
        const auto it = places_.find(patch);
        if (it != places_.end()) {
            recent_.splice(recent_.begin(), recent_, it->second);
            return it->second->tree;
        }
    }
    std::vector<InputTriangle> triangles;
    append_triangles(*surface_.micro(patch), patch, &triangles);
    auto made = std::make_shared<PatchTree>();
    made->tree = build_tree(triangles, {});
    if (!made->tree.nodes.empty()) made->view = made->tree.view();

    const std::lock_guard lock(mutex_);
    const auto it = places_.find(patch);
    if (it != places_.end()) return it->second->tree;
    bytes_ += made->tree.bytes();
    recent_.push_front({patch, made});
    places_[patch] = recent_.begin();
    while (bytes_ > budget_ && recent_.size() > 1) {
        bytes_ -= recent_.back().tree->tree.bytes();
        places_.erase(recent_.back().patch);
        recent_.pop_back();
    }
    return made;
}

void PatchPins::reset(PatchCache* cache) {
    cache_ = cache;
    if (pins_.empty()) return;
    pins_.clear();
    std::fill(table_.begin(), table_.end(), 0);
}

const TreeView* PatchPins::fetch(void* context, int32_t patch) {
    auto& pins = *static_cast<PatchPins*>(context);
    if (pins.table_.size() < 2 * (pins.pins_.size() + 1))
        pins.rehash(std::max<size_t>(64, pins.table_.size() * 2));
    const size_t mask = pins.table_.size() - 1;
    size_t slot = static_cast<uint32_t>(patch) * 2654435761u & mask;
    for (; pins.table_[slot] != 0; slot = (slot + 1) & mask) {
        const auto& pin = pins.pins_[static_cast<size_t>(pins.table_[slot] - 1)];
        if (pin.first == patch) return &pin.second->view;
    }
    pins.pins_.emplace_back(patch, pins.cache_->get(patch));
    pins.table_[slot] = static_cast<int32_t>(pins.pins_.size());
    return &pins.pins_.back().second->view;
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
