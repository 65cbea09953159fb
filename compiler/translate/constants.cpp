// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Lookups in curves (abi/curve_table.h): the stretch is picked by one select a key and coefficient, which costs as much
// as a third of a `noise` of three axes, needs no table in memory, and has intervals and derivatives like all
// arithmetic.

#include "abi/curve_table.h"
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

Value StageTranslator::curve(const check::Expr& expr) {
    const Value table = expression(*expr.args[0]);
    const ValueId given = scalar(*expr.args[1]);
    if (gave_up_) return zero(expr.type);
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
