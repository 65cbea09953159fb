// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <utility>

#include "compiler/ir/ir.h"

namespace openfab::ir {

namespace {

constexpr const char* kSpellings[] = {
#define OPENFAB_IR_OP(name, spelling, arity) spelling,
#include "compiler/ir/nodes.def"
#undef OPENFAB_IR_OP
};

constexpr int kArities[] = {
#define OPENFAB_IR_OP(name, spelling, arity) arity,
#include "compiler/ir/nodes.def"
#undef OPENFAB_IR_OP
};

bool gives_bool(Op op) {
    switch (op) {
        case Op::kEq:
        case Op::kNe:
        case Op::kLt:
        case Op::kLe:
        case Op::kGt:
        case Op::kGe:
        case Op::kAnd:
        case Op::kOr:
        case Op::kNot:
        case Op::kIsNan:
            return true;
        default:
            return false;
    }
}

Instr make_const(Type type, uint32_t bits) {
    Instr instr;
    instr.op = Op::kConst;
    instr.type = type;
    instr.bits = bits;
    return instr;
}

}  // namespace

const char* spelling(Op op) {
    return kSpellings[static_cast<size_t>(op)];
}

int arity(Op op) {
    return kArities[static_cast<size_t>(op)];
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

ValueId Builder::constant(float value) {
    return append(make_const(Type::kFloat, std::bit_cast<uint32_t>(value)));
}

ValueId Builder::constant(int32_t value) {
    return append(make_const(Type::kInt, static_cast<uint32_t>(value)));
}

ValueId Builder::constant(uint32_t value) {
    return append(make_const(Type::kUint, value));
}

ValueId Builder::constant(bool value) {
    return append(make_const(Type::kBool, value ? 1 : 0));
}

ValueId Builder::input(Type type, int32_t kind, int32_t a, int32_t b) {
    Instr instr;
    instr.op = Op::kInput;
    instr.type = type;
    instr.kind = kind;
    instr.a = a;
    instr.b = b;
    return append(std::move(instr));
}

ValueId Builder::emit(Op op, std::vector<ValueId> args) {
    Instr instr;
    instr.op = op;
    if (gives_bool(op)) {
        instr.type = Type::kBool;
    } else if (op == Op::kSample || op == Op::kSampleBound) {
        instr.type = Type::kFloat;
    } else if (op == Op::kSelect) {
        instr.type = type(args[1]);
    } else {
        instr.type = type(args[0]);
    }
    instr.args = std::move(args);
    return append(std::move(instr));
}

ValueId Builder::convert(ValueId value, Type to) {
    if (type(value) == to) return value;
    Instr instr;
    instr.op = Op::kConvert;
    instr.type = to;
    instr.args = {value};
    return append(std::move(instr));
}

ValueId Builder::loop(ValueId guard) {
    return emit(Op::kLoop, {guard});
}

ValueId Builder::loop_var(ValueId loop, int32_t number, ValueId first) {
    Instr instr;
    instr.op = Op::kLoopVar;
    instr.type = type(first);
    instr.a = number;
    instr.args = {loop, first};
    return append(std::move(instr));
}

ValueId Builder::loop_end(ValueId loop, ValueId again, const std::vector<ValueId>& next) {
    Instr instr;
    instr.op = Op::kLoopEnd;
    instr.type = Type::kBool;
    instr.args = {loop, again};
    instr.args.insert(instr.args.end(), next.begin(), next.end());
    return append(std::move(instr));
}

ValueId Builder::loop_result(ValueId loop_end, int32_t number) {
    Instr instr;
    instr.op = Op::kLoopResult;
    instr.a = number;
    instr.type = type(stage_->instrs[loop_end].args[static_cast<size_t>(number) + kLoopEndNext]);
    instr.args = {loop_end};
    return append(std::move(instr));
}

ValueId Builder::query(int32_t object, ValueId guard, const std::array<ValueId, 3>& point) {
    Instr instr;
    instr.op = Op::kQuery;
    instr.type = Type::kBool;
    instr.a = object;
    instr.args = {guard, point[0], point[1], point[2]};
    return append(std::move(instr));
}

ValueId Builder::query_result(ValueId query, Type type, openfab_query_result kind, int32_t a,
                              int32_t b) {
    Instr instr;
    instr.op = Op::kQueryResult;
    instr.type = type;
    instr.kind = kind;
    instr.a = a;
    instr.b = b;
    instr.args = {query};
    return append(std::move(instr));
}

ValueId Builder::bit_cast(ValueId value, Type to) {
    if (type(value) == to) return value;
    Instr instr;
    instr.op = Op::kBitCast;
    instr.type = to;
    instr.args = {value};
    return append(std::move(instr));
}

ValueId Builder::select(ValueId condition, ValueId if_true, ValueId if_false) {
    return emit(Op::kSelect, {condition, if_true, if_false});
}

}  // namespace openfab::ir
