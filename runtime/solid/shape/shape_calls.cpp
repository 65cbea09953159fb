// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_calls.h"

#include <algorithm>

namespace openfab::solid {

namespace {

/// Points of one call: their buffers stay in the second-level cache.
constexpr size_t kMost = 4096;

bool is_output(const openfab_arg& arg) {
    return arg.kind == OPENFAB_ARG_SHAPE_VALUE || arg.kind == OPENFAB_ARG_SHAPE_VALUE_LO ||
           arg.kind == OPENFAB_ARG_SHAPE_VALUE_HI || arg.kind == OPENFAB_ARG_SHAPE_OUT;
}

size_t whole_groups(size_t n) {
    return (n + segments::kLanes - 1) / segments::kLanes * segments::kLanes;
}

}  // namespace

ShapeCalls::ShapeCalls(const part::Part& stage, const surface::StaticArgs& fixed, openfab_isa isa)
    : shape_(*stage.fablet->shape), fixed_(fixed), isa_(isa) {
    for (int32_t i = 0; i < shape_.output_count; ++i) {
        first_component_.push_back(components_);
        components_ += static_cast<size_t>(shape_.outputs[i].components);
    }
}

abi::KernelStatus ShapeCalls::values(const ShapePoints& points, std::vector<float>* out) {
    out->resize(whole_groups(points.size()));
    for (size_t a = 0; a < 3; ++a)
        points_[a] = points.at[a].data();
    value_ = out->data();
    const openfab_segments& segments = shape_.value_segments;
    return run(shape_.values, segments.step_count > 0 ? &segments : nullptr, points.size());
}

abi::KernelStatus ShapeCalls::bounds(const ShapePoints& lo, const ShapePoints& hi,
                                     std::vector<float>* out_lo, std::vector<float>* out_hi) {
    out_lo->resize(lo.size());
    out_hi->resize(lo.size());
    if (shape_.bounds.arg_count == 0) {
        std::fill(out_lo->begin(), out_lo->end(), std::numeric_limits<float>::quiet_NaN());
        *out_hi = *out_lo;
        return {};
    }
    for (size_t a = 0; a < 3; ++a)
        lo_[a] = lo.at[a].data(), hi_[a] = hi.at[a].data();
    value_lo_ = out_lo->data();
    value_hi_ = out_hi->data();
    return run(shape_.bounds, nullptr, lo.size());
}

abi::KernelStatus ShapeCalls::attributes(const ShapePoints& points,
                                         std::vector<std::vector<uint32_t>>* out) {
    out->resize(components_);
    for (auto& component : *out)
        component.assign(whole_groups(points.size()), 0);
    for (size_t a = 0; a < 3; ++a)
        points_[a] = points.at[a].data();
    outputs_ = out;
    const openfab_segments& segments = shape_.attribute_segments;
    return run(shape_.attributes, segments.step_count > 0 ? &segments : nullptr, points.size());
}

/// Returns the values of a list from its current piece on.
float* ShapeCalls::data(const openfab_arg& arg, size_t first) {
    const auto from = [&](const float* list) { return const_cast<float*>(list) + first; };
    switch (arg.kind) {
        case OPENFAB_ARG_SHAPE_POINT:
            return from(points_[static_cast<size_t>(arg.a)]);
        case OPENFAB_ARG_SHAPE_POINT_LO:
            return from(lo_[static_cast<size_t>(arg.a)]);
        case OPENFAB_ARG_SHAPE_POINT_HI:
            return from(hi_[static_cast<size_t>(arg.a)]);
        case OPENFAB_ARG_SHAPE_VALUE:
            return from(value_);
        case OPENFAB_ARG_SHAPE_VALUE_LO:
            return from(value_lo_);
        case OPENFAB_ARG_SHAPE_VALUE_HI:
            return from(value_hi_);
        case OPENFAB_ARG_SHAPE_OUT:
            return reinterpret_cast<float*>(
                (*outputs_)[first_component(arg.a) + static_cast<size_t>(arg.b)].data() + first);
        default:
            return nullptr;
    }
}

const void* ShapeCalls::input(const openfab_arg& arg) {
    if (const void* fixed = fixed_.find(arg)) return fixed;
    if (buffers_used_ == buffers_.size()) buffers_.push_back(std::make_unique<abi::KernelBuffer>());
    abi::KernelBuffer& buffer = *buffers_[buffers_used_++];
    buffer.set_dense(abi::halide_type(arg.scalar), data(arg, first_), {count_});
    return buffer.raw();
}

segments::OutputView ShapeCalls::output(const openfab_arg& arg) {
    return {reinterpret_cast<uint32_t*>(data(arg, first_))};
}

/// The language has queries in the volume stage only.
abi::KernelStatus ShapeCalls::query(const openfab_query& /*query*/,
                                    std::span<const int32_t> /*groups*/,
                                    const segments::States& /*states*/) {
    return abi::KernelStatus::of_code(halide_error_code_generic_error);
}

/// Points are evaluated as often as coverage and caches need them, which logs nothing.
void ShapeCalls::printf(const openfab_printf& /*call*/, std::span<const int32_t> /*groups*/,
                        const segments::States& /*states*/) {}

abi::KernelStatus ShapeCalls::run(const openfab_kernel& kernel, const openfab_segments* segments,
                                  size_t n) {
    for (first_ = 0; first_ < n; first_ += kMost) {
        const size_t count = std::min(kMost, n - first_);
        buffers_used_ = 0;
        if (segments != nullptr) {
            const size_t groups = whole_groups(count) / segments::kLanes;
            wanted_.assign(groups, 255);
            if (const size_t rest = count % segments::kLanes; rest != 0)
                wanted_.back() = static_cast<uint8_t>((1u << rest) - 1u);
            count_ = static_cast<int32_t>(groups * segments::kLanes);
            const abi::KernelStatus status = driver_.run(*segments, isa_, wanted_, this, this);
            if (!status.ok()) return status;
            continue;
        }
        count_ = static_cast<int32_t>(count);
        abi::KernelCall call(kernel, isa_);
        int32_t i = 0;
        for (; i < kernel.arg_count; ++i) {
            if (kernel.packed != 0 && is_output(kernel.args[i])) break;
            call.set(i, input(kernel.args[i]));
        }
        const auto packed = static_cast<size_t>(kernel.arg_count - i);
        abi::KernelBuffer all;
        if (packed > 0) {
            packed_.resize(packed * count);
            all.set_dense(abi::halide_type(OPENFAB_UINT), packed_.data(),
                          {count_, static_cast<int32_t>(packed)});
            call.set(i, all.raw());
        }
        if (const abi::KernelStatus status = call.run(); !status.ok()) return status;
        for (size_t k = 0; k < packed; ++k) {
            std::copy_n(
                packed_.data() + k * count, count,
                reinterpret_cast<uint32_t*>(data(kernel.args[static_cast<size_t>(i) + k], first_)));
        }
    }
    return {};
}

}  // namespace openfab::solid
