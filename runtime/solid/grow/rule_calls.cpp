// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/rule_calls.h"

#include <algorithm>

#include "abi/grow_table.h"

namespace openfab::solid {

namespace {

/// Nodes of one call: their buffers stay in the second-level cache.
constexpr size_t kMost = 2048;

}  // namespace

RuleCalls::RuleCalls(const part::Part& stage, const surface::StaticArgs& fixed, openfab_isa isa)
    : shape_(*stage.fablet->shape), fixed_(fixed), isa_(isa) {
    for (int32_t i = 0; i < shape_.output_count; ++i) {
        first_component_.push_back(components_);
        components_ += static_cast<size_t>(shape_.outputs[i].components);
    }
}

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

const void* RuleCalls::input(const openfab_arg& arg) {
    if (const void* fixed = fixed_.find(arg)) return fixed;
    if (buffers_used_ == buffers_.size()) buffers_.push_back(std::make_unique<abi::KernelBuffer>());
    abi::KernelBuffer& buffer = *buffers_[buffers_used_++];
    buffer.set_dense(abi::halide_type(arg.scalar), data(arg), {count_});
    return buffer.raw();
}

segments::OutputView RuleCalls::output(const openfab_arg& arg) {
    return {static_cast<uint32_t*>(data(arg))};
}

/// The language has queries in the volume stage only.
abi::KernelStatus RuleCalls::query(const openfab_query& /*query*/,
                                   std::span<const int32_t> /*groups*/,
                                   const segments::States& /*states*/) {
    return abi::KernelStatus::of_code(halide_error_code_generic_error);
}

/// Nodes are made as often as caches need them, which logs nothing.
void RuleCalls::printf(const openfab_printf& /*call*/, std::span<const int32_t> /*groups*/,
                       const segments::States& /*states*/) {}

abi::KernelStatus RuleCalls::grow(const NodeColumns& parents, const NodePlaces& places,
                                  size_t count, NodeColumns* out) {
    parents_ = &parents;
    places_ = &places;
    out_ = out;
    out->assign(components_, count);
    const openfab_kernel& kernel = shape_.attributes;
    for (first_ = 0; first_ < count; first_ += kMost) {
        const size_t lanes = whole_lanes(std::min(kMost, count - first_));
        buffers_used_ = 0;
        count_ = static_cast<int32_t>(lanes);
        if (shape_.attribute_segments.step_count > 0) {
            wanted_.assign(lanes / segments::kLanes, 255);
            if (const size_t rest = (count - first_) % segments::kLanes;
                rest != 0 && count - first_ < lanes)
                wanted_.back() = static_cast<uint8_t>((1u << rest) - 1u);
            const abi::KernelStatus status =
                driver_.run(shape_.attribute_segments, isa_, wanted_, this, this, fixed_.stop());
            if (!status.ok()) return status;
            continue;
        }
        abi::KernelCall call(kernel, isa_);
        int32_t i = 0;
        for (; i < kernel.arg_count; ++i) {
            if (kernel.packed != 0 && kernel.args[i].kind == OPENFAB_ARG_SHAPE_OUT) break;
            call.set(i, input(kernel.args[i]));
        }
        const auto packed = static_cast<size_t>(kernel.arg_count - i);
        abi::KernelBuffer all;
        if (packed > 0) {
            packed_.resize(packed * lanes);
            all.set_dense(abi::halide_type(OPENFAB_UINT), packed_.data(),
                          {count_, static_cast<int32_t>(packed)});
            call.set(i, all.raw());
        }
        if (const abi::KernelStatus status = call.run(); !status.ok()) return status;
        for (size_t k = 0; k < packed; ++k) {
            std::copy_n(packed_.data() + k * lanes, lanes,
                        static_cast<uint32_t*>(data(kernel.args[static_cast<size_t>(i) + k])));
        }
    }
    return {};
}

}  // namespace openfab::solid
