// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Walks the table of operations: what it says of types is what the verifier takes, the interpreter
// computes and the code generator makes.
#include "compiler/lower/algorithm/ops.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "compiler/ir/arithmetic.h"

namespace openfab::lower {
namespace {

using ir::Op;
using ir::Operands;
using ir::Result;
using ir::Type;

constexpr Type kTypes[] = {Type::kBool, Type::kInt, Type::kUint, Type::kFloat};

bool allows(Operands rule, Type type) {
    const bool integer = type == Type::kInt || type == Type::kUint;
    if (rule == Operands::kNumbers) return type != Type::kBool;
    if (rule == Operands::kIntegers) return integer;
    if (rule == Operands::kFloats) return type == Type::kFloat;
    return rule == Operands::kAny || type == Type::kBool;
}

template <typename F>
void for_each_operation(F f) {
    for (size_t k = 0; k < ir::kOpCount; ++k) {
        const Op op = static_cast<Op>(k);
        if (ir::traits(op).operands != Operands::kOwn) f(op);
    }
}

Type result_of(Op op, Type operand) {
    return ir::traits(op).result == Result::kBool ? Type::kBool : operand;
}

TEST(Ops, HaveNamesOfTheirOwn) {
    std::set<std::string> seen;
    for (size_t k = 0; k < ir::kOpCount; ++k)
        EXPECT_TRUE(seen.insert(ir::spelling(static_cast<Op>(k))).second);
}

TEST(Ops, TakeTheTypesOfTheTable) {
    for_each_operation([](Op op) {
        for (const Type type : kTypes) {
            ir::Stage stage;
            ir::Instr constant;
            constant.type = type;
            ir::Instr instr;
            instr.op = op;
            instr.type = result_of(op, type);
            for (int k = 0; k < ir::arity(op); ++k) {
                stage.instrs.push_back(constant);
                instr.args.push_back(static_cast<ir::ValueId>(k));
            }
            stage.instrs.push_back(instr);
            EXPECT_EQ(ir::verify(stage).empty(), allows(ir::traits(op).operands, type))
                << ir::spelling(op) << " of " << ir::spelling(type);
        }
    });
}

/// Some of these arguments give another result than 0, whatever the operation.
TEST(Ops, AreInterpreted) {
    for_each_operation([](Op op) {
        if (ir::is_function(op)) return;
        for (const Type type : kTypes) {
            if (!allows(ir::traits(op).operands, type)) continue;
            uint32_t any = 0;
            for (const float a : {0.0f, 1.0f, -2.5f, std::nanf("")}) {
                for (const float b : {1.0f, 2.0f}) {
                    const uint32_t x = ir::eval_convert(Type::kFloat, type, ir::as_bits(a));
                    const uint32_t y = ir::eval_convert(Type::kFloat, type, ir::as_bits(b));
                    any |= ir::eval(op, type, x, y, 0) | ir::eval(op, type, y, x, 0);
                }
            }
            EXPECT_NE(any, 0u) << ir::spelling(op) << " of " << ir::spelling(type);
        }
    });
}

TEST(Ops, HaveCode) {
    for_each_operation([](Op op) {
        if (ir::is_function(op)) return;
        for (const Type type : kTypes) {
            if (!allows(ir::traits(op).operands, type)) continue;
            std::vector<Value> args;
            for (int k = 0; k < ir::arity(op); ++k)
                args.push_back({type, Halide::Internal::Variable::make(halide_type(type),
                                                                       std::string(1, 'a' + k))});
            const Value made = operate(op, args);
            ASSERT_TRUE(made.expr.defined()) << ir::spelling(op) << " of " << ir::spelling(type);
            EXPECT_EQ(made.type, result_of(op, type)) << ir::spelling(op);
        }
    });
}

}  // namespace
}  // namespace openfab::lower
