// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Every IR operation on every pair of edge-case values: compiled code against the interpreter, bit
// for bit.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "tests/exec/compiled_stage.h"

namespace openfab::testing {

namespace {

using ir::Op;
using ir::Type;

std::vector<uint32_t> float_values() {
    const float inf = std::numeric_limits<float>::infinity();
    const std::vector<float> values = {0.0f,
                                       -0.0f,
                                       1.0f,
                                       -1.0f,
                                       std::numeric_limits<float>::quiet_NaN(),
                                       inf,
                                       -inf,
                                       0x1p-149f,
                                       -0x1p-140f,
                                       std::numeric_limits<float>::max(),
                                       std::numeric_limits<float>::lowest(),
                                       0.5f,
                                       1.5f,
                                       -2.5f,
                                       3.0f,
                                       0.1f,
                                       -0.3f,
                                       2147483648.0f,
                                       -2147483648.0f,
                                       4294967040.0f,
                                       1e10f,
                                       16777217.0f};
    std::vector<uint32_t> bits;
    for (const float value : values)
        bits.push_back(std::bit_cast<uint32_t>(value));
    return bits;
}

std::vector<uint32_t> int_values() {
    return {0u,          1u,          0xffffffffu, 2u,          0xfffffffeu, 7u,
            0xfffffff9u, 31u,         32u,         33u,         0x7fffffffu, 0x80000000u,
            0x80000001u, 0x7ffffffeu, 0x01000001u, 0xff7fffffu, 1000003u,    0x55555555u,
            10u,         3u,          0xfffffffdu, 0xffffff80u};
}

std::vector<uint32_t> values_of(Type type) {
    if (type == Type::kBool) return {0, 1};
    return type == Type::kFloat ? float_values() : int_values();
}

bool defined_on(Op op, Type type) {
    ir::Stage stage;
    ir::Builder b(&stage);
    const ir::ValueId a = b.input(type, OPENFAB_ARG_NEAREST, 0, 0);
    std::vector<ir::ValueId> args(static_cast<size_t>(ir::arity(op)), a);
    b.emit(op, args);
    return ir::verify(stage).empty();
}

const std::vector<Op> kOperations = {
    Op::kAdd,    Op::kSub,    Op::kMul,  Op::kDiv,   Op::kMod,   Op::kNeg,  Op::kBitAnd, Op::kBitOr,
    Op::kBitXor, Op::kBitNot, Op::kShl,  Op::kShr,   Op::kAnd,   Op::kOr,   Op::kNot,    Op::kEq,
    Op::kNe,     Op::kLt,     Op::kLe,   Op::kGt,    Op::kGe,    Op::kMin,  Op::kMax,    Op::kAbs,
    Op::kSqrt,   Op::kFloor,  Op::kCeil, Op::kRound, Op::kTrunc, Op::kIsNan};

/// All operations on one type; `a` and `b` are varying, or one of them a constant.
class Operations {
  public:
    Operations(ir::StageKind kind, Type type) : type_(type) {
        stage_.kind = kind;
        x_ = b_.input(type, OPENFAB_ARG_NEAREST, 0, 0);
        y_ = b_.input(type, OPENFAB_ARG_NEAREST, 0, 1);
    }

    void add_varying() {
        add_all("", x_, y_);
        // The same value twice, which compilers like to fold.
        add_all(" same", x_, x_);
    }

    void add_all(const std::string& suffix, ir::ValueId a, ir::ValueId b) {
        for (const Op op : kOperations) {
            if (!defined_on(op, type_)) continue;
            std::vector<ir::ValueId> args = {a, b};
            args.resize(static_cast<size_t>(ir::arity(op)));
            output(ir::spelling(op) + suffix, b_.emit(op, args));
        }
    }

    void add_conversions() {
        for (const Type to : {Type::kBool, Type::kInt, Type::kUint, Type::kFloat}) {
            if (to != type_) output(std::string("to ") + ir::spelling(to), b_.convert(x_, to));
        }
    }

    /// Shapes that simplifiers are known to fold wrongly.
    void add_traps() {
        if (type_ == Type::kBool) return;
        const ir::ValueId one = b_.convert(b_.constant(1.0f), type_);
        output("x + 1 > x", b_.emit(Op::kGt, {b_.emit(Op::kAdd, {x_, one}), x_}));
        output("x - y < x", b_.emit(Op::kLt, {b_.emit(Op::kSub, {x_, y_}), x_}));
        output("(x + y) - y", b_.emit(Op::kSub, {b_.emit(Op::kAdd, {x_, y_}), y_}));
        output("(x * 3) / 3", b_.emit(Op::kDiv, {b_.emit(Op::kMul, {x_, three()}), three()}));
        output("(x / y) * y", b_.emit(Op::kMul, {b_.emit(Op::kDiv, {x_, y_}), y_}));
        const ir::ValueId below = b_.emit(Op::kLt, {x_, y_});
        output("!(x < y)", b_.emit(Op::kNot, {below}));
        output("x<y || x>=y", b_.emit(Op::kOr, {below, b_.emit(Op::kGe, {x_, y_})}));
        output("x<1 || x>0",
               b_.emit(Op::kOr, {b_.emit(Op::kLt, {x_, one}), b_.emit(Op::kGt, {x_, zero()})}));
        output("x==y && x!=y",
               b_.emit(Op::kAnd, {b_.emit(Op::kEq, {x_, y_}), b_.emit(Op::kNe, {x_, y_})}));
        output("select(!(x<y),x,y)", b_.select(b_.emit(Op::kNot, {below}), x_, y_));
        output("x > 0 ? 0 : x", b_.select(b_.emit(Op::kGt, {x_, zero()}), zero(), x_));
        output("x < 0 ? x : 0", b_.select(b_.emit(Op::kLt, {x_, zero()}), x_, zero()));
        output("min(max(x,0),1)", b_.emit(Op::kMin, {b_.emit(Op::kMax, {x_, zero()}), one}));
        output("-(-x)", b_.emit(Op::kNeg, {b_.emit(Op::kNeg, {x_})}));
        output("0 - x", b_.emit(Op::kSub, {zero(), x_}));
        output("x * 0", b_.emit(Op::kMul, {x_, zero()}));
        output("x / 3", b_.emit(Op::kDiv, {x_, three()}));
        output("x % 3", b_.emit(Op::kMod, {x_, three()}));
        output("3 - (x - y)", b_.emit(Op::kSub, {three(), b_.emit(Op::kSub, {x_, y_})}));
    }

    ir::ValueId zero() { return b_.convert(b_.constant(0.0f), type_); }
    ir::ValueId three() { return b_.convert(b_.constant(3.0f), type_); }
    ir::Builder& builder() { return b_; }
    ir::ValueId x() const { return x_; }

    /// A mirror image of the pairs of edge-case values.
    StageInputs inputs() const {
        const std::vector<uint32_t> values = values_of(type_);
        std::vector<uint32_t> a;
        std::vector<uint32_t> b;
        for (const uint32_t x : values) {
            for (const uint32_t y : values) {
                a.push_back(x);
                b.push_back(y);
            }
        }
        StageInputs out;
        out.elements = static_cast<int32_t>(a.size());
        if (stage_.kind == ir::StageKind::kVolume) {
            out.elements = 1;
            a.resize(512, values[0]);
            b.resize(512, values[0]);
        }
        out.set(OPENFAB_ARG_NEAREST, 0, 0, a);
        out.set(OPENFAB_ARG_NEAREST, 0, 1, b);
        return out;
    }

    const ir::Stage& stage() const { return stage_; }

  private:
    void output(const std::string& name, ir::ValueId value) {
        const auto slot = static_cast<int32_t>(stage_.outputs.size());
        stage_.outputs.push_back({name, OPENFAB_ARG_WEIGHT, slot, 0, value});
    }

    Type type_;
    ir::Stage stage_;
    ir::Builder b_{&stage_};
    ir::ValueId x_ = 0;
    ir::ValueId y_ = 0;
};

void check(const ir::Stage& stage, const std::vector<StageInputs>& runs) {
    ASSERT_EQ(ir::verify(stage), "");
    const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(stage);
    ASSERT_NE(compiled, nullptr);
    for (const StageInputs& inputs : runs) {
        const StageResults expected = interpret(stage, inputs);
        expect_equal(stage, expected, *compiled, inputs);
    }
}

class OperationsTest : public ::testing::TestWithParam<Type> {};

TEST_P(OperationsTest, CompiledEqualsInterpreted) {
    Operations operations(ir::StageKind::kVolume, GetParam());
    operations.add_varying();
    operations.add_conversions();
    operations.add_traps();
    check(operations.stage(), {operations.inputs()});
}

std::vector<uint32_t> constants_of(Type type) {
    if (type == Type::kBool) return {0, 1};
    if (type == Type::kFloat) {
        return {0u,          0x80000000u, 0x3f800000u, 0xbf800000u,
                0x7fc00000u, 0x7f800000u, 0x40400000u, 0x00000001u};
    }
    return {0u, 1u, 0xffffffffu, 0x80000000u, 7u, 31u, 0x7fffffffu, 0xfffffff9u};
}

/// A few at a time: a kernel of thousands of results takes minutes to compile.
void check_constants(Type type, size_t first) {
    Operations operations(ir::StageKind::kVolume, type);
    const std::vector<uint32_t> values = constants_of(type);
    for (size_t k = first; k < std::min(first + 2, values.size()); ++k) {
        const uint32_t bits = values[k];
        ir::Instr constant;
        constant.type = type;
        constant.bits = bits;
        const ir::ValueId c = operations.builder().append(constant);
        operations.add_all(" const " + std::to_string(bits), operations.x(), c);
        operations.add_all(" const first " + std::to_string(bits), c, operations.x());
    }
    check(operations.stage(), {operations.inputs()});
}

TEST_P(OperationsTest, ConstantOperands) {
    for (size_t k = 0; k < constants_of(GetParam()).size(); k += 2) {
        check_constants(GetParam(), k);
#ifdef OPENFAB_SANITIZED
        break;
#endif
    }
}

TEST_P(OperationsTest, OneByOneWithATail) {
    Operations operations(ir::StageKind::kSurfaceBounds, GetParam());
    operations.add_varying();
    std::vector<StageInputs> runs = {operations.inputs()};
    for (const int32_t elements : {1, 3, 8, 9}) {
        StageInputs few = operations.inputs();
        few.elements = std::min(elements, few.elements);
        runs.push_back(std::move(few));
    }
    check(operations.stage(), runs);
}

INSTANTIATE_TEST_SUITE_P(Types, OperationsTest,
                         ::testing::Values(Type::kFloat, Type::kInt, Type::kUint, Type::kBool),
                         [](const auto& info) { return std::string(ir::spelling(info.param)); });

}  // namespace

}  // namespace openfab::testing
