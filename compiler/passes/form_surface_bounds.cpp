// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_surface_bounds.h"

#include <bit>
#include <limits>

#include "compiler/passes/interval.h"

namespace openfab::passes {

namespace {

using ir::Op;
using ir::ValueId;

// Relative rounding error of a sum of three and of the length that bound_displacement compares.
constexpr float kLengthSlack = 1.000001f;

std::optional<std::array<int32_t, 2>> ends_of(int32_t kind) {
    switch (kind) {
        case OPENFAB_ARG_SURFACE_IN:
            return {{OPENFAB_ARG_SURFACE_IN_LO, OPENFAB_ARG_SURFACE_IN_HI}};
        case OPENFAB_ARG_SURFACE_IN_GRAD:
            return {{OPENFAB_ARG_SURFACE_IN_GRAD_LO, OPENFAB_ARG_SURFACE_IN_GRAD_HI}};
        case OPENFAB_ARG_SURFACE_ATTR:
            return {{OPENFAB_ARG_SURFACE_ATTR_LO, OPENFAB_ARG_SURFACE_ATTR_HI}};
        case OPENFAB_ARG_SURFACE_ATTR_GRAD:
            return {{OPENFAB_ARG_SURFACE_ATTR_GRAD_LO, OPENFAB_ARG_SURFACE_ATTR_GRAD_HI}};
        default:
            return std::nullopt;
    }
}

bool is_unknown(int32_t /*kind*/) {
    return false;
}

/// Applies what bound_displacement may do to a vector of the interval.
class Clamp {
  public:
    Clamp(ir::Builder* b, const std::array<Interval, 3>& raw) : b_(*b) {
        limit_ = b_.input(ir::Type::kFloat, OPENFAB_ARG_FRAME, OPENFAB_FRAME_MAX_DISPLACEMENT, 0);
        zero_ = b_.constant(0.0f);
        infinity_ = b_.constant(std::numeric_limits<float>::infinity());
        known_ = b_.constant(true);
        ValueId sum = ir::kNoValue;
        for (const Interval& axis : raw) {
            for (const ValueId end : {axis.lo, axis.hi}) {
                const ValueId finite = b_.emit(Op::kLt, {b_.emit(Op::kAbs, {end}), infinity_});
                known_ = b_.emit(Op::kAnd, {known_, finite});
            }
            const ValueId most =
                b_.emit(Op::kMax, {b_.emit(Op::kAbs, {axis.lo}), b_.emit(Op::kAbs, {axis.hi})});
            sum = sum == ir::kNoValue ? most : b_.emit(Op::kAdd, {sum, most});
        }
        // The sum of magnitudes is at least the length.
        const ValueId longest = b_.emit(Op::kMul, {sum, b_.constant(kLengthSlack)});
        within_ = b_.emit(Op::kLe, {longest, limit_});
    }

    Interval axis(const Interval& raw) {
        const ValueId below = b_.emit(Op::kNeg, {limit_});
        // Cutting moves a component towards 0 and at least into [-B, B].
        const ValueId cut_lo = b_.emit(Op::kMin, {b_.emit(Op::kMax, {raw.lo, below}), zero_});
        const ValueId cut_hi = b_.emit(Op::kMax, {b_.emit(Op::kMin, {raw.hi, limit_}), zero_});
        const ValueId lo = b_.select(within_, raw.lo, cut_lo);
        const ValueId hi = b_.select(within_, raw.hi, cut_hi);
        const ValueId bounded = b_.emit(Op::kLt, {limit_, infinity_});
        const ValueId nan = b_.constant(std::bit_cast<float>(0x7fc00000u));
        const ValueId blind_lo = b_.select(bounded, below, nan);
        const ValueId blind_hi = b_.select(bounded, limit_, nan);
        return {b_.select(known_, lo, blind_lo), b_.select(known_, hi, blind_hi), ir::kNoValue};
    }

  private:
    ir::Builder& b_;
    ValueId limit_;
    ValueId zero_;
    ValueId infinity_;
    ValueId known_;
    ValueId within_;
};

}  // namespace

ir::Stage form_surface_bounds(const ir::Stage& surface) {
    ir::Stage out;
    out.kind = ir::StageKind::kSurfaceBounds;
    IntervalForm form(surface, &out, ends_of, is_unknown);
    const std::vector<Interval>& values = form.run();
    std::array<Interval, 3> raw;
    for (const ir::Output& output : surface.outputs) {
        if (output.kind == OPENFAB_ARG_POSITION) {
            raw[static_cast<size_t>(output.b)] = values[output.value];
        }
    }
    Clamp clamp(&form.builder(), raw);
    std::vector<ir::Output> outputs;
    for (const ir::Output& output : surface.outputs) {
        const bool moves = output.kind == OPENFAB_ARG_POSITION;
        Interval value = values[output.value];
        if (moves) value = clamp.axis(value);
        if (surface.instrs[output.value].type == ir::Type::kBool) {
            // Least and greatest value of the bool.
            value.lo = form.builder().emit(Op::kNot, {value.lo});
        }
        outputs.push_back({output.name + "_lo",
                           moves ? OPENFAB_ARG_DISPLACEMENT_LO : OPENFAB_ARG_SURFACE_OUT_LO,
                           output.a, output.b, value.lo});
        outputs.push_back({output.name + "_hi",
                           moves ? OPENFAB_ARG_DISPLACEMENT_HI : OPENFAB_ARG_SURFACE_OUT_HI,
                           output.a, output.b, value.hi});
    }
    out.outputs = std::move(outputs);
    return out;
}

}  // namespace openfab::passes
