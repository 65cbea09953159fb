// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/proof.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "compiler/ir/arithmetic.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

constexpr size_t kMaxNodes = size_t{1} << 14;
constexpr int kProofDepth = 8;  // of nested min and max

bool is_formula(const ir::Instr& instr) {
    if (instr.op == Op::kSelect) return instr.type == ir::Type::kBool;
    return ir::family(instr.op) == ir::Family::kLogic;
}

/// Ordered binary decision diagrams (Bryant 1986): equal formulas are the same node, so that a
/// tautology is the node `kTrue`.
class Diagram {
  public:
    using Node = uint32_t;
    static constexpr Node kFalse = 0;
    static constexpr Node kTrue = 1;

    explicit Diagram(const ir::Stage& stage) : stage_(stage) {
        nodes_ = {{kLeaf, kFalse, kFalse}, {kLeaf, kTrue, kTrue}};
    }

    bool too_large() const { return nodes_.size() > kMaxNodes; }

    /// Arguments precede their instruction, so ascending order needs no recursion.
    Node build(ValueId value) {
        std::set<ValueId> needed;
        std::vector<ValueId> open = {value};
        while (!open.empty()) {
            const ValueId id = open.back();
            open.pop_back();
            if (built_.count(id) != 0 || !needed.insert(id).second) continue;
            const ir::Instr& instr = stage_.instrs[id];
            if (is_formula(instr)) open.insert(open.end(), instr.args.begin(), instr.args.end());
        }
        for (const ValueId id : needed)
            built_[id] = node_of(id);
        return built_[value];
    }

    Node if_then_else(Node test, Node yes, Node no) {
        if (test == kTrue || yes == no) return yes;
        if (test == kFalse) return no;
        if (too_large()) return kFalse;
        const Key key{test, yes, no};
        if (const auto known = results_.find(key); known != results_.end()) return known->second;
        const Atom top = std::min({nodes_[test].atom, nodes_[yes].atom, nodes_[no].atom});
        const Node lo =
            if_then_else(side(test, top, false), side(yes, top, false), side(no, top, false));
        const Node hi =
            if_then_else(side(test, top, true), side(yes, top, true), side(no, top, true));
        const Node out = make(top, lo, hi);
        results_.emplace(key, out);
        return out;
    }

    Node negate(Node a) { return if_then_else(a, kFalse, kTrue); }

    /// Returns what the numbers in comparisons of integers say: a value below one of them is below
    /// the greater ones.
    Node order_of_numbers() {
        Node out = kTrue;
        for (const auto& [value, numbers] : numbers_) {
            for (auto number = numbers.rbegin(); std::next(number) != numbers.rend(); ++number) {
                const Node lower = decide({value, 0, *std::next(number)});
                const Node greater = decide({value, 0, *number});
                out = if_then_else(if_then_else(lower, greater, kTrue), out, kFalse);
            }
        }
        return out;
    }

  private:
    /// `value` below `number`; or, where `numbered`, the atom of this number. The order keeps the
    /// comparisons of one value together.
    struct Atom {
        ValueId value = 0;
        int numbered = 0;
        int64_t number = 0;
        bool operator==(const Atom&) const = default;
        bool operator<(const Atom& other) const {
            return std::tie(value, numbered, number) <
                   std::tie(other.value, other.numbered, other.number);
        }
    };
    static constexpr Atom kLeaf = {ir::kNoValue, 0, 0};
    struct Decision {
        Atom atom;
        Node lo, hi;
    };
    using Key = std::tuple<uint32_t, uint32_t, uint32_t>;

    Node side(Node node, const Atom& atom, bool holds) const {
        const Decision& d = nodes_[node];
        if (d.atom != atom) return node;
        return holds ? d.hi : d.lo;
    }

    Node make(const Atom& atom, Node lo, Node hi) {
        if (lo == hi) return lo;
        const auto [known, fresh] =
            unique_.emplace(std::tuple{atom, lo, hi}, static_cast<Node>(nodes_.size()));
        if (fresh) nodes_.push_back({atom, lo, hi});
        return known->second;
    }

    Node decide(const Atom& atom) { return make(atom, kFalse, kTrue); }

    Node atom(Op op, ValueId a, ValueId b) {
        const auto number = static_cast<int64_t>(atoms_.size());
        const auto known = atoms_.emplace(std::tuple{op, a, b}, number).first;
        return decide({std::max(a, b), 1, known->second});
    }

    /// Returns the number of a constant integer.
    std::optional<int64_t> integer(ValueId value) const {
        const ir::Instr& instr = stage_.instrs[value];
        if (instr.op != Op::kConst) return std::nullopt;
        if (instr.type == ir::Type::kInt) return ir::as_int(instr.bits);
        return instr.type == ir::Type::kUint ? std::optional<int64_t>(instr.bits) : std::nullopt;
    }

    /// Returns when an integer is below a number.
    Node below(ValueId value, int64_t number, int depth = kProofDepth) {
        const ir::Instr& instr = stage_.instrs[value];
        const bool is_int = instr.type == ir::Type::kInt;
        if (number <= (is_int ? std::numeric_limits<int32_t>::min() : 0)) return kFalse;
        if (number >
            (is_int ? std::numeric_limits<int32_t>::max() : std::numeric_limits<uint32_t>::max())) {
            return kTrue;
        }
        if (const auto known = integer(value)) return *known < number ? kTrue : kFalse;
        const bool extreme = instr.op == Op::kMin || instr.op == Op::kMax;
        if (extreme && depth > 0) {
            const Node a = below(instr.args[0], number, depth - 1);
            const Node b = below(instr.args[1], number, depth - 1);
            return instr.op == Op::kMin ? if_then_else(a, kTrue, b) : if_then_else(a, b, kFalse);
        }
        if (instr.op == Op::kMod || instr.op == Op::kBitAnd) {
            // At most the mask; less than the divisor.
            const auto right = integer(instr.args[1]);
            const int64_t end = instr.op == Op::kMod ? 0 : 1;
            if (right && *right >= 1 - end && number >= *right + end) return kTrue;
        }
        numbers_[value].insert(number);
        return decide({value, 0, number});
    }

    /// Comparisons of an integer with numbers become ones of a single form, so that they bear on
    /// each other.
    std::optional<Node> comparison_with_number(Op op, ValueId a, ValueId b) {
        const auto number = integer(b);
        if (!number) return std::nullopt;
        if (op == Op::kEq) return if_then_else(below(a, *number), kFalse, below(a, *number + 1));
        if (op == Op::kLt) return below(a, *number);
        if (op == Op::kLe) return below(a, *number + 1);
        return negate(below(a, op == Op::kGt ? *number + 1 : *number));
    }

    /// Returns whether floats `a < b` never: no min is greater than either side that is a number.
    bool is_never_less(ValueId a, ValueId b) const {
        const ir::Instr& left = stage_.instrs[a];
        const ir::Instr& right = stage_.instrs[b];
        if (left.op != Op::kConst || right.op != Op::kMin) return false;
        return std::any_of(right.args.begin(), right.args.end(), [&](ValueId arg) {
            const ir::Instr& side = stage_.instrs[arg];
            return side.op == Op::kConst && ir::as_float(left.bits) >= ir::as_float(side.bits);
        });
    }

    /// `a >= b` is the opposite of `a < b`, but for floats, of which one may be NaN.
    Node comparison(Op op, ValueId a, ValueId b) {
        if (op == Op::kNe) return negate(comparison(Op::kEq, a, b));
        if (op == Op::kGt) return comparison(Op::kLt, b, a);
        const bool total = stage_.instrs[a].type != ir::Type::kFloat;
        if (op == Op::kGe) {
            return total ? negate(comparison(Op::kLt, a, b)) : comparison(Op::kLe, b, a);
        }
        if (const auto node = comparison_with_number(op, a, b)) return *node;
        if (op == Op::kEq) {
            if (const auto node = comparison_with_number(op, b, a)) return *node;
            return atom(op, std::max(a, b), std::min(a, b));
        }
        if (integer(a)) return *comparison_with_number(op == Op::kLt ? Op::kGt : Op::kGe, b, a);
        if (op == Op::kLe) return total ? negate(comparison(Op::kLt, b, a)) : atom(op, a, b);
        return !total && is_never_less(a, b) ? kFalse : atom(op, a, b);
    }

    Node node_of(ValueId id) {
        const ir::Instr& instr = stage_.instrs[id];
        const auto arg = [&](size_t i) { return built_.at(instr.args[i]); };
        switch (instr.op) {
            case Op::kConst:
                return instr.bits != 0 ? kTrue : kFalse;
            case Op::kAnd:
                return if_then_else(arg(0), arg(1), kFalse);
            case Op::kOr:
                return if_then_else(arg(0), kTrue, arg(1));
            case Op::kNot:
                return negate(arg(0));
            case Op::kSelect:
                return if_then_else(arg(0), arg(1), arg(2));
                OPENFAB_IR_CASES(COMPARISONS)
                return comparison(instr.op, instr.args[0], instr.args[1]);
            case Op::kInput:
            case Op::kConvert:
                OPENFAB_IR_CASES(ARITHMETIC)
                OPENFAB_IR_CASES(BITS)
                OPENFAB_IR_CASES(EXTREMES)
                OPENFAB_IR_CASES(FLOAT_PARTS)
                OPENFAB_IR_CASES(LOOKUPS)
                OPENFAB_IR_CASES(CONTROL)
                OPENFAB_IR_CASES(FUNCTIONS)
                OPENFAB_IR_CASES(DERIVATIVES)
                break;
        }
        return atom(instr.op, id, id);
    }

    const ir::Stage& stage_;
    std::vector<Decision> nodes_;
    std::map<std::tuple<Atom, Node, Node>, Node> unique_;
    std::map<Key, Node> results_;
    std::map<std::tuple<Op, ValueId, ValueId>, int64_t> atoms_;
    std::map<ValueId, std::set<int64_t>> numbers_;  ///< that a value is compared with
    std::map<ValueId, Node> built_;
};

}  // namespace

bool follows(const ir::Stage& stage, const std::vector<ValueId>& given, ValueId fact) {
    Diagram diagram(stage);
    Diagram::Node holds = diagram.build(fact);
    for (const ValueId condition : given)
        holds = diagram.if_then_else(diagram.build(condition), holds, Diagram::kTrue);
    if (holds != Diagram::kTrue) {
        holds = diagram.if_then_else(diagram.order_of_numbers(), holds, Diagram::kTrue);
    }
    return holds == Diagram::kTrue && !diagram.too_large();
}

}  // namespace openfab::translate
