// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Every function of compiler/functions on edge cases and random values: expanded to primitive
// operations and compiled, against the interpreter, bit for bit.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/eliminate_dead_values.h"
#include "compiler/passes/expand_functions.h"
#include "compiler/passes/simplify.h"
#include "tests/exec/compiled_stage.h"

namespace openfab::testing {

namespace {

using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr int32_t kBlocks = 4;
constexpr size_t kPlaces = 512 * kBlocks;

const std::vector<float>& awkward() {
    static const std::vector<float> values = {0.0f,
                                              -0.0f,
                                              1.0f,
                                              -1.0f,
                                              0x1p-149f,
                                              -0x1p-149f,
                                              0x1.fffffcp-127f,
                                              0x1p-126f,
                                              0.5f,
                                              -0.5f,
                                              1.5f,
                                              2.0f,
                                              -2.0f,
                                              3.0f,
                                              -3.0f,
                                              1e-10f,
                                              -1e-10f,
                                              88.7f,
                                              -87.3f,
                                              -103.9f,
                                              -104.1f,
                                              128.0f,
                                              -149.5f,
                                              0.7071067f,
                                              1.4142135f,
                                              1.2247449f,
                                              32768.0f,
                                              -32769.0f,
                                              65536.5f,
                                              4194303.5f,
                                              4194305.0f,
                                              1e10f,
                                              -1e30f,
                                              0x1.fffffep127f,
                                              -0x1.fffffep127f,
                                              std::numeric_limits<float>::infinity(),
                                              -std::numeric_limits<float>::infinity(),
                                              std::numeric_limits<float>::quiet_NaN()};
    return values;
}

uint32_t pick(std::mt19937* random) {
    const uint32_t draw = (*random)();
    switch (draw % 4) {
        case 0:
            return std::bit_cast<uint32_t>(awkward()[(draw >> 8) % awkward().size()]);
        case 1:
            return (*random)();
        default:
            return std::bit_cast<uint32_t>(static_cast<float>(static_cast<int32_t>((*random)())) *
                                           0x1p-26f);
    }
}

/// A stage with varying floats 0 to 3, ints 0 to 3 (periods) and a uint (a seed).
class Functions {
  public:
    Functions() {
        stage_.kind = ir::StageKind::kVolume;
        for (int32_t k = 0; k < 4; ++k) {
            x_.push_back(b_.input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, k));
            periods_.push_back(b_.input(Type::kInt, OPENFAB_ARG_NEAREST, 1, k));
        }
        seed_ = b_.input(Type::kUint, OPENFAB_ARG_NEAREST, 2, 0);
    }

    void elementary(Op op) {
        std::vector<ValueId> args(x_.begin(), x_.begin() + ir::arity(op));
        output(ir::spelling(op), b_.emit(op, args));
    }

    void noise(Op op, size_t axes, int32_t which) {
        std::vector<ValueId> args(x_.begin(), x_.begin() + static_cast<ptrdiff_t>(axes));
        if (op == Op::kNoise && (which & ir::kPeriodic) != 0) {
            args.insert(args.end(), periods_.begin(),
                        periods_.begin() + static_cast<ptrdiff_t>(axes));
        }
        args.push_back(seed_);
        output(ir::spelling(op), b_.function(op, which, args));
    }

    void hash(size_t words, int32_t which) {
        std::vector<ValueId> args;
        for (size_t k = 0; k + 1 < words; ++k)
            args.push_back(b_.bit_cast(periods_[k], Type::kUint));
        args.push_back(seed_);
        output("hash", b_.function(Op::kHash, which, args));
    }

    void check() const {
        ASSERT_EQ(ir::verify(stage_), "");
        ir::Stage written = stage_;
        passes::expand_functions(&written);
        ASSERT_EQ(ir::verify(written), "");
        passes::simplify(&written);
        passes::eliminate_common_values(&written);
        passes::eliminate_dead_values(&written);
        const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(written);
        ASSERT_NE(compiled, nullptr);
        const StageInputs in = inputs();
        const StageResults expected = interpret(stage_, in);
        expect_equal(stage_, expected, interpret(written, in), "written out");
        expect_equal(stage_, expected, *compiled, in);
    }

  private:
    StageInputs inputs() const {
        std::mt19937 random(77);
        StageInputs in;
        in.elements = kBlocks;
        const auto fill = [&](int32_t a, int32_t b, const auto& next) {
            std::vector<uint32_t> bits(kPlaces);
            for (uint32_t& value : bits)
                value = next();
            in.set(OPENFAB_ARG_NEAREST, a, b, std::move(bits));
        };
        for (int32_t k = 0; k < 4; ++k) {
            fill(0, k, [&] { return pick(&random); });
            fill(1, k, [&] {
                return random() % 4 == 0 ? random() : static_cast<uint32_t>(random() % 9) - 1;
            });
        }
        fill(2, 0, [&] { return random() % 2 == 0 ? random() : random() % 4; });
        return in;
    }

    void output(const std::string& name, ValueId value) {
        const auto slot = static_cast<int32_t>(stage_.outputs.size());
        stage_.outputs.push_back({name, OPENFAB_ARG_WEIGHT, slot, 0, value});
    }

    ir::Stage stage_;
    ir::Builder b_{&stage_};
    std::vector<ValueId> x_;
    std::vector<ValueId> periods_;
    ValueId seed_ = 0;
};

TEST(Functions, Elementary) {
    Functions functions;
    for (auto op = static_cast<int>(Op::kSin); op <= static_cast<int>(Op::kCbrt); ++op)
        functions.elementary(static_cast<Op>(op));
    functions.check();
}

class NoiseTest : public ::testing::TestWithParam<size_t> {};

TEST_P(NoiseTest, Perlin) {
    const size_t axes = GetParam();
    Functions functions;
    functions.noise(Op::kNoise, axes, 0);
    functions.noise(Op::kNoise, axes, ir::kPeriodic);
    functions.noise(Op::kNoise, axes, static_cast<int32_t>(axes));
    functions.check();
}

TEST_P(NoiseTest, SimplexAndCellular) {
    const size_t axes = GetParam();
    if (axes < 2) GTEST_SKIP() << "there is none of one axis";
    Functions functions;
    functions.noise(Op::kSimplex, axes, 0);
    functions.noise(Op::kSimplex, axes, 1);
    if (axes < 4) {
        for (const int32_t which : {0, 1, 2})
            functions.noise(Op::kCellular, axes, which);
    }
    functions.check();
}

INSTANTIATE_TEST_SUITE_P(Axes, NoiseTest, ::testing::Values(1, 2, 3, 4));

TEST(Functions, Hashes) {
    Functions functions;
    for (size_t words = 1; words <= 5; ++words)
        functions.hash(words, static_cast<int32_t>(words) % 4);
    functions.check();
}

}  // namespace

}  // namespace openfab::testing
