// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/kernel_inputs.h"

#include <algorithm>
#include <string>
#include <utility>

#include "compiler/lower/algorithm/blue_noise.h"
#include "compiler/lower/algorithm/normalise.h"
#include "compiler/lower/algorithm/sample_parts.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using ir::Type;

constexpr int32_t kSide = 8;

}  // namespace

void KernelInputs::add(const openfab_arg& arg, LoweringContext* context, Deferred* deferred) {
    const std::string name = arg_name(arg);
    if (arg.kind == OPENFAB_ARG_NEAREST_SOURCE) {
        source_ = Halide::Param<void*>(name);
        arguments_.push_back(source_);
        return;
    }
    const Key key = {arg.kind, arg.a, arg.b};
    const Halide::Type type = storage_type(ir_type(arg.scalar));
    if (is_scalar(arg.kind)) {
        const Halide::Param<> param(type, name);
        scalars_.emplace(key, param);
        arguments_.push_back(param);
        return;
    }
    const bool texture = arg.kind == OPENFAB_ARG_TEXTURE;
    const bool blocks = arg.kind == OPENFAB_ARG_BLOCKS;
    const bool channels = arg.kind == OPENFAB_ARG_CHANNELS;
    const bool mask = arg.kind == OPENFAB_ARG_BLUE_NOISE;
    const int dimensions = blocks || channels || mask ? 2 : 1;
    Halide::ImageParam image(mask ? Halide::UInt(16) : type, dimensions, name);
    for (int d = 0; d < dimensions; ++d)
        image.dim(d).set_min(0);
    if (blocks) image.dim(0).set_extent(3);
    if (mask) shape_blue_noise(&image);
    arguments_.push_back(image);
    if (arg.kind == OPENFAB_ARG_VALUES) deferred->set_values(image);
    if (texture) {
        context->textures.emplace(std::pair(arg.a, arg.b), image);
    } else {
        buffers_.emplace(key, image);
    }
}

Expr KernelInputs::index_along(const Halide::ImageParam& image, int dimension) const {
    if (lists_groups(kind_)) {
        return Halide::unsafe_promise_clamped(listed_group() / (kSide * kSide), 0,
                                              image.dim(dimension).extent() - 1);
    }
    return Halide::min(group_ * kLanes + lane_, image.dim(dimension).extent() - 1);
}

Expr KernelInputs::listed_group() const {
    const Halide::ImageParam& groups = buffers_.at({OPENFAB_ARG_GROUPS, 0, 0});
    return groups(group_);
}

Value KernelInputs::load(const Key& key, Type type) const {
    if (!fields_.empty() && is_field(key[0])) {
        const auto same = [&](const openfab_arg& arg) {
            return Key{arg.kind, arg.a, arg.b} == key;
        };
        const auto field = std::ranges::find_if(fields_, same) - fields_.begin();
        const Expr bits = nearest_(lane_, static_cast<int>(field), group_);
        return from_storage(type, Halide::reinterpret(storage_type(type), bits));
    }
    if (key[0] == OPENFAB_ARG_FRACTION)
        return convert({Type::kInt, Halide::cast<int32_t>(normalised_->fraction(key[1]))}, type);
    if (auto scalar = scalars_.find(key); scalar != scalars_.end()) {
        return from_storage(type, scalar->second);
    }
    const Halide::ImageParam& image = buffers_.at(key);
    if (lists_groups(kind_)) {
        // The list names groups that the buffers hold.
        const Expr group =
            Halide::unsafe_promise_clamped(listed_group(), 0, image.dim(0).extent() / kLanes - 1);
        return from_storage(type, image(group * kLanes + lane_));
    }
    return from_storage(type, image(index_along(image, 0)));
}

Value KernelInputs::voxel_index(int32_t axis) const {
    const Halide::ImageParam& blocks = buffers_.at({OPENFAB_ARG_BLOCKS, 0, 0});
    const std::array<Expr, 3> axes = {listed_group() % kSide, listed_group() / kSide % kSide,
                                      lane_};
    return Value{Type::kInt, blocks(axis, index_along(blocks, 1))} + Value{Type::kInt, axes[axis]};
}

Value KernelInputs::voxel_coord(const ir::Instr& instr) const {
    const Halide::ImageParam& blocks = buffers_.at({OPENFAB_ARG_BLOCKS, 0, 0});
    Value index{Type::kInt, blocks(instr.a, index_along(blocks, 1))};
    if (instr.kind == ir::kVoxelCoord) {
        index = voxel_index(instr.a);
    } else if (instr.kind == ir::kVoxelCoordHi) {
        const Value size{Type::kInt, scalars_.at({OPENFAB_ARG_BLOCK_SIZE, 0, 0})};
        index = index + (size - constant(1));
    }
    return convert(index, Type::kFloat) + constant(0.5f);
}

Value KernelInputs::blue_noise(int32_t face) const {
    const Halide::ImageParam& blocks = buffers_.at({OPENFAB_ARG_BLOCKS, 0, 0});
    std::array<Expr, 3> lowest;
    for (int32_t axis = 0; axis < 3; ++axis) {
        const Value in_part =
            axis == 2 ? Value{Type::kInt, blocks(axis, index_along(blocks, 1))} : voxel_index(axis);
        lowest.at(static_cast<size_t>(axis)) =
            (in_part + Value{Type::kInt, scalars_.at({OPENFAB_ARG_GRID, axis, 0})}).expr;
    }
    return {Type::kInt, blue_noise_threshold(
                            buffers_.at({OPENFAB_ARG_BLUE_NOISE, face == 0 ? 0 : 1, 0}), face,
                            scalars_.at({OPENFAB_ARG_GRID, OPENFAB_GRID_SEED, 0}), lowest, lane_)};
}

Value KernelInputs::value(const ir::Instr& instr) const {
    if (instr.kind == OPENFAB_ARG_BLUE_NOISE) return blue_noise(instr.a);
    if (instr.kind == ir::kVoxelIndex) {
        return voxel_index(instr.a) +
               Value{Type::kInt, scalars_.at({OPENFAB_ARG_GRID, instr.a, 0})};
    }
    if (ir::is_voxel_coord(instr.kind)) return voxel_coord(instr);
    return load({instr.kind, instr.a, instr.b}, instr.type);
}

}  // namespace openfab::lower
