// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/engine/patch_cache.h"

#include <algorithm>
#include <limits>

#include "base/check.h"

namespace openfab::nearest {

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
    const bool treelet = treelets.has(id) && !pins.sources_.pieces.has(id);
    return treelet ? treelets.get(id) : pins.pin(id);
}

size_t PatchPins::slot_of(int32_t id) const {
    const size_t mask = table_.size() - 1;
    size_t slot = static_cast<uint32_t>(id) * 2654435761u & mask;
    while (table_[slot] != 0 && pins_[table_[slot] - 1].first != id)
        slot = (slot + 1) & mask;
    return slot;
}

std::shared_ptr<const PatchTree> PatchPins::get(int32_t id) {
    const TreeSources& from = sources_;
    if (!from.pieces.has(id)) {
        return from.cache->get(from.surface_id, id, [&] {
            const std::span<const int32_t> unit = from.units->patches(id);
            if (unit.size() > 1) return make_unit_tree(*from.surface, unit, &builder_);
            // A patch with a box had a tree that was evicted: there is not room for whole ones.
            const bool cut = from.crowded || from.boxes->has(id);
            return make_patch_tree(*from.surface, id, from.pieces, cut, &builder_);
        });
    }
    const int32_t patch = from.pieces.patch(id);
    const int32_t whole = table_[slot_of(patch)];
    OPENFAB_CHECK_NE(whole, 0);
    return from.cache->get(from.surface_id, id, [&] {
        return make_piece_tree(*from.surface, patch, *pins_[whole - 1].second,
                               from.pieces.piece(id), &builder_);
    });
}

const TreeView* PatchPins::pin(int32_t id) {
    if (table_.size() < 2 * (pins_.size() + 1)) rehash(std::max<size_t>(64, table_.size() * 2));
    const size_t slot = slot_of(id);
    if (table_[slot] != 0) return &pins_[table_[slot] - 1].second->view();
    if (bytes_ >= max_bytes_) {
        static const TreeView kNothing;
        left_out_ = true;
        return &kNothing;
    }
    pins_.emplace_back(id, get(id));
    table_[slot] = static_cast<int32_t>(pins_.size());
    const TreeView& view = pins_.back().second->view();
    bytes_ += pins_.back().second->bytes();
    if (view.nodes != nullptr && !sources_.pieces.has(id)) sources_.boxes->put(id, view.nodes[0]);
    return &view;
}

void PatchPins::rehash(size_t slots) {
    table_.assign(slots, 0);
    for (size_t i = 0; i < pins_.size(); ++i)
        table_[slot_of(pins_[i].first)] = static_cast<int32_t>(i + 1);
}

}  // namespace openfab::nearest
