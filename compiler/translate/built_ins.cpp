// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "compiler/ir/arithmetic.h"
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

constexpr int32_t kMaxChannel = 63;  // no supported image format has more

}  // namespace

Value StageTranslator::intrinsic(const check::Expr& expr) {
    if (is_function_intrinsic(expr.intrinsic)) return function_call(expr);
    std::vector<Value> args;
    for (const check::ExprPtr& arg : expr.args)
        args.push_back(expression(*arg));
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

Value StageTranslator::sample(const check::Expr& expr) {
    const ValueId texture = scalar(*expr.args[0]);
    const ValueId channel = scalar(*expr.args[1]);
    const ValueId width = scalar(*expr.args[2]);
    Value at;
    for (size_t i = 3; i < expr.args.size(); ++i) {
        const Value part = expression(*expr.args[i]);
        at.insert(at.end(), part.begin(), part.end());
    }
    if (gave_up_ || refuse_in_dither(expr, fmt::format("Sample{}", expr.type.size)))
        return zero(expr.type);
    emit_.set_span(expr.span);
    if (!emit_.is_constant(channel)) {
        sink_->report(expr.args[1]->span, diag::kNotConstant, "the channel of a lookup");
        return zero(expr.type);
    }
    const int32_t first = ir::as_int(emit_.instr(channel).bits);
    if (first < 0 || first > kMaxChannel) {
        sink_->report(expr.args[1]->span, diag::kOutOfRange, "channel", first, 0, kMaxChannel);
        return zero(expr.type);
    }
    // Who reads alpha, too, puts the colour itself where it says.
    const bool picture = at.size() == 2;
    const bool with_alpha = picture && first + expr.type.size > ir::kAlphaChannel;
    // If the texture varies, each candidate is sampled under the condition that it is selected.
    const std::vector<int32_t> textures = possible_indices(texture, fablet_.ir.texture_count);
    Value out = zero(expr.type);
    if (textures.size() > check::kMaxTextures) {
        sink_
            ->report(expr.span, diag::kTooComplex,
                     fmt::format("a varying index that may pick one of {} textures; at most {} "
                                 "are supported",
                                 textures.size(), check::kMaxTextures))
            .help("each of them is sampled separately: pack them into one texture");
        return out;
    }
    for (int32_t index : textures) {
        const ValueId here =
            textures.size() == 1
                ? emit_.constant(true)
                : emit_.binary(Op::kEq, texture,
                               emit_.constant(ir::Type::kInt, static_cast<uint32_t>(index)));
        const ValueId guard = emit_.logical_and(live_, here);
        Value args = {guard};
        args.insert(args.end(), at.begin(), at.end());
        args.push_back(width);
        for (int32_t i = 0; i < expr.type.size; ++i) {
            const bool own = with_alpha && first + i < ir::kAlphaChannel;
            const int32_t number = first + i + (own ? ir::kOwnColor : 0);
            const ValueId value = emit_.sample(index, number, args);
            out[i] = emit_.select(here, value, out[i]);
        }
    }
    return out;
}

/// Reads the one of a rule's `count` inputs of a kind that the argument names. A number beyond them
/// is the nearest, as of an array.
Value StageTranslator::numbered(const check::Expr& expr, int32_t kind, int32_t count) {
    const ValueId number = scalar(*expr.args[0]);
    if (gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    ValueId out = emit_.input(ir::Type::kInt, kind, 0, 0);
    for (int32_t k = 1; k < count; ++k) {
        const ValueId from_here = emit_.binary(Op::kGe, number, emit_.constant(k));
        if (emit_.is_false(from_here)) break;
        out = emit_.select(from_here, emit_.input(ir::Type::kInt, kind, k, 0), out);
    }
    return {out};
}

Value StageTranslator::composition(const check::Expr& expr) {
    const check::Expr& object = *expr.args[0];
    const Target to = target(object);
    if (expr.kind == check::ExprKind::kClear) {
        store(to, zero(object.type));
        return {};
    }
    Value amounts = read(to, object);
    if (expr.kind == check::ExprKind::kTotal) {
        return {formulas_.sum(amounts)};
    }
    const ValueId material = scalar(*expr.args[1]);
    const auto is_slot = [&](size_t slot) {
        return emit_.binary(Op::kEq, material,
                            emit_.constant(ir::Type::kInt, static_cast<uint32_t>(slot)));
    };
    // The common case of a single slot.
    const bool known = emit_.is_constant(material);
    const size_t first = known ? emit_.instr(material).bits : 0;
    const size_t last = known ? first + 1 : amounts.size();
    if (expr.kind == check::ExprKind::kGet) {
        ValueId out = emit_.constant(0.0f);
        for (size_t i = first; i < last; ++i) {
            out = emit_.select(is_slot(i), amounts[i], out);
        }
        return {out};
    }
    const ValueId amount = scalar(*expr.args[2]);
    // Evaluating the arguments may have changed it: `mc.Set(m, mc.Total())` does not, but a
    // function with an out parameter can.
    amounts = read(to, object);
    if (gave_up_) return {};
    emit_.set_span(expr.span);
    for (size_t i = first; i < last; ++i) {
        const ValueId value = expr.kind == check::ExprKind::kAdd
                                  ? emit_.binary(Op::kAdd, amounts[i], amount)
                                  : amount;
        amounts[i] = emit_.select(is_slot(i), value, amounts[i]);
    }
    store(to, amounts);
    return {};
}

/// Composites the upper amounts over the lower ones: above + below * (1 - saturate(above.Total())).
Value StageTranslator::over(const check::Expr& expr) {
    const Value above = expression(*expr.args[0]);
    const Value below = expression(*expr.args[1]);
    if (above.empty() || gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    const ValueId total =
        formulas_.clamp(formulas_.sum(above), emit_.constant(0.0f), emit_.constant(1.0f));
    const ValueId rest = emit_.binary(Op::kSub, emit_.constant(1.0f), total);
    return formulas_.binary(Op::kAdd, above, formulas_.binary(Op::kMul, below, {rest}));
}

}  // namespace openfab::translate
