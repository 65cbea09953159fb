// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/proof.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

constexpr size_t kMaxNodes = size_t{1} << 14;

bool is_formula(const ir::Instr& instr) {
    switch (instr.op) {
        case Op::kAnd:
        case Op::kOr:
        case Op::kNot:
            return true;
        case Op::kSelect:
            return instr.type == ir::Type::kBool;
        default:
            return false;
    }
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
        const uint32_t top = std::min({nodes_[test].atom, nodes_[yes].atom, nodes_[no].atom});
        const Node lo =
            if_then_else(side(test, top, false), side(yes, top, false), side(no, top, false));
        const Node hi =
            if_then_else(side(test, top, true), side(yes, top, true), side(no, top, true));
        const Node out = make(top, lo, hi);
        results_.emplace(key, out);
        return out;
    }

    Node negate(Node a) { return if_then_else(a, kFalse, kTrue); }

  private:
    static constexpr uint32_t kLeaf = ~uint32_t{0};
    struct Decision {
        uint32_t atom;
        Node lo, hi;
    };
    using Key = std::tuple<uint32_t, uint32_t, uint32_t>;

    Node side(Node node, uint32_t atom, bool holds) const {
        const Decision& d = nodes_[node];
        if (d.atom != atom) return node;
        return holds ? d.hi : d.lo;
    }

    Node make(uint32_t atom, Node lo, Node hi) {
        if (lo == hi) return lo;
        const auto [known, fresh] =
            unique_.emplace(Key{atom, lo, hi}, static_cast<Node>(nodes_.size()));
        if (fresh) nodes_.push_back({atom, lo, hi});
        return known->second;
    }

    Node atom(Op op, ValueId a, ValueId b) {
        const auto number = static_cast<uint32_t>(atoms_.size());
        return make(atoms_.emplace(std::tuple{op, a, b}, number).first->second, kFalse, kTrue);
    }

    /// `a >= b` is the opposite of `a < b`, but for floats, of which one may be NaN.
    Node comparison(Op op, ValueId a, ValueId b) {
        const bool total = stage_.instrs[a].type != ir::Type::kFloat;
        switch (op) {
            case Op::kNe:
                return negate(atom(Op::kEq, a, b));
            case Op::kGt:
                return atom(Op::kLt, b, a);
            case Op::kGe:
                return total ? negate(atom(Op::kLt, a, b)) : atom(Op::kLe, b, a);
            case Op::kLe:
                return total ? negate(atom(Op::kLt, b, a)) : atom(Op::kLe, a, b);
            default:
                return atom(op, a, b);
        }
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
            case Op::kEq:
            case Op::kNe:
            case Op::kLt:
            case Op::kLe:
            case Op::kGt:
            case Op::kGe:
                return comparison(instr.op, instr.args[0], instr.args[1]);
            default:
                return atom(instr.op, id, id);
        }
    }

    const ir::Stage& stage_;
    std::vector<Decision> nodes_;
    std::map<Key, Node> unique_;
    std::map<Key, Node> results_;
    std::map<std::tuple<Op, ValueId, ValueId>, uint32_t> atoms_;
    std::map<ValueId, Node> built_;
};

}  // namespace

bool follows(const ir::Stage& stage, const std::vector<ValueId>& given, ValueId fact) {
    Diagram diagram(stage);
    Diagram::Node holds = diagram.build(fact);
    for (const ValueId condition : given)
        holds = diagram.if_then_else(diagram.build(condition), holds, Diagram::kTrue);
    return holds == Diagram::kTrue && !diagram.too_large();
}

}  // namespace openfab::translate
