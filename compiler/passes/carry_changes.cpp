// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/carry_changes.h"

#include <algorithm>
#include <utility>

#include "compiler/functions/differentiate.h"
#include "compiler/functions/functions.h"

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr const char* kLookup = "a texture lookup whose place depends on it";
constexpr const char* kBits = "the bits of a number that depends on it";

/// Returns what changes its sign with some bits, the one float operation that noises make of bits; kNoValue if an
/// instruction is none.
ValueId flipped(const ir::Stage& stage, const Instr& instr) {
    if (instr.op != Op::kBitCast || instr.type != Type::kFloat) return kNoValue;
    const Instr& bits = stage.instrs[instr.args[0]];
    if (bits.op != Op::kBitXor) return kNoValue;
    const Instr& from = stage.instrs[bits.args[0]];
    const bool is_float =
        from.op == Op::kBitCast && stage.instrs[from.args[0]].type == Type::kFloat;
    return is_float ? from.args[0] : kNoValue;
}

/// Returns which values are bits of floats that serve more than a change of sign.
std::vector<bool> used_bits(const ir::Stage& stage) {
    std::vector<bool> out(stage.instrs.size());
    const auto mark = [&](ValueId user, ValueId arg) {
        const Instr& of = stage.instrs[arg];
        const bool bits = of.op == Op::kBitCast && of.type != Type::kFloat;
        const bool changed = of.op == Op::kBitXor && !of.args.empty();
        if (bits && stage.instrs[user].op != Op::kBitXor) out[arg] = true;
        if (!changed || flipped(stage, stage.instrs[user]) != kNoValue) return;
        for (const ValueId bit : of.args) {
            if (stage.instrs[bit].op == Op::kBitCast) out[bit] = true;
        }
    };
    for (ValueId id = 0; id < stage.instrs.size(); ++id) {
        for (const ValueId arg : stage.instrs[id].args)
            mark(id, arg);
    }
    return out;
}

/// Returns the arguments of a Sample that say where it is made.
std::span<const ValueId> place_of(const Instr& sample) {
    constexpr size_t kPlain = 4, kWithFootprint = 10;
    const bool flat = sample.args.size() == kPlain || sample.args.size() == kWithFootprint;
    return std::span(sample.args).subspan(1, flat ? 3 : 4);
}

std::vector<ValueId> deciding_args(const ir::Stage& stage, const Instr& instr) {
    if (const ValueId from = flipped(stage, instr); from != kNoValue) return {from};
    return functions::differentiable_args(instr);
}

/// Has the derivative of a noise no operation of its own?
bool is_closed(const Instr& instr) {
    if (instr.op == Op::kCellular) return instr.a < 2;
    return ir::family(instr.op) == ir::Family::kNoise && (instr.a & ~ir::kPeriodic) != 0;
}

}  // namespace

std::vector<Mask> active_directions(const ir::Stage& stage, const Seeds& seeds) {
    const std::vector<ValueId> ends = ir::loop_ends(stage);
    std::vector<Mask> out(stage.instrs.size(), 0);
    const auto any = [&](std::span<const ValueId> args) {
        Mask mask = 0;
        for (const ValueId arg : args)
            mask |= out[arg];
        return mask;
    };
    const auto of = [&](const Instr& instr) -> Mask {
        if (instr.type != Type::kFloat) return 0;
        if (instr.op == Op::kInput) return seeds.active(instr);
        if (instr.op == Op::kSample) return any(place_of(instr));
        if (instr.op == Op::kQueryResult) {
            const Instr& query = stage.instrs[instr.args[0]];
            return seeds.active_result(query, instr, any(std::span(query.args).subspan(1)));
        }
        if (instr.op == Op::kLoopVar) {
            const size_t number = static_cast<size_t>(instr.a) + ir::kLoopEndNext;
            return out[instr.args[1]] | out[stage.instrs[ends[instr.args[0]]].args[number]];
        }
        if (instr.op == Op::kLoopResult)
            return out[stage.instrs[instr.args[0]].args[0] + 1 + static_cast<ValueId>(instr.a)];
        return any(deciding_args(stage, instr));
    };
    // Loops pass changes back to their variables.
    for (bool grows = true; grows;) {
        grows = false;
        for (ValueId id = 0; id < stage.instrs.size(); ++id) {
            const Mask mask = of(stage.instrs[id]);
            grows |= mask != out[id];
            out[id] = mask;
        }
    }
    return out;
}

ir::Stage with_open_noises(const ir::Stage& stage, const Seeds& seeds) {
    const std::vector<Mask> active = active_directions(stage, seeds);
    ir::Stage out;
    out.kind = stage.kind;
    out.printfs = stage.printfs;
    ir::Builder builder(&out);
    std::vector<ValueId> renamed;
    for (ValueId id = 0; id < stage.instrs.size(); ++id) {
        Instr copy = stage.instrs[id];
        for (ValueId& arg : copy.args)
            arg = renamed[arg];
        builder.set_span(copy.span);
        renamed.push_back(active[id] != 0 && is_closed(copy) ? functions::expand(copy, &builder)
                                                             : builder.append(std::move(copy)));
    }
    for (ir::Output output : stage.outputs) {
        output.value = renamed[output.value];
        out.outputs.push_back(std::move(output));
    }
    return out;
}

ChangeCarrier::ChangeCarrier(const ir::Stage& stage, size_t directions, Seeds* seeds,
                             ir::Builder* builder)
    : old_(stage),
      directions_(directions),
      seeds_(*seeds),
      builder_(*builder),
      active_(active_directions(stage, *seeds)),
      changes_(directions, std::vector<ValueId>(stage.instrs.size(), kNoValue)),
      numbers_(directions, std::vector<int32_t>(stage.instrs.size(), -1)) {}

void ChangeCarrier::run() {
    const std::vector<bool> bits = used_bits(old_);
    for (ValueId id = 0; id < old_.instrs.size(); ++id) {
        const Instr& instr = old_.instrs[id];
        builder_.set_span(instr.span);
        Instr copy = instr;
        for (ValueId& arg : copy.args)
            arg = values_[arg];
        if (copy.op == Op::kLoop) before_loop(id);
        if (copy.op == Op::kLoopEnd) end_loop(instr, &copy);
        const bool head = copy.op == Op::kLoop || copy.op == Op::kLoopVar;
        ValueId value = copy.op == Op::kInput ? seeds_.value(instr) : kNoValue;
        if (value == kNoValue) value = builder_.append(std::move(copy));
        values_.push_back(value);
        if (head && old_.instrs[id + 1].op != Op::kLoopVar) begin_loop(id + 1);
        if (!head && active_[id] != 0) differentiate(id);
        if (bits[id] && changes(instr.args[0])) seeds_.refuse(instr.span, kBits);
    }
}

bool ChangeCarrier::changes(ValueId old) const {
    return std::any_of(changes_.begin(), changes_.end(),
                       [&](const auto& of) { return of[old] != kNoValue; });
}

ValueId ChangeCarrier::change_or_zero(ValueId old, size_t direction) {
    const ValueId change = changes_[direction][old];
    return change == kNoValue ? builder_.constant(0.0f) : change;
}

/// Emits the first values of the variables that are changes, before the loop.
void ChangeCarrier::before_loop(ValueId loop) {
    for (ValueId var = loop + 1; old_.instrs[var].op == Op::kLoopVar; ++var) {
        for (size_t k = 0; k < directions_; ++k) {
            if (moves(var, k))
                firsts_.push_back({var, k, change_or_zero(old_.instrs[var].args[1], k)});
        }
    }
}

/// Adds these variables behind the loop's own, which end before `next`.
void ChangeCarrier::begin_loop(ValueId next) {
    ValueId loop = next - 1;
    while (old_.instrs[loop].op != Op::kLoop)
        --loop;
    auto number = static_cast<int32_t>(next - loop - 1);
    open_.push_back(std::exchange(firsts_, {}));
    for (const Variable& v : open_.back()) {
        numbers_[v.direction][v.old] = number;
        changes_[v.direction][v.old] = builder_.loop_var(values_[loop], number++, v.first);
    }
}

void ChangeCarrier::end_loop(const Instr& old, Instr* end) {
    for (const Variable& v : open_.back()) {
        const auto number = static_cast<size_t>(old_.instrs[v.old].a);
        end->args.push_back(change_or_zero(old.args[number + ir::kLoopEndNext], v.direction));
    }
    open_.pop_back();
}

void ChangeCarrier::differentiate(ValueId id) {
    const Op op = old_.instrs[id].op;
    if (op == Op::kSample) return seeds_.refuse(old_.instrs[id].span, kLookup);
    if (op == Op::kQueryResult) return differentiate_result(id);
    for (size_t k = 0; k < directions_; ++k) {
        if (moves(id, k)) changes_[k][id] = differentiate(id, k);
    }
}

void ChangeCarrier::differentiate_result(ValueId id) {
    const Instr& result = old_.instrs[id];
    const ValueId query = result.args[0];
    std::vector<std::array<ValueId, 3>> points;
    for (size_t k = 0; k < directions_; ++k) {
        std::array<ValueId, 3>& point = points.emplace_back();
        for (size_t axis = 0; axis < point.size(); ++axis)
            point[axis] = changes_[k][old_.instrs[query].args[axis + 1]];
    }
    std::vector<ValueId> changes(directions_, kNoValue);
    seeds_.query_changes(values_[query], result, values_[id], points, &changes);
    for (size_t k = 0; k < directions_; ++k)
        changes_[k][id] = changes[k];
}

ValueId ChangeCarrier::differentiate(ValueId id, size_t direction) {
    const Instr& old = old_.instrs[id];
    if (old.op == Op::kInput) return seeds_.change(old, direction);
    if (old.op == Op::kLoopResult) {
        const ValueId loop = old_.instrs[old.args[0]].args[0];
        const ValueId var = loop + 1 + static_cast<ValueId>(old.a);
        return builder_.loop_result(values_[old.args[0]], numbers_[direction][var]);
    }
    if (const ValueId from = flipped(old_, old); from != kNoValue) {
        const ValueId change = changes_[direction][from];
        if (change == kNoValue) return kNoValue;
        const ValueId sign = values_[old_.instrs[old.args[0]].args[1]];
        const ValueId bits = builder_.bit_cast(change, Type::kUint);
        return builder_.bit_cast(builder_.emit(Op::kBitXor, {bits, sign}), Type::kFloat);
    }
    if (old.op == Op::kPick) {
        if (const ValueId change = differentiate_pick(old, direction); change != kNoValue)
            return change;
    }
    if (old.op == Op::kMin || old.op == Op::kMax) return differentiate_extreme(id, direction);
    if (old.op == Op::kPow)
        return still_at_rest(old, direction, differentiate_power(id, direction));
    const Instr copy = builder_.instr(values_[id]);
    std::vector<ValueId> changes;
    for (const ValueId arg : old.args)
        changes.push_back(changes_[direction][arg]);
    const ValueId change =
        functions::differentiate(values_[id], copy, changes, functions::AtZero::kZero, &builder_);
    return still_at_rest(old, direction, change);
}

/// A Pick of which one element changes, such as a number of an array of uniforms: a comparison instead of a table with one
/// number in it. kNoValue where more do.
ValueId ChangeCarrier::differentiate_pick(const Instr& pick, size_t direction) {
    size_t only = 0;
    for (size_t k = 1; k < pick.args.size(); ++k) {
        if (changes_[direction][pick.args[k]] == kNoValue) continue;
        if (only != 0) return kNoValue;
        only = k;
    }
    const size_t last = pick.args.size() - 1;
    if (only == 0 || last == 1) return kNoValue;
    const ValueId index = values_[pick.args[0]];
    const auto number = static_cast<uint32_t>(only - 1);
    // An index that names no element names the nearest.
    const Op is = only == 1 ? Op::kLe : only == last ? Op::kGe : Op::kEq;
    const ValueId here =
        builder_.emit(is, {index, builder_.constant(builder_.type(index), number)});
    return builder_.select(here, changes_[direction][pick.args[only]], builder_.constant(0.0f));
}

/// Of two equal numbers the first, which is the one that a `clamp` is of: it moves where its bound is reached alone, as
/// where a curve has the same value everywhere.
ValueId ChangeCarrier::differentiate_extreme(ValueId id, size_t direction) {
    const Instr& old = old_.instrs[id];
    const ValueId a = values_[old.args[0]], b = values_[old.args[1]];
    const ValueId first = builder_.emit(old.op == Op::kMin ? Op::kLe : Op::kGe, {a, b});
    return builder_.select(first, change_or_zero(old.args[0], direction),
                           change_or_zero(old.args[1], direction));
}

/// x^y where x may be 0, as behind a `max`.
ValueId ChangeCarrier::differentiate_power(ValueId id, size_t direction) {
    const Instr& old = old_.instrs[id];
    const ValueId x = values_[old.args[0]], y = values_[old.args[1]];
    const ValueId dx = changes_[direction][old.args[0]], dy = changes_[direction][old.args[1]];
    ValueId out = kNoValue;
    if (dx != kNoValue) {
        const ValueId less = builder_.emit(Op::kSub, {y, builder_.constant(1.0f)});
        const ValueId slope = builder_.emit(Op::kMul, {y, builder_.emit(Op::kPow, {x, less})});
        out = builder_.emit(Op::kMul, {dx, slope});
    }
    if (dy == kNoValue) return out;
    const ValueId zero = builder_.constant(0.0f);
    const ValueId slope = builder_.emit(Op::kMul, {values_[id], builder_.emit(Op::kLog, {x})});
    const ValueId by_power = builder_.select(builder_.emit(Op::kGt, {x, zero}),
                                             builder_.emit(Op::kMul, {dy, slope}), zero);
    return out == kNoValue ? by_power : builder_.emit(Op::kAdd, {out, by_power});
}

/// A function with a steep end does not change where its argument does not, as behind a `clamp`: 0 times infinity is 0.
ValueId ChangeCarrier::still_at_rest(const Instr& old, size_t direction, ValueId change) {
    const bool steep = old.op == Op::kAsin || old.op == Op::kAcos || old.op == Op::kCbrt ||
                       old.op == Op::kPow || old.op == Op::kAtan2 || old.op == Op::kLog ||
                       old.op == Op::kLog2 || old.op == Op::kLog10;
    if (!steep || change == kNoValue) return change;
    const ValueId zero = builder_.constant(0.0f);
    ValueId rests = kNoValue;
    for (const ValueId arg : old.args) {
        const ValueId of = changes_[direction][arg];
        if (of == kNoValue) continue;
        const ValueId here = builder_.emit(Op::kEq, {of, zero});
        rests = rests == kNoValue ? here : builder_.emit(Op::kAnd, {rests, here});
    }
    return rests == kNoValue ? change : builder_.select(rests, zero, change);
}

}  // namespace openfab::passes
