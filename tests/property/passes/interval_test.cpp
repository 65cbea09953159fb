// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The interval form of random stages: values at points of a box lie within the bounds of the box,
// and a box of one point gives that point's bits or "unknown". Seeds are printed with a failure.

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include "compiler/interp/evaluate.h"
#include "compiler/passes/form_volume_bounds.h"
#include "tests/exec/random_stage.h"

namespace openfab::testing {

namespace {

using Key = std::array<int32_t, 3>;

constexpr int32_t kOperations = 60;
constexpr uint32_t kStages = 1000;
constexpr int32_t kBoxes = 12;
constexpr int32_t kPoints = 24;

class Values : public interp::Environment {
  public:
    uint32_t input(int32_t kind, int32_t a, int32_t b) const override {
        return values.at({kind, a, b});
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }

    std::map<Key, uint32_t> values;
};

struct Box {
    Values lo_hi;  ///< inputs of the bounds stage
    std::map<Key, std::array<float, 2>> floats;
    std::map<Key, std::array<int32_t, 2>> ints;
    Values uniforms;
};

Key with_kind(Key key, int32_t kind) {
    key[0] = kind;
    return key;
}

Box random_box(std::mt19937* random, bool single) {
    Box box;
    const auto add_float = [&](const Key& key, int32_t lo_kind, int32_t hi_kind) {
        float lo = random_float(random);
        float hi = single || (*random)() % 6 == 0 ? lo : random_float(random);
        // Narrow boxes give useful bounds.
        if (!single && (*random)() % 2 == 0) hi = lo + std::abs(lo) * 0.01f;
        if (lo > hi) std::swap(lo, hi);
        box.floats[key] = {lo, hi};
        box.lo_hi.values[with_kind(key, lo_kind)] = std::bit_cast<uint32_t>(lo);
        box.lo_hi.values[with_kind(key, hi_kind)] = std::bit_cast<uint32_t>(hi);
    };
    for (int32_t k = 0; k < kRandomFloats; ++k) {
        add_float({OPENFAB_ARG_NEAREST, 0, k}, OPENFAB_ARG_NEAREST_LO, OPENFAB_ARG_NEAREST_HI);
        add_float({ir::kVoxelCoord, k, 0}, ir::kVoxelCoordLo, ir::kVoxelCoordHi);
    }
    add_float({OPENFAB_ARG_DISTANCE, 0, 0}, OPENFAB_ARG_DISTANCE_LO, OPENFAB_ARG_DISTANCE_HI);
    for (int32_t k = 0; k < kRandomInts; ++k) {
        const Key key = {OPENFAB_ARG_NEAREST, 1, k};
        int32_t lo = random_int(random);
        int32_t hi = single || (*random)() % 4 == 0 ? lo : random_int(random);
        if (lo > hi) std::swap(lo, hi);
        box.ints[key] = {lo, hi};
        box.lo_hi.values[with_kind(key, OPENFAB_ARG_NEAREST_LO)] = static_cast<uint32_t>(lo);
        box.lo_hi.values[with_kind(key, OPENFAB_ARG_NEAREST_HI)] = static_cast<uint32_t>(hi);
    }
    box.uniforms.values[{OPENFAB_ARG_UNIFORM, kFloatUniform, 0}] =
        std::bit_cast<uint32_t>(random_float(random));
    box.uniforms.values[{OPENFAB_ARG_UNIFORM, kIntUniform, 0}] =
        static_cast<uint32_t>(random_int(random));
    for (const auto& [key, bits] : box.uniforms.values)
        box.lo_hi.values[key] = bits;
    return box;
}

/// Corners, and points between them.
Values random_point(std::mt19937* random, const Box& box) {
    Values out = box.uniforms;
    for (const auto& [key, ends] : box.floats) {
        float value = ends[(*random)() % 2];
        if ((*random)() % 2 == 0) {
            const float t = static_cast<float>((*random)() >> 8) * 0x1p-24f;
            value = std::fmin(std::fmax(ends[0] + (ends[1] - ends[0]) * t, ends[0]), ends[1]);
        }
        out.values[key] = std::bit_cast<uint32_t>(value);
    }
    for (const auto& [key, ends] : box.ints) {
        const auto span = static_cast<uint64_t>(static_cast<int64_t>(ends[1]) - ends[0]);
        const auto step = static_cast<int64_t>((*random)() % (span + 1));
        const int64_t value = (*random)() % 2 == 0 ? ends[(*random)() % 2] : ends[0] + step;
        out.values[key] = static_cast<uint32_t>(static_cast<int32_t>(value));
    }
    return out;
}

bool unknown(ir::Type type, uint32_t lo) {
    return type == ir::Type::kFloat && std::isnan(std::bit_cast<float>(lo));
}

bool contains(ir::Type type, uint32_t lo, uint32_t hi, uint32_t value) {
    switch (type) {
        case ir::Type::kFloat:
            return unknown(type, lo) || (std::bit_cast<float>(lo) <= std::bit_cast<float>(value) &&
                                         std::bit_cast<float>(value) <= std::bit_cast<float>(hi));
        case ir::Type::kInt:
            return static_cast<int32_t>(lo) <= static_cast<int32_t>(value) &&
                   static_cast<int32_t>(value) <= static_cast<int32_t>(hi);
        case ir::Type::kUint:
            return lo <= value && value <= hi;
        // lo: may be false, hi: may be true.
        case ir::Type::kBool:
            return value != 0 ? hi != 0 : lo != 0;
    }
    return false;
}

/// Points (uniforms and what follows from them) keep infinities and NaNs, which are their own
/// bounds.
bool same_special(ir::Type type, uint32_t lo, uint32_t hi, uint32_t value) {
    return type == ir::Type::kFloat && lo == hi && lo == value;
}

struct Tally {
    int64_t known = 0;
    int64_t all = 0;
};

void check_stage(const ir::Stage& stage, uint32_t seed, Tally* tally) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const ir::Stage bounds = passes::form_volume_bounds(stage);
    ASSERT_EQ(ir::verify(bounds), "");
    std::mt19937 random(seed * 7919);
    for (int32_t box_number = 0; box_number < kBoxes; ++box_number) {
        const bool single = box_number % 4 == 0;
        const Box box = random_box(&random, single);
        const std::vector<uint32_t> ends = interp::evaluate(bounds, box.lo_hi);
        for (int32_t k = 0; k < (single ? 1 : kPoints); ++k) {
            const std::vector<uint32_t> values =
                interp::evaluate(stage, random_point(&random, box));
            for (size_t j = 0; j < values.size(); ++j) {
                const ir::Output& output = stage.outputs[j];
                const ir::Type type = stage.instrs[output.value].type;
                const uint32_t lo = ends[2 * j];
                const uint32_t hi = ends[2 * j + 1];
                if (same_special(type, lo, hi, values[j])) continue;
                ASSERT_TRUE(contains(type, lo, hi, values[j]))
                    << output.name << " box " << box_number << std::hex << ": " << values[j]
                    << " is outside " << lo << " .. " << hi << "\n"
                    << ir::dump(stage);
                if (type == ir::Type::kFloat) tally->all++;
                if (type == ir::Type::kFloat && !unknown(type, lo)) tally->known++;
                if (!single || unknown(type, lo) || type == ir::Type::kBool) continue;
                if (type == ir::Type::kFloat && lo == hi) {
                    ASSERT_TRUE(lo == values[j] || std::bit_cast<float>(lo) == 0.0f)
                        << output.name << " of a single point: " << std::hex << lo << " is not "
                        << values[j];
                }
            }
        }
    }
}

TEST(Interval, HoldsWhatPointsGive) {
    Tally tally;
    for (uint32_t seed = 1; seed <= kStages; ++seed) {
        check_stage(random_stage(seed, kOperations), seed, &tally);
        if (::testing::Test::HasFatalFailure()) return;
    }
    // Bounds that are always unknown would pass, too.
    EXPECT_GT(tally.known * 10, tally.all);
}

TEST(Interval, HoldsWhatFunctionsGive) {
    Tally tally;
    for (uint32_t seed = 1; seed <= kStages; ++seed) {
        check_stage(random_stage_with_functions(seed, kOperations / 2), seed, &tally);
        if (::testing::Test::HasFatalFailure()) return;
    }
    EXPECT_GT(tally.known * 10, tally.all);
}

/// abs(q - floor(q) - c), abs(m * (q - round(q)) + c), …: the fraction of a nearest float, moved by
/// constants and by a uniform.
ir::Stage folded(ir::Op whole, float factor, float offset, bool uniform) {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder b(&stage);
    const ir::ValueId q = b.input(ir::Type::kFloat, OPENFAB_ARG_NEAREST, 0, 0);
    ir::ValueId value = b.emit(ir::Op::kSub, {q, b.emit(whole, {q})});
    const ir::ValueId m =
        uniform ? b.input(ir::Type::kFloat, OPENFAB_ARG_UNIFORM, 0, 0) : b.constant(factor);
    value = b.emit(ir::Op::kSub, {b.emit(ir::Op::kMul, {m, value}), b.constant(offset)});
    stage.outputs.push_back({"out", OPENFAB_ARG_WEIGHT, 0, 0, b.emit(ir::Op::kAbs, {value})});
    return stage;
}

/// A fold is continuous, and so exact in narrow boxes, with a break in them or not.
TEST(Interval, OfAFoldIsExact) {
    std::mt19937 random(5);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    int breaks = 0;
    for (int k = 0; k < 4000; ++k) {
        const bool floors = k % 2 == 0, uniform = k % 4 > 1;
        const float factor = std::array{1.0f, 2.0f, -3.0f, 0.25f}[static_cast<size_t>(k / 4 % 4)];
        // Continuous where the fraction starts anew; and anything, which is not.
        const bool continuous = k % 3 != 0;
        const float offset = continuous ? (floors ? 0.5f * factor : 0.0f) : unit() - 0.5f;
        const ir::Stage stage =
            folded(floors ? ir::Op::kFloor : ir::Op::kRound, factor, offset, uniform);
        const ir::Stage bounds = passes::form_volume_bounds(stage);
        const float lo = (unit() - 0.5f) * (k % 5 == 0 ? 1e6f : 8.0f);
        const float hi = lo + unit() * (k % 7 == 0 ? 3.0f : 0.6f);
        Values ends, at;
        ends.values[{OPENFAB_ARG_NEAREST_LO, 0, 0}] = std::bit_cast<uint32_t>(lo);
        ends.values[{OPENFAB_ARG_NEAREST_HI, 0, 0}] = std::bit_cast<uint32_t>(hi);
        ends.values[{OPENFAB_ARG_UNIFORM, 0, 0}] = std::bit_cast<uint32_t>(factor);
        at.values = ends.values;
        const std::vector<uint32_t> known = interp::evaluate(bounds, ends);
        const float low = std::bit_cast<float>(known[0]), high = std::bit_cast<float>(known[1]);
        float least = 1e9f, most = -1e9f;
        constexpr int kSteps = 400;
        for (int step = 0; step <= kSteps; ++step) {
            const float t = static_cast<float>(step) / kSteps;
            const float q = std::fmin(std::fmax(lo + (hi - lo) * t, lo), hi);
            at.values[{OPENFAB_ARG_NEAREST, 0, 0}] = std::bit_cast<uint32_t>(q);
            const float value = std::bit_cast<float>(interp::evaluate(stage, at)[0]);
            ASSERT_TRUE(low <= value && value <= high)
                << value << " at " << q << " is outside " << low << " .. " << high;
            least = std::min(least, value);
            most = std::max(most, value);
        }
        if (!continuous) continue;
        // Up to a step of the samples.
        const float slack = std::abs(factor) * ((hi - lo) / kSteps + std::abs(lo) * 1e-6f);
        EXPECT_NEAR(low, least, slack) << k << ": " << lo << " to " << hi;
        EXPECT_NEAR(high, most, slack) << k << ": " << lo << " to " << hi;
        breaks +=
            std::floor(lo + (floors ? 0.0f : 0.5f)) != std::floor(hi + (floors ? 0.0f : 0.5f));
    }
    EXPECT_GT(breaks, 500);
    // Nothing is known of a fold of what may be infinite.
    const ir::Stage bounds = passes::form_volume_bounds(folded(ir::Op::kFloor, 1, 0.5f, false));
    Values ends;
    ends.values[{OPENFAB_ARG_NEAREST_LO, 0, 0}] = std::bit_cast<uint32_t>(0.0f);
    ends.values[{OPENFAB_ARG_NEAREST_HI, 0, 0}] = 0x7f800000u;
    EXPECT_TRUE(std::isnan(std::bit_cast<float>(interp::evaluate(bounds, ends)[0])));
}

/// The hash of a single list of words is that hash; of several it may be anything.
TEST(Interval, OfAHashIsExactInOneCell) {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder b(&stage);
    const ir::ValueId cell =
        b.convert(b.emit(ir::Op::kFloor, {b.input(ir::Type::kFloat, OPENFAB_ARG_NEAREST, 0, 0)}),
                  ir::Type::kInt);
    ir::Instr hash;
    hash.op = ir::Op::kHash;
    hash.type = ir::Type::kUint;
    hash.args = {b.convert(cell, ir::Type::kUint), b.constant(uint32_t{5})};
    stage.outputs.push_back(
        {"out", OPENFAB_ARG_WEIGHT, 0, 0, b.convert(b.append(hash), ir::Type::kFloat)});
    ASSERT_EQ(ir::verify(stage), "");
    const ir::Stage bounds = passes::form_volume_bounds(stage);
    for (const float at : {-7.9f, -0.5f, 0.25f, 12.0f}) {
        Values ends, point;
        point.values[{OPENFAB_ARG_NEAREST, 0, 0}] = std::bit_cast<uint32_t>(at + 0.05f);
        ends.values[{OPENFAB_ARG_NEAREST_LO, 0, 0}] = std::bit_cast<uint32_t>(at);
        ends.values[{OPENFAB_ARG_NEAREST_HI, 0, 0}] = std::bit_cast<uint32_t>(at + 0.1f);
        const std::vector<uint32_t> known = interp::evaluate(bounds, ends);
        EXPECT_EQ(known[0], interp::evaluate(stage, point)[0]);
        EXPECT_EQ(known[1], known[0]);
        ends.values[{OPENFAB_ARG_NEAREST_HI, 0, 0}] = std::bit_cast<uint32_t>(at + 1);
        EXPECT_LT(std::bit_cast<float>(interp::evaluate(bounds, ends)[0]), 1.0f);
    }
}

}  // namespace

}  // namespace openfab::testing
