// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/args.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "compiler/ir/text.h"

namespace openfab::lower {

namespace {

openfab_arg make_arg(int32_t kind, openfab_scalar_type scalar, int32_t a, int32_t b) {
    return {static_cast<openfab_arg_kind>(kind), scalar, a, b};
}

auto sort_key(const openfab_arg& arg) {
    return std::make_tuple(static_cast<int>(arg.kind), arg.a, arg.b);
}

void add_instr(const ir::Instr& instr, std::vector<openfab_arg>* out) {
    if (instr.op == ir::Op::kInput) {
        switch (instr.kind) {
            case ir::kVoxelCoordHi:
                out->push_back(make_arg(OPENFAB_ARG_BLOCK_SIZE, OPENFAB_INT, 0, 0));
                [[fallthrough]];
            case OPENFAB_ARG_FRACTION:
                return;  // made in the kernel
            case OPENFAB_ARG_BLUE_NOISE:
                for (int32_t a = 0; a < 3; ++a)
                    out->push_back(make_arg(OPENFAB_ARG_GRID, OPENFAB_INT, a, 0));
                out->push_back(make_arg(OPENFAB_ARG_GRID, OPENFAB_UINT, OPENFAB_GRID_SEED, 0));
                out->push_back(make_arg(OPENFAB_ARG_BLOCKS, OPENFAB_INT, 0, 0));
                out->push_back(
                    make_arg(OPENFAB_ARG_BLUE_NOISE, OPENFAB_UINT, instr.a == 0 ? 0 : 1, 0));
                return;
            case ir::kVoxelIndex:
                out->push_back(make_arg(OPENFAB_ARG_GRID, OPENFAB_INT, instr.a, 0));
                [[fallthrough]];
            case ir::kVoxelCoord:
            case ir::kVoxelCoordLo:
                out->push_back(make_arg(OPENFAB_ARG_BLOCKS, OPENFAB_INT, 0, 0));
                return;
            default:
                out->push_back(make_arg(instr.kind, scalar_type(instr.type), instr.a, instr.b));
                return;
        }
    }
    if (instr.op == ir::Op::kTable)
        out->push_back(make_arg(OPENFAB_ARG_VALUES, OPENFAB_UINT, 0, 0));
    if (instr.op == ir::Op::kSample || instr.op == ir::Op::kSampleBound) {
        const bool bound = instr.op == ir::Op::kSampleBound;
        out->push_back(make_arg(OPENFAB_ARG_TEXTURE, OPENFAB_FLOAT, instr.a,
                                bound ? OPENFAB_TEXTURE_MINMAX : OPENFAB_TEXTURE_TEXELS));
        out->push_back(make_arg(OPENFAB_ARG_TEXTURE, OPENFAB_INT, instr.a, OPENFAB_TEXTURE_INFO));
    }
}

/// Lists what the slab kernel makes of the amounts, which are the stage's outputs.
std::vector<openfab_arg> slab_outputs(const ir::Stage& volume, bool chooses) {
    std::vector<openfab_arg> out{make_arg(OPENFAB_ARG_CODE, OPENFAB_UINT, 0, 0),
                                 make_arg(OPENFAB_ARG_UNUSABLE, OPENFAB_UINT, 0, 0),
                                 make_arg(OPENFAB_ARG_FRACTION, OPENFAB_UINT, 0, 0)};
    const auto slots = static_cast<int32_t>(volume.outputs.size());
    for (int32_t channel = 1; channel <= slots; ++channel)
        out.push_back(make_arg(OPENFAB_ARG_FRACTION, OPENFAB_UINT, channel, 0));
    if (chooses) out.push_back(make_arg(OPENFAB_ARG_CHOICE, OPENFAB_UINT, 0, 0));
    return out;
}

}  // namespace

/// Returns whether a kernel may have many outputs.
static bool may_be_packed(ir::StageKind kind) {
    return kind == ir::StageKind::kVolume || kind == ir::StageKind::kVolumeBounds ||
           kind == ir::StageKind::kVolumeSegment || kind == ir::StageKind::kSurfaceSegment ||
           kind == ir::StageKind::kShapeSegment || kind == ir::StageKind::kDerived;
}

bool lists_groups(ir::StageKind kind) {
    return kind == ir::StageKind::kSurfaceSegment || kind == ir::StageKind::kVolumeSegment ||
           kind == ir::StageKind::kShapeSegment || kind == ir::StageKind::kVolume ||
           kind == ir::StageKind::kVolumeDemand;
}

openfab_scalar_type scalar_type(ir::Type type) {
    switch (type) {
        case ir::Type::kBool:
            return OPENFAB_BOOL;
        case ir::Type::kInt:
            return OPENFAB_INT;
        case ir::Type::kUint:
            return OPENFAB_UINT;
        case ir::Type::kFloat:
            break;
    }
    return OPENFAB_FLOAT;
}

ir::Type ir_type(openfab_scalar_type type) {
    switch (type) {
        case OPENFAB_BOOL:
            return ir::Type::kBool;
        case OPENFAB_INT:
            return ir::Type::kInt;
        case OPENFAB_UINT:
            return ir::Type::kUint;
        case OPENFAB_FLOAT:
            break;
    }
    return ir::Type::kFloat;
}

bool is_field(int32_t kind) {
    return kind == OPENFAB_ARG_NEAREST || kind == OPENFAB_ARG_NEAREST_GRAD ||
           kind == OPENFAB_ARG_DISTANCE;
}

std::vector<openfab_arg> KernelArgs::all() const {
    std::vector<openfab_arg> out = inputs;
    out.insert(out.end(), outputs.begin(), outputs.end());
    return out;
}

namespace {

/// Lists what live instructions of a stage need, in order.
std::vector<openfab_arg> collect_inputs(const ir::Stage& stage) {
    std::vector<openfab_arg> out;
    const std::vector<bool> live = ir::live_values(stage);
    for (size_t id = 0; id < stage.instrs.size(); ++id) {
        if (live[id]) add_instr(stage.instrs[id], &out);
    }
    return out;
}

void sort_and_merge(std::vector<openfab_arg>* args) {
    std::ranges::sort(*args, {}, sort_key);
    const auto same = [](const auto& x, const auto& y) { return sort_key(x) == sort_key(y); };
    args->erase(std::unique(args->begin(), args->end(), same), args->end());
}

}  // namespace

std::vector<openfab_arg> collect_fields(const ir::Stage& volume) {
    std::vector<openfab_arg> out = collect_inputs(volume);
    std::erase_if(out, [](const openfab_arg& arg) { return !is_field(arg.kind); });
    sort_and_merge(&out);
    return out;
}

KernelArgs collect_args(const ir::Stage& stage, const SlabStages& inside) {
    KernelArgs args;
    args.inputs = collect_inputs(stage);
    const bool slab = stage.kind == ir::StageKind::kVolume;
    if (lists_groups(stage.kind))
        args.inputs.push_back(make_arg(OPENFAB_ARG_GROUPS, OPENFAB_INT, 0, 0));
    if (slab) {
        args.inputs.push_back(make_arg(OPENFAB_ARG_CHANNELS, OPENFAB_INT, 0, 0));
    }
    if (slab && !inside.after_segments) {
        const size_t fields =
            std::erase_if(args.inputs, [](const openfab_arg& arg) { return is_field(arg.kind); });
        if (fields > 0)
            args.inputs.push_back(make_arg(OPENFAB_ARG_NEAREST_SOURCE, OPENFAB_UINT, 0, 0));
    }
    for (const ir::Stage* other : {inside.demand, inside.dither}) {
        if (other == nullptr) continue;
        const std::vector<openfab_arg> more = collect_inputs(*other);
        args.inputs.insert(args.inputs.end(), more.begin(), more.end());
    }
    sort_and_merge(&args.inputs);
    args.packed = may_be_packed(stage.kind) && stage.outputs.size() > kMostResults;
    if (slab) {
        args.outputs = slab_outputs(stage, inside.dither != nullptr);
        return args;
    }
    for (const ir::Output& output : stage.outputs) {
        const ir::Type type = stage.instrs[output.value].type;
        args.outputs.push_back(make_arg(output.kind, scalar_type(type), output.a, output.b));
    }
    return args;
}

bool is_scalar(openfab_arg_kind kind) {
    return kind == OPENFAB_ARG_UNIFORM || kind == OPENFAB_ARG_FRAME ||
           kind == OPENFAB_ARG_INSTANCE || kind == OPENFAB_ARG_BLOCK_SIZE ||
           kind == OPENFAB_ARG_NEAREST_SOURCE || kind == OPENFAB_ARG_GRID;
}

std::string arg_name(const openfab_arg& arg) {
    const char* kind = ir::kind_name(arg.kind);
    return fmt::format("{}_{}_{}", kind != nullptr ? kind : "arg", arg.a, arg.b);
}

}  // namespace openfab::lower
