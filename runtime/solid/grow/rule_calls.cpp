// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/rule_calls.h"

#include "abi/grow_table.h"

namespace openfab::solid {

namespace {

/// Nodes of one call: their buffers stay in the second-level cache.
constexpr size_t kMost = 2048;

}  // namespace

RuleCalls::RuleCalls(const part::Part& stage, const surface::StaticArgs& fixed, openfab_isa isa)
    : StageCalls(*stage.fablet->shape, fixed, isa, kMost) {}

void* RuleCalls::data(const openfab_arg& arg) {
    switch (static_cast<int32_t>(arg.kind)) {
        case OPENFAB_ARG_GROW_PARENT:
            return const_cast<uint32_t*>(parents_->column(column(arg))) + first_;
        case OPENFAB_ARG_GROW_PLACE:
            if (arg.a == OPENFAB_GROW_PATH)
                return const_cast<uint32_t*>(places_->path.data()) + first_;
            return const_cast<int32_t*>(arg.a == OPENFAB_GROW_CHILD ? places_->child.data()
                                                                    : places_->level.data()) +
                   first_;
        case OPENFAB_ARG_SHAPE_OUT:
            return out_->column(column(arg)) + first_;
        default:
            return nullptr;
    }
}

abi::KernelStatus RuleCalls::grow(const NodeColumns& parents, const NodePlaces& places,
                                  size_t count, NodeColumns* out) {
    parents_ = &parents;
    places_ = &places;
    out_ = out;
    out->assign(components(), count);
    const openfab_segments& segments = shape_.attribute_segments;
    return run(shape_.attributes, segments, segments.step_count > 0 ? count : out->lanes);
}

}  // namespace openfab::solid
