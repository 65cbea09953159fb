// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/ir/ir.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "compiler/ir/text.h"
#include "tests/support/ir/read.h"

namespace openfab::ir {
namespace {

/// Every operation, every type, unusual constants, names and annotations.
Fablet sampler() {
    Fablet f;
    f.name = "All";
    f.uniform_value_count = 3;
    f.texture_count = 1;
    f.slot_count = 2;
    f.void_slot = 1;
    Uniform u;
    u.name = "size";
    u.type_name = "float3";
    u.components = 3;
    u.default_bits = {0x80000000u, 0x7fc00001u, 0x3dcccccdu};
    u.annotations = {{"help", "a \"quoted\" \\ text\nof two lines"}, {"min", "0"}};
    f.uniforms.push_back(u);
    u = {};
    u.name = "m";
    u.type_name = "Material";
    u.kind = OPENFAB_UNIFORM_MATERIAL;
    f.uniforms.push_back(u);
    Varying v;
    v.name = "face";
    v.type_name = "int";
    v.type = Type::kInt;
    v.default_bits = {0xfffffffeu};
    f.surface_inputs.push_back(v);
    v.default_bits.clear();
    v.source = 0;
    f.surface_outputs.push_back(v);
    f.nearest.push_back(v);
    f.has_surface = true;
    f.surface.kind = StageKind::kSurface;

    Builder b(&f.volume);
    const ValueId x = b.input(Type::kFloat, kVoxelCoord, 0, 0);
    const ValueId i = b.input(Type::kInt, OPENFAB_ARG_NEAREST, 0, 0);
    const ValueId c = b.constant(std::numeric_limits<float>::infinity());
    b.constant(-0.0f);
    b.constant(1e-45f);
    b.constant(0xffffffffu);
    b.constant(std::numeric_limits<int32_t>::min());
    const ValueId t = b.constant(true);
    for (int op = static_cast<int>(Op::kAdd); op <= static_cast<int>(Op::kMod); ++op) {
        b.emit(static_cast<Op>(op), {x, c});
    }
    for (Op op : {Op::kBitAnd, Op::kBitOr, Op::kBitXor, Op::kShl, Op::kShr, Op::kMin, Op::kMax})
        b.emit(op, {i, i});
    for (Op op : {Op::kBitNot, Op::kNeg, Op::kAbs})
        b.emit(op, {i});
    for (Op op : {Op::kEq, Op::kNe, Op::kLt, Op::kLe, Op::kGt, Op::kGe})
        b.emit(op, {x, c});
    for (Op op : {Op::kSqrt, Op::kFloor, Op::kCeil, Op::kRound, Op::kTrunc, Op::kIsNan})
        b.emit(op, {x});
    b.emit(Op::kAnd, {t, t});
    b.emit(Op::kNot, {b.emit(Op::kOr, {t, t})});
    b.convert(i, Type::kUint);
    const ValueId s = b.select(t, x, c);
    b.sample(0, 2, {t, x, x, x});
    f.volume.outputs = {{"m", OPENFAB_ARG_WEIGHT, 0, 0, s}, {"VOID", OPENFAB_ARG_WEIGHT, 1, 0, x}};
    return f;
}

TEST(IrText, ReadInvertsDump) {
    const Fablet f = sampler();
    ASSERT_EQ(verify(f.volume), "");
    const std::string text = dump(f);
    std::string fault;
    const std::optional<Fablet> back = read(text, &fault);
    ASSERT_TRUE(back.has_value()) << fault;
    EXPECT_EQ(dump(*back), text);
    ASSERT_EQ(back->volume.instrs.size(), f.volume.instrs.size());
    for (size_t i = 0; i < f.volume.instrs.size(); ++i) {
        EXPECT_EQ(back->volume.instrs[i].bits, f.volume.instrs[i].bits) << i;
        EXPECT_EQ(back->volume.instrs[i].args, f.volume.instrs[i].args) << i;
        EXPECT_EQ(back->volume.instrs[i].kind, f.volume.instrs[i].kind) << i;
    }
    EXPECT_EQ(back->uniforms[0].default_bits, f.uniforms[0].default_bits);
    EXPECT_EQ(back->uniforms[0].annotations, f.uniforms[0].annotations);
    EXPECT_EQ(back->void_slot, 1);
    EXPECT_EQ(back->nearest[0].source, 0);
}

TEST(IrText, FaultsNameTheLine) {
    const auto fault_of = [](const char* text) {
        std::string fault;
        EXPECT_FALSE(read(text, &fault).has_value()) << text;
        return fault;
    };
    EXPECT_EQ(fault_of("fablet A\n  nonsense\n"), "line 2: unexpected `nonsense`");
    EXPECT_EQ(fault_of("%0 = const float 1\n"), "line 1: an instruction outside a stage");
    EXPECT_EQ(fault_of("stage volume\n%1 = const float 1\n"), "line 2: expected %0");
    EXPECT_EQ(fault_of("stage volume\n%0 = fly float\n"), "line 2: no operation `fly`");
    EXPECT_EQ(fault_of("stage volume\n%0 = const int 1.5\n"), "line 2: `1.5` is not a valid int");
    EXPECT_EQ(fault_of("stage volume\n%0 = const float\n"), "line 2: the line ends early");
    EXPECT_EQ(fault_of("stage volume\n%0 = const float 1 2\n"),
              "line 2: expected a value, not `2`");
    EXPECT_EQ(fault_of("stage cellar\n"), "line 1: no stage `cellar`");
}

TEST(IrText, EveryKindHasAName) {
    for (int32_t kind = 0; kind <= OPENFAB_ARG_SURFACE_OUT_HI; ++kind) {
        ASSERT_NE(kind_name(kind), nullptr) << kind;
        EXPECT_EQ(kind_from_name(kind_name(kind)), kind);
    }
    EXPECT_STREQ(kind_name(OPENFAB_ARG_DISTANCE), "distance");
    EXPECT_STREQ(kind_name(OPENFAB_ARG_SURFACE_IN), "surface_in");
    EXPECT_STREQ(kind_name(OPENFAB_ARG_POSITION), "position");
    EXPECT_STREQ(kind_name(OPENFAB_ARG_SURFACE_OUT_HI), "surface_out_hi");
    EXPECT_EQ(kind_from_name("voxel_coord_hi"), kVoxelCoordHi);
    EXPECT_EQ(kind_name(99), nullptr);
}

/// A stage of one float input, then `instr`.
std::string fault_of(Instr instr) {
    Stage stage;
    Builder b(&stage);
    b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    b.constant(true);
    b.append(std::move(instr));
    return verify(stage);
}

TEST(IrVerify, FindsEachKindOfFault) {
    EXPECT_EQ(fault_of({Op::kAdd, Type::kFloat, 0, 0, 0, 0, {0, 0}, {}}), "");
    EXPECT_EQ(fault_of({Op::kAdd, Type::kFloat, 0, 0, 0, 0, {0, 2}, {}}),
              "%2 = add: argument %2 does not come earlier");
    EXPECT_EQ(fault_of({Op::kAdd, Type::kFloat, 0, 0, 0, 0, {0}, {}}),
              "%2 = add: 1 arguments, not 2");
    EXPECT_EQ(fault_of({Op::kAdd, Type::kFloat, 0, 0, 0, 0, {0, 1}, {}}),
              "%2 = add: operands of different types");
    EXPECT_EQ(fault_of({Op::kAdd, Type::kInt, 0, 0, 0, 0, {0, 0}, {}}),
              "%2 = add: a result of type int");
    EXPECT_EQ(fault_of({Op::kAdd, Type::kBool, 0, 0, 0, 0, {1, 1}, {}}),
              "%2 = add: not defined on bool");
    EXPECT_EQ(fault_of({Op::kShl, Type::kFloat, 0, 0, 0, 0, {0, 0}, {}}),
              "%2 = shl: not defined on float");
    EXPECT_EQ(fault_of({Op::kLt, Type::kFloat, 0, 0, 0, 0, {0, 0}, {}}),
              "%2 = lt: a result of type float");
    EXPECT_EQ(fault_of({Op::kSelect, Type::kFloat, 0, 0, 0, 0, {0, 0, 0}, {}}),
              "%2 = select: the condition is not a bool");
    EXPECT_NE(fault_of({Op::kSample, Type::kFloat, 0, 0, 0, 0, {1, 0, 0}, {}}), "");
    EXPECT_EQ(fault_of({Op::kSample, Type::kFloat, 0, 0, 0, 0, {0, 0, 0, 0}, {}}),
              "%2 = sample: the guard is not a bool");
    EXPECT_EQ(fault_of({Op::kConst, Type::kBool, 2, 0, 0, 0, {}, {}}),
              "%2 = const: a bool is 0 or 1");
    Stage stage;
    stage.outputs = {{"x", OPENFAB_ARG_WEIGHT, 0, 0, 5}};
    EXPECT_EQ(verify(stage), "output x: no value %5");
}

}  // namespace
}  // namespace openfab::ir
