// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <iterator>
#include <utility>

#include "compiler/ir/ir.h"

namespace openfab::ir {

namespace {

constexpr Traits kTraits[] = {
#define OPENFAB_IR_TRAITS(name, spelling, arity, operands, result) \
    {spelling, arity, Operands::k##operands, Result::k##result},
    OPENFAB_IR_OPS(OPENFAB_IR_TRAITS)
#undef OPENFAB_IR_TRAITS
};
static_assert(std::size(kTraits) == kOpCount);

Instr make(Op op, Type type, std::vector<ValueId> args) {
    Instr instr;
    instr.op = op;
    instr.type = type;
    instr.args = std::move(args);
    return instr;
}

}  // namespace

const Traits& traits(Op op) {
    return kTraits[static_cast<size_t>(op)];
}

const char* spelling(Op op) {
    return traits(op).spelling;
}

int arity(Op op) {
    return traits(op).arity;
}

const char* spelling(Type type) {
    switch (type) {
        case Type::kBool:
            return "bool";
        case Type::kInt:
            return "int";
        case Type::kUint:
            return "uint";
        case Type::kFloat:
            return "float";
    }
    return "?";
}

ValueId Builder::append(Instr instr) {
    if (instr.span == source::Span{}) instr.span = span_;
    stage_->instrs.push_back(std::move(instr));
    return static_cast<ValueId>(stage_->instrs.size() - 1);
}

ValueId Builder::constant(Type type, uint32_t bits) {
    Instr instr = make(Op::kConst, type, {});
    instr.bits = bits;
    return add(std::move(instr));
}

ValueId Builder::constant(float value) {
    return constant(Type::kFloat, std::bit_cast<uint32_t>(value));
}

ValueId Builder::constant(int32_t value) {
    return constant(Type::kInt, static_cast<uint32_t>(value));
}

ValueId Builder::constant(uint32_t value) {
    return constant(Type::kUint, value);
}

ValueId Builder::constant(bool value) {
    return constant(Type::kBool, value ? 1u : 0u);
}

ValueId Builder::input(Type type, int32_t kind, int32_t a, int32_t b) {
    Instr instr = make(Op::kInput, type, {});
    instr.kind = kind;
    instr.a = a;
    instr.b = b;
    return add(std::move(instr));
}

ValueId Builder::emit(Op op, std::vector<ValueId> args) {
    const Type operands = type(args[op == Op::kSelect || op == Op::kPick ? 1 : 0]);
    const bool gives_bool = traits(op).result == Result::kBool;
    return add(make(op, gives_bool ? Type::kBool : operands, std::move(args)));
}

ValueId Builder::convert(ValueId value, Type to) {
    return type(value) == to ? value : add(make(Op::kConvert, to, {value}));
}

ValueId Builder::bit_cast(ValueId value, Type to) {
    return type(value) == to ? value : add(make(Op::kBitCast, to, {value}));
}

ValueId Builder::select(ValueId condition, ValueId if_true, ValueId if_false) {
    return emit(Op::kSelect, {condition, if_true, if_false});
}

ValueId Builder::pick(ValueId index, const std::vector<ValueId>& elements) {
    std::vector<ValueId> args = {index};
    args.insert(args.end(), elements.begin(), elements.end());
    return emit(Op::kPick, std::move(args));
}

ValueId Builder::function(Op op, int32_t which, std::vector<ValueId> args) {
    Instr instr = make(op, op == Op::kHash ? Type::kUint : Type::kFloat, std::move(args));
    instr.a = which;
    return add(std::move(instr));
}

ValueId Builder::sample(int32_t texture, int32_t channel, std::vector<ValueId> args) {
    Instr instr = make(Op::kSample, Type::kFloat, std::move(args));
    instr.a = texture;
    instr.b = channel;
    return add(std::move(instr));
}

ValueId Builder::query(int32_t object, ValueId guard, const std::array<ValueId, 3>& point) {
    Instr instr = make(Op::kQuery, Type::kBool, {guard, point[0], point[1], point[2]});
    instr.a = object;
    return add(std::move(instr));
}

ValueId Builder::walk(int32_t object, ValueId guard, const std::array<ValueId, 3>& point,
                      ValueId stop, ValueId seed) {
    Instr instr = make(Op::kQuery, Type::kBool, {guard, point[0], point[1], point[2], stop, seed});
    instr.a = object;
    return add(std::move(instr));
}

ValueId Builder::query_result(ValueId query, Type type, openfab_query_result kind, int32_t a,
                              int32_t b) {
    Instr instr = make(Op::kQueryResult, type, {query});
    instr.kind = kind;
    instr.a = a;
    instr.b = b;
    return add(std::move(instr));
}

ValueId Builder::loop(ValueId guard) {
    return append(make(Op::kLoop, Type::kBool, {guard}));
}

ValueId Builder::loop_var(ValueId loop, int32_t number, ValueId first) {
    Instr instr = make(Op::kLoopVar, type(first), {loop, first});
    instr.a = number;
    return append(std::move(instr));
}

ValueId Builder::loop_end(ValueId loop, ValueId again, const std::vector<ValueId>& next) {
    Instr instr = make(Op::kLoopEnd, Type::kBool, {loop, again});
    instr.args.insert(instr.args.end(), next.begin(), next.end());
    return append(std::move(instr));
}

ValueId Builder::loop_result(ValueId loop_end, int32_t number) {
    const ValueId next = instr(loop_end).args[static_cast<size_t>(number) + kLoopEndNext];
    Instr result = make(Op::kLoopResult, type(next), {loop_end});
    result.a = number;
    return append(std::move(result));
}

ValueId Builder::printf(int32_t number, std::vector<ValueId> args) {
    Instr instr = make(Op::kPrintf, Type::kBool, std::move(args));
    instr.a = number;
    return append(std::move(instr));
}

}  // namespace openfab::ir
