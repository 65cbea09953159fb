// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/path_condition.h"

#include <algorithm>
#include <utility>

namespace openfab::passes {

namespace {

using ir::Op;
using ir::ValueId;

/// Limit of the nodes of a stage's conditions. Diagrams may double with each variable; those of
/// fablets have tens of nodes.
constexpr size_t kMaxNodes = 1u << 14;

}  // namespace

Condition PathConditions::node(ValueId value, Condition if_true, Condition if_false) {
    if (if_true == if_false) return if_true;
    const auto [id, is_new] = unique_table_.try_emplace({value, if_true, if_false},
                                                        static_cast<Condition>(nodes_.size()));
    if (is_new) nodes_.push_back({value, if_true, if_false});
    return id->second;
}

/// `decides`: the dominating operand, kNever for `and`, kAlways for `or`.
Condition PathConditions::combine(Condition a, Condition b, Condition decides) {
    const Condition passes = decides == kNever ? kAlways : kNever;
    if (a == decides || b == decides) return decides;
    if (a == passes || a == b) return b;
    if (b == passes) return a;
    if (a > b) std::swap(a, b);
    const std::array<uint32_t, 3> key = {a, b, decides};
    if (const auto known = computed_table_.find(key); known != computed_table_.end())
        return known->second;
    if (nodes_.size() >= kMaxNodes) return kAlways;
    const Node x = nodes_[a], y = nodes_[b];
    const ValueId value = std::min(x.value, y.value);
    const auto side = [value](const Node& of, Condition self, Condition Node::*end) {
        return of.value == value ? of.*end : self;
    };
    const Condition if_true =
        combine(side(x, a, &Node::if_true), side(y, b, &Node::if_true), decides);
    const Condition if_false =
        combine(side(x, a, &Node::if_false), side(y, b, &Node::if_false), decides);
    return computed_table_[key] = node(value, if_true, if_false);
}

std::vector<bool> PathConditions::reached(Condition condition) const {
    std::vector<bool> out(nodes_.size(), false);
    out[condition] = true;
    // The ends of a node are made before it.
    for (size_t id = condition; id > kAlways; --id) {
        if (out[id]) out[nodes_[id].if_true] = out[nodes_[id].if_false] = true;
    }
    return out;
}

std::vector<ValueId> PathConditions::tested(Condition condition) const {
    const std::vector<bool> here = reached(condition);
    std::vector<ValueId> out;
    for (size_t id = kAlways + 1; id < nodes_.size(); ++id) {
        if (here[id]) out.push_back(nodes_[id].value);
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

ValueId PathConditions::write(Condition condition, const std::function<ValueId(ValueId)>& value,
                              ir::Builder* builder) const {
    const std::vector<bool> here = reached(condition);
    std::vector<ValueId> written(nodes_.size(), ir::kNoValue);
    for (size_t id = kAlways + 1; id <= condition; ++id) {
        if (!here[id]) continue;
        const auto [tested, if_true, if_false] = nodes_[id];
        const ValueId test = value(tested);
        const auto negated = [&] { return builder->emit(Op::kNot, {test}); };
        ValueId& out = written[id];
        if (if_true == kAlways) {
            out = if_false == kNever ? test : builder->emit(Op::kOr, {test, written[if_false]});
        } else if (if_false == kAlways) {
            out = if_true == kNever ? negated()
                                    : builder->emit(Op::kOr, {negated(), written[if_true]});
        } else if (if_true == kNever) {
            out = builder->emit(Op::kAnd, {negated(), written[if_false]});
        } else if (if_false == kNever) {
            out = builder->emit(Op::kAnd, {test, written[if_true]});
        } else {
            out = builder->select(test, written[if_true], written[if_false]);
        }
    }
    return written[condition];
}

}  // namespace openfab::passes
