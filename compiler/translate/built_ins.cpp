// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/built_ins.h"

#include <algorithm>
#include <array>

#include "abi/curve_table.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

bool is_function_intrinsic(check::Intrinsic id) {
    const check::Family of = check::family(id);
    return of != check::Family::kComponent && of != check::Family::kGeometric &&
           of != check::Family::kChoice;
}

}  // namespace

Value BuiltIns::intrinsic(const check::Expr& expr) {
    if (is_function_intrinsic(expr.intrinsic)) return function(expr);
    std::vector<Value> args;
    for (const check::ExprPtr& arg : expr.args)
        args.push_back(expressions_.expression(*arg));
    emit_.set_span(expr.span);
    if (Formulas::is_geometric(expr.intrinsic)) return formulas_.geometric(expr.intrinsic, args);
    // A scalar goes with each component of the others: the `t` of a lerp of compositions, the condition of a select.
    size_t count = 0;
    for (const Value& arg : args)
        count = std::max(count, arg.size());
    Value out;
    for (size_t i = 0; i < count; ++i) {
        std::vector<ValueId> component;
        for (const Value& arg : args)
            component.push_back(arg[arg.size() == 1 ? 0 : i]);
        out.push_back(formulas_.component(expr.intrinsic, component));
    }
    return out;
}

Value BuiltIns::function(const check::Expr& expr) {
    const check::Family family = check::family(expr.intrinsic);
    if (family == check::Family::kSeveral) return several_results(expr);
    std::vector<Value> args;
    for (const check::ExprPtr& arg : expr.args)
        args.push_back(expressions_.expression(*arg));
    if (budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    if (family == check::Family::kDerivative) return derivatives(expr, args[0]);
    if (family == check::Family::kBending) return formulas_.geometric(expr.intrinsic, args);
    if (Formulas::is_elementary(expr.intrinsic)) {
        Value out;
        for (size_t i = 0; i < args[0].size(); ++i) {
            const Value& second = args.back();
            const ValueId y = second[second.size() == 1 ? 0 : i];
            out.push_back(formulas_.elementary(expr.intrinsic, args[0][i], y));
        }
        return out;
    }
    return formulas_.field(expr.intrinsic, expr.type.size, args);
}

/// sincos(x, s, c); modf(x, whole) returns the fraction; frexp(x, exponent) a mantissa in [0.5, 1).
Value BuiltIns::several_results(const check::Expr& expr) {
    const Value x = expressions_.expression(*expr.args[0]);
    std::vector<Target> targets;
    for (size_t i = 1; i < expr.args.size(); ++i)
        targets.push_back(targets_.target(*expr.args[i]));
    if (budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    std::array<Value, 2> out;
    for (const ValueId v : x) {
        if (expr.intrinsic == check::Intrinsic::kSincos) {
            out[0].push_back(emit_.function(Op::kSin, 0, {v}));
            out[1].push_back(emit_.function(Op::kCos, 0, {v}));
        } else if (expr.intrinsic == check::Intrinsic::kModf) {
            out[0].push_back(emit_.unary(Op::kTrunc, v));
            out[1].push_back(emit_.binary(Op::kSub, v, out[0].back()));
        } else {
            const std::array<ValueId, 2> parts = formulas_.mantissa_and_exponent(v);
            out[0].push_back(parts[1]);
            out[1].push_back(parts[0]);
        }
    }
    targets_.store(targets[0], out[0]);
    if (targets.size() > 1) targets_.store(targets[1], out[1]);
    return targets.size() > 1 ? Value{} : out[1];
}

Value BuiltIns::derivatives(const check::Expr& expr, const Value& x) {
    if (place_.alone) {
        Value unknown;
        for (const ValueId v : x) {
            const auto which = static_cast<int32_t>(expr.intrinsic);
            unknown.push_back(emit_.unknown(ir::Type::kFloat, kChange, which, 0, {v}));
        }
        return unknown;
    }
    if (rules_.refuse_in_dither(expr, "ddx") ||
        rules_.refuse_in_shape(
            expr, "ddx",
            "a shape has no micropolygons; `gradient(f, p)` differentiates a function"))
        return layout_.zero(expr.type);
    if (place_.kind != ir::StageKind::kSurface) {
        sink_->report(expr.span, diag::kStageMismatch, "ddx", "called in a volume stage")
            .note(place_.fablet.volume.span,
                  "stage declared `@Volume` here, which calls this function");
        return layout_.zero(expr.type);
    }
    Value out;
    for (const ValueId v : x) {
        const ValueId along_x = emit_.function(Op::kDerivative, 0, {v});
        const ValueId along_y = emit_.function(Op::kDerivative, 1, {v});
        if (expr.intrinsic == check::Intrinsic::kFwidth) {
            out.push_back(emit_.binary(Op::kAdd, emit_.unary(Op::kAbs, along_x),
                                       emit_.unary(Op::kAbs, along_y)));
        } else {
            out.push_back(expr.intrinsic == check::Intrinsic::kDdx ? along_x : along_y);
        }
    }
    return out;
}

/// Matrices are row-major.
Value BuiltIns::matrix(const check::Expr& expr) {
    std::vector<Value> args;
    for (const check::ExprPtr& arg : expr.args)
        args.push_back(expressions_.expression(*arg));
    if (budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    const check::Type& type = expr.args[0]->type;
    const auto columns = static_cast<size_t>(type.size);
    switch (expr.matrix_op) {
        case check::MatrixOp::kMul:
            return formulas_.product(args[0], args[1], columns);
        case check::MatrixOp::kTranspose: {
            Value out;
            for (size_t j = 0; j < columns; ++j) {
                for (size_t i = 0; i < static_cast<size_t>(type.rows); ++i)
                    out.push_back(args[0][i * columns + j]);
            }
            return out;
        }
        case check::MatrixOp::kDeterminant:
            return {formulas_.determinant(args[0], columns)};
        case check::MatrixOp::kInverse:
            return formulas_.inverse(args[0], columns);
    }
    return layout_.zero(expr.type);
}

/// Lookups in curves (abi/curve_table.h): the stretch is picked by one select a key and coefficient, which costs as much
/// as a third of a `noise` of three axes, needs no table in memory, and has intervals and derivatives like all
/// arithmetic.
Value BuiltIns::curve(const check::Expr& expr) {
    const Value table = expressions_.expression(*expr.args[0]);
    const ValueId given = expressions_.scalar(*expr.args[1]);
    if (budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    const int32_t channels = expr.type.size;
    const auto stride = static_cast<size_t>(abi::curve_stride(channels));
    const auto header = static_cast<size_t>(abi::curve_header(channels));
    // In this order NaN is the first key's.
    const ValueId x = emit_.binary(Op::kMin, emit_.binary(Op::kMax, given, table[0]), table[1]);
    Value piece(table.begin() + static_cast<ptrdiff_t>(header),
                table.begin() + static_cast<ptrdiff_t>(header + stride));
    for (size_t key = 1; key < size_t{abi::kCurveKeys}; ++key) {
        const size_t at = header + key * stride;
        const ValueId here = emit_.binary(Op::kGe, x, table[at]);
        for (size_t k = 0; k < stride; ++k)
            piece[k] = emit_.select(here, table[at + k], piece[k]);
    }
    const ValueId d = emit_.binary(Op::kSub, x, piece[0]);
    Value out;
    for (size_t channel = 0; channel < static_cast<size_t>(channels); ++channel) {
        const ValueId* c = &piece[1 + 4 * channel];
        ValueId value = c[3];
        for (size_t k = 3; k-- > 0;)
            value = emit_.binary(Op::kAdd, emit_.binary(Op::kMul, value, d), c[k]);
        // Rounding goes no further than the keys, and intervals are no wider.
        value = emit_.binary(Op::kMax, value, table[2 + 2 * channel]);
        out.push_back(emit_.binary(Op::kMin, value, table[3 + 2 * channel]));
    }
    return out;
}

}  // namespace openfab::translate
