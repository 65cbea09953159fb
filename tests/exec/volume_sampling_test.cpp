// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Lookups in volumes: generated code against the interpreter bit for bit, the interval form against
// lookups in its box, and the definition against closed forms.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "compiler/interp/sample_volume.h"
#include "compiler/passes/form_surface_bounds.h"
#include "tests/exec/compiled_stage.h"
#include "tests/exec/random_schedules.h"
#include "texture/pyramid.h"

namespace openfab::testing {

namespace {

using ir::Op;
using ir::Type;

constexpr int32_t kArgs = 13;  // x, y, z, width, and their changes along three axes
constexpr int32_t kFilters[] = {0, 1, 2, texture::kFilterFinest};

/// Texels in [0, 1]: noise blended with a ramp along x of weight `ramp`.
TestTexture make_volume(const Vec3i& size, int32_t channels, int32_t wrap, int32_t filter,
                        uint32_t seed, float ramp = 0) {
    std::mt19937 random(seed);
    std::vector<float> texels;
    for (int32_t k = 0; k < size.x * size.y * size.z * channels; ++k) {
        const float noise = static_cast<float>(random() >> 8) * 0x1p-24f;
        const float along = static_cast<float>(k / channels % size.x) / static_cast<float>(size.x);
        texels.push_back(ramp * along + (1 - ramp) * noise);
    }
    const texture::VolumeDomain domain{{-1.5f, 0.25f, 3.0f}, {4.0f, 2.5f, 3.0f}, false};
    const auto pyramid =
        texture::Pyramid::from_volume(size, channels, domain, texels, wrap, filter);
    const auto copy = [](const auto& span) { return std::vector(span.begin(), span.end()); };
    return {copy(pyramid->texels()), copy(pyramid->info()), copy(pyramid->minmax())};
}

ir::Stage make_stage(ir::StageKind kind, bool with_footprint) {
    ir::Stage stage;
    stage.kind = kind;
    ir::Builder b(&stage);
    const int32_t from =
        kind == ir::StageKind::kSurface ? OPENFAB_ARG_SURFACE_IN : OPENFAB_ARG_NEAREST;
    std::vector<ir::ValueId> args = {b.input(Type::kBool, from, 1, 0)};
    for (int32_t k = 0; k < (with_footprint ? kArgs : 4); ++k)
        args.push_back(b.input(Type::kFloat, from, 0, k));
    for (const int32_t channel : {0, 1, 3}) {
        stage.outputs.push_back({"channel " + std::to_string(channel), OPENFAB_ARG_WEIGHT, channel,
                                 0, b.sample(0, channel, args)});
    }
    return stage;
}

StageInputs make_inputs(size_t count, int32_t elements, uint32_t seed) {
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    const float inf = std::numeric_limits<float>::infinity();
    const float awkward[] = {0.0f,  -0.0f, -1.5f, 2.5f,   0.25f, 2.75f,      3.0f,         6.0f,
                             1e30f, inf,   -inf,  1e-40f, -1e9f, 5.9999995f, std::nanf("")};
    StageInputs inputs;
    inputs.elements = elements;
    for (int32_t k = 0; k < kArgs; ++k) {
        std::vector<uint32_t> bits;
        for (size_t i = 0; i < count; ++i) {
            float value = k < 3    ? unit() * 14 - 5
                          : k == 3 ? (i % 3 == 0 ? unit() * 4 : static_cast<float>(i % 2))
                                   : std::ldexp(unit() - 0.5f, 2 - static_cast<int>(random() % 12));
            if (k != 3 && random() % 12 == 0) value = awkward[random() % std::size(awkward)];
            bits.push_back(std::bit_cast<uint32_t>(value));
        }
        inputs.set(OPENFAB_ARG_NEAREST, 0, k, bits);
    }
    std::vector<uint32_t> guard;
    for (size_t i = 0; i < count; ++i)
        guard.push_back(i / 8 % 4 == 0 ? 0 : random() % 4 != 0);
    inputs.set(OPENFAB_ARG_NEAREST, 1, 0, guard);
    return inputs;
}

TEST(VolumeSampling, EqualsInterpreter) {
    for (const bool with_footprint : {true, false}) {
        const ir::Stage stage = make_stage(ir::StageKind::kVolume, with_footprint);
        ASSERT_EQ(ir::verify(stage), "");
        const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(stage);
        ASSERT_NE(compiled, nullptr);
        uint32_t seed = 1;
        for (const int32_t channels : {1, 3}) {
            for (int32_t wrap = 0; wrap < 4; ++wrap) {
                for (const int32_t filter : kFilters) {
                    SCOPED_TRACE(::testing::Message() << "channels " << channels << " wrap " << wrap
                                                      << " filter " << filter);
                    StageInputs inputs = make_inputs(1024, 2, seed);
                    inputs.textures = {make_volume({13, 6, 9}, channels, wrap, filter, seed++)};
                    const StageResults expected = interpret(stage, inputs);
                    expect_equal(stage, expected, *compiled, inputs);
                }
            }
        }
    }
}

/// Red and green of a volume are the coordinates of a lookup in a picture, whose red offsets a
/// lookup in the volume.
ir::Stage make_mixed_stage() {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder b(&stage);
    std::vector<ir::ValueId> args = {b.input(Type::kBool, OPENFAB_ARG_NEAREST, 1, 0)};
    for (int32_t k = 0; k < kArgs; ++k)
        args.push_back(b.input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, k));
    const ir::ValueId red = b.sample(0, 0, args);
    const ir::ValueId green = b.sample(0, 1, args);
    const ir::ValueId found = b.sample(1, 0, {args[0], red, green, b.constant(0.0f)});
    args[1] = b.emit(Op::kAdd, {args[1], found});
    stage.outputs = {{"found", OPENFAB_ARG_WEIGHT, 0, 0, found},
                     {"moved", OPENFAB_ARG_WEIGHT, 1, 0, b.sample(0, 1, args)}};
    return stage;
}

TEST(VolumeSampling, BesidePicturesEqualsInterpreter) {
    const ir::Stage stage = make_mixed_stage();
    ASSERT_EQ(ir::verify(stage), "");
    const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(stage);
    ASSERT_NE(compiled, nullptr);
    for (const int32_t filter : {0, 1, 2}) {
        SCOPED_TRACE(::testing::Message() << "filter " << filter);
        StageInputs inputs = make_inputs(1024, 2, 5);
        inputs.textures = {make_volume({13, 6, 9}, 3, 1, filter, 1),
                           make_texture(64, 48, 3, 1, filter, 2)};
        expect_equal(stage, interpret(stage, inputs), *compiled, inputs);
    }
}

/// A reduction over two levels.
TEST(VolumeSampling, RandomSchedulesChangeNoBit) {
    StageInputs inputs = make_inputs(1024, 2, 5);
    inputs.textures = {make_volume({9, 6, 5}, 3, 1, 1, 5)};
    expect_schedules_change_no_bit(make_stage(ir::StageKind::kVolume, false), inputs, 3);
}

TEST(VolumeSampling, BoundsHoldEverySample) {
    constexpr size_t kBoxes = 200;
    constexpr size_t kPoints = 40;
    const ir::Stage stage = make_displacing_stage(kArgs);
    const ir::Stage bounds = passes::form_surface_bounds(stage);
    ASSERT_EQ(ir::verify(bounds), "");
    const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(bounds);
    ASSERT_NE(compiled, nullptr);
    std::mt19937 random(1);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    for (int32_t wrap = 0; wrap < 4; ++wrap) {
        for (const int32_t filter : kFilters) {
            StageInputs boxes, points;
            boxes.elements = kBoxes;
            points.elements = kBoxes * kPoints;
            boxes.textures =
                points.textures = {make_volume({97, 61, 40}, 1, wrap, filter, random(), 0.9f)};
            boxes.set(OPENFAB_ARG_FRAME, OPENFAB_FRAME_MAX_DISPLACEMENT, 0,
                      {std::bit_cast<uint32_t>(std::numeric_limits<float>::infinity())});
            for (int32_t arg = 0; arg < kArgs; ++arg) {
                std::vector<uint32_t> lows, highs, inside;
                for (size_t k = 0; k < kBoxes; ++k) {
                    const float scale = arg == 0 ? 4 : arg == 1 ? 2.5f : 3;
                    float lo = k % 5 == 0 ? unit() * 12 - 4 : -1.5f + unit() * scale;
                    if (arg == 1) lo += 1.75f;
                    if (arg == 2) lo += 4.5f;
                    float hi = lo + std::ldexp(unit(), -2 - static_cast<int>(random() % 9));
                    if (k % 7 == 0) hi = lo;
                    if (arg == 3) lo = 0, hi = k % 3 == 0 ? 2.0f : 1.0f;
                    if (arg > 3) {
                        hi = k % 4 == 0 ? 0.0f
                                        : std::ldexp(unit(), -3 - static_cast<int>(random() % 8));
                        lo = -hi * unit();
                    }
                    if (k % 40 == 39 && arg == 2) lo = hi = std::nanf("");
                    lows.push_back(std::bit_cast<uint32_t>(lo));
                    highs.push_back(std::bit_cast<uint32_t>(hi));
                    for (size_t p = 0; p < kPoints; ++p) {
                        const float t =
                            random() % 3 == 0 ? static_cast<float>(random() % 2) : unit();
                        inside.push_back(
                            std::bit_cast<uint32_t>(std::clamp(lo + (hi - lo) * t, lo, hi)));
                    }
                }
                boxes.set(OPENFAB_ARG_SURFACE_IN_LO, 0, arg, lows);
                boxes.set(OPENFAB_ARG_SURFACE_IN_HI, 0, arg, highs);
                points.set(OPENFAB_ARG_SURFACE_IN, 0, arg, inside);
            }
            const StageResults ends = compiled->run(compiled->isas()[0], boxes);
            expect_equal(bounds, ends, *compiled, boxes);
            const std::vector<uint32_t> values = interpret(stage, points)[0];
            size_t narrow = 0;
            for (size_t k = 0; k < values.size(); ++k) {
                const auto lo = std::bit_cast<float>(ends[0][k / kPoints]);
                const auto hi = std::bit_cast<float>(ends[1][k / kPoints]);
                const auto value = std::bit_cast<float>(values[k]);
                ASSERT_TRUE(lo <= value && value <= hi)
                    << "wrap " << wrap << " filter " << filter << " box " << k / kPoints << ": "
                    << value << " is outside " << lo << " .. " << hi;
                ASSERT_TRUE(lo >= 0 && hi <= 1) << "texels are in [0, 1]";
                narrow += hi - lo < 0.6f ? 1 : 0;
            }
            EXPECT_GT(narrow * 20, values.size()) << "wrap " << wrap << " filter " << filter;
        }
    }
}

/// A lookup in a volume from (0, 0, 0) to (8, 4, 2), 1 mm per texel.
float look(const std::vector<float>& texels, int32_t wrap, int32_t filter, const Vec3f& p,
           float width = 0, float step = 0) {
    const texture::VolumeDomain domain{{0, 0, 0}, {8, 4, 2}, filter == texture::kFilterFinest};
    const auto pyramid = texture::Pyramid::from_volume({8, 4, 2}, 1, domain, texels, wrap,
                                                       domain.table ? 1 : filter);
    interp::VolumeSampleArgs args;
    args.p = {p.x, p.y, p.z};
    args.width = width;
    for (size_t k = 0; k < 3; ++k)
        args.dp[k][k] = step;
    return interp::sample_volume({pyramid->texels(), pyramid->info()}, 0, args);
}

TEST(VolumeSampling, ClosedForms) {
    std::vector<float> linear, last;
    for (int z = 0; z < 2; ++z) {
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 8; ++x)
                linear.push_back(static_cast<float>(x) + 16 * static_cast<float>(y) +
                                 128 * static_cast<float>(z));
        }
    }
    // Between texel centres a linear function is reproduced; texel centres are at halves.
    for (const Vec3f& p :
         {Vec3f{3.25f, 2.5f, 1.0f}, Vec3f{0.5f, 0.5f, 0.5f}, Vec3f{7.5f, 3.0f, 1.5f}}) {
        EXPECT_FLOAT_EQ(look(linear, 0, 0, p),
                        (p.x - 0.5f) + 16 * (p.y - 0.5f) + 128 * (p.z - 0.5f));
    }
    EXPECT_EQ(look(linear, 0, 0, {-9, -9, -9}), linear.front());
    EXPECT_EQ(look(linear, 0, 0, {99, 99, 99}), linear.back());
    EXPECT_EQ(look(linear, 3, 0, {-9, 1, 1}), 0.0f);
    EXPECT_EQ(look(linear, 1, 0, {8 + 3.25f, 2.5f - 4, 1.5f + 2}),
              look(linear, 1, 0, {3.25f, 2.5f, 1.5f}));
    EXPECT_EQ(look(linear, 2, 0, {-0.75f, 1.5f, 0.5f}), look(linear, 2, 0, {0.75f, 1.5f, 0.5f}));
    EXPECT_EQ(look(linear, 0, 2, {3.9f, 2.1f, 1.2f}), 3.0f + 16 * 2 + 128);
    // A footprint as large as the volume gives its mean; a table is never filtered.
    EXPECT_FLOAT_EQ(look(linear, 0, 0, {1, 1, 1}, 1, 8), 3.5f + 16 * 1.5f + 128 * 0.5f);
    EXPECT_EQ(look(linear, 0, texture::kFilterFinest, {0.5f, 0.5f, 0.5f}, 1, 8), 0.0f);
    // A cube of 2 mm selects the level of 2 texels: the mean of 2 x 2 x 2 texels.
    EXPECT_FLOAT_EQ(look(linear, 0, 1, {3, 3, 1}, 1, 2), 2.5f + 16 * 2.5f + 128 * 0.5f);
}

}  // namespace

}  // namespace openfab::testing
