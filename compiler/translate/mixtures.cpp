// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Calls of transcendental functions, noises, hashes, derivatives and bit operations. Names, types
// and defaults: own_functions.cpp. Formulas: formulas.cpp, compiler/functions.

#include <array>

#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

bool StageTranslator::is_function_intrinsic(check::Intrinsic id) {
    const check::Family of = check::family(id);
    return of != check::Family::kComponent && of != check::Family::kGeometric &&
           of != check::Family::kChoice;
}

Value StageTranslator::function_call(const check::Expr& expr) {
    const check::Family family = check::family(expr.intrinsic);
    if (family == check::Family::kSeveral) return several_results(expr);
    std::vector<Value> args;
    for (const check::ExprPtr& arg : expr.args)
        args.push_back(expression(*arg));
    if (gave_up_) return zero(expr.type);
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
Value StageTranslator::several_results(const check::Expr& expr) {
    const Value x = expression(*expr.args[0]);
    std::vector<Target> targets;
    for (size_t i = 1; i < expr.args.size(); ++i)
        targets.push_back(target(*expr.args[i]));
    if (gave_up_) return zero(expr.type);
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
    store(targets[0], out[0]);
    if (targets.size() > 1) store(targets[1], out[1]);
    return targets.size() > 1 ? Value{} : out[1];
}

Value StageTranslator::derivatives(const check::Expr& expr, const Value& x) {
    if (alone_) {
        Value unknown;
        for (const ValueId v : x) {
            const auto which = static_cast<int32_t>(expr.intrinsic);
            unknown.push_back(emit_.unknown(ir::Type::kFloat, kChange, which, 0, {v}));
        }
        return unknown;
    }
    if (refuse_in_dither(expr, "ddx") ||
        refuse_in_shape(expr, "ddx",
                        "a shape has no micropolygons; `gradient(f, p)` differentiates a function"))
        return zero(expr.type);
    if (kind_ != ir::StageKind::kSurface) {
        sink_->report(expr.span, diag::kStageMismatch, "ddx", "called in a volume stage")
            .note(fablet_.volume.span, "stage declared `@Volume` here, which calls this function");
        return zero(expr.type);
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

}  // namespace openfab::translate
