// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The interval rule of each function over many boxes: values inside lie within the bounds. And
// bounds are useful: small boxes have narrow ones.

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <random>

#include "compiler/interp/evaluate.h"
#include "compiler/passes/form_volume_bounds.h"

namespace openfab::testing {

namespace {

using ir::Op;
using ir::Type;

#ifdef OPENFAB_SANITIZED
constexpr int kBoxes = 300;
#else
constexpr int kBoxes = 3000;
#endif
constexpr int kPoints = 40;

class Values : public interp::Environment {
  public:
    uint32_t input(int32_t kind, int32_t a, int32_t b) const override {
        return values.at({kind, a, b});
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }
    void set(int32_t kind, int32_t b, float value) {
        values[{kind, 0, b}] = std::bit_cast<uint32_t>(value);
    }

    std::map<std::array<int32_t, 3>, uint32_t> values;
};

/// One function of nearest floats 0 to 3.
ir::Stage stage_of(Op op, size_t axes, int32_t which, bool periodic) {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder b(&stage);
    ir::Instr instr;
    instr.op = op;
    instr.type = Type::kFloat;
    instr.a = which + (periodic ? ir::kPeriodic : 0);
    for (size_t k = 0; k < axes; ++k) {
        instr.args.push_back(
            b.input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, static_cast<int32_t>(k)));
    }
    if (ir::arity(op) < 0) {
        for (size_t k = 0; periodic && k < axes; ++k)
            instr.args.push_back(b.constant(static_cast<int32_t>(3 + 2 * k)));
        instr.args.push_back(b.constant(uint32_t{5}));
    }
    const ir::ValueId value = b.append(instr);
    stage.outputs.push_back({"out", OPENFAB_ARG_WEIGHT, 0, 0, value});
    return stage;
}

struct Case {
    Op op;
    size_t axes;
    int32_t which;
    bool periodic;
};

float centre(std::mt19937* random) {
    const float unit = static_cast<float>((*random)() >> 8) * 0x1p-23f - 1.0f;
    switch ((*random)() % 6) {
        case 0:
            return unit;
        case 1:
            return unit * 100.0f;
        case 2:
            return unit * 40000.0f;
        case 3:
            return std::ldexp(unit, static_cast<int>((*random)() % 60) - 30);
        case 4:
            return std::round(unit * 8.0f) * 0.25f;
        default:
            return unit * 6.0f;
    }
}

void check(const Case& c) {
    SCOPED_TRACE(::testing::Message() << ir::spelling(c.op) << " axes " << c.axes << " which "
                                      << c.which << " periodic " << c.periodic);
    const ir::Stage stage = stage_of(c.op, c.axes, c.which, c.periodic);
    ASSERT_EQ(ir::verify(stage), "");
    const ir::Stage bounds = passes::form_volume_bounds(stage);
    std::mt19937 random(static_cast<uint32_t>(c.op) * 31 + static_cast<uint32_t>(c.axes));
    for (int box = 0; box < kBoxes; ++box) {
        Values ends;
        std::array<std::array<float, 2>, 4> sides{};
        const float size = std::ldexp(1.0f, static_cast<int>(random() % 24) - 20);
        for (size_t k = 0; k < c.axes; ++k) {
            const float lo = centre(&random);
            const float width = std::abs(lo) < 1e-3f ? size * std::abs(lo) : size;
            sides[k] = {lo, lo + width * static_cast<float>(random() % 5)};
            ends.set(OPENFAB_ARG_NEAREST_LO, static_cast<int32_t>(k), sides[k][0]);
            ends.set(OPENFAB_ARG_NEAREST_HI, static_cast<int32_t>(k), sides[k][1]);
        }
        const std::vector<uint32_t> found = interp::evaluate(bounds, ends);
        const float lo = std::bit_cast<float>(found[0]);
        const float hi = std::bit_cast<float>(found[1]);
        if (std::isnan(lo)) continue;
        for (int point = 0; point < kPoints; ++point) {
            Values at;
            for (size_t k = 0; k < c.axes; ++k) {
                const float t = point < 2 ? static_cast<float>(point)
                                          : static_cast<float>(random() >> 8) * 0x1p-24f;
                const float x = sides[k][0] + (sides[k][1] - sides[k][0]) * t;
                at.set(OPENFAB_ARG_NEAREST, static_cast<int32_t>(k),
                       std::fmin(std::fmax(x, sides[k][0]), sides[k][1]));
            }
            const float value = std::bit_cast<float>(interp::evaluate(stage, at)[0]);
            ASSERT_TRUE(lo <= value && value <= hi)
                << value << " outside " << lo << " .. " << hi << " box " << box << " at "
                << std::bit_cast<float>(at.values.begin()->second);
        }
    }
}

TEST(FunctionBounds, HoldOverBoxes) {
    for (auto op = static_cast<int>(Op::kSin); op <= static_cast<int>(Op::kCbrt); ++op) {
        const auto axes = static_cast<size_t>(ir::arity(static_cast<Op>(op)));
        check({static_cast<Op>(op), axes, 0, false});
        if (::testing::Test::HasFatalFailure()) return;
    }
}

TEST(FunctionBounds, HoldOverBoxesOfNoise) {
    for (size_t axes = 1; axes <= 4; ++axes) {
        for (int32_t which = 0; which <= static_cast<int32_t>(axes); ++which) {
            check({Op::kNoise, axes, which, false});
            check({Op::kNoise, axes, which, true});
            if (axes > 1) check({Op::kSimplex, axes, which, false});
            if (axes == 2 || axes == 3) check({Op::kCellular, axes, std::min(which, 2), false});
            if (::testing::Test::HasFatalFailure()) return;
        }
    }
}

/// Width of the bounds over a cube of the given size around a point.
float width(const Case& c, float place, float size) {
    const ir::Stage bounds = passes::form_volume_bounds(stage_of(c.op, c.axes, c.which, false));
    Values ends;
    for (int32_t k = 0; k < static_cast<int32_t>(c.axes); ++k) {
        ends.set(OPENFAB_ARG_NEAREST_LO, k, place - size / 2);
        ends.set(OPENFAB_ARG_NEAREST_HI, k, place + size / 2);
    }
    const std::vector<uint32_t> found = interp::evaluate(bounds, ends);
    return std::bit_cast<float>(found[1]) - std::bit_cast<float>(found[0]);
}

TEST(FunctionBounds, AreNarrowOverSmallBoxes) {
    for (auto op = static_cast<int>(Op::kSin); op <= static_cast<int>(Op::kCbrt); ++op) {
        const auto axes = static_cast<size_t>(ir::arity(static_cast<Op>(op)));
        EXPECT_LT(width({static_cast<Op>(op), axes, 0, false}, 0.7f, 0.01f), 0.04f)
            << ir::spelling(static_cast<Op>(op));
    }
    EXPECT_LT(width({Op::kNoise, 3, 0, false}, 3.3f, 0.01f), 0.06f);
    EXPECT_LT(width({Op::kSimplex, 3, 0, false}, 3.3f, 0.01f), 0.13f);
    EXPECT_LT(width({Op::kCellular, 3, 0, false}, 3.3f, 0.01f), 0.02f);
}

}  // namespace

}  // namespace openfab::testing
