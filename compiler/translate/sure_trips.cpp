// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/sure_trips.h"

#include <algorithm>
#include <array>
#include <set>

#include "compiler/ir/arithmetic.h"
#include "compiler/translate/proof.h"

namespace openfab::translate {

using ir::Instr;
using ir::Op;
using ir::ValueId;

namespace {

constexpr int kDepth = 8;                     // of formulas that are analysed
constexpr size_t kMaxSame = 64;               // iterations in which an index is the same
constexpr size_t kMaxTests = 16;              // of one formula
constexpr size_t kMaxAlternatives = 1 << 22;  // of a read, over all iterations
constexpr size_t kLooksOfProof = 64;          // lookups that cost as much as a diagram
constexpr size_t kMaxSteps = 1 << 17;         // instructions evaluated, over all iterations

bool is_comparison(Op op) {
    return op >= Op::kEq && op <= Op::kGe;
}

/// Returns whether ir::eval computes an operation from its arguments.
bool is_arithmetic(Op op) {
    return (op >= Op::kAdd && op <= Op::kIsNan) || op == Op::kBitCast;
}

/// Evaluates an instruction from the bits of its arguments, as far as they are known.
std::optional<uint32_t> evaluate(const ir::Stage& stage, const Instr& instr,
                                 const std::array<std::optional<uint32_t>, 3>& args) {
    const auto& [a, b, c] = args;
    if (instr.op == Op::kAnd && ((a && *a == 0) || (b && *b == 0))) return 0;
    if (instr.op == Op::kOr && ((a && *a != 0) || (b && *b != 0))) return 1;
    if (instr.op == Op::kSelect) return !a ? std::nullopt : *a != 0 ? b : c;
    for (size_t i = 0; i < instr.args.size(); ++i) {
        if (!args[i]) return std::nullopt;
    }
    const ir::Type type = stage.instrs[instr.args[0]].type;
    if (instr.op == Op::kConvert) return ir::eval_convert(type, instr.type, *a);
    return ir::eval(instr.op, type, *a, b.value_or(0), 0);
}

}  // namespace

SureTrips::SureTrips(const ir::Stage& stage, ValueId loop, ValueId again,
                     const std::vector<ValueId>& next, const std::vector<ValueId>& facts)
    : stage_(stage), loop_(loop), next_(next) {
    std::set<ValueId> roots;
    for (const ValueId fact : facts) {
        for (const Test& test : tests(fact))
            roots.insert(test.first);
    }
    follow(again, {roots.begin(), roots.end()});
}

bool SureTrips::is_variable(ValueId id) const {
    return at(id).op == Op::kLoopVar && at(id).args[0] == loop_;
}

/// Collects the comparisons with constants in a formula.
std::vector<SureTrips::Test> SureTrips::tests(ValueId fact) const {
    std::vector<Test> out;
    std::set<ValueId> seen;
    std::vector<ValueId> open = {fact};
    while (!open.empty() && seen.size() < kMaxTests * 4 && out.size() < kMaxTests) {
        const ValueId id = open.back();
        open.pop_back();
        if (id < loop_ || !seen.insert(id).second) continue;
        const Instr& instr = at(id);
        if (is_comparison(instr.op)) {
            for (const size_t side : {0, 1}) {
                const Instr& number = at(instr.args[side]);
                if (number.op == Op::kConst) out.emplace_back(instr.args[1 - side], number.bits);
            }
        } else if (instr.type == ir::Type::kBool && is_arithmetic(instr.op)) {
            open.insert(open.end(), instr.args.begin(), instr.args.end());
        }
    }
    return out;
}

/// Returns the instructions of the loop that `roots` depend on, across iterations, in order.
std::vector<ValueId> SureTrips::needed_for(std::vector<ValueId> roots) const {
    std::set<ValueId> out;
    while (!roots.empty()) {
        const ValueId id = roots.back();
        roots.pop_back();
        if (id < loop_ || !out.insert(id).second) continue;
        if (is_variable(id)) {
            roots.push_back(next_[static_cast<size_t>(at(id).a)]);
        } else if (is_arithmetic(at(id).op)) {
            roots.insert(roots.end(), at(id).args.begin(), at(id).args.end());
        }
    }
    return {out.begin(), out.end()};
}

/// Evaluates from the first iteration on, assuming that it runs.
void SureTrips::follow(ValueId again, const std::vector<ValueId>& roots) {
    std::vector<ValueId> all = roots;
    all.push_back(again);
    const std::vector<ValueId> order = needed_for(all);
    std::map<ValueId, uint32_t> now;
    const auto bits_of = [&](ValueId id) -> Bits {
        if (at(id).op == Op::kConst) return at(id).bits;
        const auto found = now.find(id);
        return found != now.end() ? Bits(found->second) : std::nullopt;
    };
    std::map<int32_t, uint32_t> state;
    for (const ValueId id : order) {
        if (!is_variable(id)) continue;
        const Instr& first = at(at(id).args[1]);
        if (first.op == Op::kConst) state.emplace(at(id).a, first.bits);
    }
    bool sure = true;
    for (size_t steps = 0; steps < kMaxSteps && !state.empty(); steps += order.size() + 1) {
        now.clear();
        for (const ValueId id : order) {
            const Instr& instr = at(id);
            Bits bits;
            if (is_variable(id)) {
                const auto found = state.find(instr.a);
                if (found != state.end()) bits = found->second;
            } else if (is_arithmetic(instr.op)) {
                std::array<Bits, 3> args;
                for (size_t i = 0; i < instr.args.size(); ++i)
                    args[i] = bits_of(instr.args[i]);
                bits = evaluate(stage_, instr, args);
            }
            if (bits) now.emplace(id, *bits);
        }
        for (const ValueId root : roots) {
            const Bits bits = bits_of(root);
            if (!bits) continue;
            std::vector<size_t>& equal = trips_where_[{root, *bits}];
            if (equal.size() < kMaxSame) equal.push_back(trips_.size());
        }
        if (sure) ++sure_;
        trips_.push_back(state);
        const Bits more = bits_of(again);
        all_ = more && *more == 0;
        if (all_) return;
        sure = sure && more;
        for (auto variable = state.begin(); variable != state.end();) {
            const Bits bits = bits_of(next_[variable->first]);
            if (bits) variable->second = *bits;
            variable = bits ? std::next(variable) : state.erase(variable);
        }
    }
}

/// Returns the iterations below `end` in which `fact` may become true.
std::vector<size_t> SureTrips::candidates(ValueId fact, size_t end) const {
    std::set<size_t> out;
    if (end > 0) out = {0, end - 1};
    for (const Test& test : tests(fact)) {
        const auto found = trips_where_.find(test);
        if (found == trips_where_.end()) continue;
        for (const size_t trip : found->second) {
            if (trip < end) out.insert(trip);
        }
    }
    return {out.begin(), out.end()};
}

SureTrips::Bits SureTrips::known(ValueId value, size_t trip, int depth) const {
    const Instr& instr = at(value);
    if (instr.op == Op::kConst) return instr.bits;
    if (value < loop_ || depth == 0) return std::nullopt;
    if (is_variable(value)) {
        const auto found = trips_[trip].find(instr.a);
        return found != trips_[trip].end() ? Bits(found->second) : std::nullopt;
    }
    if (!is_arithmetic(instr.op)) return std::nullopt;
    std::array<Bits, 3> args;
    for (size_t i = 0; i < instr.args.size(); ++i)
        args[i] = known(instr.args[i], trip, depth - 1);
    return evaluate(stage_, instr, args);
}

/// Returns the value of `value` in an iteration as a value from before the loop; kNoValue if there
/// is none.
ValueId SureTrips::exactly(ValueId value, size_t trip, int depth, Emitter* emit) const {
    if (const Bits bits = known(value, trip, depth)) return emit->constant(at(value).type, *bits);
    const Instr instr = at(value);  // a copy, since emitting reallocates
    if (value < loop_) return value;
    if (depth == 0 || !is_arithmetic(instr.op) || instr.op == Op::kSelect) return ir::kNoValue;
    std::vector<ValueId> args;
    for (const ValueId arg : instr.args) {
        args.push_back(exactly(arg, trip, depth - 1, emit));
        if (args.back() == ir::kNoValue) return ir::kNoValue;
    }
    if (instr.op == Op::kConvert) return emit->convert(args[0], instr.type);
    if (instr.op == Op::kBitCast) return emit->bit_cast(args[0], instr.type);
    if (instr.op == Op::kAnd) return emit->logical_and(args[0], args[1]);
    if (instr.op == Op::kOr) return emit->logical_or(args[0], args[1]);
    return args.size() == 1 ? emit->unary(instr.op, args[0])
                            : emit->binary(instr.op, args[0], args[1]);
}

/// Returns a condition from before the loop under which `value` holds in an iteration. Facts in
/// `by_trips` hold if an earlier iteration established them.
ValueId SureTrips::at_least(ValueId value, size_t trip, int depth, const ByTrips& by_trips,
                            Emitter* emit) const {
    if (const Bits bits = known(value, trip, depth)) return emit->constant(*bits != 0);
    if (depth == 0) return emit->constant(false);
    if (const auto earlier = by_trips.find(value); earlier != by_trips.end()) {
        return some_gives(earlier->second, trip, emit);
    }
    const Instr instr = at(value);
    // Assignments before the loop count independently of it.
    if (instr.op == Op::kInput && instr.kind == kEarlierTrip) return emit->constant(false);
    const auto part = [&](size_t i) {
        return at_least(instr.args[i], trip, depth - 1, by_trips, emit);
    };
    if (value >= loop_ && instr.op == Op::kAnd) return emit->logical_and(part(0), part(1));
    if (instr.op == Op::kOr) return emit->logical_or(part(0), part(1));
    if (value >= loop_ && instr.op == Op::kSelect) {
        const ValueId test = exactly(instr.args[0], trip, depth - 1, emit);
        if (test == ir::kNoValue) return emit->logical_and(part(1), part(2));
        return emit->select(test, part(1), part(2));
    }
    const ValueId same = exactly(value, trip, depth, emit);
    return same != ir::kNoValue ? same : emit->constant(false);
}

ValueId SureTrips::some_gives(ValueId fact, size_t end, Emitter* emit) const {
    ValueId out = emit->constant(false);
    for (const size_t trip : candidates(fact, end)) {
        out = emit->logical_or(out, at_least(fact, trip, kDepth, {}, emit));
        if (emit->is_true(out)) break;
    }
    return out;
}

ValueId SureTrips::some_gives(ValueId fact, Emitter* emit) const {
    return some_gives(fact, sure_, emit);
}

/// If an iteration runs, all earlier ones ran to their end.
bool SureTrips::is_assigned(const DoubtfulRead::Alternative& alternative, size_t trip,
                            const ByTrips& by_trips, Emitter* emit) {
    ValueId here = exactly(alternative.condition, trip, kDepth, emit);
    if (here == ir::kNoValue) here = emit->constant(true);
    for (const ValueId assigned : alternative.assigned) {
        if (looks_ == 0) return false;
        --looks_;
        const ValueId fact = at_least(assigned, trip, kDepth, by_trips, emit);
        if (emit->is_true(fact) || emit->implies(here, fact)) continue;
        looks_ -= std::min(looks_, kLooksOfProof);
        if (!follows(stage_, {here}, fact)) return false;
    }
    return true;
}

bool SureTrips::always_assigned(const DoubtfulRead& read, const ByTrips& by_trips, Emitter* emit) {
    if (!all_ || trips_.size() * read.alternatives.size() > kMaxAlternatives) return false;
    for (size_t trip = 0; trip < trips_.size(); ++trip) {
        if (known(read.reached, trip, kDepth) == Bits(0)) continue;
        std::map<ValueId, Bits> indices;
        for (const DoubtfulRead::Alternative& alternative : read.alternatives) {
            // Most elements of an array are not the indexed one: `index == number` is false.
            const Instr& condition = at(alternative.condition);
            if (condition.op == Op::kEq && at(condition.args[1]).op == Op::kConst) {
                const auto [index, fresh] = indices.try_emplace(condition.args[0]);
                if (fresh) index->second = known(index->first, trip, kDepth);
                if (index->second && *index->second != at(condition.args[1]).bits) continue;
            }
            if (known(alternative.condition, trip, kDepth) == Bits(0)) continue;
            if (!is_assigned(alternative, trip, by_trips, emit)) return false;
        }
    }
    return true;
}

}  // namespace openfab::translate
