// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <utility>

#include "abi/grow_table.h"
#include "compiler/ir/arithmetic.h"
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

constexpr int32_t kFaces = 5;  // of a mixture: abi::BlueNoiseFace

/// Appends the IR type of each component of a value.
void StageTranslator::add_components(const check::Type& type, std::vector<ir::Type>* out) const {
    if (type.is_array()) {
        const check::Type element = type.element();
        for (int i = 0; i < type.length(); ++i)
            add_components(element, out);
        return;
    }
    switch (type.base) {
        case check::Base::kError:
        case check::Base::kVoid:
        case check::Base::kSurfaceAttributes:  // one per stage, without storage
        case check::Base::kVolumeAttributes:
        case check::Base::kDitherAttributes:
        case check::Base::kShapeAttributes:
        case check::Base::kGrowAttributes:
            return;
        case check::Base::kStruct:
            for (const check::StructMember& member : type.record->members)
                add_components(member.type, out);
            return;
        case check::Base::kSurfacePoint:
            for (const check::StructMember& member : fablet_.point_members)
                add_components(member.type, out);
            return;
        case check::Base::kComposition:
            out->insert(out->end(), static_cast<size_t>(fablet_.ir.slot_count), ir::Type::kFloat);
            return;
        case check::Base::kBool:
        case check::Base::kInt:
        case check::Base::kUint:
        case check::Base::kFloat:
        case check::Base::kTexture2D:
        case check::Base::kTexture3D:
        case check::Base::kMaterial:
        case check::Base::kObject:
        case check::Base::kSpline:
        case check::Base::kColorRamp:
            out->insert(out->end(), static_cast<size_t>(check::min_components(type)),
                        check::component_type(type));
    }
}

std::vector<ir::Type> StageTranslator::components(const check::Type& type) const {
    std::vector<ir::Type> out;
    add_components(type, &out);
    return out;
}

size_t StageTranslator::component_count(const check::Type& type) const {
    if (type.is_arithmetic()) return static_cast<size_t>(check::min_components(type));
    return components(type).size();
}

Value StageTranslator::zero(const check::Type& type) {
    Value out;
    for (ir::Type component : components(type))
        out.push_back(emit_.constant(component, 0));
    return out;
}

/// For a variable without an initializer: it starts at zero, which arrays and compositions may be
/// meant to do; of others it is likely a mistake to use that.
Value StageTranslator::unassigned(const check::Type& type) {
    const bool starts = type.is_array() || type.base == check::Base::kComposition;
    if (type.is(check::Base::kStruct) && !starts) {
        Value out;
        for (const check::StructMember& member : type.record->members) {
            const Value part = unassigned(member.type);
            out.insert(out.end(), part.begin(), part.end());
        }
        return out;
    }
    return Value(component_count(type), emit_.constant(starts));
}

StageTranslator::VariableId StageTranslator::variable_of(const check::Symbol& symbol) const {
    return frame_.variables.at(&symbol);
}

Value StageTranslator::expression(const check::Expr& expr) {
    if (gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    switch (expr.kind) {
        case check::ExprKind::kError:
            return zero(expr.type);
        case check::ExprKind::kConstant:
            return {emit_.constant(check::component_type(expr.type), expr.bits)};
        case check::ExprKind::kVariable:
            return variable(expr);
        case check::ExprKind::kAttribute:
            return attribute(expr);
        case check::ExprKind::kConvert:
            return convert(expression(*expr.args[0]), expr.args[0]->type, expr.type);
        case check::ExprKind::kUnary: {
            Value value = expression(*expr.args[0]);
            emit_.set_span(expr.span);
            for (ValueId& v : value)
                v = emit_.unary(expr.op, v);
            return value;
        }
        case check::ExprKind::kBinary: {
            const Value a = expression(*expr.args[0]);
            const Value b = expression(*expr.args[1]);
            emit_.set_span(expr.span);
            return formulas_.binary(expr.op, a, b);
        }
        case check::ExprKind::kAndThen:
        case check::ExprKind::kOrElse:
            return logical(expr);
        case check::ExprKind::kConditional:
            return conditional(expr);
        case check::ExprKind::kSwizzle:
        case check::ExprKind::kMember:
        case check::ExprKind::kIndex: {
            const Target at = target(expr);
            return read(at, expr);
        }
        case check::ExprKind::kConstruct: {
            if (expr.args.empty()) return zero(expr.type);
            Value out;
            for (const check::ExprPtr& arg : expr.args) {
                const Value part = expression(*arg);
                out.insert(out.end(), part.begin(), part.end());
            }
            return out;
        }
        case check::ExprKind::kAssign:
            return assign(expr);
        case check::ExprKind::kIncrement:
            return increment(expr);
        case check::ExprKind::kComma:
            expression(*expr.args[0]);
            return expression(*expr.args[1]);
        case check::ExprKind::kIntrinsic:
            return intrinsic(expr);
        case check::ExprKind::kMatrix:
            return matrix(expr);
        case check::ExprKind::kCall:
            return inline_call(expr);
        case check::ExprKind::kGradient:
        case check::ExprKind::kMeanCurvature:
            return field(expr);
        case check::ExprKind::kSample:
            return sample(expr);
        case check::ExprKind::kCurve:
            return curve(expr);
        case check::ExprKind::kFraction:
            return numbered(expr, OPENFAB_ARG_FRACTION, fablet_.ir.slot_count + 1);
        case check::ExprKind::kBlueNoise:
            return numbered(expr, OPENFAB_ARG_BLUE_NOISE, kFaces);
        case check::ExprKind::kDistance:
            return distance(expr);
        case check::ExprKind::kNearestPoint:
            return nearest_point(expr);
        case check::ExprKind::kDistanceTo:
            return distance_to(expr);
        case check::ExprKind::kSet:
        case check::ExprKind::kAdd:
        case check::ExprKind::kGet:
        case check::ExprKind::kClear:
        case check::ExprKind::kTotal:
            return composition(expr);
        case check::ExprKind::kOver:
            return over(expr);
        case check::ExprKind::kPrintf:
            return printf_call(expr);
    }
    return zero(expr.type);
}

Value StageTranslator::variable(const check::Expr& expr) {
    const check::Symbol& symbol = *expr.symbol;
    switch (symbol.kind) {
        case check::SymbolKind::kUniform: {
            const ir::Uniform& u = fablet_.ir.uniforms[symbol.index];
            Value out;
            if (u.kind != OPENFAB_UNIFORM_VALUE && u.kind != OPENFAB_UNIFORM_CURVE) {
                for (int32_t i = 0; i < u.array_length; ++i) {
                    out.push_back(
                        emit_.constant(ir::Type::kInt, static_cast<uint32_t>(u.first_index + i)));
                }
                return out;
            }
            for (int32_t i = 0; i < u.components * u.array_length; ++i) {
                out.push_back(emit_.input(u.type, OPENFAB_ARG_UNIFORM, u.first_index + i, 0));
            }
            return out;
        }
        case check::SymbolKind::kConstant:
            return constant(symbol);
        case check::SymbolKind::kVoid:
            return {emit_.constant(ir::Type::kInt, static_cast<uint32_t>(fablet_.ir.void_slot))};
        case check::SymbolKind::kAttributes:
        case check::SymbolKind::kType:
            return {};
        case check::SymbolKind::kLocal:
        case check::SymbolKind::kParameter:
        case check::SymbolKind::kSurfaceInput:
        case check::SymbolKind::kSurfaceOutput:
        case check::SymbolKind::kShapeOutput:
        case check::SymbolKind::kGrowParent:
        case check::SymbolKind::kNearest:
            break;
    }
    return read(target(expr), expr);
}

/// Evaluates outside the limits of a loop that is being unrolled around it.
Value StageTranslator::constant_expression(const check::Expr& expr) {
    const size_t before = steps_;
    const size_t outer = std::exchange(step_limit_, check::kMaxSteps);
    const size_t unroll = std::exchange(unroll_limit_, check::kMaxUnrolledStepsOfConstant);
    Value out = expression(expr);
    unroll_limit_ = unroll;
    step_limit_ = std::min(outer + steps_ - before, check::kMaxSteps);
    return out;
}

/// A table is computed once; constant results are cached.
Value StageTranslator::constant(const check::Symbol& symbol) {
    const std::vector<ir::Type> types = components(symbol.type);
    const auto known = constants_.find(&symbol);
    if (known != constants_.end()) {
        Value out;
        for (size_t i = 0; i < types.size(); ++i)
            out.push_back(emit_.constant(types[i], known->second[i]));
        return out;
    }
    Value out = constant_expression(*symbol.init);
    std::vector<uint32_t> bits;
    for (ValueId value : out) {
        if (!emit_.is_constant(value)) return out;
        bits.push_back(emit_.instr(value).bits);
    }
    constants_.emplace(&symbol, std::move(bits));
    return out;
}

// --- attributes

Value StageTranslator::frame_vector(int32_t first) {
    Value out;
    for (int32_t i = 0; i < 3; ++i) {
        out.push_back(emit_.input(ir::Type::kFloat, OPENFAB_ARG_FRAME, first + i, 0));
    }
    return out;
}

/// In the order of operations of abi/fablet_table.h.
Value StageTranslator::voxel_center() {
    const Value center = frame_vector(OPENFAB_FRAME_CENTER);
    const Value origin = frame_vector(OPENFAB_FRAME_ORIGIN);
    const Value step_i = frame_vector(OPENFAB_FRAME_STEP_I);
    const Value step_j = frame_vector(OPENFAB_FRAME_STEP_J);
    const Value step_k = frame_vector(OPENFAB_FRAME_STEP_K);
    Value at;
    for (int32_t axis = 0; axis < 3; ++axis) {
        at.push_back(emit_.input(ir::Type::kFloat, ir::kVoxelCoord, axis, 0));
    }
    Value out;
    for (size_t c = 0; c < 3; ++c) {
        ValueId sum = emit_.binary(Op::kAdd, emit_.binary(Op::kMul, at[0], step_i[c]),
                                   emit_.binary(Op::kMul, at[1], step_j[c]));
        sum = emit_.binary(Op::kAdd, sum, emit_.binary(Op::kMul, at[2], step_k[c]));
        sum = emit_.binary(Op::kAdd, sum, origin[c]);
        out.push_back(emit_.binary(Op::kAdd, sum, center[c]));
    }
    return out;
}

Value StageTranslator::shape_point() {
    Value point;
    for (int32_t axis = 0; axis < 3; ++axis)
        point.push_back(emit_.input(ir::Type::kFloat, OPENFAB_ARG_SHAPE_POINT, axis, 0));
    return formulas_.binary(Op::kAdd, point, frame_vector(OPENFAB_FRAME_CENTER));
}

Value StageTranslator::attribute(const check::Expr& expr) {
    const auto surface = [&](openfab_surface_attr which, int32_t components) {
        Value out;
        for (int32_t i = 0; i < components; ++i) {
            out.push_back(emit_.input(ir::Type::kFloat, OPENFAB_ARG_SURFACE_ATTR, which, i));
        }
        return out;
    };
    switch (expr.attribute) {
        case check::Attribute::kP:
            if (kind_ == ir::StageKind::kShape) return shape_point();
            return formulas_.binary(Op::kAdd, surface(OPENFAB_SURFACE_P, 3),
                                    frame_vector(OPENFAB_FRAME_CENTER));
        case check::Attribute::kN:
            return surface(OPENFAB_SURFACE_N, 3);
        case check::Attribute::kNg:
            return surface(OPENFAB_SURFACE_NG, 3);
        case check::Attribute::kUv:
            return surface(OPENFAB_SURFACE_UV, 2);
        case check::Attribute::kDpdu:
            return surface(OPENFAB_SURFACE_DPDU, 3);
        case check::Attribute::kDpdv:
            return surface(OPENFAB_SURFACE_DPDV, 3);
        case check::Attribute::kInstance:
            return {emit_.input(ir::Type::kInt, OPENFAB_ARG_INSTANCE, 0, 0)};
        case check::Attribute::kVoxelCenter:
            return voxel_center();
        case check::Attribute::kVoxelSize:
            return frame_vector(OPENFAB_FRAME_VOXEL_SIZE);
        case check::Attribute::kBuildPosition: {
            Value at;
            for (int32_t axis = 0; axis < 3; ++axis) {
                at.push_back(emit_.input(ir::Type::kFloat, ir::kVoxelCoord, axis, 0));
            }
            return formulas_.binary(
                Op::kAdd, frame_vector(OPENFAB_FRAME_BUILD_ORIGIN),
                formulas_.binary(Op::kMul, at, frame_vector(OPENFAB_FRAME_VOXEL_SIZE)));
        }
        case check::Attribute::kVoxel: {
            Value index;
            for (int32_t axis = 0; axis < 3; ++axis)
                index.push_back(emit_.input(ir::Type::kInt, ir::kVoxelIndex, axis, 0));
            return index;
        }
        case check::Attribute::kSeed:
            return {emit_.input(ir::Type::kUint, OPENFAB_ARG_GRID, OPENFAB_GRID_SEED, 0)};
        case check::Attribute::kCount:
            return {emit_.constant(fablet_.ir.slot_count + 1)};
        case check::Attribute::kChild:
            return {emit_.input(ir::Type::kInt, OPENFAB_ARG_GROW_PLACE, OPENFAB_GROW_CHILD, 0)};
        case check::Attribute::kLevel:
            return {emit_.input(ir::Type::kInt, OPENFAB_ARG_GROW_PLACE, OPENFAB_GROW_LEVEL, 0)};
        case check::Attribute::kPath:
            return {emit_.input(ir::Type::kUint, OPENFAB_ARG_GROW_PLACE, OPENFAB_GROW_PATH, 0)};
    }
    return zero(expr.type);
}

// --- operators

Value StageTranslator::convert(const Value& from, const check::Type& from_type,
                               const check::Type& to) {
    Value out;
    const std::vector<ir::Type> types = components(to);
    for (size_t i = 0; i < types.size(); ++i) {
        size_t source = from_type.is_scalar() ? 0 : i;
        if (from_type.is_matrix() && to.is_matrix()) {
            const auto columns = static_cast<size_t>(to.size);
            source = i / columns * static_cast<size_t>(from_type.size) + i % columns;
        }
        out.push_back(emit_.convert(from[source], types[i]));
    }
    return out;
}

Value StageTranslator::logical(const check::Expr& expr) {
    const bool is_and = expr.kind == check::ExprKind::kAndThen;
    const ValueId left = scalar(*expr.args[0]);
    if (is_and ? emit_.is_false(left) : emit_.is_true(left)) return {left};
    ValueId right = 0;
    const auto run_right = [&] { right = scalar(*expr.args[1]); };
    branch(is_and ? left : emit_.logical_not(left), run_right, [] {});
    emit_.set_span(expr.span);
    return {is_and ? emit_.logical_and(left, right) : emit_.logical_or(left, right)};
}

Value StageTranslator::conditional(const check::Expr& expr) {
    const ValueId test = scalar(*expr.args[0]);
    Value yes;
    Value no;
    branch(
        test, [&] { yes = expression(*expr.args[1]); }, [&] { no = expression(*expr.args[2]); });
    if (yes.empty()) return no;
    if (no.empty()) return yes;
    emit_.set_span(expr.span);
    Value out;
    for (size_t i = 0; i < yes.size(); ++i)
        out.push_back(emit_.select(test, yes[i], no[i]));
    return out;
}

// --- assignment

Value StageTranslator::assign(const check::Expr& expr) {
    const check::Type& type = expr.args[0]->type;
    Value value = expression(*expr.args[1]);
    const Target to = target(*expr.args[0]);
    if (expr.compound) {
        Value old = read(to, *expr.args[0]);
        emit_.set_span(expr.span);
        const bool number = type.is_arithmetic();
        if (number) old = convert(old, type, expr.operand_type);
        value = formulas_.binary(expr.op, old, value);
        if (number) value = convert(value, expr.operand_type, type);
    }
    store(to, value);
    return value;
}

Value StageTranslator::increment(const check::Expr& expr) {
    const Target to = target(*expr.args[0]);
    const Value old = read(to, *expr.args[0]);
    emit_.set_span(expr.span);
    const ir::Type type = check::component_type(expr.type);
    const ValueId one = emit_.convert(emit_.constant(ir::Type::kInt, 1), type);
    const Value value = formulas_.binary(expr.op, old, {one});
    store(to, value);
    return expr.postfix ? old : value;
}

}  // namespace openfab::translate
