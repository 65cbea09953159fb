// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <iterator>

#include "abi/grow_table.h"
#include "abi/shape_distance.h"
#include "compiler/ir/grows.h"
#include "compiler/ir/ir.h"
#include "compiler/ir/text.h"

namespace openfab::ir {

namespace {

// In the order of openfab_arg_kind.
constexpr const char* kKindNames[] = {
    "uniform",
    "texture",
    "frame",
    "instance",
    "blocks",
    "block_size",
    "nearest",
    "nearest_grad",
    "distance",
    "weight",
    "nearest_lo",
    "nearest_hi",
    "distance_lo",
    "distance_hi",
    "weight_lo",
    "weight_hi",
    "surface_in",
    "surface_in_grad",
    "surface_attr",
    "surface_attr_grad",
    "position",
    "surface_out",
    "surface_status",
    "surface_in_lo",
    "surface_in_hi",
    "surface_in_grad_lo",
    "surface_in_grad_hi",
    "surface_attr_lo",
    "surface_attr_hi",
    "surface_attr_grad_lo",
    "surface_attr_grad_hi",
    "displacement_lo",
    "displacement_hi",
    "surface_out_lo",
    "surface_out_hi",
    "groups",
    "state",
    "state_out",
    "derived",
    "demand",
    "channels",
    "code",
    "unusable",
    "fraction",
    "nearest_source",
    "grid",
    "choice",
    "blue_noise",
    "values",
    "shape_point",
    "shape_point_lo",
    "shape_point_hi",
    "shape_value",
    "shape_value_lo",
    "shape_value_hi",
    "shape_out",
    "grow_parent",
    "grow_place",
};
static_assert(std::size(kKindNames) == OPENFAB_ARG_GROW_PLACE + 1);

constexpr const char* kShapeDistanceNames[] = {"shape_distance", "shape_distance_lo",
                                               "shape_distance_hi"};

constexpr const char* kStageNames[] = {
    "surface",          "surface_bounds", "volume",        "volume_bounds", "surface_segment",
    "volume_segment",   "derived",        "volume_demand", "dither",        "shape",
    "shape_attributes", "shape_bounds",   "shape_segment",
};
constexpr const char* kUniformKindNames[] = {"value",  "texture2d", "material",    "texture3d",
                                             "object", "curve",     "curve_change"};
static_assert(std::size(kUniformKindNames) == OPENFAB_UNIFORM_CURVE_CHANGE + 1);
constexpr const char* kQueryResultNames[] = {"distance",  "position", "normal",
                                             "attribute", "end",      "end_on"};
constexpr const char* kVoxelCoordNames[] = {"voxel_coord", "voxel_coord_lo", "voxel_coord_hi",
                                            "voxel_index"};

void print_instr(const Instr& instr, size_t id, std::string* out) {
    auto to = std::back_inserter(*out);
    fmt::format_to(to, "    %{} = {}", id, instr_text(instr));
    for (ValueId arg : instr.args)
        fmt::format_to(to, " %{}", arg);
    *out += '\n';
}

void print_defaults(Type type, const std::vector<uint32_t>& bits, std::string* out) {
    if (bits.empty()) return;
    *out += " =";
    for (uint32_t value : bits)
        *out += ' ' + constant_text(type, value);
}

void print_varying(const char* role, const Varying& varying, std::string* out) {
    fmt::format_to(std::back_inserter(*out), "  {} {} {} {} {} source {}", role, varying.type_name,
                   varying.name, spelling(varying.type), varying.components, varying.source);
    print_defaults(varying.type, varying.default_bits, out);
    *out += '\n';
}

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (c == '\n') {
            out += "\\n";
            continue;
        }
        out += c;
    }
    return out + '"';
}

void print_uniform(const Uniform& uniform, std::string* out) {
    fmt::format_to(std::back_inserter(*out), "  uniform {} {} {} {} {} x {} at {}",
                   uniform.type_name, uniform.name, uniform_kind_name(uniform.kind),
                   spelling(uniform.type), uniform.components, uniform.array_length,
                   uniform.first_index);
    print_defaults(uniform.type, uniform.default_bits, out);
    *out += '\n';
    for (const auto& [name, text] : uniform.annotations) {
        fmt::format_to(std::back_inserter(*out), "  annotation {} {}\n", name, quoted(text));
    }
}

}  // namespace

const char* kind_name(int32_t kind) {
    if (kind >= 0 && kind <= OPENFAB_ARG_GROW_PLACE) return kKindNames[kind];
    if (kind >= abi::kShapeDistance && kind <= abi::kShapeDistanceHi)
        return kShapeDistanceNames[kind - abi::kShapeDistance];
    if (kind >= kVoxelCoord && kind <= kVoxelIndex) return kVoxelCoordNames[kind - kVoxelCoord];
    return nullptr;
}

const char* stage_name(StageKind kind) {
    return kStageNames[static_cast<size_t>(kind)];
}

const char* uniform_kind_name(openfab_uniform_kind kind) {
    return kUniformKindNames[static_cast<size_t>(kind)];
}

const char* query_result_name(int32_t kind) {
    return kQueryResultNames[static_cast<size_t>(kind)];
}

bool has_a(Op op) {
    return op == Op::kSample || op == Op::kSampleBound || op == Op::kLoopVar ||
           op == Op::kLoopResult || op == Op::kQuery || op == Op::kPrintf || op == Op::kNoise ||
           op == Op::kHash || op == Op::kDerivative || op == Op::kSimplex || op == Op::kCellular;
}

std::string constant_text(Type type, uint32_t bits) {
    switch (type) {
        case Type::kBool:
            return bits != 0 ? "true" : "false";
        case Type::kInt:
            return fmt::format("{}", static_cast<int32_t>(bits));
        case Type::kUint:
            return fmt::format("{}", bits);
        case Type::kFloat:
            break;
    }
    const float value = std::bit_cast<float>(bits);
    if (std::isnan(value)) return fmt::format("nan:{:#010x}", bits);
    return fmt::format("{}", value);
}

std::string instr_text(const Instr& instr) {
    std::string out;
    auto to = std::back_inserter(out);
    fmt::format_to(to, "{} {}", spelling(instr.op), spelling(instr.type));
    if (instr.op == Op::kConst) fmt::format_to(to, " {}", constant_text(instr.type, instr.bits));
    if (instr.op == Op::kInput) {
        fmt::format_to(to, " {} {} {}", kind_name(instr.kind), instr.a, instr.b);
    }
    if (has_a(instr.op)) fmt::format_to(to, " {}", instr.a);
    if (instr.op == Op::kSample || instr.op == Op::kSampleBound) fmt::format_to(to, " {}", instr.b);
    if (instr.op == Op::kQueryResult) {
        fmt::format_to(to, " {} {} {}", query_result_name(instr.kind), instr.a, instr.b);
    }
    if (instr.op == Op::kSampleBound) fmt::format_to(to, " {}", instr.bits);
    if (instr.op == Op::kTable) fmt::format_to(to, " {} {} {}", instr.a, instr.b, instr.bits);
    return out;
}

std::string dump(const Stage& stage) {
    std::string out = fmt::format("  stage {}\n", stage_name(stage.kind));
    for (size_t id = 0; id < stage.instrs.size(); ++id)
        print_instr(stage.instrs[id], id, &out);
    for (const Printf& p : stage.printfs) {
        fmt::format_to(std::back_inserter(out), "    {} {} {} {} {}\n",
                       p.is_assert ? "assert" : "printf", quoted(p.format), quoted(p.source),
                       p.line, p.column);
    }
    for (const Output& output : stage.outputs) {
        fmt::format_to(std::back_inserter(out), "    output {} {} {} {} %{}\n", output.name,
                       kind_name(output.kind), output.a, output.b, output.value);
    }
    return out;
}

std::string dump(const Fablet& fablet) {
    std::string out = fmt::format("fablet {}\n", fablet.name);
    fmt::format_to(std::back_inserter(out),
                   "  counts values {} textures {} objects {} slots {} void {}\n",
                   fablet.uniform_value_count, fablet.texture_count, fablet.object_count,
                   fablet.slot_count, fablet.void_slot);
    for (const Uniform& uniform : fablet.uniforms)
        print_uniform(uniform, &out);
    for (const Varying& varying : fablet.shape_outputs)
        print_varying("shape_out", varying, &out);
    for (const Varying& varying : fablet.surface_inputs)
        print_varying("in", varying, &out);
    for (const Varying& varying : fablet.surface_outputs)
        print_varying("out", varying, &out);
    for (const Varying& varying : fablet.nearest)
        print_varying("nearest", varying, &out);
    if (fablet.has_shape) {
        if (fablet.shape_is_distance) out += "  shape is a distance\n";
        if (grows(fablet)) out += "  grows\n";
        out += dump(fablet.shape);
    }
    if (fablet.has_surface) out += dump(fablet.surface);
    out += dump(fablet.volume);
    if (fablet.has_dither) out += dump(fablet.dither);
    return out;
}

}  // namespace openfab::ir
