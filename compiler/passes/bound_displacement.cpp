// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/bound_displacement.h"

#include <array>

#include "base/infinity.h"

namespace openfab::passes {

namespace {

using ir::Op;
using ir::ValueId;
using Vector = std::array<ValueId, 3>;

constexpr int32_t kStatusFine = 0;
constexpr int32_t kStatusNotFinite = 1;
constexpr int32_t kStatusCut = 2;

ValueId all_finite(ir::Builder* b, const Vector& magnitude) {
    const ValueId infinity = b->constant(kInfinity);
    ValueId all = b->constant(true);
    for (const ValueId m : magnitude) {
        all = b->emit(Op::kAnd, {all, b->emit(Op::kLt, {m, infinity})});
    }
    return all;
}

ValueId length_of(ir::Builder* b, const Vector& d, const Vector& magnitude) {
    ValueId most = b->emit(Op::kMax, {magnitude[0], magnitude[1]});
    most = b->emit(Op::kMax, {most, magnitude[2]});
    const ValueId some = b->emit(Op::kGt, {most, b->constant(0.0f)});
    const ValueId scale = b->select(some, most, b->constant(1.0f));
    Vector square{};
    for (size_t k = 0; k < 3; ++k) {
        const ValueId q = b->emit(Op::kDiv, {d[k], scale});
        square[k] = b->emit(Op::kMul, {q, q});
    }
    const ValueId sum = b->emit(Op::kAdd, {b->emit(Op::kAdd, {square[0], square[1]}), square[2]});
    return b->emit(Op::kMul, {most, b->emit(Op::kSqrt, {sum})});
}

}  // namespace

void bound_displacement(ir::Stage* surface) {
    ir::Builder b(surface);
    Vector d{};
    for (const ir::Output& output : surface->outputs) {
        if (output.kind == OPENFAB_ARG_POSITION) d[output.b] = output.value;
    }
    Vector magnitude{};
    for (size_t k = 0; k < 3; ++k)
        magnitude[k] = b.emit(Op::kAbs, {d[k]});
    const ValueId finite = all_finite(&b, magnitude);
    const ValueId length = length_of(&b, d, magnitude);
    const ValueId limit =
        b.input(ir::Type::kFloat, OPENFAB_ARG_FRAME, OPENFAB_FRAME_MAX_DISPLACEMENT, 0);
    const ValueId cut = b.emit(Op::kGt, {length, limit});
    const ValueId ratio = b.emit(Op::kDiv, {limit, length});
    const ValueId scale = b.emit(Op::kMul, {ratio, b.constant(kShrink)});
    for (ir::Output& output : surface->outputs) {
        if (output.kind != OPENFAB_ARG_POSITION) continue;
        const ValueId scaled = b.emit(Op::kMul, {output.value, scale});
        const ValueId inside = b.select(cut, scaled, output.value);
        const ValueId moved = b.select(finite, inside, b.constant(0.0f));
        const ValueId p =
            b.input(ir::Type::kFloat, OPENFAB_ARG_SURFACE_ATTR, OPENFAB_SURFACE_P, output.b);
        output.value = b.emit(Op::kAdd, {p, moved});
    }
    const ValueId longer =
        b.emit(Op::kGt, {b.emit(Op::kMul, {length, b.constant(kShrink)}), limit});
    const ValueId status =
        b.select(finite, b.select(longer, b.constant(kStatusCut), b.constant(kStatusFine)),
                 b.constant(kStatusNotFinite));
    surface->outputs.push_back({"status", OPENFAB_ARG_SURFACE_STATUS, 0, 0, status});
}

}  // namespace openfab::passes
