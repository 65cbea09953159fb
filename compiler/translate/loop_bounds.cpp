// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/loop_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "compiler/ir/arithmetic.h"

namespace openfab::translate {

namespace {

using ir::Instr;
using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr int kBoundDepth = 24;  // of expressions that are analysed
constexpr double kIntEnd = 2147483648.0;
constexpr double kUintEnd = 4294967296.0;
// A float counter whose step is below this fraction of its magnitude may stall.
constexpr double kLeastFloatStep = 1.0 / 1048576.0;

constexpr double kFloatRounding = 1.0 / 8388608.0;
constexpr double kForever = std::numeric_limits<double>::infinity();

/// lo <= value <= hi, and no NaN. Ends are exact: 32-bit values and their sums are doubles.
struct Range {
    double lo = 0;
    double hi = 0;
};

class Analysis {
  public:
    Analysis(const ir::Stage& stage, ValueId loop, const std::vector<ValueId>& next)
        : stage_(stage), loop_(loop), next_(next) {}

    double run(ValueId again, const std::vector<ValueId>& tests) {
        for (const ValueId test : tests)
            assume(test, true);
        assume(again, true);
        // The condition is a conjunction: one part that ends the loop is enough.
        double trips = kForever;
        for (const auto& [value, truth] : facts_)
            trips = std::min(trips, trips_while(value, truth));
        return trips;
    }

  private:
    const Instr& at(ValueId id) const { return stage_.instrs[id]; }

    /// Records the consequences of `value` being `truth`.
    void assume(ValueId value, bool truth) {
        const Instr& instr = at(value);
        if (instr.op == Op::kNot) return assume(instr.args[0], !truth);
        if (instr.op == (truth ? Op::kAnd : Op::kOr)) {
            assume(instr.args[0], truth);
            assume(instr.args[1], truth);
            return;
        }
        facts_.emplace(value, truth);
    }

    static Op opposite(Op op) {
        if (op == Op::kLt) return Op::kGe;
        if (op == Op::kLe) return Op::kGt;
        return op == Op::kGt ? Op::kLe : Op::kLt;
    }
    static Op mirrored(Op op) {
        if (op == Op::kLt) return Op::kGt;
        if (op == Op::kLe) return Op::kGe;
        return op == Op::kGt ? Op::kLt : Op::kLe;
    }

    /// Returns how often the loop runs at most if a condition must have this truth.
    double trips_while(ValueId value, bool truth) const {
        const Instr& instr = at(value);
        if (!ir::is_order(instr.op)) return kForever;
        // With a NaN both a comparison and its opposite are false.
        if (!truth && at(instr.args[0]).type == Type::kFloat) return kForever;
        const Op op = truth ? instr.op : opposite(instr.op);
        double trips = kForever;
        for (size_t k = 0; k < next_.size(); ++k) {
            trips = std::min(trips, trips_until(k, instr.args[0], op, instr.args[1]));
            trips = std::min(trips, trips_until(k, instr.args[1], mirrored(op), instr.args[0]));
        }
        return trips;
    }

    /// Returns after how many iterations at most variable k drives x past the bound of
    /// `x op bound`.
    double trips_until(size_t k, ValueId x, Op op, ValueId bound) const {
        const ValueId var = loop_ + 1 + static_cast<ValueId>(k);
        if (at(x).type != at(var).type) return kForever;
        const std::optional<Range> first = range(at(var).args[1], kBoundDepth);
        const std::optional<Range> end = range(bound, kBoundDepth);
        const std::optional<Range> ahead = offset(x, var, kBoundDepth);
        const std::optional<Range> step = offset(next_[k], var, kBoundDepth);
        if (!first || !end || !ahead || !step) return kForever;
        const bool up = op == Op::kLt || op == Op::kLe;
        // Mirrors a loop that counts down.
        const Range f = up ? *first : Range{-first->hi, -first->lo};
        const Range a = up ? *ahead : Range{-ahead->hi, -ahead->lo};
        const Range s = up ? *step : Range{-step->hi, -step->lo};
        const double last = up ? end->hi : -end->lo;
        if (!(s.lo > 0)) return kForever;
        const double trips = (last - f.lo - a.lo) / s.lo;
        if (at(var).type == Type::kFloat) {
            const double size = std::max({std::fabs(f.lo), std::fabs(f.hi), std::fabs(last)}) +
                                std::fabs(a.lo) + s.hi;
            return s.lo > size * kLeastFloatStep ? 2 * trips + 2 : kForever;
        }
        const bool strict = op == Op::kLt || op == Op::kGt;
        const double passes = std::max(f.hi, last - (strict ? 1 : 0) - a.lo);
        if (wraps(at(var).type, up, passes + s.hi + std::max(a.hi, 0.0))) return kForever;
        return trips + 2;
    }

    /// Returns whether a counter that reaches `farthest` (mirrored, if it counts down) overflows
    /// its type.
    static bool wraps(Type type, bool up, double farthest) {
        if (type == Type::kUint) return up ? farthest >= kUintEnd : -farthest < 0;
        return farthest >= kIntEnd;
    }

    /// Returns value - var, wherever the facts hold.
    std::optional<Range> offset(ValueId value, ValueId var, int depth) const {
        if (value == var) return Range{0, 0};
        if (depth == 0 || value < loop_) return std::nullopt;
        const Instr& instr = at(value);
        switch (instr.op) {
            case Op::kAdd:
                if (auto sum = plus(instr.args[0], instr.args[1], var, depth)) return sum;
                return plus(instr.args[1], instr.args[0], var, depth);
            case Op::kSub: {
                const auto from = offset(instr.args[0], var, depth - 1);
                const auto by = range(instr.args[1], depth - 1);
                if (!from || !by) return std::nullopt;
                return Range{from->lo - by->hi, from->hi - by->lo};
            }
            case Op::kSelect: {
                const std::optional<bool> known = truth(instr.args[0]);
                if (known) return offset(instr.args[*known ? 1 : 2], var, depth - 1);
                const auto yes = offset(instr.args[1], var, depth - 1);
                const auto no = offset(instr.args[2], var, depth - 1);
                if (!yes || !no) return std::nullopt;
                return Range{std::min(yes->lo, no->lo), std::max(yes->hi, no->hi)};
            }
            case Op::kMul:
            case Op::kDiv:
            case Op::kMod:
            case Op::kNeg:
            case Op::kConvert:
                OPENFAB_IR_CASES(LEAVES)
                OPENFAB_IR_CASES(BITS)
                OPENFAB_IR_CASES(LOGIC)
                OPENFAB_IR_CASES(COMPARISONS)
                OPENFAB_IR_CASES(EXTREMES)
                OPENFAB_IR_CASES(FLOAT_PARTS)
                OPENFAB_IR_CASES(LOOKUPS)
                OPENFAB_IR_CASES(CONTROL)
                OPENFAB_IR_CASES(FUNCTIONS)
                OPENFAB_IR_CASES(DERIVATIVES)
                break;
        }
        return std::nullopt;
    }
    std::optional<Range> plus(ValueId a, ValueId b, ValueId var, int depth) const {
        const auto from = offset(a, var, depth - 1);
        const auto by = from ? range(b, depth - 1) : std::nullopt;
        if (!by) return std::nullopt;
        return Range{from->lo + by->lo, from->hi + by->hi};
    }

    /// Returns the value of a condition that the facts decide.
    std::optional<bool> truth(ValueId condition) const {
        const auto fact = facts_.find(condition);
        if (fact != facts_.end()) return fact->second;
        const Instr& instr = at(condition);
        if (instr.op == Op::kNot) {
            const std::optional<bool> inner = truth(instr.args[0]);
            if (inner) return !*inner;
        }
        if (instr.op == Op::kOr || instr.op == Op::kAnd) {
            const bool settles = instr.op == Op::kOr;
            const std::optional<bool> a = truth(instr.args[0]);
            const std::optional<bool> b = truth(instr.args[1]);
            if ((a && *a == settles) || (b && *b == settles)) return settles;
            if (a && b) return !settles;
        }
        return std::nullopt;
    }

    static std::optional<Range> within(Type type, const Range& range) {
        if (std::isnan(range.lo) || std::isnan(range.hi)) return std::nullopt;
        if (type == Type::kInt && (range.lo < -kIntEnd || range.hi >= kIntEnd)) return std::nullopt;
        if (type == Type::kUint && (range.lo < 0 || range.hi >= kUintEnd)) return std::nullopt;
        return range;
    }

    static std::optional<Range> constant(const Instr& instr) {
        double value = 0;
        switch (instr.type) {
            case Type::kBool:
                return std::nullopt;
            case Type::kInt:
                value = ir::as_int(instr.bits);
                break;
            case Type::kUint:
                value = instr.bits;
                break;
            case Type::kFloat:
                value = ir::as_float(instr.bits);
                if (!std::isfinite(value)) return std::nullopt;
        }
        return Range{value, value};
    }

    std::optional<Range> range(ValueId value, int depth) const {
        const Instr& instr = at(value);
        if (instr.op == Op::kConst) return constant(instr);
        if (depth == 0 || instr.args.empty() || instr.type == Type::kBool) return std::nullopt;
        const bool is_float = instr.type == Type::kFloat;
        const auto arg = [&](size_t k) { return range(instr.args[k], depth - 1); };
        switch (instr.op) {
            case Op::kMin:
            case Op::kMax:
                return extreme(instr, depth);
            case Op::kPick: {
                std::optional<Range> all = arg(1);
                for (size_t k = 2; k < instr.args.size() && all; ++k) {
                    const std::optional<Range> one = arg(k);
                    if (!one) return std::nullopt;
                    *all = {std::min(all->lo, one->lo), std::max(all->hi, one->hi)};
                }
                return all;
            }
            case Op::kSelect: {
                const auto a = chosen(instr, true, depth);
                const auto b = chosen(instr, false, depth);
                if (!a || !b) return std::nullopt;
                return Range{std::min(a->lo, b->lo), std::max(a->hi, b->hi)};
            }
            case Op::kAdd:
            case Op::kSub: {
                const auto a = arg(0);
                const auto b = arg(1);
                if (!a || !b || is_float) return std::nullopt;
                if (instr.op == Op::kAdd) {
                    return within(instr.type, {a->lo + b->lo, a->hi + b->hi});
                }
                return within(instr.type, {a->lo - b->hi, a->hi - b->lo});
            }
            case Op::kMul:
                return is_float ? std::nullopt : product(instr.type, arg(0), arg(1));
            case Op::kMod:
            case Op::kBitAnd:
                return is_float ? std::nullopt : remainder(instr.op, arg(0), arg(1));
            case Op::kFloor:
            case Op::kCeil:
            case Op::kRound:
            case Op::kTrunc: {
                const auto a = arg(0);
                if (!a) return std::nullopt;
                return Range{std::floor(a->lo), std::ceil(a->hi)};
            }
            case Op::kConvert:
                return converted(instr, depth);
            case Op::kLoopVar:
                return is_float ? std::nullopt : counter(value, depth);
            case Op::kDiv:
            case Op::kNeg:
            case Op::kBitOr:
            case Op::kBitXor:
            case Op::kBitNot:
            case Op::kShl:
            case Op::kShr:
            case Op::kAbs:
            case Op::kSqrt:
            case Op::kIsNan:
            case Op::kSample:
            case Op::kSampleBound:
            case Op::kBitCast:
            case Op::kTable:
            case Op::kLoop:
            case Op::kLoopEnd:
            case Op::kLoopResult:
            case Op::kQuery:
            case Op::kQueryResult:
            case Op::kPrintf:
                OPENFAB_IR_CASES(LEAVES)
                OPENFAB_IR_CASES(LOGIC)
                OPENFAB_IR_CASES(COMPARISONS)
                OPENFAB_IR_CASES(FUNCTIONS)
                OPENFAB_IR_CASES(DERIVATIVES)
                break;
        }
        return std::nullopt;
    }

    static Range all_of(Type type) {
        return type == Type::kUint ? Range{0, kUintEnd - 1} : Range{-kIntEnd, kIntEnd - 1};
    }

    /// Cuts the range of an integer to what `fact` says if it compares it; returns whether it does.
    bool cut(ValueId value, ValueId fact, bool truth, int depth, Range* out) const {
        const Instr& test = at(fact);
        if (!ir::is_order(test.op)) return false;
        const bool left = test.args[0] == value;
        if (!left && test.args[1] != value) return false;
        const std::optional<Range> other = range(test.args[left ? 1 : 0], depth - 1);
        if (!other) return false;
        const Op op = truth ? test.op : opposite(test.op);
        const Op from_here = left ? op : mirrored(op);
        if (from_here == Op::kLt) out->hi = std::min(out->hi, other->hi - 1);
        if (from_here == Op::kLe) out->hi = std::min(out->hi, other->hi);
        if (from_here == Op::kGt) out->lo = std::max(out->lo, other->lo + 1);
        if (from_here == Op::kGe) out->lo = std::max(out->lo, other->lo);
        return true;
    }

    /// The range of a counter of an enclosing loop, from the tests that compare it.
    std::optional<Range> counter(ValueId value, int depth) const {
        Range out = all_of(at(value).type);
        bool known = false;
        for (const auto& [fact, truth] : facts_)
            known |= cut(value, fact, truth, depth, &out);
        return known && out.lo <= out.hi ? std::optional<Range>(out) : std::nullopt;
    }

    /// The range of a value that a Select chooses, where it chooses it: `n` is at most 10 in
    /// `n > 10 ? 10 : n`.
    std::optional<Range> chosen(const Instr& select, bool first, int depth) const {
        const ValueId value = select.args[first ? 1 : 2];
        const std::optional<Range> known = range(value, depth - 1);
        if (select.type == Type::kFloat) return known;
        Range out = known ? *known : all_of(select.type);
        const bool compared = cut(value, select.args[0], first, depth, &out);
        return (known || compared) && out.lo <= out.hi ? std::optional<Range>(out) : known;
    }

    /// min(a, b) = a < b ? a : b gives b where a is NaN, and is never above b if b is not NaN.
    std::optional<Range> extreme(const Instr& instr, int depth) const {
        const auto a = range(instr.args[0], depth - 1);
        const auto b = range(instr.args[1], depth - 1);
        const bool is_min = instr.op == Op::kMin;
        if (a && b) {
            if (is_min) return Range{std::min(a->lo, b->lo), std::min(a->hi, b->hi)};
            return Range{std::max(a->lo, b->lo), std::max(a->hi, b->hi)};
        }
        const bool is_float = instr.type == Type::kFloat;
        if (!b && (!a || is_float)) return std::nullopt;
        const Range& known = b ? *b : *a;
        const double inf = std::numeric_limits<double>::infinity();
        const double lowest = is_float ? -inf : instr.type == Type::kUint ? 0 : -kIntEnd;
        const double highest =
            is_float ? inf : (instr.type == Type::kUint ? kUintEnd : kIntEnd) - 1;
        return is_min ? Range{lowest, known.hi} : Range{known.lo, highest};
    }

    static std::optional<Range> product(Type type, const std::optional<Range>& a,
                                        const std::optional<Range>& b) {
        if (!a || !b) return std::nullopt;
        const auto ends = std::minmax({a->lo * b->lo, a->lo * b->hi, a->hi * b->lo, a->hi * b->hi});
        return within(type, {ends.first, ends.second});
    }

    static std::optional<Range> remainder(Op op, const std::optional<Range>& a,
                                          const std::optional<Range>& b) {
        if (op == Op::kBitAnd) {
            const bool left = a && a->lo >= 0;
            const bool right = b && b->lo >= 0;
            if (!left && !right) return std::nullopt;
            return Range{0, left && right ? std::min(a->hi, b->hi) : left ? a->hi : b->hi};
        }
        if (!b || b->lo < 0 || b->hi < 1) return std::nullopt;
        return Range{a && a->lo >= 0 ? 0 : 1 - b->hi, b->hi - 1};
    }

    std::optional<Range> converted(const Instr& instr, int depth) const {
        const Type from = at(instr.args[0]).type;
        if (from == Type::kBool) return Range{0, 1};
        const auto a = range(instr.args[0], depth - 1);
        if (!a) return std::nullopt;
        if (instr.type == Type::kFloat) {
            const auto rounding = [](double x) { return std::fabs(x) * kFloatRounding; };
            return Range{a->lo - rounding(a->lo), a->hi + rounding(a->hi)};
        }
        const double lowest = instr.type == Type::kUint ? 0 : -kIntEnd;
        const double highest = (instr.type == Type::kUint ? kUintEnd : kIntEnd) - 1;
        if (from != Type::kFloat) return within(instr.type, *a);
        return Range{std::trunc(std::clamp(a->lo, lowest, highest)),
                     std::trunc(std::clamp(a->hi, lowest, highest))};
    }

    const ir::Stage& stage_;
    const ValueId loop_;
    const std::vector<ValueId>& next_;
    std::map<ValueId, bool> facts_;  ///< conditions whose value is known where the loop continues
};

}  // namespace

double most_trips(const ir::Stage& stage, ValueId loop, ValueId again,
                  const std::vector<ValueId>& next, const std::vector<ValueId>& tests) {
    return Analysis(stage, loop, next).run(again, tests);
}

}  // namespace openfab::translate
