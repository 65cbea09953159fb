// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// Every IR operation, once, in families: X(Name, "spelling", arity, operands, result).
//   arity     number of arguments; -1: see compiler/ir/ir.h
//   operands  what the arguments are, all of one type: Any, Numbers, Integers, Floats, Bools; Own: a rule of its own in verify.cpp
//   result    Same type as the operands, Bool, or Own
// Arithmetic is that of rule 2 (docs/determinism.md): wrapping integers, x/0 = x%0 = 0 for integers, shift counts & 31, float to int
// saturating with NaN = 0, min(a,b) = a<b?a:b and max(a,b) = a>b?a:b.
//
// A switch over operations has no `default`: it names the operations that it treats, and the families of the others by
// OPENFAB_IR_CASES. So a new operation is a row here, and the build fails wherever else it must be handled.
// clang-format off

#define OPENFAB_IR_LEAVES(X) \
    X(Const, "const", 0, Own, Own) \
    X(Input, "input", 0, Own, Own)

#define OPENFAB_IR_ARITHMETIC(X) \
    X(Add, "add", 2, Numbers, Same) \
    X(Sub, "sub", 2, Numbers, Same) \
    X(Mul, "mul", 2, Numbers, Same) \
    X(Div, "div", 2, Numbers, Same) \
    X(Mod, "mod", 2, Numbers, Same) \
    X(Neg, "neg", 1, Numbers, Same)

#define OPENFAB_IR_BITS(X) \
    X(BitAnd, "bitand", 2, Integers, Same) \
    X(BitOr, "bitor", 2, Integers, Same) \
    X(BitXor, "bitxor", 2, Integers, Same) \
    X(BitNot, "bitnot", 1, Integers, Same) \
    X(Shl, "shl", 2, Integers, Same) \
    X(Shr, "shr", 2, Integers, Same)

#define OPENFAB_IR_LOGIC(X) \
    X(And, "and", 2, Bools, Same) \
    X(Or, "or", 2, Bools, Same) \
    X(Not, "not", 1, Bools, Same)

#define OPENFAB_IR_EQUALITIES(X) \
    X(Eq, "eq", 2, Any, Bool) \
    X(Ne, "ne", 2, Any, Bool)

#define OPENFAB_IR_ORDERS(X) \
    X(Lt, "lt", 2, Numbers, Bool) \
    X(Le, "le", 2, Numbers, Bool) \
    X(Gt, "gt", 2, Numbers, Bool) \
    X(Ge, "ge", 2, Numbers, Bool)

// Select and conversions.
#define OPENFAB_IR_CHOICES(X) \
    X(Select, "select", 3, Own, Own) \
    X(Convert, "convert", 1, Own, Own)

#define OPENFAB_IR_EXTREMES(X) \
    X(Min, "min", 2, Numbers, Same) \
    X(Max, "max", 2, Numbers, Same) \
    X(Abs, "abs", 1, Numbers, Same)

#define OPENFAB_IR_FLOAT_PARTS(X) \
    X(Sqrt, "sqrt", 1, Floats, Same) \
    X(Floor, "floor", 1, Floats, Same) \
    X(Ceil, "ceil", 1, Floats, Same) \
    X(Round, "round", 1, Floats, Same) \
    X(Trunc, "trunc", 1, Floats, Same) \
    X(IsNan, "isnan", 1, Floats, Bool)

#define OPENFAB_IR_LOOKUPS(X) \
    X(Sample, "sample", -1, Own, Own) \
    X(SampleBound, "sample_bound", -1, Own, Own) \
    X(BitCast, "bitcast", 1, Own, Own) \
    X(Pick, "pick", -1, Own, Own) \
    X(Table, "table", 1, Own, Own)

// Loops, queries, printfs and their parts: they keep their order and are not pure functions of their arguments.
#define OPENFAB_IR_CONTROL(X) \
    X(Loop, "loop", 1, Own, Own) \
    X(LoopVar, "loop_var", 2, Own, Own) \
    X(LoopEnd, "loop_end", -1, Own, Own) \
    X(LoopResult, "loop_result", 1, Own, Own) \
    X(Query, "query", -1, Own, Own) \
    X(QueryResult, "query_result", 1, Own, Own) \
    X(Printf, "printf", -1, Own, Own)

// Functions of one or two floats: see compiler/functions.
#define OPENFAB_IR_ELEMENTARY(X) \
    X(Sin, "sin", 1, Floats, Same) \
    X(Cos, "cos", 1, Floats, Same) \
    X(Tan, "tan", 1, Floats, Same) \
    X(Asin, "asin", 1, Floats, Same) \
    X(Acos, "acos", 1, Floats, Same) \
    X(Atan, "atan", 1, Floats, Same) \
    X(Atan2, "atan2", 2, Floats, Same) \
    X(Sinh, "sinh", 1, Floats, Same) \
    X(Cosh, "cosh", 1, Floats, Same) \
    X(Tanh, "tanh", 1, Floats, Same) \
    X(Exp, "exp", 1, Floats, Same) \
    X(Exp2, "exp2", 1, Floats, Same) \
    X(Log, "log", 1, Floats, Same) \
    X(Log2, "log2", 1, Floats, Same) \
    X(Log10, "log10", 1, Floats, Same) \
    X(Pow, "pow", 2, Floats, Same) \
    X(Cbrt, "cbrt", 1, Floats, Same)

#define OPENFAB_IR_HASHES(X) X(Hash, "hash", -1, Own, Own)

#define OPENFAB_IR_NOISES(X) \
    X(Noise, "noise", -1, Own, Own) \
    X(Simplex, "simplex", -1, Own, Own) \
    X(Cellular, "cellular", -1, Own, Own)

// Expanded by attach_footprints.
#define OPENFAB_IR_DERIVATIVES(X) X(Derivative, "derivative", 1, Own, Own)

#define OPENFAB_IR_FUNCTIONS(X) OPENFAB_IR_ELEMENTARY(X) OPENFAB_IR_HASHES(X) OPENFAB_IR_NOISES(X)
#define OPENFAB_IR_COMPARISONS(X) OPENFAB_IR_EQUALITIES(X) OPENFAB_IR_ORDERS(X)
// What is no operation on values of one type.
#define OPENFAB_IR_STRUCTURE(X) \
    OPENFAB_IR_LEAVES(X) OPENFAB_IR_CHOICES(X) OPENFAB_IR_LOOKUPS(X) OPENFAB_IR_CONTROL(X) \
    OPENFAB_IR_FUNCTIONS(X) OPENFAB_IR_DERIVATIVES(X)
// What is.
#define OPENFAB_IR_OPERATIONS(X) \
    OPENFAB_IR_ARITHMETIC(X) OPENFAB_IR_BITS(X) OPENFAB_IR_LOGIC(X) OPENFAB_IR_COMPARISONS(X) \
    OPENFAB_IR_EXTREMES(X) OPENFAB_IR_FLOAT_PARTS(X)

#define OPENFAB_IR_OPS(X) \
    OPENFAB_IR_LEAVES(X) OPENFAB_IR_ARITHMETIC(X) OPENFAB_IR_BITS(X) OPENFAB_IR_LOGIC(X) \
    OPENFAB_IR_EQUALITIES(X) OPENFAB_IR_ORDERS(X) OPENFAB_IR_CHOICES(X) OPENFAB_IR_EXTREMES(X) \
    OPENFAB_IR_FLOAT_PARTS(X) OPENFAB_IR_LOOKUPS(X) OPENFAB_IR_CONTROL(X) \
    OPENFAB_IR_ELEMENTARY(X) OPENFAB_IR_HASHES(X) OPENFAB_IR_NOISES(X) OPENFAB_IR_DERIVATIVES(X)

#define OPENFAB_IR_CASE(name, ...) case ::openfab::ir::Op::k##name:
// The case labels of a family, in a switch: OPENFAB_IR_CASES(FUNCTIONS).
#define OPENFAB_IR_CASES(family) OPENFAB_IR_##family(OPENFAB_IR_CASE)
// clang-format on

namespace openfab::ir {

enum class Type : uint8_t { kBool, kInt, kUint, kFloat };

enum class Op : uint8_t {
#define OPENFAB_IR_NAME(name, ...) k##name,
    OPENFAB_IR_OPS(OPENFAB_IR_NAME)
#undef OPENFAB_IR_NAME
};

}  // namespace openfab::ir
