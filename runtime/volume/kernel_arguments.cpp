// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/kernel_arguments.h"

#include <algorithm>

#include "base/at.h"
#include "base/check.h"
#include "runtime/dither/blue_noise.h"

namespace openfab::volume {

const void* part_argument(const PlacedPart& part, const openfab_arg& arg,
                          abi::KernelBuffer* buffer) {
    const auto a = static_cast<size_t>(arg.a);
    switch (arg.kind) {
        case OPENFAB_ARG_UNIFORM:
            return &part.part->uniform_values[a];
        case OPENFAB_ARG_VALUES:
            buffer->set_dense(abi::halide_type(arg), part.part->uniform_values.data(),
                              {static_cast<int32_t>(part.part->uniform_values.size())});
            return buffer->raw();
        case OPENFAB_ARG_FRAME:
            return &part.frame[a];
        case OPENFAB_ARG_INSTANCE:
            return &part.part->instance;
        case OPENFAB_ARG_GRID:
            return &part.rule_inputs[a];
        case OPENFAB_ARG_BLUE_NOISE:
            buffer->set_dense(abi::halide_type(arg),
                              a == 0 ? dither::kBlueNoiseInside : dither::kBlueNoiseSides,
                              {8, static_cast<int32_t>(dither::kBlueNoisePixels)});
            return buffer->raw();
        case OPENFAB_ARG_TEXTURE: {
            const texture::Pyramid& pyramid = *part.part->textures[a];
            if (arg.b == OPENFAB_TEXTURE_INFO) {
                buffer->set_dense(abi::halide_type(OPENFAB_INT), pyramid.info().data(),
                                  {static_cast<int32_t>(pyramid.info().size())});
            } else {
                const std::span<const float> values =
                    arg.b == OPENFAB_TEXTURE_TEXELS ? pyramid.texels() : pyramid.minmax();
                buffer->set_dense(abi::halide_type(OPENFAB_FLOAT), values.data(),
                                  {static_cast<int32_t>(values.size())});
            }
            return buffer->raw();
        }
        default:
            return nullptr;
    }
}

void KernelArguments::begin(const openfab_kernel& kernel, const PlacedPart& part,
                            const int32_t* corners, int32_t n, int32_t block_size) {
    kernel_ = &kernel;
    n_ = n;
    block_size_ = block_size;
    const auto count = static_cast<size_t>(kernel.arg_count);
    args_.assign(count, nullptr);
    if (buffer_count_ < count) {
        buffers_ = std::make_unique<abi::KernelBuffer[]>(count);
        buffer_count_ = count;
    }
    for (size_t i = 0; i < count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        if (arg.kind == OPENFAB_ARG_BLOCK_SIZE) {
            args_[i] = &block_size_;
        } else if (arg.kind == OPENFAB_ARG_BLOCKS) {
            buffers_[i].set_dense(abi::halide_type(OPENFAB_INT), corners, {3, n});
            args_[i] = buffers_[i].raw();
        } else if (arg.kind == OPENFAB_ARG_CHANNELS) {
            buffers_[i].set_dense(abi::halide_type(OPENFAB_INT), part.channels.table(),
                                  {OPENFAB_CHANNEL_ROWS, part.channels.count()});
            args_[i] = buffers_[i].raw();
        } else {
            args_[i] = const_cast<void*>(part_argument(part, arg, &buffers_[i]));
        }
    }
}

void KernelArguments::set_groups(std::span<const int32_t> columns) {
    columns_ = static_cast<int32_t>(columns.size());
    for (int32_t i = 0; i < kernel_->arg_count; ++i) {
        if (kernel_->args[i].kind != OPENFAB_ARG_GROUPS) continue;
        const auto index = static_cast<size_t>(i);
        buffers_[index].set_dense(abi::halide_type(OPENFAB_INT), columns.data(), {columns_});
        args_[index] = buffers_[index].raw();
    }
}

void KernelArguments::set_source(int32_t i, openfab_nearest_source* source) {
    source_ = source;
    at(args_, i) = &source_;
}

void KernelArguments::set_columns(int32_t i, const void* data, int32_t stride) {
    const auto index = static_cast<size_t>(i);
    buffers_[index].set_columns(abi::halide_type(kernel_->args[i]), data, columns_, stride);
    args_[index] = buffers_[index].raw();
}

void KernelArguments::set_list(int32_t i, const void* data) {
    set_values(i, data, n_);
}

void KernelArguments::set_values(int32_t i, const void* data, int32_t count) {
    const auto index = static_cast<size_t>(i);
    buffers_[index].set_dense(abi::halide_type(kernel_->args[i].scalar), data, {count});
    args_[index] = buffers_[index].raw();
}

void KernelArguments::set_packed(int32_t i, const void* data, int32_t count) {
    const auto index = static_cast<size_t>(i);
    buffers_[index].set_dense(abi::halide_type(OPENFAB_UINT), data, {n_, count});
    args_[index] = buffers_[index].raw();
    args_.resize(index + 1);
}

void KernelArguments::set_packed_columns(int32_t i, const void* data, int32_t count) {
    const auto index = static_cast<size_t>(i);
    buffers_[index].set_dense({halide_type_uint, 16, 1}, data, {8, count, columns_});
    args_[index] = buffers_[index].raw();
    args_.resize(index + 1);
}

abi::KernelStatus KernelArguments::run(openfab_isa isa) {
    OPENFAB_CHECK(kernel_ != nullptr);
    OPENFAB_DCHECK(std::find(args_.begin(), args_.end(), nullptr) == args_.end());
    return abi::KernelStatus::of_code(abi::function_for(kernel_->fn, isa)(args_.data()));
}

}  // namespace openfab::volume
