// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Demand of random stages: if a voxel does not need its nearest surface point, the inputs that
// derive from it may have any value without changing a bit of an output, query or printf. Seeds are
// printed with a failure.

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <limits>
#include <map>

#include "compiler/interp/evaluate.h"
#include "compiler/passes/form_demand.h"
#include "tests/exec/random_stage.h"

namespace openfab::testing {

namespace {

using ir::Op;
using ir::Type;
using ir::ValueId;
using Key = std::array<int32_t, 3>;

constexpr int32_t kOperations = 60;
#ifdef OPENFAB_SANITIZED
constexpr uint32_t kStages = 150;
#else
constexpr uint32_t kStages = 1000;
#endif
constexpr int32_t kPoints = 24;
constexpr int32_t kReplacements = 4;

bool is_nearest(int32_t kind) {
    return kind == OPENFAB_ARG_NEAREST || kind == OPENFAB_ARG_DISTANCE;
}

class Values : public interp::Environment {
  public:
    uint32_t input(int32_t kind, int32_t a, int32_t b) const override {
        return values.at({kind, a, b});
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }
    uint32_t query(const ir::Instr& /*query*/, const ir::Instr& result,
                   std::span<const uint32_t> args) const override {
        log.insert(log.end(), args.begin(), args.end());
        return args[1] ^ static_cast<uint32_t>(result.kind);
    }
    void printf(const ir::Printf& /*call*/, std::span<const uint32_t> bits) const override {
        log.insert(log.end(), bits.begin(), bits.end());
    }

    std::map<Key, uint32_t> values;
    mutable std::vector<uint32_t> log;  ///< queries and printfs
};

Values random_values(std::mt19937* random) {
    Values out;
    const auto set = [&](const Key& key, bool is_float) {
        out.values[key] = is_float ? std::bit_cast<uint32_t>(random_float(random))
                                   : static_cast<uint32_t>(random_int(random));
    };
    for (int32_t k = 0; k < kRandomFloats; ++k) {
        set({OPENFAB_ARG_NEAREST, 0, k}, true);
        set({ir::kVoxelCoord, k, 0}, true);
    }
    for (int32_t k = 0; k < kRandomInts; ++k)
        set({OPENFAB_ARG_NEAREST, 1, k}, false);
    set({OPENFAB_ARG_DISTANCE, 0, 0}, true);
    set({OPENFAB_ARG_UNIFORM, kFloatUniform, 0}, true);
    set({OPENFAB_ARG_UNIFORM, kIntUniform, 0}, false);
    return out;
}

/// Arbitrary values in the inputs that are not needed.
void replace_nearest(std::mt19937* random, Values* values) {
    const std::array<uint32_t, 5> special = {
        0, std::bit_cast<uint32_t>(std::numeric_limits<float>::quiet_NaN()),
        std::bit_cast<uint32_t>(std::numeric_limits<float>::infinity()), 0x80000000u, 0xffffffffu};
    for (auto& [key, bits] : values->values) {
        if (!is_nearest(key[0])) continue;
        const uint32_t draw = static_cast<uint32_t>((*random)());
        bits =
            draw % 2 == 0 ? special[draw / 2 % special.size()] : static_cast<uint32_t>((*random)());
    }
}

/// Bools outside loops that no nearest input, loop or query goes into.
std::vector<ValueId> free_bools(const ir::Stage& stage) {
    std::vector<bool> free(stage.instrs.size(), false);
    std::vector<ValueId> out;
    int depth = 0;
    for (ValueId id = 0; id < stage.instrs.size(); ++id) {
        const ir::Instr& instr = stage.instrs[id];
        depth += instr.op == Op::kLoop ? 1 : 0;
        bool mine = depth == 0 && instr.op != Op::kLoopResult && instr.op != Op::kQuery &&
                    instr.op != Op::kQueryResult && instr.op != Op::kPrintf &&
                    instr.op != Op::kLoopEnd && !(instr.op == Op::kInput && is_nearest(instr.kind));
        for (const ValueId arg : instr.args)
            mine = mine && free[arg];
        depth -= instr.op == Op::kLoopEnd ? 1 : 0;
        free[id] = mine;
        if (mine && instr.type == Type::kBool && instr.op != Op::kConst) out.push_back(id);
    }
    return out;
}

/// The stage with one of its outputs, under conditions such as early returns make.
ir::Stage behind_conditions(const ir::Stage& stage, size_t output, std::mt19937* random) {
    ir::Stage out = stage;
    out.outputs = {stage.outputs[output]};
    std::vector<ValueId> conditions = free_bools(stage);
    // A nontrivial one, which random stages seldom have.
    ir::Builder b(&out);
    conditions.push_back(b.emit(Op::kLt, {b.input(Type::kFloat, ir::kVoxelCoord, 0, 0),
                                          b.input(Type::kFloat, ir::kVoxelCoord, 1, 0)}));
    ValueId value = out.outputs[0].value;
    for (int k = 0; k < 2; ++k) {
        const ValueId condition = conditions[(*random)() % conditions.size()];
        const ir::Output& other = stage.outputs[(*random)() % stage.outputs.size()];
        const bool fits = b.type(other.value) == b.type(value);
        ValueId rest = fits ? other.value : ir::kNoValue;
        if (rest == ir::kNoValue || (*random)() % 2 == 0) {
            ir::Instr zero;
            zero.type = b.type(value);
            rest = b.append(std::move(zero));
        }
        value = (*random)() % 2 == 0 ? b.select(condition, value, rest)
                                     : b.select(condition, rest, value);
    }
    out.outputs[0].value = value;
    // Dead code does not run and may query anything.
    ir::drop_dead_values(&out);
    return out;
}

struct Tally {
    int64_t stages = 0, points = 0, spared = 0;
};

void check_stage(const ir::Stage& stage, std::mt19937* random, Tally* tally) {
    const ir::Stage demand = passes::form_demand(stage);
    ASSERT_EQ(ir::verify(demand), "") << ir::dump(demand);
    if (demand.outputs.empty()) return;
    ++tally->stages;
    for (const ir::Instr& instr : demand.instrs)
        ASSERT_FALSE(instr.op == Op::kInput && is_nearest(instr.kind)) << ir::dump(demand);
    for (int32_t point = 0; point < kPoints; ++point) {
        const Values values = random_values(random);
        ++tally->points;
        if (interp::evaluate(demand, values)[0] != 0) continue;
        ++tally->spared;
        const std::vector<uint32_t> expected = interp::evaluate(stage, values);
        for (int32_t k = 0; k < kReplacements; ++k) {
            Values other;
            other.values = values.values;
            replace_nearest(random, &other);
            const std::vector<uint32_t> got = interp::evaluate(stage, other);
            ASSERT_EQ(expected, got) << ir::dump(stage) << ir::dump(demand);
            ASSERT_EQ(values.log, other.log) << ir::dump(stage) << ir::dump(demand);
        }
    }
}

void check_all(ir::Stage (*make)(uint32_t seed, int32_t operations), int64_t least_share) {
    Tally tally;
    for (uint32_t seed = 1; seed <= kStages; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        ir::Stage stage = make(seed, kOperations);
        std::mt19937 random(seed * 7919);
        for (size_t k = 0; k < stage.outputs.size(); k += 4) {
            check_stage(behind_conditions(stage, k, &random), &random, &tally);
            if (::testing::Test::HasFatalFailure()) return;
        }
        ir::drop_dead_values(&stage);
        check_stage(stage, &random, &tally);
        if (::testing::Test::HasFatalFailure()) return;
    }
    // A demand that always holds would pass, too.
    EXPECT_GT(tally.stages, static_cast<int64_t>(kStages) / 4);
    EXPECT_GT(tally.spared * 100, tally.points * least_share)
        << tally.spared << " of " << tally.points;
}

TEST(Demand, WhatIsNotAskedForChangesNothing) {
    check_all(random_stage, 20);
}

TEST(Demand, WhatIsNotAskedForChangesNothingAroundLoopsQueriesAndPrints) {
    check_all(random_looping_stage, 20);
}

}  // namespace

}  // namespace openfab::testing
