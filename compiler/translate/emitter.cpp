// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/emitter.h"

#include <bit>
#include <utility>

#include "compiler/functions/functions.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::sema {

using ir::Op;
using ir::ValueId;

namespace {

// In operations that take as long to compile. A look-up is a stage of its own, and its interval
// form long; loops, queries and prints end a kernel and begin another.
constexpr size_t kLookUpCost = 500;
constexpr size_t kStepCost = 100;
constexpr size_t kPrintedCost = 10;

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
            return kLookUpCost;
        case Op::kLoop:
        case Op::kQuery:
            return kStepCost;
        case Op::kPrint:
            return kStepCost + kPrintedCost * instr.args.size();
        default:
            break;
    }
    if (!ir::is_function(instr.op)) return 1;
    size_t& known = function_sizes_[{instr.op, instr.a, instr.args.size()}];
    if (known == 0) known = functions::operations(instr);
    return known;
}

size_t Emitter::operations(size_t size) {
    while (sums_.size() < size) {
        const size_t at = sums_.size();
        const size_t before = at == 0 ? 0 : sums_.back();
        const ir::Instr& instr = stage_->instrs[at];
        // Channels that are read at one place are one look-up.
        const bool more = instr.op == Op::kSample && instr.b > 0 && at > 0;
        sums_.push_back(before + (more ? 1 : cost(instr)));
    }
    return size == 0 ? 0 : sums_[size - 1];
}

ValueId Emitter::add(ir::Instr instr) {
    Key key{instr.op, instr.type, instr.bits, instr.kind, instr.a, instr.b, instr.args};
    const auto found = known_.find(key);
    if (found != known_.end()) return found->second;
    const ValueId id = builder_.append(std::move(instr));
    known_.emplace(std::move(key), id);
    return id;
}

ValueId Emitter::constant(ir::Type type, uint32_t bits) {
    ir::Instr instr;
    instr.op = Op::kConst;
    instr.type = type;
    instr.bits = bits;
    return add(std::move(instr));
}

ValueId Emitter::constant(float value) {
    return constant(ir::Type::kFloat, std::bit_cast<uint32_t>(value));
}

ValueId Emitter::input(ir::Type type, int32_t kind, int32_t a, int32_t b) {
    ir::Instr instr;
    instr.op = Op::kInput;
    instr.type = type;
    instr.kind = kind;
    instr.a = a;
    instr.b = b;
    return add(std::move(instr));
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

ValueId Emitter::sample(int32_t texture, int32_t channel, const std::array<ValueId, 4>& args) {
    ir::Instr instr;
    instr.op = Op::kSample;
    instr.type = ir::Type::kFloat;
    instr.a = texture;
    instr.b = channel;
    instr.args.assign(args.begin(), args.end());
    return add(std::move(instr));
}

ValueId Emitter::sample_volume(int32_t texture, int32_t channel,
                               const std::array<ValueId, 5>& args) {
    ir::Instr instr;
    instr.op = Op::kSample;
    instr.type = ir::Type::kFloat;
    instr.a = texture;
    instr.b = channel;
    instr.args.assign(args.begin(), args.end());
    return add(std::move(instr));
}

ValueId Emitter::query(int32_t object, const std::array<ValueId, 4>& args) {
    ir::Instr instr;
    instr.op = Op::kQuery;
    instr.type = ir::Type::kBool;
    instr.a = object;
    instr.args.assign(args.begin(), args.end());
    return add(std::move(instr));
}

ValueId Emitter::query_result(ValueId query, ir::Type type, openfab_query_result kind, int32_t a,
                              int32_t b) {
    ir::Instr instr;
    instr.op = Op::kQueryResult;
    instr.type = type;
    instr.kind = kind;
    instr.a = a;
    instr.b = b;
    instr.args = {query};
    return add(std::move(instr));
}

/// Each one is its own: two prints of the same values are two.
void Emitter::print(int32_t number, std::vector<ValueId> args) {
    ir::Instr instr;
    instr.op = Op::kPrint;
    instr.type = ir::Type::kBool;
    instr.a = number;
    instr.args = std::move(args);
    builder_.append(std::move(instr));
}

ValueId Emitter::unary(Op op, ValueId a) {
    const ir::Type type = this->type(a);
    const ir::Type result = op == Op::kIsNan ? ir::Type::kBool : type;
    if (is_constant(a)) return constant(result, ir::eval(op, type, instr(a).bits, 0, 0));
    if (op == Op::kNot && instr(a).op == Op::kNot) return instr(a).args[0];
    ir::Instr out;
    out.op = op;
    out.type = result;
    out.args = {a};
    return add(std::move(out));
}

ValueId Emitter::binary(Op op, ValueId a, ValueId b) {
    const ir::Type type = this->type(a);
    const ir::Type result = op >= Op::kEq && op <= Op::kGe ? ir::Type::kBool : type;
    if (is_constant(a) && is_constant(b)) {
        return constant(result, ir::eval(op, type, instr(a).bits, instr(b).bits, 0));
    }
    ir::Instr out;
    out.op = op;
    out.type = result;
    out.args = {a, b};
    return add(std::move(out));
}

ValueId Emitter::convert(ValueId value, ir::Type to) {
    const ir::Type from = type(value);
    if (from == to) return value;
    if (is_constant(value)) return constant(to, ir::eval_convert(from, to, instr(value).bits));
    ir::Instr out;
    out.op = Op::kConvert;
    out.type = to;
    out.args = {value};
    return add(std::move(out));
}

void Emitter::forget_from(ValueId first) {
    std::erase_if(known_, [&](const auto& item) { return item.second >= first; });
}

ValueId Emitter::end_loop(ValueId loop, ValueId again, const std::vector<ValueId>& next) {
    forget_from(loop);
    return builder_.loop_end(loop, again, next);
}

void Emitter::forget_after(size_t size) {
    forget_from(static_cast<ValueId>(size));
    stage_->instrs.resize(size);
    if (sums_.size() > size) sums_.resize(size);
}

ValueId Emitter::bit_cast(ValueId value, ir::Type to) {
    if (type(value) == to) return value;
    if (is_constant(value)) return constant(to, instr(value).bits);
    ir::Instr out;
    out.op = Op::kBitCast;
    out.type = to;
    out.args = {value};
    return add(std::move(out));
}

ValueId Emitter::function(Op op, int32_t which, std::vector<ValueId> args) {
    ir::Instr out;
    out.op = op;
    out.type = op == Op::kHash ? ir::Type::kUint : ir::Type::kFloat;
    out.a = which;
    std::vector<uint32_t> bits;
    for (const ValueId arg : args) {
        if (is_constant(arg)) bits.push_back(instr(arg).bits);
    }
    if (bits.size() == args.size()) {
        // What is constant does not change.
        return constant(out.type, op == Op::kDerivative ? 0 : functions::evaluate(out, bits));
    }
    out.args = std::move(args);
    return add(std::move(out));
}

ValueId Emitter::logical_not(ValueId a) {
    return unary(Op::kNot, a);
}

bool Emitter::is_one_of(Op op, ValueId value, ValueId part) const {
    const ir::Instr& i = instr(value);
    return i.op == op && (i.args[0] == part || i.args[1] == part);
}

bool Emitter::are_opposite(ValueId a, ValueId b) const {
    return (instr(a).op == Op::kNot && instr(a).args[0] == b) ||
           (instr(b).op == Op::kNot && instr(b).args[0] == a);
}

ValueId Emitter::logical_and(ValueId a, ValueId b) {
    if (is_false(a) || is_true(b) || a == b) return a;
    if (is_false(b) || is_true(a)) return b;
    if (are_opposite(a, b)) return boolean(false);
    if (is_one_of(Op::kOr, a, b)) return b;
    if (is_one_of(Op::kOr, b, a)) return a;
    return binary(Op::kAnd, a, b);
}

ValueId Emitter::logical_or(ValueId a, ValueId b) {
    if (is_true(a) || is_false(b) || a == b) return a;
    if (is_true(b) || is_false(a)) return b;
    if (are_opposite(a, b)) return boolean(true);
    if (is_one_of(Op::kAnd, a, b)) return b;
    if (is_one_of(Op::kAnd, b, a)) return a;
    return binary(Op::kOr, a, b);
}

ValueId Emitter::select(ValueId condition, ValueId if_true, ValueId if_false) {
    if (if_true == if_false) return if_true;
    if (is_constant(condition)) return is_true(condition) ? if_true : if_false;
    if (instr(condition).op == Op::kNot) {
        return select(instr(condition).args[0], if_false, if_true);
    }
    if (type(if_true) == ir::Type::kBool) {
        if (is_true(if_true) || if_true == condition) return logical_or(condition, if_false);
        if (is_false(if_false) || if_false == condition) return logical_and(condition, if_true);
        if (is_false(if_true)) return logical_and(logical_not(condition), if_false);
        if (is_true(if_false)) return logical_or(logical_not(condition), if_true);
    }
    ir::Instr out;
    out.op = Op::kSelect;
    out.type = type(if_true);
    out.args = {condition, if_true, if_false};
    return add(std::move(out));
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

}  // namespace openfab::sema
