// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/mixtures.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

Value Mixtures::composition(const check::Expr& expr) {
    const check::Expr& object = *expr.args[0];
    const Target to = targets_.target(object);
    if (expr.kind == check::ExprKind::kClear) {
        targets_.store(to, layout_.zero(object.type));
        return {};
    }
    Value amounts = targets_.read(to, object);
    if (expr.kind == check::ExprKind::kTotal) {
        return {formulas_.sum(amounts)};
    }
    const ValueId material = expressions_.scalar(*expr.args[1]);
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
    const ValueId amount = expressions_.scalar(*expr.args[2]);
    // Evaluating the arguments may have changed it: `mc.Set(m, mc.Total())` does not, but a
    // function with an out parameter can.
    amounts = targets_.read(to, object);
    if (budget_.gave_up) return {};
    emit_.set_span(expr.span);
    for (size_t i = first; i < last; ++i) {
        const ValueId value = expr.kind == check::ExprKind::kAdd
                                  ? emit_.binary(Op::kAdd, amounts[i], amount)
                                  : amount;
        amounts[i] = emit_.select(is_slot(i), value, amounts[i]);
    }
    targets_.store(to, amounts);
    return {};
}

/// Composites the upper amounts over the lower ones: above + below * (1 - saturate(above.Total())).
Value Mixtures::over(const check::Expr& expr) {
    const Value above = expressions_.expression(*expr.args[0]);
    const Value below = expressions_.expression(*expr.args[1]);
    if (above.empty() || budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    const ValueId total =
        formulas_.clamp(formulas_.sum(above), emit_.constant(0.0f), emit_.constant(1.0f));
    const ValueId rest = emit_.binary(Op::kSub, emit_.constant(1.0f), total);
    return formulas_.binary(Op::kAdd, above, formulas_.binary(Op::kMul, below, {rest}));
}

}  // namespace openfab::translate
