// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Where a box need not look at the surface, every distance within its bounds, with any attributes,
// gives its points the same outputs. Seeds are printed with a failure.

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "abi/looks.h"
#include "abi/shape_distance.h"
#include "compiler/interp/evaluate.h"
#include "compiler/passes/form_shape_bounds.h"
#include "compiler/passes/form_volume_bounds.h"
#include "compiler/passes/pipeline.h"
#include "tests/exec/random_stage.h"

namespace openfab::testing {

namespace {

using ir::Op;
using ir::Type;
using ir::ValueId;
using Key = std::array<int32_t, 3>;

constexpr Key kDistance = {OPENFAB_ARG_DISTANCE, 0, 0};

class Values : public interp::Environment {
  public:
    uint32_t input(int32_t kind, int32_t a, int32_t b) const override {
        return values.at({kind, a, b});
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }
    void set(const Key& key, float value) { values[key] = std::bit_cast<uint32_t>(value); }

    std::map<Key, uint32_t> values;
};

/// A box whose attributes are unknown, as those of pieces are, and whose distance is narrow.
struct Box {
    Values ends, uniforms;
    std::map<Key, std::array<float, 2>> coordinates;
    std::array<float, 2> distance{};
};

Box random_box(std::mt19937* random) {
    Box box;
    const auto narrow = [&] {
        const float lo = random_float(random);
        return std::array{lo, lo + std::abs(lo) * ((*random)() % 2 == 0 ? 0.01f : 0.5f)};
    };
    for (int32_t k = 0; k < kRandomFloats; ++k) {
        const float nan = std::numeric_limits<float>::quiet_NaN();
        box.ends.set({OPENFAB_ARG_NEAREST_LO, 0, k}, nan);
        box.ends.set({OPENFAB_ARG_NEAREST_HI, 0, k}, nan);
        const std::array<float, 2> ends = narrow();
        box.coordinates[{ir::kVoxelCoord, k, 0}] = ends;
        box.ends.set({ir::kVoxelCoordLo, k, 0}, ends[0]);
        box.ends.set({ir::kVoxelCoordHi, k, 0}, ends[1]);
    }
    for (int32_t k = 0; k < kRandomInts; ++k) {
        box.ends.values[{OPENFAB_ARG_NEAREST_LO, 1, k}] = 0x80000000u;
        box.ends.values[{OPENFAB_ARG_NEAREST_HI, 1, k}] = 0x7fffffffu;
    }
    box.distance = narrow();
    box.ends.set({OPENFAB_ARG_DISTANCE_LO, 0, 0}, box.distance[0]);
    box.ends.set({OPENFAB_ARG_DISTANCE_HI, 0, 0}, box.distance[1]);
    box.uniforms.set({OPENFAB_ARG_UNIFORM, kFloatUniform, 0}, random_float(random));
    box.uniforms.values[{OPENFAB_ARG_UNIFORM, kIntUniform, 0}] =
        static_cast<uint32_t>(random_int(random));
    for (const auto& [key, bits] : box.uniforms.values)
        box.ends.values[key] = bits;
    return box;
}

float between(const std::array<float, 2>& ends, std::mt19937* random) {
    const float t = static_cast<float>((*random)() >> 8) * 0x1p-24f;
    return std::fmin(std::fmax(ends[0] + (ends[1] - ends[0]) * t, ends[0]), ends[1]);
}

/// What a query might say.
void answer(const Box& box, std::mt19937* random, Values* point) {
    point->set(kDistance, (*random)() % 2 == 0 ? box.distance[(*random)() % 2]
                                               : between(box.distance, random));
    for (int32_t k = 0; k < kRandomFloats; ++k)
        point->set({OPENFAB_ARG_NEAREST, 0, k}, random_float(random));
    for (int32_t k = 0; k < kRandomInts; ++k)
        point->values[{OPENFAB_ARG_NEAREST, 1, k}] = static_cast<uint32_t>(random_int(random));
}

bool same(Type type, uint32_t a, uint32_t b) {
    const auto x = std::bit_cast<float>(a), y = std::bit_cast<float>(b);
    return a == b || (type == Type::kFloat && ((x == 0 && y == 0) || (x != x && y != y)));
}

struct Tally {
    int blind = 0, all = 0;
};

void check(const ir::Stage& stage, std::mt19937* random, Tally* tally) {
    const ir::Stage bounds = passes::form_volume_bounds(stage);
    ASSERT_EQ(ir::verify(bounds), "");
    if (bounds.outputs.size() == 2 * stage.outputs.size()) return;  // reads no distance
    ASSERT_EQ(bounds.outputs.back().a, abi::kLooksSlot);
    for (int n = 0; n < 12; ++n) {
        const Box box = random_box(random);
        ++tally->all;
        if (std::bit_cast<float>(interp::evaluate(bounds, box.ends).back()) != 0) continue;
        ++tally->blind;
        for (int k = 0; k < 12; ++k) {
            Values point = box.uniforms;
            for (const auto& [key, ends] : box.coordinates)
                point.set(key, between(ends, random));
            answer(box, random, &point);
            const std::vector<uint32_t> one = interp::evaluate(stage, point);
            answer(box, random, &point);
            const std::vector<uint32_t> other = interp::evaluate(stage, point);
            for (size_t j = 0; j < one.size(); ++j) {
                ASSERT_TRUE(same(stage.instrs[stage.outputs[j].value].type, one[j], other[j]))
                    << stage.outputs[j].name << ": " << std::hex << one[j] << " and " << other[j]
                    << "\n"
                    << ir::dump(stage);
            }
        }
    }
}

TEST(Looks, WhatIsNotLookedAtChangesNothing) {
    Tally tally;
    for (uint32_t seed = 1; seed <= 1500; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        std::mt19937 random(seed * 7919);
        check(seed % 2 == 0 ? random_stage(seed, 12) : random_stage_with_functions(seed, 8),
              &random, &tally);
        if (::testing::Test::HasFatalFailure()) return;
    }
    // To look everywhere would pass, too.
    EXPECT_GT(tally.blind * 20, tally.all) << tally.blind << " of " << tally.all;
}

/// distance < -2 || x < 1 ? 0 : (attribute of the layer at -1 to 0)
ir::Stage layers() {
    ir::Stage stage;
    ir::Builder b(&stage);
    const ValueId d = b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    const ValueId x = b.input(Type::kFloat, ir::kVoxelCoord, 0, 0);
    const ValueId attribute = b.input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, 0);
    const ValueId deep = b.emit(Op::kLt, {d, b.constant(-2.0f)});
    const ValueId here = b.emit(Op::kLt, {x, b.constant(1.0f)});
    const ValueId layer = b.select(b.emit(Op::kGt, {d, b.constant(-1.0f)}), attribute, x);
    const ValueId w = b.select(b.emit(Op::kOr, {deep, here}), b.constant(0.0f), layer);
    stage.outputs = {{"w", OPENFAB_ARG_WEIGHT, 0, 0, w}};
    return stage;
}

TEST(Looks, FollowsFromConditionsThatAreDecided) {
    const ir::Stage bounds = passes::form_volume_bounds(layers());
    const auto looks = [&](float lo, float hi, float x0, float x1) {
        Box box;
        std::mt19937 random(1);
        box = random_box(&random);
        box.ends.set({OPENFAB_ARG_DISTANCE_LO, 0, 0}, lo);
        box.ends.set({OPENFAB_ARG_DISTANCE_HI, 0, 0}, hi);
        box.ends.set({ir::kVoxelCoordLo, 0, 0}, x0);
        box.ends.set({ir::kVoxelCoordHi, 0, 0}, x1);
        return std::bit_cast<float>(interp::evaluate(bounds, box.ends).back()) != 0;
    };
    EXPECT_FALSE(looks(-5, -3, 0, 9)) << "all are deep";
    EXPECT_FALSE(looks(-1.9f, -1.1f, 0, 9)) << "none is deep, none in the layer: x decides alone";
    EXPECT_TRUE(looks(-2.5f, -1.5f, 0, 9)) << "some may be deep";
    EXPECT_TRUE(looks(-0.5f, -0.1f, 0, 9)) << "in the layer";
    EXPECT_FALSE(looks(-5, -0.1f, 0, 0.5f)) << "x decides alone";
}

TEST(Looks, TellsZerosApartWhereAQuotientDoes) {
    // 1 / min(max(distance, -0), 0): of zeros only, and yet of two infinities.
    ir::Stage stage;
    ir::Builder b(&stage);
    const ValueId d = b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    const ValueId zero = b.emit(Op::kMax, {d, b.constant(0.0f)});
    stage.outputs = {{"w", OPENFAB_ARG_WEIGHT, 0, 0, b.emit(Op::kDiv, {b.constant(1.0f), zero})}};
    const ir::Stage bounds = passes::form_volume_bounds(stage);
    Values ends;
    ends.set({OPENFAB_ARG_DISTANCE_LO, 0, 0}, -2);
    ends.set({OPENFAB_ARG_DISTANCE_HI, 0, 0}, -1);
    EXPECT_EQ(std::bit_cast<float>(interp::evaluate(bounds, ends).back()), 1);
}

TEST(Looks, IsAnOutputOnlyWhereItFollowsFromTheDistance) {
    ir::Fablet fablet;
    fablet.volume = layers();
    EXPECT_EQ(passes::run_pipeline(fablet).stages.volume_bounds.outputs.size(), 3u);
    // An amount that is the distance itself: it is always looked at.
    ir::Stage plain;
    ir::Builder b(&plain);
    plain.outputs = {
        {"w", OPENFAB_ARG_WEIGHT, 0, 0, b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0)}};
    fablet.volume = plain;
    const ir::Stage bounds = passes::run_pipeline(fablet).stages.volume_bounds;
    EXPECT_TRUE(bounds.outputs.size() == 2 || passes::says_looks(bounds));
}

/// The stage with the inputs of a shape: its point, a distance to an object, uniforms.
ir::Stage as_shape(ir::Stage stage) {
    for (ir::Instr& instr : stage.instrs) {
        if (instr.op != Op::kInput) continue;
        if (instr.kind == ir::kVoxelCoord) {
            instr.kind = OPENFAB_ARG_SHAPE_POINT;
        } else if (instr.kind == OPENFAB_ARG_DISTANCE) {
            instr.kind = abi::kShapeDistance;
        } else if (instr.kind == OPENFAB_ARG_NEAREST) {
            instr.kind = OPENFAB_ARG_UNIFORM;
            instr.a = instr.type == Type::kFloat ? kFloatUniform : kIntUniform;
            instr.b = 0;
        }
    }
    return stage;
}

/// The ends of a box of a shape's inputs.
Values shape_ends(const Box& box) {
    Values ends = box.uniforms;
    for (const auto& [key, range] : box.coordinates) {
        ends.set({OPENFAB_ARG_SHAPE_POINT_LO, key[1], 0}, range[0]);
        ends.set({OPENFAB_ARG_SHAPE_POINT_HI, key[1], 0}, range[1]);
    }
    ends.set({abi::kShapeDistanceLo, 0, 0}, box.distance[0]);
    ends.set({abi::kShapeDistanceHi, 0, 0}, box.distance[1]);
    return ends;
}

bool shape_looks(const ir::Stage& bounds, const Box& box) {
    return std::bit_cast<float>(interp::evaluate(bounds, shape_ends(box)).back()) != 0;
}

TEST(ShapeLooks, WhatIsNotLookedAtChangesNoBit) {
    Tally tally;
    for (uint32_t seed = 1; seed <= 1500; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        std::mt19937 random(seed * 7907);
        const ir::Stage stage =
            as_shape(seed % 2 == 0 ? random_stage(seed, 12) : random_stage_with_functions(seed, 8));
        const ir::Stage bounds = passes::form_shape_bounds(stage);
        ASSERT_EQ(ir::verify(bounds), "");
        if (bounds.outputs.size() == 2 * stage.outputs.size()) continue;  // reads no distance
        for (int n = 0; n < 12; ++n) {
            const Box box = random_box(&random);
            ++tally.all;
            if (shape_looks(bounds, box)) continue;
            ++tally.blind;
            for (int k = 0; k < 12; ++k) {
                Values point = box.uniforms;
                for (const auto& [key, ends] : box.coordinates)
                    point.set({OPENFAB_ARG_SHAPE_POINT, key[1], 0}, between(ends, &random));
                std::array<std::vector<uint32_t>, 2> found;
                for (auto& of : found) {
                    point.set({abi::kShapeDistance, 0, 0}, between(box.distance, &random));
                    of = interp::evaluate(stage, point);
                }
                for (size_t j = 0; j < found[0].size(); ++j) {
                    const auto a = std::bit_cast<float>(found[0][j]);
                    const auto b = std::bit_cast<float>(found[1][j]);
                    const bool nans = stage.instrs[stage.outputs[j].value].type == Type::kFloat &&
                                      a != a && b != b;
                    ASSERT_TRUE(found[0][j] == found[1][j] || nans) << stage.outputs[j].name << "\n"
                                                                    << ir::dump(stage);
                }
            }
        }
    }
    EXPECT_GT(tally.blind * 20, tally.all) << tally.blind << " of " << tally.all;
}

TEST(ShapeLooks, TheLargerOfTwoDoesNotFollowFromTheSmaller) {
    // max(x, distance - 1)
    ir::Stage stage;
    ir::Builder b(&stage);
    const ValueId x = b.input(Type::kFloat, OPENFAB_ARG_SHAPE_POINT, 0, 0);
    const ValueId d = b.input(Type::kFloat, abi::kShapeDistance, 0, 0);
    const ValueId skin = b.emit(Op::kSub, {d, b.constant(1.0f)});
    for (const Op op : {Op::kMax, Op::kMin}) {
        stage.outputs = {{"value", OPENFAB_ARG_SHAPE_VALUE, 0, 0, b.emit(op, {x, skin})}};
        const ir::Stage bounds = passes::form_shape_bounds(stage);
        const auto looks = [&](float x_lo, float x_hi, float lo, float hi) {
            Box box;
            box.coordinates[{ir::kVoxelCoord, 0, 0}] = {x_lo, x_hi};
            box.distance = {lo, hi};
            return shape_looks(bounds, box);
        };
        const float sign = op == Op::kMax ? 1 : -1;
        EXPECT_FALSE(looks(sign * 20, sign * 20 + 1, -10, 10));
        EXPECT_TRUE(looks(0, 1, 0, 3));
        EXPECT_TRUE(looks(-sign * 20, -sign * 20, -10, 10));
        EXPECT_TRUE(looks(0, 0, std::numeric_limits<float>::quiet_NaN(), 3));
    }
}

TEST(ShapeLooks, IsAnOutputOnlyWhereItFollowsFromADistance) {
    ir::Stage stage;
    ir::Builder b(&stage);
    const ValueId x = b.input(Type::kFloat, OPENFAB_ARG_SHAPE_POINT, 0, 0);
    stage.outputs = {{"value", OPENFAB_ARG_SHAPE_VALUE, 0, 0, b.emit(Op::kMax, {x, x})}};
    EXPECT_EQ(passes::form_shape_bounds(stage).outputs.size(), 2u);
}

}  // namespace

}  // namespace openfab::testing
