// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/emitter.h"

#include <algorithm>
#include <utility>

#include "compiler/functions/functions.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

// Compile costs in operations. A lookup is a stage of its own, and its interval form is long;
// loops, queries and printfs split a kernel.
constexpr size_t kSampleCost = 500;
constexpr size_t kStepCost = 100;
constexpr size_t kPrintfValueCost = 10;
// Of an element that the runtime loads or stores: the index, and what keeps it in the array.
constexpr size_t kAccessCost = 4;

}  // namespace

size_t Emitter::cost(const ir::Instr& instr) {
    switch (instr.op) {
        case Op::kConst:
        case Op::kInput:
        case Op::kLoopVar:
        case Op::kLoopResult:
        case Op::kQueryResult:
            return 0;
        case Op::kSample:
            return kSampleCost;
        case Op::kLoop:
        case Op::kQuery:
            return kStepCost;
        case Op::kPrintf:
            return kStepCost + kPrintfValueCost * instr.args.size();
        case Op::kPick:
            return pick_cost(instr);
        case Op::kSampleBound:
        case Op::kBitCast:
        case Op::kTable:
        case Op::kLoopEnd:
            OPENFAB_IR_CASES(CHOICES)
            OPENFAB_IR_CASES(DERIVATIVES)
            OPENFAB_IR_CASES(OPERATIONS)
            return 1;
            OPENFAB_IR_CASES(FUNCTIONS)
            break;
    }
    size_t& known = function_sizes_[{instr.op, instr.a, instr.args.size()}];
    if (known == 0) known = functions::operations(instr);
    return known;
}

/// A table is one load; elements that differ from voxel to voxel are compared and chosen one by one.
size_t Emitter::pick_cost(const ir::Instr& pick) const {
    const bool table = std::all_of(pick.args.begin() + 1, pick.args.end(), [&](ValueId element) {
        const ir::Instr& of = instr(element);
        return of.op == Op::kConst || (of.op == Op::kInput && of.kind == OPENFAB_ARG_UNIFORM);
    });
    return table ? 1 : 2 * (pick.args.size() - 1);
}

Emitter::Sum Emitter::sum(size_t size) {
    while (sums_.size() < size) {
        const size_t at = sums_.size();
        Sum next = at == 0 ? Sum{} : sums_.back();
        const ir::Instr& instr = stage_->instrs[at];
        // Channels read at one coordinate share a lookup.
        const bool more = instr.op == Op::kSample && instr.b > 0 && at > 0;
        const size_t alone = more ? 1 : cost(instr);
        next.operations += alone;
        next.by_steps += instr.op == Op::kPick ? std::min(alone, kAccessCost) : alone;
        sums_.push_back(next);
    }
    return size == 0 ? Sum{} : sums_[size - 1];
}

size_t Emitter::operations(size_t size) {
    return sum(size).operations;
}

void Emitter::count_none(size_t from) {
    const Sum before = sum(from);
    sums_.resize(from);
    sums_.resize(size(), before);
}

void Emitter::count_as_step(size_t from) {
    const size_t before = sum(from).by_steps;
    sum(size());
    for (size_t at = from; at < size(); ++at)
        sums_[at].by_steps = before + kAccessCost;
}

ValueId Emitter::add(ir::Instr instr) {
    if (const std::optional<ValueId> other = simplified(instr)) return *other;
    Key key{instr.op, instr.type, instr.bits, instr.kind, instr.a, instr.b, instr.args};
    const auto known = known_.find(key);
    if (known != known_.end()) return known->second;
    const ValueId id = append(std::move(instr));
    known_.emplace(std::move(key), id);
    return id;
}

ValueId Emitter::unknown(ir::Type type, int32_t kind, int32_t a, int32_t b,
                         std::vector<ValueId> args) {
    ir::Instr instr;
    instr.op = Op::kInput;
    instr.type = type;
    instr.kind = kind;
    instr.a = a;
    instr.b = b;
    instr.args = std::move(args);
    return add(std::move(instr));
}

/// Returns an equal earlier value, or a constant.
std::optional<ValueId> Emitter::simplified(const ir::Instr& made) {
    const std::vector<ValueId>& args = made.args;
    std::optional<ValueId> same;
    if (made.op == Op::kAnd) same = simplified_and(args[0], args[1]);
    if (made.op == Op::kOr) same = simplified_or(args[0], args[1]);
    if (made.op == Op::kSelect) same = simplified_select(args[0], args[1], args[2]);
    if (made.op == Op::kPick) same = simplified_pick(made);
    if (made.op == Op::kNot && instr(args[0]).op == Op::kNot) same = instr(args[0]).args[0];
    if (same) return same;
    const std::optional<uint32_t> bits = functions::fold(*stage_, made);
    return bits ? std::optional(constant(made.type, *bits)) : std::nullopt;
}

void Emitter::forget_from(ValueId first) {
    std::erase_if(known_, [&](const auto& item) { return item.second >= first; });
}

ValueId Emitter::loop_end(ValueId loop, ValueId again, const std::vector<ValueId>& next) {
    forget_from(loop);
    return ir::Builder::loop_end(loop, again, next);
}

void Emitter::truncate(size_t size) {
    forget_from(static_cast<ValueId>(size));
    stage_->instrs.resize(size);
    if (sums_.size() > size) sums_.resize(size);
}

bool Emitter::is_one_of(Op op, ValueId value, ValueId part) const {
    const ir::Instr& i = instr(value);
    return i.op == op && (i.args[0] == part || i.args[1] == part);
}

bool Emitter::are_opposite(ValueId a, ValueId b) const {
    return (instr(a).op == Op::kNot && instr(a).args[0] == b) ||
           (instr(b).op == Op::kNot && instr(b).args[0] == a);
}

std::optional<ValueId> Emitter::simplified_and(ValueId a, ValueId b) {
    if (is_false(a) || is_true(b) || a == b) return a;
    if (is_false(b) || is_true(a)) return b;
    if (are_opposite(a, b)) return constant(false);
    if (is_one_of(Op::kOr, a, b)) return b;
    if (is_one_of(Op::kOr, b, a)) return a;
    return std::nullopt;
}

std::optional<ValueId> Emitter::simplified_or(ValueId a, ValueId b) {
    if (is_true(a) || is_false(b) || a == b) return a;
    if (is_true(b) || is_false(a)) return b;
    if (are_opposite(a, b)) return constant(true);
    if (is_one_of(Op::kAnd, a, b)) return b;
    if (is_one_of(Op::kAnd, b, a)) return a;
    return std::nullopt;
}

std::optional<ValueId> Emitter::simplified_select(ValueId condition, ValueId if_true,
                                                  ValueId if_false) {
    if (if_true == if_false) return if_true;
    if (is_constant(condition)) return is_true(condition) ? if_true : if_false;
    if (instr(condition).op == Op::kNot) {
        return select(instr(condition).args[0], if_false, if_true);
    }
    if (type(if_true) != ir::Type::kBool) return std::nullopt;
    if (is_true(if_true) || if_true == condition) return logical_or(condition, if_false);
    if (is_false(if_false) || if_false == condition) return logical_and(condition, if_true);
    if (is_false(if_true)) return logical_and(logical_not(condition), if_false);
    if (is_true(if_false)) return logical_or(logical_not(condition), if_true);
    return std::nullopt;
}

std::optional<ValueId> Emitter::simplified_pick(const ir::Instr& pick) const {
    const ir::Instr& index = instr(pick.args[0]);
    if (index.op == Op::kConst)
        return pick.args[1 + ir::picked_element(index.type, index.bits, pick.args.size() - 1)];
    const bool same = std::all_of(pick.args.begin() + 1, pick.args.end(),
                                  [&](ValueId element) { return element == pick.args[1]; });
    return same ? std::optional(pick.args[1]) : std::nullopt;
}

bool Emitter::implies(ValueId condition, ValueId fact) const {
    std::vector<ValueId> open = {condition};
    while (!open.empty()) {
        const ValueId value = open.back();
        open.pop_back();
        if (value == fact) return true;
        if (instr(value).op != Op::kAnd) continue;
        open.insert(open.end(), instr(value).args.begin(), instr(value).args.end());
    }
    return false;
}

}  // namespace openfab::translate
