// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/sure_trips.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <set>

#include "compiler/ir/arithmetic.h"
#include "compiler/translate/proof.h"

namespace openfab::translate {

using ir::Instr;
using ir::Op;
using ir::ValueId;

namespace {

constexpr int kDepth = 12;                    // of formulas that are analysed
constexpr size_t kMaxSame = 64;               // iterations in which an index is the same
constexpr size_t kMaxTests = 16;              // of one formula
constexpr size_t kMaxAlternatives = 1 << 22;  // of a read, over all iterations
constexpr size_t kMaxSteps = 1 << 17;         // instructions evaluated, over all iterations
constexpr size_t kMaxConditional = 256;       // iterations with a condition of their own
constexpr size_t kMaxParts = 16;              // of such a condition
constexpr size_t kFormula = 8;                // effort, in terms of an evaluated instruction
constexpr size_t kMaxLeft = 1 << 14;          // alternatives of a read for the enclosing loop

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
                     const std::vector<ValueId>& next, const std::vector<ValueId>& facts,
                     double most, size_t effort, Emitter* emit)
    : stage_(stage), loop_(loop), next_(next), effort_(effort) {
    std::set<ValueId> roots;
    for (const ValueId fact : facts) {
        for (const Test& test : tests(fact))
            roots.insert(test.first);
    }
    follow(again, {roots.begin(), roots.end()}, most, emit);
}

/// Returns false where nothing is left.
bool SureTrips::spend(size_t effort) const {
    effort_ -= std::min(effort_, effort);
    return effort_ > 0;
}

bool SureTrips::proves(const std::vector<ValueId>& given, ValueId fact) const {
    size_t steps = 0;
    const bool out = spend(kFormula) && follows(stage_, given, fact, &steps);
    return spend(kFormula * steps / 2) && out;
}

bool SureTrips::is_variable(ValueId id) const {
    return at(id).op == Op::kLoopVar && at(id).args[0] == loop_;
}

int64_t SureTrips::number(ValueId value, uint32_t bits) const {
    return at(value).type == ir::Type::kInt ? int64_t{ir::as_int(bits)} : int64_t{bits};
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
                const ValueId constant = instr.args[side];
                if (at(constant).op != Op::kConst) continue;
                out.emplace_back(instr.args[1 - side], number(constant, at(constant).bits));
            }
        } else if (instr.type == ir::Type::kBool && is_arithmetic(instr.op)) {
            open.insert(open.end(), instr.args.begin(), instr.args.end());
        }
    }
    return out;
}

/// Returns the least and the greatest value of an integer's type.
std::pair<int64_t, int64_t> SureTrips::range(ValueId value) const {
    if (at(value).type == ir::Type::kUint) return {0, std::numeric_limits<uint32_t>::max()};
    return {std::numeric_limits<int32_t>::min(), std::numeric_limits<int32_t>::max()};
}

/// Reads a comparison of an integer with a constant: `v == c`, `v <= c` or `v >= c`.
std::optional<SureTrips::Window> SureTrips::half_window(ValueId comparison) const {
    const Instr& instr = at(comparison);
    if (!is_comparison(instr.op) || at(instr.args[1]).op != Op::kConst) return std::nullopt;
    const ValueId value = instr.args[0];
    if (at(value).type != ir::Type::kInt && at(value).type != ir::Type::kUint) return std::nullopt;
    const auto [least, greatest] = range(value);
    const int64_t bound = number(value, at(instr.args[1]).bits);
    if (instr.op == Op::kEq) return Window{value, bound, bound};
    if (instr.op == Op::kLe) return Window{value, least, bound};
    if (instr.op == Op::kGe) return Window{value, bound, greatest};
    return std::nullopt;
}

/// Reads a comparison, or `v <= c && v >= d`.
std::optional<SureTrips::Window> SureTrips::window(ValueId condition) const {
    const Instr& instr = at(condition);
    if (instr.op != Op::kAnd) return half_window(condition);
    const auto a = half_window(instr.args[0]);
    const auto b = half_window(instr.args[1]);
    if (!a || !b || a->value != b->value) return std::nullopt;
    return Window{a->value, std::max(a->lo, b->lo), std::min(a->hi, b->hi)};
}

/// Returns the windows in a formula that imply it where `facts` hold.
std::map<ValueId, SureTrips::Window> SureTrips::windows(ValueId fact, const Facts& facts,
                                                        int depth) const {
    fact = chosen(fact, facts);
    const Instr& instr = at(fact);
    if (depth == 0 || fact < loop_ || !spend(kFormula * (1 + facts.size()))) return {};
    if (const auto found = window(fact)) return {{fact, *found}};
    const auto part = [&](size_t i) { return windows(instr.args[i], facts, depth - 1); };
    const auto in_both = [](std::map<ValueId, Window> a, const std::map<ValueId, Window>& b) {
        std::erase_if(a, [&](const auto& item) { return b.count(item.first) == 0; });
        return a;
    };
    if (instr.op == Op::kOr) {
        std::map<ValueId, Window> out = part(0);
        out.merge(part(1));
        return out;
    }
    if (instr.op == Op::kAnd) return in_both(part(0), part(1));
    if (instr.op != Op::kSelect) return {};
    const auto branch = [&](bool truth) {
        Facts inside = facts;
        assume(instr.args[0], truth, &inside);
        return windows(instr.args[truth ? 1 : 2], inside, depth - 1);
    };
    return in_both(branch(true), branch(false));
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

/// Collects the consequences of `value` being `truth`.
void SureTrips::assume(ValueId value, bool truth, Facts* facts) const {
    if (!facts->emplace(value, truth).second) return;
    const Instr& instr = at(value);
    if (instr.op == Op::kNot) return assume(instr.args[0], !truth, facts);
    if (instr.op != (truth ? Op::kAnd : Op::kOr)) return;
    for (const ValueId arg : instr.args)
        assume(arg, truth, facts);
}

/// Returns the value that selects on facts come to.
ValueId SureTrips::chosen(ValueId value, const Facts& facts) const {
    while (at(value).op == Op::kSelect) {
        const auto fact = facts.find(at(value).args[0]);
        if (fact == facts.end()) break;
        value = at(value).args[fact->second ? 1 : 2];
    }
    return value;
}

/// Evaluates from the first iteration on, assuming that it runs.
void SureTrips::follow(ValueId again, const std::vector<ValueId>& roots, double most,
                       Emitter* emit) {
    std::vector<ValueId> all = roots;
    all.push_back(again);
    const std::vector<ValueId> order = needed_for(all);
    std::map<ValueId, uint32_t> now;
    const auto bits_of = [&](ValueId id) -> Bits {
        if (at(id).op == Op::kConst) return at(id).bits;
        const auto found = now.find(id);
        return found != now.end() ? Bits(found->second) : std::nullopt;
    };
    // Where there is a next iteration, no `break` was taken.
    Facts facts;
    assume(again, true, &facts);
    Trip trip = {{}, emit->constant(true), emit->constant(true)};
    for (const ValueId id : order) {
        if (!is_variable(id)) continue;
        const Instr& first = at(at(id).args[1]);
        if (first.op == Op::kConst) trip.counters.emplace(at(id).a, first.bits);
    }
    for (size_t steps = 0; steps < kMaxSteps && !trip.counters.empty(); steps += order.size() + 1) {
        now.clear();
        for (const ValueId id : order) {
            const Instr& instr = at(id);
            Bits bits;
            if (is_variable(id)) {
                const auto found = trip.counters.find(instr.a);
                if (found != trip.counters.end()) bits = found->second;
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
            std::vector<size_t>& equal = trips_where_[{root, number(root, *bits)}];
            if (equal.size() < kMaxSame) equal.push_back(trips_.size());
        }
        trips_.push_back(trip);
        if (emit->is_true(trip.sure_if)) certain_ = trips_.size();
        if (!emit->is_false(trip.sure_if)) sure_ = trips_.size();
        const Bits more = bits_of(again);
        all_ = static_cast<double>(trips_.size()) >= most ||
               (more ? *more == 0 : !go_on(again, facts, &trip, emit));
        if (all_) return;
        for (auto variable = trip.counters.begin(); variable != trip.counters.end();) {
            const Bits bits = bits_of(chosen(next_[static_cast<size_t>(variable->first)], facts));
            if (bits) variable->second = *bits;
            variable = bits ? std::next(variable) : trip.counters.erase(variable);
        }
    }
}

/// Returns a condition that holds where both do: usually the later one alone, since a counter that
/// is below its bound was so before. Formulas of many parts are dear.
ValueId SureTrips::both(ValueId earlier, ValueId now, Emitter* emit) {
    if (proves({now}, earlier)) return now;
    conditional_ += kMaxConditional / kMaxParts;
    return emit->logical_and(earlier, now);
}

/// Narrows the conditions of the last iteration to those of the next one, where `again` has no
/// known value and implies `facts`. Returns false if there is none.
bool SureTrips::go_on(ValueId again, const Facts& facts, Trip* next, Emitter* emit) {
    ValueId exact = ir::kNoValue;
    if (conditional_ < kMaxConditional) {
        ++conditional_;
        const ValueId may = at_most(again, trips_.size() - 1, kDepth, facts, emit);
        if (proves({may}, emit->constant(false))) return false;
        next->may_if = both(next->may_if, may, emit);
        exact = exactly(again, trips_.size() - 1, kDepth, {}, emit);
    }
    if (exact == ir::kNoValue || emit->is_false(next->sure_if)) {
        next->sure_if = emit->constant(false);
    } else {
        next->sure_if = both(next->sure_if, exact, emit);
    }
    return true;
}

/// Returns the iterations below `end` in which `fact` may become true; the first and the last one
/// too if `ends`.
std::vector<size_t> SureTrips::candidates(ValueId fact, size_t end, bool ends) const {
    std::set<size_t> out;
    if (end > 0 && ends) out = {0, end - 1};
    const auto add = [&](const std::vector<size_t>& trips) {
        for (const size_t trip : trips) {
            if (trip < end) out.insert(trip);
        }
    };
    for (const Test& test : tests(fact)) {
        // Of values that are not the number itself, those next to it.
        const auto from = trips_where_.lower_bound(test);
        if (from != trips_where_.end() && from->first.first == test.first) add(from->second);
        if (from != trips_where_.end() && from->first == test) continue;
        if (from == trips_where_.begin()) continue;
        const auto below = std::prev(from);
        if (below->first.first == test.first) add(below->second);
    }
    return {out.begin(), out.end()};
}

SureTrips::Bits SureTrips::known(ValueId value, size_t trip, int depth) const {
    const Instr& instr = at(value);
    if (instr.op == Op::kConst) return instr.bits;
    if (value < loop_ || depth == 0 || !spend(1)) return std::nullopt;
    if (is_variable(value)) {
        const auto found = trips_[trip].counters.find(instr.a);
        return found != trips_[trip].counters.end() ? Bits(found->second) : std::nullopt;
    }
    if (!is_arithmetic(instr.op)) return std::nullopt;
    std::array<Bits, 3> args;
    for (size_t i = 0; i < instr.args.size(); ++i)
        args[i] = known(instr.args[i], trip, depth - 1);
    return evaluate(stage_, instr, args);
}

/// Returns by how much an integer changes from each of the iterations below `end` to the next,
/// modulo 2^32; nothing if that differs or is unknown.
SureTrips::Bits SureTrips::stride(ValueId value, size_t end, int depth) const {
    const Instr& instr = at(value);
    if (value < loop_ || instr.op == Op::kConst) return 0;
    const bool is_integer = instr.type == ir::Type::kInt || instr.type == ir::Type::kUint;
    if (depth == 0 || !is_integer) return std::nullopt;
    if (is_variable(value)) {
        Bits out;
        for (size_t trip = 1; trip < end; ++trip) {
            const Bits from = known(value, trip - 1, 1);
            const Bits to = known(value, trip, 1);
            if (!from || !to || (out && *out != *to - *from)) return std::nullopt;
            out = *to - *from;
        }
        return out;
    }
    if (instr.op != Op::kAdd && instr.op != Op::kSub && instr.op != Op::kMul) return std::nullopt;
    const Bits a = stride(instr.args[0], end, depth - 1);
    const Bits b = stride(instr.args[1], end, depth - 1);
    if (!a || !b) return std::nullopt;
    if (instr.op == Op::kAdd) return *a + *b;
    if (instr.op == Op::kSub) return *a - *b;
    if (*a == 0 && *b == 0) return 0;
    for (const size_t side : {0, 1}) {
        const Instr& factor = at(instr.args[side]);
        if (factor.op == Op::kConst) return factor.bits * (side == 0 ? *b : *a);
    }
    return std::nullopt;
}

/// Returns the value of `value` in an iteration where `facts` hold as a value from before the loop;
/// kNoValue if there is none.
ValueId SureTrips::exactly(ValueId value, size_t trip, int depth, const Facts& facts,
                           Emitter* emit) const {
    value = chosen(value, facts);
    if (const Bits bits = known(value, trip, depth)) return emit->constant(at(value).type, *bits);
    const Instr instr = at(value);  // a copy, since emitting reallocates
    if (value < loop_) return value;
    // A kernel's argument; placeholders differ between iterations.
    if (instr.op == Op::kInput && instr.kind >= 0 && instr.args.empty()) {
        return emit->input(instr.type, instr.kind, instr.a, instr.b);
    }
    const bool readable = is_arithmetic(instr.op) && instr.op != Op::kSelect;
    if (depth == 0 || !readable || !spend(kFormula)) return ir::kNoValue;
    std::vector<ValueId> args;
    for (const ValueId arg : instr.args) {
        args.push_back(exactly(arg, trip, depth - 1, facts, emit));
        if (args.back() == ir::kNoValue) return ir::kNoValue;
    }
    if (instr.op == Op::kConvert) return emit->convert(args[0], instr.type);
    if (instr.op == Op::kBitCast) return emit->bit_cast(args[0], instr.type);
    if (instr.op == Op::kAnd) return emit->logical_and(args[0], args[1]);
    if (instr.op == Op::kOr) return emit->logical_or(args[0], args[1]);
    if (instr.op == Op::kAdd && instr.type != ir::Type::kFloat) {
        // Shorter formulas are analysed further out.
        if (emit->is_zero(args[1])) return args[0];
        if (emit->is_zero(args[0])) return args[1];
    }
    return args.size() == 1 ? emit->unary(instr.op, args[0])
                            : emit->binary(instr.op, args[0], args[1]);
}

/// Returns a condition from before the loop without which `value` does not hold in an iteration,
/// given that it implies `facts`.
ValueId SureTrips::at_most(ValueId value, size_t trip, int depth, const Facts& facts,
                           Emitter* emit) const {
    const Instr instr = at(value);
    if (value >= loop_ && depth > 0 && instr.op == Op::kAnd) {
        const ValueId a = at_most(instr.args[0], trip, depth - 1, facts, emit);
        return emit->logical_and(a, at_most(instr.args[1], trip, depth - 1, facts, emit));
    }
    const ValueId same = exactly(value, trip, depth, facts, emit);
    return same != ir::kNoValue ? same : emit->constant(true);
}

/// Returns a condition from before the loop under which `value` holds in an iteration. Facts in
/// `by_trips` hold if an earlier iteration established them.
ValueId SureTrips::at_least(ValueId value, size_t trip, int depth, const ByTrips& by_trips,
                            Emitter* emit) const {
    if (const Bits bits = known(value, trip, depth)) return emit->constant(*bits != 0);
    if (depth == 0 || !spend(kFormula)) return emit->constant(false);
    const Instr instr = at(value);
    if (const auto earlier = by_trips.find(value); earlier != by_trips.end()) {
        const ValueId before = instr.op == Op::kOr ? instr.args[0] : emit->constant(false);
        return emit->logical_or(before, some_gives(earlier->second, trip, true, emit));
    }
    const auto part = [&](size_t i) {
        return at_least(instr.args[i], trip, depth - 1, by_trips, emit);
    };
    if (value >= loop_ && instr.op == Op::kAnd) return emit->logical_and(part(0), part(1));
    if (instr.op == Op::kOr) return emit->logical_or(part(0), part(1));
    if (value >= loop_ && instr.op == Op::kSelect) {
        const ValueId test = exactly(instr.args[0], trip, depth - 1, {}, emit);
        if (test == ir::kNoValue) return emit->logical_and(part(1), part(2));
        return emit->select(test, part(1), part(2));
    }
    const ValueId same = exactly(value, trip, depth, {}, emit);
    return same != ir::kNoValue ? same : emit->constant(false);
}

/// Returns a condition from before the loop under which an iteration below `end` has a value in a
/// window; kNoValue if none is known.
ValueId SureTrips::some_is_in(const Window& window, size_t end, bool all_ran, Emitter* emit) const {
    if (known(window.value, 0, kDepth)) {
        const auto found = trips_where_.lower_bound({window.value, window.lo});
        if (found == trips_where_.end() || found->first.first != window.value) return ir::kNoValue;
        const size_t trip = found->second.front();
        if (found->first.second > window.hi || trip >= end) return ir::kNoValue;
        return all_ran ? emit->constant(true) : trips_[trip].sure_if;
    }
    if (!all_ran) end = std::min(end, certain_);
    const Bits change = end < 2 ? std::nullopt : stride(window.value, end, kDepth);
    if (!change || *change == 0) return ir::kNoValue;
    const bool up = ir::as_int(*change) > 0;
    const int64_t step = std::abs(int64_t{ir::as_int(*change)});
    // Steps that are longer than the window may pass over it.
    const bool is_one = window.lo == window.hi;
    if (!is_one && window.hi - window.lo + 1 < step) return ir::kNoValue;
    const ValueId first = exactly(window.value, 0, kDepth, {}, emit);
    if (first == ir::kNoValue) return ir::kNoValue;
    // Values between the first one and the window do not wrap.
    const int64_t way = step * static_cast<int64_t>(end - 1);
    const auto [least, greatest] = range(window.value);
    const auto number = [&](int64_t value) {
        return emit->constant(at(first).type, static_cast<uint32_t>(value));
    };
    const int64_t lo = up ? window.lo - way : window.lo;
    const int64_t hi = up ? window.hi : window.hi + way;
    ValueId in_reach = emit->constant(true);
    if (hi < greatest) in_reach = emit->binary(Op::kLe, first, number(hi));
    if (lo > least) {
        in_reach = emit->logical_and(in_reach, emit->binary(Op::kGe, first, number(lo)));
    }
    if (!is_one || step == 1) return in_reach;
    const ValueId by = number(step);
    const ValueId met = emit->binary(Op::kEq, emit->binary(Op::kMod, first, by),
                                     emit->binary(Op::kMod, number(window.lo), by));
    return emit->logical_and(in_reach, met);
}

ValueId SureTrips::some_gives(ValueId fact, size_t end, bool all_ran, Emitter* emit) const {
    ValueId out = emit->constant(false);
    bool ends = true;
    for (const auto& [condition, window] : windows(fact, {}, kDepth)) {
        const ValueId found = some_is_in(window, end, all_ran, emit);
        if (found == ir::kNoValue) continue;
        out = emit->logical_or(out, found);
        if (emit->is_true(out)) return out;
        ends = false;
    }
    for (const size_t trip : candidates(fact, end, ends)) {
        const ValueId gives = at_least(fact, trip, kDepth, {}, emit);
        const ValueId runs = all_ran ? emit->constant(true) : trips_[trip].sure_if;
        out = emit->logical_or(out, emit->logical_and(runs, gives));
        if (emit->is_true(out)) break;
    }
    return out;
}

ValueId SureTrips::some_gives(ValueId fact, Emitter* emit) const {
    return some_gives(fact, sure_, false, emit);
}

/// Returns false if the proof is given up. If an iteration runs, all earlier ones ran to their end.
/// `where` holds in this one.
bool SureTrips::leaves(const DoubtfulRead::Alternative& alternative, size_t trip,
                       const std::vector<ValueId>& where, const ByTrips& by_trips, Emitter* emit,
                       DoubtfulRead* left) {
    std::vector<ValueId> here = where;
    here.push_back(at_most(alternative.condition, trip, kDepth, {}, emit));
    std::vector<ValueId> open;
    for (const ValueId assigned : alternative.assigned) {
        const ValueId fact = at_least(assigned, trip, kDepth, by_trips, emit);
        if (emit->is_true(fact) || emit->implies(here.back(), fact)) continue;
        if (!proves(here, fact)) open.push_back(fact);
        if (!spend(0)) return false;
    }
    if (open.empty()) return true;
    ValueId condition = trips_[trip].may_if;
    for (const ValueId part : {where.back(), here.back()})
        condition = emit->logical_and(condition, part);
    left->alternatives.push_back({condition, std::move(open)});
    return left->alternatives.size() <= kMaxLeft;
}

std::optional<DoubtfulRead> SureTrips::left_in_doubt(const DoubtfulRead& read,
                                                     const std::vector<ValueId>& given,
                                                     const ByTrips& by_trips, Emitter* emit) {
    if (!all_ || trips_.size() * read.alternatives.size() > kMaxAlternatives) return std::nullopt;
    DoubtfulRead left = {read.symbol, read.span, read.reached, {}};
    for (size_t trip = 0; trip < trips_.size(); ++trip) {
        if (known(read.reached, trip, kDepth) == Bits(0)) continue;
        std::vector<ValueId> where = given;
        where.push_back(trips_[trip].may_if);
        where.push_back(at_most(read.reached, trip, kDepth, {}, emit));
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
            if (!leaves(alternative, trip, where, by_trips, emit, &left)) return std::nullopt;
        }
    }
    return left;
}

}  // namespace openfab::translate
