// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/element_pattern.h"

#include <algorithm>
#include <utility>

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;
using Kind = ElementNode::Kind;

// Longer patterns are code, which kernels are for.
constexpr size_t kMostNodes = 200;

bool is_integer(Type type) {
    return type == Type::kInt || type == Type::kUint;
}

}  // namespace

bool is_element_load(const Instr& instr) {
    return instr.op == Op::kTable && instr.kind == OPENFAB_ARG_STATE;
}

ValueId emit_clamped(ValueId value, uint32_t first, uint32_t last, bool below, bool above,
                     ir::Builder* builder) {
    const Type type = builder->type(value);
    if (above) value = builder->binary(Op::kMin, value, builder->constant(type, last));
    if (below) value = builder->binary(Op::kMax, value, builder->constant(type, first));
    return value;
}

bool ElementPattern::find(std::span<const ValueId> elements) {
    count_ = elements.size();
    nodes_.clear();
    known_.clear();
    const std::optional<size_t> root = unify(Values(elements.begin(), elements.end()));
    root_ = root.value_or(0);
    return root.has_value();
}

std::optional<size_t> ElementPattern::unify(const Values& values) {
    const auto before = known_.find(values);
    if (before != known_.end()) return before->second;
    std::optional<size_t> out;
    if (std::optional<ElementNode> node = make(values); node && nodes_.size() < kMostNodes) {
        out = nodes_.size();
        nodes_.push_back(std::move(*node));
    }
    known_.emplace(values, out);
    return out;
}

std::optional<size_t> ElementPattern::unify_argument(const Values& values, size_t k) {
    Values args;
    args.reserve(values.size());
    for (const ValueId id : values)
        args.push_back(at(id).args[k]);
    return unify(args);
}

std::optional<ElementNode> ElementPattern::make(const Values& values) {
    const Instr& first = at(values[0]);
    const auto all = [&](const auto& holds) { return std::ranges::all_of(values, holds); };
    if (all([&](ValueId id) { return id == values[0]; }))
        return ElementNode{Kind::kCommon, values[0], 0, 0, false, false, {}};
    if (!all([&](ValueId id) { return at(id).type == first.type; })) return std::nullopt;
    if (all([&](ValueId id) { return at(id).op == Op::kConst; })) return of_constants(values);
    if (all([&](ValueId id) { return at(id).op == Op::kInput; })) return of_inputs(values);
    if (std::optional<ElementNode> test = of_test(values)) return test;
    const auto same = [&](ValueId id) {
        const Instr& other = at(id);
        return other.op == first.op && other.kind == first.kind && other.a == first.a &&
               other.b == first.b && other.bits == first.bits &&
               other.args.size() == first.args.size();
    };
    const bool leaf = ir::family(first.op) == ir::Family::kLeaf;
    if (leaf || ir::is_effectful(first.op) || !all(same)) return std::nullopt;
    ElementNode out{Kind::kOperation, values[0], 0, 0, false, false, {}};
    for (size_t k = 0; k < first.args.size(); ++k) {
        const std::optional<size_t> arg = unify_argument(values, k);
        if (!arg) return std::nullopt;
        out.args.push_back(*arg);
    }
    return out;
}

std::optional<ElementNode> ElementPattern::of_constants(const Values& values) const {
    const uint32_t first = at(values[0]).bits, step = at(values[1]).bits - first;
    for (size_t k = 0; k < values.size(); ++k) {
        if (at(values[k]).bits != first + step * static_cast<uint32_t>(k)) return std::nullopt;
    }
    if (step == 0) return ElementNode{Kind::kCommon, values[0], 0, 0, false, false, {}};
    if (!is_integer(at(values[0]).type)) return std::nullopt;
    return ElementNode{Kind::kNumber, values[0], first, step, false, false, {}};
}

std::optional<ElementNode> ElementPattern::of_inputs(const Values& values) const {
    const Instr& first = at(values[0]);
    if (first.kind != OPENFAB_ARG_STATE) return std::nullopt;
    const int32_t step = at(values[1]).a - first.a;
    if (step < 1) return std::nullopt;
    for (size_t k = 0; k < values.size(); ++k) {
        const Instr& input = at(values[k]);
        if (input.kind != first.kind || input.a != first.a + step * static_cast<int32_t>(k))
            return std::nullopt;
    }
    return ElementNode{
        Kind::kState, values[0], static_cast<uint32_t>(first.a), static_cast<uint32_t>(step), false,
        false,        {}};
}

/// Tests of one index for each number in order. At the ends they may hold beyond, as a varying index
/// is clamped to its array.
std::optional<ElementNode> ElementPattern::of_test(const Values& values) {
    const Op begin = at(values.front()).op, end = at(values.back()).op;
    const bool inner = std::all_of(values.begin() + 1, values.end() - 1,
                                   [&](ValueId id) { return at(id).op == Op::kEq; });
    if (!inner || (begin != Op::kEq && begin != Op::kLe) || (end != Op::kEq && end != Op::kGe))
        return std::nullopt;
    const std::optional<size_t> index = unify_argument(values, 0);
    const std::optional<size_t> number = unify_argument(values, 1);
    if (!index || !number) return std::nullopt;
    const ElementNode& of_number = nodes_[*number];
    if (nodes_[*index].kind != Kind::kCommon || of_number.kind != Kind::kNumber ||
        of_number.step != 1)
        return std::nullopt;
    return ElementNode{Kind::kIs,        values[0],      of_number.first, 1,
                       begin == Op::kLe, end == Op::kGe, {*index}};
}

ValueId ElementPattern::emit(ValueId number, const std::vector<ValueId>& renamed,
                             ir::Builder* builder) const {
    std::vector<ValueId> made(nodes_.size(), kNoValue);
    return emit(root_, number, renamed, &made, builder);
}

ValueId ElementPattern::emit(size_t k, ValueId number, const std::vector<ValueId>& renamed,
                             std::vector<ValueId>* made, ir::Builder* builder) const {
    if ((*made)[k] != kNoValue) return (*made)[k];
    const ElementNode& node = nodes_[k];
    const Instr& of = at(node.id);
    const auto argument = [&](size_t i) {
        return emit(node.args[i], number, renamed, made, builder);
    };
    const auto counted = [&](Type type) {
        ValueId value = builder->convert(number, type);
        if (node.step != 1)
            value = builder->binary(Op::kMul, value, builder->constant(type, node.step));
        if (node.first == 0) return value;
        return builder->binary(Op::kAdd, value, builder->constant(type, node.first));
    };
    ValueId out = kNoValue;
    builder->set_span(of.span);
    switch (node.kind) {
        case Kind::kCommon:
            out = renamed[node.id];
            break;
        case Kind::kNumber:
            out = counted(of.type);
            break;
        case Kind::kState: {
            Instr load;
            load.op = Op::kTable;
            load.type = of.type;
            load.bits = static_cast<uint32_t>(count_);
            load.kind = OPENFAB_ARG_STATE;
            load.a = static_cast<int32_t>(node.first);
            load.b = static_cast<int32_t>(node.step);
            load.args = {number};
            out = builder->append(std::move(load));
            break;
        }
        case Kind::kIs: {
            const ValueId index = argument(0);
            const uint32_t last = node.first + static_cast<uint32_t>(count_ - 1);
            const ValueId kept =
                emit_clamped(index, node.first, last, node.below, node.above, builder);
            out = builder->binary(Op::kEq, kept, counted(builder->type(index)));
            break;
        }
        case Kind::kOperation: {
            Instr copy = of;
            for (size_t i = 0; i < copy.args.size(); ++i)
                copy.args[i] = argument(i);
            out = builder->append(std::move(copy));
            break;
        }
    }
    (*made)[k] = out;
    return out;
}

}  // namespace openfab::passes
