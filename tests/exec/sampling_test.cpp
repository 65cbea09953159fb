// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Texture lookups in generated code against the interpreter, bit for bit: wraps, filters,
// footprints, channels, guards.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "tests/exec/compiled_stage.h"
#include "tests/exec/random_schedules.h"
#include "texture/pyramid.h"
#include "texture/sample.h"

namespace openfab::testing {

namespace {

using ir::Op;
using ir::Type;
using ir::ValueId;

/// Along u and v.
constexpr std::array<std::array<int32_t, 2>, 8> kWraps = {
    {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {1, 0}, {0, 3}, {3, 1}, {2, 1}}};
constexpr int32_t kFilters = 3;
constexpr int32_t kOwn = texture::kOwnColor;
constexpr int32_t kInputs = 9;  // u, v, width, du and dv along three axes

/// Arguments of a lookup at varying coordinates; a bool input is the guard.
std::vector<ValueId> make_args(ir::Builder* b, int32_t inputs = kInputs) {
    std::vector<ValueId> args = {b->input(Type::kBool, OPENFAB_ARG_NEAREST, 1, 0)};
    for (int32_t k = 0; k < inputs; ++k)
        args.push_back(b->input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, k));
    return args;
}

ir::Stage make_stage(ir::StageKind kind, const std::vector<int32_t>& channels,
                     int32_t inputs = kInputs) {
    ir::Stage stage;
    stage.kind = kind;
    ir::Builder b(&stage);
    const std::vector<ValueId> args = make_args(&b, inputs);
    for (const int32_t channel : channels) {
        stage.outputs.push_back({"channel " + std::to_string(channel), OPENFAB_ARG_WEIGHT, channel,
                                 0, b.sample(0, channel, args)});
    }
    return stage;
}

/// Each lookup's result offsets the next; a dozen operations follow each.
ValueId add_two_samples(ir::Builder* b, std::vector<ValueId> args) {
    const auto stir = [&](ValueId x) {
        for (int32_t k = 0; k < 12; ++k)
            x = b->emit(k % 2 == 0 ? Op::kMul : Op::kSub,
                        {x, args[static_cast<size_t>(1 + k % 3)]});
        return x;
    };
    const ValueId first = b->sample(0, 0, args);
    args[1] = b->emit(Op::kAdd, {args[1], stir(first)});
    const ValueId second = b->sample(0, 1, args);
    return b->emit(Op::kAdd, {stir(second), first});
}

ir::Stage make_dependent_stage(ir::StageKind kind) {
    ir::Stage stage;
    stage.kind = kind;
    ir::Builder b(&stage);
    stage.outputs.push_back(
        {"twice", OPENFAB_ARG_WEIGHT, 0, 0, add_two_samples(&b, make_args(&b))});
    return stage;
}

/// Three iterations at most: the stage is cut into segments, one of which samples.
ir::Stage make_looping_stage() {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder b(&stage);
    std::vector<ValueId> args = make_args(&b);
    const ValueId zero = b.constant(int32_t{0}), quarter = b.constant(0.25f);
    const ValueId loop = b.loop(args[0]);
    const ValueId counter = b.loop_var(loop, 0, zero);
    const ValueId before = b.loop_var(loop, 1, quarter);
    args[2] = b.emit(Op::kAdd, {args[2], before});
    const ValueId next = b.emit(Op::kAdd, {counter, b.constant(int32_t{1})});
    const ValueId found = add_two_samples(&b, args);
    const ValueId again = b.emit(Op::kLt, {next, b.constant(int32_t{3})});
    const ValueId end = b.loop_end(loop, again, {next, found});
    stage.outputs.push_back({"found", OPENFAB_ARG_WEIGHT, 0, 0, b.loop_result(end, 1)});
    return stage;
}

std::vector<uint32_t> floats(size_t count, const std::function<float(size_t)>& value) {
    std::vector<uint32_t> bits;
    for (size_t k = 0; k < count; ++k)
        bits.push_back(std::bit_cast<uint32_t>(value(k)));
    return bits;
}

/// Random coordinates, and every edge case; footprints from none to many texels, of every direction
/// and ratio. Every other vector of 8 samples one spot with small footprints: inside the picture it
/// needs no wrap, and has a code path of its own.
StageInputs make_inputs(size_t count, int32_t elements, uint32_t seed) {
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    const float inf = std::numeric_limits<float>::infinity();
    const std::vector<float> awkward = {0.0f,
                                        -0.0f,
                                        1.0f,
                                        0.5f,
                                        -1.0f,
                                        2.0f,
                                        1e30f,
                                        -1e30f,
                                        inf,
                                        -inf,
                                        std::numeric_limits<float>::quiet_NaN(),
                                        0x1p-140f,
                                        0.99999994f,
                                        -1e-9f};
    float near = 0;
    const auto together = [](size_t k) { return k / 8 % 2 == 1; };
    const auto coordinate = [&](size_t k) {
        if (k % 8 == 0) near = unit() * 4.0f - 2.0f;
        if (together(k)) return near + unit() * 0.02f;
        if (random() % 8 == 0) return awkward[random() % awkward.size()];
        return unit() * 6.0f - 3.0f;
    };
    const auto change = [&](size_t k) {
        if (together(k)) return std::ldexp(unit() - 0.5f, -3 - static_cast<int>(random() % 6));
        if (random() % 16 == 0) return awkward[random() % awkward.size()];
        return std::ldexp(unit() - 0.5f, -static_cast<int>(random() % 12));
    };
    StageInputs inputs;
    inputs.elements = elements;
    inputs.set(OPENFAB_ARG_NEAREST, 0, 0, floats(count, coordinate));
    inputs.set(OPENFAB_ARG_NEAREST, 0, 1, floats(count, coordinate));
    inputs.set(OPENFAB_ARG_NEAREST, 0, 2, floats(count, [&](size_t k) {
                   return k % 3 == 0 ? unit() * 4.0f : static_cast<float>(k % 2);
               }));
    for (int32_t k = 3; k < kInputs; ++k) {
        inputs.set(OPENFAB_ARG_NEAREST, 0, k, floats(count, change));
    }
    std::vector<uint32_t> guard;
    // Whole vectors without a lookup, and mixed ones.
    for (size_t k = 0; k < count; ++k)
        guard.push_back(k / 8 % 4 == 0 ? 0 : random() % 4 != 0);
    inputs.set(OPENFAB_ARG_NEAREST, 1, 0, guard);
    return inputs;
}

/// Voxels of two blocks, or micro-vertices that leave lanes unused.
void check(const ir::Stage& stage) {
    const bool volume = stage.kind == ir::StageKind::kVolume;
    const size_t count = volume ? 1024 : 203;
    const int32_t elements = volume ? 2 : 203;
    ASSERT_EQ(ir::verify(stage), "");
    const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(stage);
    ASSERT_NE(compiled, nullptr);
    uint32_t seed = 1;
    for (const int32_t channels : {1, 2, 3, 4}) {
        for (const auto& [wrap, wrap_v] : kWraps) {
            for (int32_t filter = 0; filter < kFilters; ++filter) {
                const bool alpha = channels % 2 == 0 && filter + wrap_v != 2;
                SCOPED_TRACE(::testing::Message()
                             << "channels " << channels << " wrap " << wrap << " " << wrap_v
                             << " filter " << filter << " alpha " << alpha << " seed " << seed);
                StageInputs inputs = make_inputs(count, elements, seed);
                // Quotients by a power of two are computed as products.
                const bool power = (channels + filter + wrap) % 2 == 0;
                inputs.textures = {
                    make_texture(power ? 64 : 37, power ? 32 : 20, channels, wrap, filter, seed)};
                inputs.textures[0].info[texture::kInfoWrapV] = wrap_v;
                inputs.textures[0].info[texture::kInfoAlpha] = alpha ? 1 : 0;
                const StageResults expected = interpret(stage, inputs);
                expect_equal(stage, expected, *compiled, inputs);
                ++seed;
            }
        }
    }
}

// The requested channels decide how texels are read.
TEST(Sampling, VolumeEqualsInterpreter) {
    for (const std::vector<int32_t>& channels : {std::vector<int32_t>{0, 1, 3},
                                                 {0},
                                                 {2},
                                                 {3},
                                                 {kOwn, kOwn + 1, kOwn + 2, 3},
                                                 {kOwn + 1, 1},
                                                 {0, 1, 2, 3, 4, 300}})
        check(make_stage(ir::StageKind::kVolume, channels));
    constexpr int32_t kWithoutFootprint = 3;
    check(make_stage(ir::StageKind::kVolume, {0, 1}, kWithoutFootprint));
}

TEST(Sampling, SurfaceEqualsInterpreter) {
    check(make_stage(ir::StageKind::kSurface, {0, 1, 3}));
}

TEST(Sampling, SamplesAtSampledCoordinatesEqualInterpreter) {
    check(make_dependent_stage(ir::StageKind::kVolume));
    check(make_dependent_stage(ir::StageKind::kSurface));
}

// By default they are computed first of all; otherwise per column of a whole call.
TEST(Sampling, SchedulesChangeNoBit) {
    const ir::Stage stage = make_dependent_stage(ir::StageKind::kVolume);
    StageInputs inputs = make_inputs(1024, 2, 3);
    inputs.textures = {make_texture(37, 20, 3, 1, 1, 3)};
    const StageResults expected = interpret(stage, inputs);
    for (const char* text :
         {"slab.vectorize(z)\n",
          "values_early_*.compute_root()\nsamples_1.compute_at(weights, column)\n"}) {
        SCOPED_TRACE(text);
        expect_schedule_changes_no_bit(stage, expected, inputs, text, tested_isas());
    }
}

TEST(Sampling, RandomSchedulesChangeNoBit) {
    for (const ir::StageKind kind : {ir::StageKind::kVolume, ir::StageKind::kSurface}) {
        const bool volume = kind == ir::StageKind::kVolume;
        StageInputs inputs = make_inputs(volume ? 1024 : 203, volume ? 2 : 203, 3);
        inputs.textures = {make_texture(37, 20, 3, 1, 1, 3)};
        expect_schedules_change_no_bit(make_dependent_stage(kind), inputs, 2);
    }
}

TEST(Sampling, SamplesInLoopsEqualInterpreter) {
    check(make_looping_stage());
}

}  // namespace

}  // namespace openfab::testing
