// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/stage_calls.h"

#include <algorithm>

namespace openfab::solid {

namespace {

bool is_output(const openfab_arg& arg) {
    return arg.kind == OPENFAB_ARG_SHAPE_VALUE || arg.kind == OPENFAB_ARG_SHAPE_VALUE_LO ||
           arg.kind == OPENFAB_ARG_SHAPE_VALUE_HI || arg.kind == OPENFAB_ARG_SHAPE_OUT;
}

}  // namespace

StageCalls::StageCalls(const openfab_shape& shape, const surface::StaticArgs& fixed,
                       openfab_isa isa, size_t most)
    : shape_(shape), fixed_(fixed), isa_(isa), most_(most) {
    for (int32_t i = 0; i < shape_.output_count; ++i) {
        first_component_.push_back(components_);
        components_ += static_cast<size_t>(shape_.outputs[i].components);
    }
}

const void* StageCalls::input(const openfab_arg& arg) {
    if (const void* fixed = fixed_.find(arg)) return fixed;
    if (buffers_used_ == buffers_.size()) buffers_.push_back(std::make_unique<abi::KernelBuffer>());
    abi::KernelBuffer& buffer = *buffers_[buffers_used_++];
    buffer.set_dense(abi::halide_type(arg.scalar), data(arg), {count_});
    return buffer.raw();
}

segments::OutputView StageCalls::output(const openfab_arg& arg) {
    return {static_cast<uint32_t*>(data(arg))};
}

abi::KernelStatus StageCalls::query(const openfab_query& /*query*/,
                                    std::span<const int32_t> /*groups*/,
                                    const segments::States& /*states*/) {
    return abi::KernelStatus::of_code(halide_error_code_generic_error);
}

/// Items are evaluated as often as coverage and caches need them, which logs nothing.
void StageCalls::printf(const openfab_printf& /*call*/, std::span<const int32_t> /*groups*/,
                        const segments::States& /*states*/) {}

abi::KernelStatus StageCalls::run(const openfab_kernel& kernel, const openfab_segments& segments,
                                  size_t n) {
    for (first_ = 0; first_ < n; first_ += most_) {
        in_piece_ = std::min(most_, n - first_);
        buffers_used_ = 0;
        begin_piece();
        if (segments.step_count == 0) {
            count_ = static_cast<int32_t>(in_piece_);
            if (const abi::KernelStatus status = run_kernel(kernel); !status.ok()) return status;
            continue;
        }
        count_ = static_cast<int32_t>(whole_lanes(in_piece_));
        wanted_.assign(static_cast<size_t>(count_) / segments::kLanes, 255);
        if (const size_t rest = in_piece_ % segments::kLanes; rest != 0)
            wanted_.back() = static_cast<uint8_t>((1u << rest) - 1u);
        const abi::KernelStatus status =
            driver_.run(segments, isa_, wanted_, this, this, fixed_.stop());
        if (!status.ok()) return status;
    }
    return {};
}

/// Of the current piece. Outputs of a packed kernel come last, as the columns of one buffer.
abi::KernelStatus StageCalls::run_kernel(const openfab_kernel& kernel) {
    abi::KernelCall call(kernel, isa_);
    int32_t i = 0;
    for (; i < kernel.arg_count; ++i) {
        if (kernel.packed != 0 && is_output(kernel.args[i])) break;
        call.set(i, input(kernel.args[i]));
    }
    const auto packed = static_cast<size_t>(kernel.arg_count - i);
    abi::KernelBuffer all;
    if (packed > 0) {
        packed_.resize(packed * in_piece_);
        all.set_dense(abi::halide_type(OPENFAB_UINT), packed_.data(),
                      {count_, static_cast<int32_t>(packed)});
        call.set(i, all.raw());
    }
    if (const abi::KernelStatus status = call.run(); !status.ok()) return status;
    for (size_t k = 0; k < packed; ++k) {
        std::copy_n(packed_.data() + k * in_piece_, in_piece_,
                    static_cast<uint32_t*>(data(kernel.args[static_cast<size_t>(i) + k])));
    }
    return {};
}

}  // namespace openfab::solid
