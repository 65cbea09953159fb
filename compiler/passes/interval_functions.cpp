// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Interval rules of the IR's functions. A function as computed need not be monotone where the exact
// one is; it is off by a few ulp (compiler/functions/README.md, at most 4), so ends are widened by
// 8. A noise is bounded by its range and by its value at the box's centre and the steepest slope
// that it has anywhere (tests/property/functions checks the constants).

#include <algorithm>
#include <limits>

#include "compiler/functions/machine.h"
#include "compiler/passes/interval.h"

namespace openfab::passes {

namespace {

using functions::Emit;
using ir::Instr;
using F = Emit::F;
using B = Emit::B;

constexpr float kWider = 0x1p-20f;      // 8 ulp or more
constexpr float kSmallest = 0x1p-145f;  // the same, of denormal numbers
constexpr float kPi = 3.14159274f;      // above pi
constexpr float kExactAngles = 32768.0f;
constexpr float kLattice = 0x1p21f;  // half the coordinate at which lattice points merge
constexpr float kNoiseError = 4e-6f;

/// Indexed by the number of axes: the steepest slope along an axis, and the largest sum of the
/// slopes' magnitudes.
struct Slopes {
    float one;
    float all;
};
constexpr Slopes kPerlinSlopes[] = {
    {0, 0}, {2.72f, 2.72f}, {3.15f, 4.1f}, {3.65f, 5.27f}, {3.7f, 5.95f}};
constexpr Slopes kSimplexSlopes[] = {{0, 0}, {0, 0}, {8.6f, 10.5f}, {7.0f, 12.4f}, {6.2f, 14.2f}};

F minimum(F a, F b) {
    return {a.builder, a.builder->emit(ir::Op::kMin, {a.id, b.id})};
}
F maximum(F a, F b) {
    return {a.builder, a.builder->emit(ir::Op::kMax, {a.id, b.id})};
}
B at_most(F a, F b) {
    return {a.builder, a.builder->emit(ir::Op::kLe, {a.id, b.id})};
}
F wider(F x) {
    return Emit::abs(x) * kWider + kSmallest;
}

}  // namespace

Interval IntervalForm::function_interval(const Instr& instr) {
    const Interval& a = values_[instr.args[0]];
    switch (instr.op) {
        case Op::kSin:
        case Op::kCos:
            return wave_interval(instr.op, a);
        case Op::kTan:
            return tangent_interval(a);
        case Op::kCosh:
            return monotone_interval(instr.op, magnitude_interval(a), false);
        case Op::kAcos:
            return monotone_interval(instr.op, a, true);
        case Op::kAtan2:
            return angle_interval(a, values_[instr.args[1]]);
        case Op::kPow:
            return power_interval(a, values_[instr.args[1]]);
        case Op::kNoise:
        case Op::kSimplex:
        case Op::kCellular:
            return noise_interval(instr);
        case Op::kHash:
            return hash_interval(instr);
        case Op::kAsin:
        case Op::kAtan:
        case Op::kSinh:
        case Op::kTanh:
        case Op::kExp:
        case Op::kExp2:
        case Op::kLog:
        case Op::kLog2:
        case Op::kLog10:
        case Op::kCbrt:
            return monotone_interval(instr.op, a, false);
            OPENFAB_IR_CASES(LEAVES)
            OPENFAB_IR_CASES(CHOICES)
            OPENFAB_IR_CASES(LOOKUPS)
            OPENFAB_IR_CASES(CONTROL)
            OPENFAB_IR_CASES(DERIVATIVES)
            OPENFAB_IR_CASES(OPERATIONS)
            break;
    }
    return unknown(instr.type);
}

/// Any value, unless the box has one list of words alone: a cell of a pattern.
Interval IntervalForm::hash_interval(const ir::Instr& instr) {
    ir::Instr exact = instr;
    Id single = b_.constant(true);
    for (Id& arg : exact.args) {
        const Interval& word = values_[arg];
        if (!word.is_point()) single = both(single, emit(Op::kEq, word.lo, word.hi));
        arg = word.lo;
    }
    const Id value = b_.append(std::move(exact));
    const Interval full = full_range(Type::kUint);
    return {b_.select(single, value, full.lo), b_.select(single, value, full.hi), ir::kNoValue};
}

/// Ends in any order, widened; neither crosses 0, since all functions return results of the right
/// sign.
Interval IntervalForm::widened(Id first, Id last) {
    const F lo = minimum({&b_, first}, {&b_, last});
    const F hi = maximum({&b_, first}, {&b_, last});
    const F zero{&b_, b_.constant(0.0f)};
    const F below = lo - wider(lo);
    const F above = hi + wider(hi);
    return finish(Emit::select(at_most(zero, lo), maximum(below, zero), below).id,
                  Emit::select(at_most(hi, zero), minimum(above, zero), above).id);
}

Interval IntervalForm::monotone_interval(Op op, const Interval& a, bool falls) {
    const Id at_lo = emit(op, falls ? a.hi : a.lo);
    const Id at_hi = emit(op, falls ? a.lo : a.hi);
    // Detects a NaN end, which a minimum may drop.
    const Interval ends = widened(at_lo, at_hi);
    return finish_if(both(finite(at_lo), finite(at_hi)), ends.lo, ends.hi);
}

/// sin, cos: 1 and -1 where the interval may contain a maximum or minimum; else by its ends.
Interval IntervalForm::wave_interval(Op op, const Interval& a) {
    const F lo{&b_, a.lo};
    const F hi{&b_, a.hi};
    const F one{&b_, b_.constant(1.0f)};
    const F turns_lo = lo * (0.5f / kPi);
    const F turns_hi = hi * (0.5f / kPi);
    const auto holds = [&](float phase) {
        const F first = turns_lo - phase - (Emit::abs(turns_lo) * kWider + 1e-6f);
        const F last = turns_hi - phase + (Emit::abs(turns_hi) * kWider + 1e-6f);
        return Emit::floor(first) < Emit::floor(last);
    };
    const Interval ends = widened(emit(op, a.lo), emit(op, a.hi));
    const float crest = op == Op::kSin ? 0.25f : 0.0f;
    const B exact =
        at_most(maximum(Emit::abs(lo), Emit::abs(hi)), {&b_, b_.constant(kExactAngles)});
    const F low = Emit::select(exact & !holds(crest + 0.5f), maximum({&b_, ends.lo}, -one), -one);
    const F high = Emit::select(exact & !holds(crest), minimum({&b_, ends.hi}, one), one);
    return finish_if(both(finite(a.lo), finite(a.hi)), low.id, high.id);
}

/// Between two poles; unknown across one.
Interval IntervalForm::tangent_interval(const Interval& a) {
    const F lo{&b_, a.lo};
    const F hi{&b_, a.hi};
    const auto branch = [&](F x, float sign) {
        const F turns = x * (1.0f / kPi);
        return Emit::floor(turns + 0.5f + (Emit::abs(turns) * kWider + 1e-6f) * sign);
    };
    const B same = branch(lo, -1.0f) == branch(hi, 1.0f);
    const B exact =
        at_most(maximum(Emit::abs(lo), Emit::abs(hi)), {&b_, b_.constant(kExactAngles)});
    const Interval ends = monotone_interval(Op::kTan, a, false);
    return finish_if((same & exact).id, ends.lo, ends.hi);
}

/// atan2(y, x): by the corners where the box avoids the origin and the negative x axis.
Interval IntervalForm::angle_interval(const Interval& y, const Interval& x) {
    const Id zero = b_.constant(0.0f);
    const Id clear = either(emit(Op::kGt, x.lo, zero),
                            either(emit(Op::kGt, y.lo, zero), emit(Op::kLt, y.hi, zero)));
    const Interval ends = extremes({emit(Op::kAtan2, y.lo, x.lo), emit(Op::kAtan2, y.lo, x.hi),
                                    emit(Op::kAtan2, y.hi, x.lo), emit(Op::kAtan2, y.hi, x.hi)});
    const Interval cut = widened(ends.lo, ends.hi);
    const Id pi = b_.constant(kPi);
    const Id known = both(both(finite(y.lo), finite(y.hi)), both(finite(x.lo), finite(x.hi)));
    return finish_if(known, b_.select(clear, cut.lo, emit(Op::kNeg, pi)),
                     b_.select(clear, cut.hi, pi));
}

/// pow(x, y) of x >= 0: by the corners. For other x only a single positive integer y is handled.
Interval IntervalForm::power_interval(const Interval& x, const Interval& y) {
    const Id zero = b_.constant(0.0f);
    const Id positive = both(emit(Op::kGe, x.lo, zero),
                             either(emit(Op::kGt, x.lo, zero), emit(Op::kGt, y.lo, zero)));
    const Interval ends = extremes({emit(Op::kPow, x.lo, y.lo), emit(Op::kPow, x.lo, y.hi),
                                    emit(Op::kPow, x.hi, y.lo), emit(Op::kPow, x.hi, y.hi)});
    const Interval by_corners = widened(ends.lo, ends.hi);
    const Id whole = both(both(emit(Op::kEq, y.lo, y.hi), emit(Op::kGt, y.lo, zero)),
                          emit(Op::kEq, y.lo, emit(Op::kFloor, y.lo)));
    const Id half = emit(Op::kMul, y.lo, b_.constant(0.5f));
    const Id even = emit(Op::kEq, half, emit(Op::kFloor, half));
    const Id most = emit(Op::kMax, emit(Op::kAbs, x.lo), emit(Op::kAbs, x.hi));
    const Interval reach = widened(zero, emit(Op::kPow, most, y.lo));
    const Id known = both(both(finite(x.lo), finite(x.hi)), both(finite(y.lo), finite(y.hi)));
    const Id lo = b_.select(even, zero, emit(Op::kNeg, reach.hi));
    return finish_if(both(known, either(positive, whole)), b_.select(positive, by_corners.lo, lo),
                     b_.select(positive, by_corners.hi, reach.hi));
}

Interval IntervalForm::noise_interval(const Instr& instr) {
    size_t axes = 0;
    while (from_.instrs[instr.args[axes]].type == Type::kFloat)
        ++axes;
    const int32_t which = instr.op == Op::kNoise ? instr.a & ~ir::kPeriodic : instr.a;
    if (instr.op == Op::kCellular && which == 2) {
        return {b_.constant(0.0f), b_.constant(1.0f), ir::kNoValue};
    }
    const Slopes slopes = instr.op == Op::kSimplex ? kSimplexSlopes[axes] : kPerlinSlopes[axes];
    const bool cellular = instr.op == Op::kCellular;
    const float most = which == 0 || cellular ? 1.0f : slopes.one;
    const Interval range = {b_.constant(cellular ? 0.0f : -most), b_.constant(most), ir::kNoValue};
    // Beyond the lattice a skewed coordinate may be anything.
    Id known = b_.constant(true);
    F farthest{&b_, b_.constant(0.0f)};
    for (size_t k = 0; k < axes; ++k) {
        const Interval& x = values_[instr.args[k]];
        known = both(known, both(finite(x.lo), finite(x.hi)));
        farthest = maximum(farthest, maximum(Emit::abs({&b_, x.lo}), Emit::abs({&b_, x.hi})));
    }
    const B near = at_most(farthest, {&b_, b_.constant(kLattice)});
    if (instr.op == Op::kSimplex) known = both(known, near.id);
    const bool steady =
        std::all_of(instr.args.begin() + static_cast<ptrdiff_t>(axes), instr.args.end(),
                    [&](Id arg) { return values_[arg].is_point(); });
    Interval out = range;
    if (steady && (which == 0 || cellular)) {
        out = around_centre(instr, axes, slopes.one, slopes.all, farthest.id);
        out = {b_.select(near.id, emit(Op::kMax, out.lo, range.lo), range.lo),
               b_.select(near.id, emit(Op::kMin, out.hi, range.hi), range.hi), ir::kNoValue};
    }
    if (cellular) {
        return {b_.select(known, out.lo, range.lo), b_.select(known, out.hi, range.hi),
                ir::kNoValue};
    }
    return finish_if(known, out.lo, out.hi);
}

/// Returns the value at the centre, widened as far as the slopes allow: a distance has slope 1 in
/// every direction.
Interval IntervalForm::around_centre(const Instr& instr, size_t axes, float one, float all,
                                     Id farthest) {
    Instr centre = instr;
    F sum{&b_, b_.constant(0.0f)};
    F largest = sum;
    F squares = sum;
    for (size_t k = 0; k < instr.args.size(); ++k) {
        const Interval& x = values_[instr.args[k]];
        if (k >= axes) {
            centre.args[k] = x.point;
            continue;
        }
        const F lo{&b_, x.lo};
        const F hi{&b_, x.hi};
        const F middle = lo * 0.5f + hi * 0.5f;
        const F radius = maximum(middle - lo, hi - middle);
        centre.args[k] = middle.id;
        sum = sum + radius;
        largest = maximum(largest, radius);
        squares = squares + radius * radius;
    }
    F reach = minimum(sum * one, largest * all);
    if (instr.op == Op::kCellular) reach = Emit::sqrt(squares);
    F slack{&b_, b_.constant(kNoiseError)};
    // Skewed coordinates are rounded.
    if (instr.op == Op::kSimplex) slack = slack + F{&b_, farthest} * (0x1p-20f * all);
    reach = reach * 1.0001f + slack;
    const F value{&b_, b_.append(centre)};
    return {(value - reach).id, (value + reach).id, ir::kNoValue};
}

}  // namespace openfab::passes
