// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <numeric>
#include <utility>

#include "compiler/ir/arithmetic.h"
#include "compiler/sema/translate_state.h"

namespace openfab::sema {

using ir::Op;
using ir::ValueId;

size_t StageTranslator::component_count(const Type& type) const {
    if (type.base == Base::kComposition) return static_cast<size_t>(fablet_.ir.slot_count);
    if (type.base == Base::kVoid || type.is_error()) return 0;
    return static_cast<size_t>(type.size);
}

Value StageTranslator::zero(const Type& type) {
    return Value(component_count(type), emit_.constant(component_type(type), 0));
}

StageTranslator::VariableId StageTranslator::variable_of(const Symbol& symbol) const {
    return frame_.variables.at(&symbol);
}

Value StageTranslator::expression(const Expr& expr) {
    if (gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    switch (expr.kind) {
        case ExprKind::kError:
            return zero(expr.type);
        case ExprKind::kConstant:
            return {emit_.constant(component_type(expr.type), expr.bits)};
        case ExprKind::kVariable:
            return variable(expr);
        case ExprKind::kAttribute:
            return attribute(expr);
        case ExprKind::kConvert:
            return convert(expression(*expr.args[0]), expr.args[0]->type, expr.type);
        case ExprKind::kUnary: {
            Value value = expression(*expr.args[0]);
            emit_.set_span(expr.span);
            for (ValueId& v : value)
                v = emit_.unary(expr.op, v);
            return value;
        }
        case ExprKind::kBinary: {
            const Value a = expression(*expr.args[0]);
            const Value b = expression(*expr.args[1]);
            emit_.set_span(expr.span);
            return binary_values(expr.op, a, b);
        }
        case ExprKind::kAndThen:
        case ExprKind::kOrElse:
            return logical(expr);
        case ExprKind::kConditional:
            return conditional(expr);
        case ExprKind::kSwizzle:
        case ExprKind::kIndex: {
            std::vector<size_t> lanes;
            const Symbol* symbol = lanes_of(expr, &lanes);
            if (symbol != nullptr) return read(*symbol, lanes, expr.span);
            if (lanes.empty()) return zero(expr.type);
            const Value vector = expression(*expr.args[0]);
            lanes.clear();
            if (expr.kind == ExprKind::kSwizzle) {
                lanes.assign(expr.lanes.begin(), expr.lanes.begin() + expr.type.size);
            } else {
                size_t index = 0;
                if (!constant_index(*expr.args[1], expr.args[0]->type.size, &index))
                    return zero(expr.type);
                lanes.push_back(index);
            }
            Value out;
            for (size_t lane : lanes)
                out.push_back(vector[lane]);
            return out;
        }
        case ExprKind::kConstruct: {
            Value out;
            for (const ExprPtr& arg : expr.args) {
                const Value part = expression(*arg);
                out.insert(out.end(), part.begin(), part.end());
            }
            return out;
        }
        case ExprKind::kAssign:
            return assign(expr);
        case ExprKind::kIncrement:
            return increment(expr);
        case ExprKind::kComma:
            expression(*expr.args[0]);
            return expression(*expr.args[1]);
        case ExprKind::kIntrinsic:
            return intrinsic(expr);
        case ExprKind::kCall:
            return inline_call(expr);
        case ExprKind::kSample:
            return sample(expr);
        case ExprKind::kDistance:
            return distance(expr);
        case ExprKind::kSet:
        case ExprKind::kAdd:
        case ExprKind::kGet:
        case ExprKind::kClear:
        case ExprKind::kTotal:
            return composition(expr);
    }
    return zero(expr.type);
}

Value StageTranslator::read(const Symbol& symbol, const std::vector<size_t>& lanes,
                            const source::Span& span) {
    const Variable& v = variables_[variable_of(symbol)];
    Value out;
    bool never = false;
    bool maybe = false;
    for (size_t lane : lanes) {
        out.push_back(v.value[lane]);
        if (v.assigned.empty() || emit_.is_true(v.assigned[lane])) continue;
        if (emit_.is_false(v.assigned[lane])) {
            never = true;
        } else if (!holds(v.assigned[lane])) {
            maybe = true;
        }
    }
    if (never) {
        sink_->report(span, diag::kUninitialized, symbol.name)
            .note(symbol.span, fmt::format("`{}` is declared here", symbol.name));
    } else if (maybe) {
        sink_->report(span, diag::kMaybeUninitialized, symbol.name)
            .note(symbol.span, fmt::format("`{}` is declared here", symbol.name))
            .help("give it a value where it is declared");
    }
    return out;
}

Value StageTranslator::variable(const Expr& expr) {
    const Symbol& symbol = *expr.symbol;
    switch (symbol.kind) {
        case SymbolKind::kUniform: {
            const ir::Uniform& u = fablet_.ir.uniforms[static_cast<size_t>(symbol.index)];
            if (u.kind != OPENFAB_UNIFORM_VALUE) {
                return {emit_.constant(ir::Type::kInt, static_cast<uint32_t>(u.first_index))};
            }
            Value out;
            for (int32_t i = 0; i < u.components; ++i) {
                out.push_back(emit_.input(u.type, OPENFAB_ARG_UNIFORM, u.first_index + i, 0));
            }
            return out;
        }
        case SymbolKind::kConstant:
            return expression(*symbol.init);
        case SymbolKind::kVoid:
            return {emit_.constant(ir::Type::kInt, static_cast<uint32_t>(fablet_.ir.void_slot))};
        case SymbolKind::kAttributes:
            return {};
        default:
            break;
    }
    std::vector<size_t> lanes(component_count(symbol.type));
    std::iota(lanes.begin(), lanes.end(), size_t{0});
    return read(symbol, lanes, expr.span);
}

// --- attributes

Value StageTranslator::frame_vector(int32_t first) {
    Value out;
    for (int32_t i = 0; i < 3; ++i) {
        out.push_back(emit_.input(ir::Type::kFloat, OPENFAB_ARG_FRAME, first + i, 0));
    }
    return out;
}

/// In the order of operations that runtime/abi/fablet_table.h states.
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

Value StageTranslator::attribute(const Expr& expr) {
    const auto surface = [&](openfab_surface_attr which, int32_t components) {
        Value out;
        for (int32_t i = 0; i < components; ++i) {
            out.push_back(emit_.input(ir::Type::kFloat, OPENFAB_ARG_SURFACE_ATTR, which, i));
        }
        return out;
    };
    switch (expr.attribute) {
        case Attribute::kP:
            return binary_values(Op::kAdd, surface(OPENFAB_SURFACE_P, 3),
                                 frame_vector(OPENFAB_FRAME_CENTER));
        case Attribute::kN:
            return surface(OPENFAB_SURFACE_N, 3);
        case Attribute::kNg:
            return surface(OPENFAB_SURFACE_NG, 3);
        case Attribute::kUv:
            return surface(OPENFAB_SURFACE_UV, 2);
        case Attribute::kDpdu:
            return surface(OPENFAB_SURFACE_DPDU, 3);
        case Attribute::kDpdv:
            return surface(OPENFAB_SURFACE_DPDV, 3);
        case Attribute::kInstance:
            return {emit_.input(ir::Type::kInt, OPENFAB_ARG_INSTANCE, 0, 0)};
        case Attribute::kVoxelCenter:
            return voxel_center();
        case Attribute::kVoxelSize:
            return frame_vector(OPENFAB_FRAME_VOXEL_SIZE);
        case Attribute::kBuildPosition: {
            Value at;
            for (int32_t axis = 0; axis < 3; ++axis) {
                at.push_back(emit_.input(ir::Type::kFloat, ir::kVoxelCoord, axis, 0));
            }
            return binary_values(
                Op::kAdd, frame_vector(OPENFAB_FRAME_BUILD_ORIGIN),
                binary_values(Op::kMul, at, frame_vector(OPENFAB_FRAME_VOXEL_SIZE)));
        }
    }
    return zero(expr.type);
}

// --- operators

Value StageTranslator::convert(const Value& from, const Type& from_type, const Type& to) {
    Value out;
    for (size_t i = 0; i < static_cast<size_t>(to.size); ++i) {
        out.push_back(emit_.convert(from[from_type.size == 1 ? 0 : i], component_type(to)));
    }
    return out;
}

/// Component by component; a `b` of one component goes with each of `a`.
Value StageTranslator::binary_values(Op op, const Value& a, const Value& b) {
    Value out;
    for (size_t i = 0; i < a.size(); ++i) {
        const ValueId right = b[b.size() == 1 ? 0 : i];
        out.push_back(emit_.binary(op, a[i], right));
    }
    return out;
}

Value StageTranslator::logical(const Expr& expr) {
    const bool is_and = expr.kind == ExprKind::kAndThen;
    const ValueId left = scalar(*expr.args[0]);
    if (is_and ? emit_.is_false(left) : emit_.is_true(left)) return {left};
    ValueId right = 0;
    const auto run_right = [&] { right = scalar(*expr.args[1]); };
    branch(is_and ? left : emit_.logical_not(left), run_right, [] {});
    emit_.set_span(expr.span);
    return {is_and ? emit_.logical_and(left, right) : emit_.logical_or(left, right)};
}

Value StageTranslator::conditional(const Expr& expr) {
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

bool StageTranslator::constant_index(const Expr& expr, int size, size_t* index) {
    const ValueId value = scalar(expr);
    if (!emit_.is_constant(value)) {
        sink_->report(expr.span, diag::kUnsupported, "an index that is no constant is");
        return false;
    }
    const int32_t at = ir::as_int(emit_.instr(value).bits);
    if (at < 0 || at >= size) {
        sink_->report(expr.span, diag::kOutOfRange, "index", at, 0, size - 1);
        return false;
    }
    *index = static_cast<size_t>(at);
    return true;
}

/// The variable that a chain of swizzles and indices is about, with its components. Null where it
/// is about another value (lanes not empty) or an index is wrong (lanes empty).
const Symbol* StageTranslator::lanes_of(const Expr& target, std::vector<size_t>* lanes) {
    if (target.kind == ExprKind::kVariable) {
        lanes->resize(component_count(target.type));
        std::iota(lanes->begin(), lanes->end(), size_t{0});
        return frame_.variables.count(target.symbol) != 0 ? target.symbol : nullptr;
    }
    if (target.kind != ExprKind::kSwizzle && target.kind != ExprKind::kIndex) {
        lanes->assign(1, 0);
        return nullptr;
    }
    std::vector<size_t> inner;
    const Symbol* symbol = lanes_of(*target.args[0], &inner);
    lanes->clear();
    if (symbol == nullptr) {
        *lanes = inner;
        return nullptr;
    }
    if (target.kind == ExprKind::kSwizzle) {
        for (int i = 0; i < target.type.size; ++i)
            lanes->push_back(inner[target.lanes[i]]);
        return symbol;
    }
    size_t index = 0;
    if (!constant_index(*target.args[1], target.args[0]->type.size, &index)) return nullptr;
    lanes->push_back(inner[index]);
    return symbol;
}

void StageTranslator::store(const Target& target, const Value& value) {
    if (target.symbol == nullptr) return;
    const VariableId id = variable_of(*target.symbol);
    Variable v = variables_[id];
    for (size_t i = 0; i < target.lanes.size(); ++i) {
        v.value[target.lanes[i]] = value[i];
        if (!v.assigned.empty()) v.assigned[target.lanes[i]] = emit_.boolean(true);
    }
    set(id, std::move(v));
}

/// Once for each time that the program names it: an index may have side effects.
StageTranslator::Target StageTranslator::target(const Expr& expr) {
    Target out;
    out.symbol = lanes_of(expr, &out.lanes);
    return out;
}

Value StageTranslator::read(const Target& target, const Expr& expr) {
    return target.symbol == nullptr ? zero(expr.type)
                                    : read(*target.symbol, target.lanes, expr.span);
}

Value StageTranslator::assign(const Expr& expr) {
    const Type& type = expr.args[0]->type;
    Value value = expression(*expr.args[1]);
    const Target to = target(*expr.args[0]);
    if (expr.compound) {
        Value old = read(to, *expr.args[0]);
        emit_.set_span(expr.span);
        if (type.is_numeric()) old = convert(old, type, expr.operand_type);
        value = binary_values(expr.op, old, value);
        if (type.is_numeric()) value = convert(value, expr.operand_type, type);
    }
    store(to, value);
    return value;
}

Value StageTranslator::increment(const Expr& expr) {
    const Target to = target(*expr.args[0]);
    const Value old = read(to, *expr.args[0]);
    emit_.set_span(expr.span);
    const ir::Type type = component_type(expr.type);
    const ValueId one = emit_.convert(emit_.constant(ir::Type::kInt, 1), type);
    const Value value = binary_values(expr.op, old, {one});
    store(to, value);
    return expr.postfix ? old : value;
}

}  // namespace openfab::sema
