// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The magnitude of a sawtooth, such as abs(q - round(q)): how periodic shapes are folded into a
// part of one cell. Operation by operation a box with a break of the sawtooth in it would have the
// whole range, although the fold is continuous there.

#include <utility>

#include "compiler/passes/interval.h"

namespace openfab::passes {

namespace {

/// Factors and offsets of a sawtooth are below this, so that it stays finite.
constexpr float kMostShift = 1e9F;
/// The most operations between the fraction and its magnitude.
constexpr int kMostShifts = 3;

}  // namespace

/// q - floor(q) and q - round(q) never fall between two breaks, computed as well as exactly: there the
/// whole number is one and the same, and rounding keeps order. What a constant is added to,
/// subtracted from or multiplied with rises or falls likewise.
std::optional<IntervalForm::Sawtooth> IntervalForm::sawtooth(Id value, int depth) {
    const ir::Instr& instr = from_.instrs[value];
    if (instr.args.size() != 2 || instr.type != Type::kFloat) return std::nullopt;
    const Id first = instr.args[0], second = instr.args[1];
    if (instr.op == Op::kSub) {
        const ir::Instr& whole = from_.instrs[second];
        const bool floors = whole.op == Op::kFloor;
        if ((floors || whole.op == Op::kRound) && whole.args[0] == first) {
            const Interval& q = values_[first];
            if (q.is_point()) return std::nullopt;
            const Id lo = emit(whole.op, q.lo), hi = emit(whole.op, q.hi);
            return Sawtooth{.at_lo = emit(Op::kSub, q.lo, lo),
                            .at_hi = emit(Op::kSub, q.hi, hi),
                            .before_break = b_.constant(floors ? 1.0F : 0.5F),
                            .after_break = b_.constant(floors ? 0.0F : -0.5F),
                            .breaks = emit(Op::kSub, hi, lo),
                            .known = is_known(q)};
        }
    }
    if (instr.op != Op::kAdd && instr.op != Op::kSub && instr.op != Op::kMul) return std::nullopt;
    const bool left = values_[first].is_point();
    if (left == values_[second].is_point() || depth == kMostShifts) return std::nullopt;
    std::optional<Sawtooth> out = sawtooth(left ? second : first, depth + 1);
    if (!out) return std::nullopt;
    const Id point = values_[left ? first : second].point;
    for (Id* at : {&out->at_lo, &out->at_hi, &out->before_break, &out->after_break})
        *at = left ? emit(instr.op, point, *at) : emit(instr.op, *at, point);
    out->known = both(out->known, emit(Op::kLt, emit(Op::kAbs, point), b_.constant(kMostShift)));
    return out;
}

/// Up to a break and on from it, each of which rises or falls.
std::optional<Interval> IntervalForm::folded_interval(Id value) {
    const std::optional<Sawtooth> saw = sawtooth(value, 0);
    if (!saw) return std::nullopt;
    const auto magnitude = [&](Id a, Id b) {
        return magnitude_interval({emit(Op::kMin, a, b), emit(Op::kMax, a, b), ir::kNoValue});
    };
    const Interval none = magnitude(saw->at_lo, saw->at_hi);
    const Interval to = magnitude(saw->at_lo, saw->before_break);
    const Interval on = magnitude(saw->after_break, saw->at_hi);
    const Interval all = magnitude(saw->after_break, saw->before_break);
    const Id zero = b_.constant(0.0F), one = b_.constant(1.0F);
    const Id within = emit(Op::kEq, saw->breaks, zero), across = emit(Op::kEq, saw->breaks, one);
    const auto pick = [&](Id in_one, Id in_two, Id in_all) {
        return b_.select(within, in_one, b_.select(across, in_two, in_all));
    };
    return finish_if(saw->known, pick(none.lo, emit(Op::kMin, to.lo, on.lo), all.lo),
                     pick(none.hi, emit(Op::kMax, to.hi, on.hi), all.hi));
}

}  // namespace openfab::passes
