// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/expression_translator.h"

#include <utility>

namespace openfab::translate {

using ir::ValueId;

constexpr int32_t kFaces = 5;  // of a mixture: abi::BlueNoiseFace

Value ExpressionTranslator::expression(const check::Expr& expr) {
    if (budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    switch (expr.kind) {
        case check::ExprKind::kError:
            return layout_.zero(expr.type);
        case check::ExprKind::kConstant:
            return {emit_.constant(check::component_type(expr.type), expr.bits)};
        case check::ExprKind::kVariable:
            return variable(expr);
        case check::ExprKind::kAttribute:
            return inputs_.attribute(expr);
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
            const Target at = targets_.target(expr);
            return targets_.read(at, expr);
        }
        case check::ExprKind::kConstruct: {
            if (expr.args.empty()) return layout_.zero(expr.type);
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
            return built_ins_.intrinsic(expr);
        case check::ExprKind::kMatrix:
            return built_ins_.matrix(expr);
        case check::ExprKind::kCall:
            return calls_.inline_call(expr);
        case check::ExprKind::kGradient:
        case check::ExprKind::kMeanCurvature:
            return fields_.field(expr);
        case check::ExprKind::kSample:
            return queries_.sample(expr);
        case check::ExprKind::kCurve:
            return built_ins_.curve(expr);
        case check::ExprKind::kFraction:
            return queries_.numbered(expr, OPENFAB_ARG_FRACTION, place_.fablet.ir.slot_count + 1);
        case check::ExprKind::kBlueNoise:
            return queries_.numbered(expr, OPENFAB_ARG_BLUE_NOISE, kFaces);
        case check::ExprKind::kDistance:
            return queries_.distance(expr);
        case check::ExprKind::kNearestPoint:
            return queries_.nearest_point(expr);
        case check::ExprKind::kDistanceTo:
            return queries_.distance_to(expr);
        case check::ExprKind::kWalkEnd:
            return queries_.walk_end(expr);
        case check::ExprKind::kSet:
        case check::ExprKind::kAdd:
        case check::ExprKind::kGet:
        case check::ExprKind::kClear:
        case check::ExprKind::kTotal:
            return mixtures_.composition(expr);
        case check::ExprKind::kOver:
            return mixtures_.over(expr);
        case check::ExprKind::kPrintf:
            return printing_.call(expr);
    }
    return layout_.zero(expr.type);
}

Value ExpressionTranslator::variable(const check::Expr& expr) {
    const check::Symbol& symbol = *expr.symbol;
    switch (symbol.kind) {
        case check::SymbolKind::kUniform: {
            const ir::Uniform& u = place_.fablet.ir.uniforms[symbol.index];
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
            return constants_.value(symbol);
        case check::SymbolKind::kVoid:
            return {
                emit_.constant(ir::Type::kInt, static_cast<uint32_t>(place_.fablet.ir.void_slot))};
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
    return targets_.read(targets_.target(expr), expr);
}

Value ExpressionTranslator::convert(const Value& from, const check::Type& from_type,
                                    const check::Type& to) {
    Value out;
    const std::vector<ir::Type> types = layout_.components(to);
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

Value ExpressionTranslator::logical(const check::Expr& expr) {
    const bool is_and = expr.kind == check::ExprKind::kAndThen;
    const ValueId left = scalar(*expr.args[0]);
    if (is_and ? emit_.is_false(left) : emit_.is_true(left)) return {left};
    ValueId right = 0;
    const auto run_right = [&] { right = scalar(*expr.args[1]); };
    paths_.branch(is_and ? left : emit_.logical_not(left), run_right, [] {});
    emit_.set_span(expr.span);
    return {is_and ? emit_.logical_and(left, right) : emit_.logical_or(left, right)};
}

Value ExpressionTranslator::conditional(const check::Expr& expr) {
    const ValueId test = scalar(*expr.args[0]);
    Value yes;
    Value no;
    paths_.branch(
        test, [&] { yes = expression(*expr.args[1]); }, [&] { no = expression(*expr.args[2]); });
    if (yes.empty()) return no;
    if (no.empty()) return yes;
    emit_.set_span(expr.span);
    Value out;
    for (size_t i = 0; i < yes.size(); ++i)
        out.push_back(emit_.select(test, yes[i], no[i]));
    return out;
}

Value ExpressionTranslator::assign(const check::Expr& expr) {
    const check::Type& type = expr.args[0]->type;
    Value value = expression(*expr.args[1]);
    const Target to = targets_.target(*expr.args[0]);
    if (expr.compound) {
        Value old = targets_.read(to, *expr.args[0]);
        emit_.set_span(expr.span);
        const bool number = type.is_arithmetic();
        if (number) old = convert(old, type, expr.operand_type);
        value = formulas_.binary(expr.op, old, value);
        if (number) value = convert(value, expr.operand_type, type);
    }
    targets_.store(to, value);
    return value;
}

Value ExpressionTranslator::increment(const check::Expr& expr) {
    const Target to = targets_.target(*expr.args[0]);
    const Value old = targets_.read(to, *expr.args[0]);
    emit_.set_span(expr.span);
    const ir::Type type = check::component_type(expr.type);
    const ValueId one = emit_.convert(emit_.constant(ir::Type::kInt, 1), type);
    const Value value = formulas_.binary(expr.op, old, {one});
    targets_.store(to, value);
    return expr.postfix ? old : value;
}

}  // namespace openfab::translate
