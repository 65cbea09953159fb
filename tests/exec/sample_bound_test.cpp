// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The interval form of texture lookups, compiled: every lookup in a box of coordinates and
// footprints lies within the bounds kernel's result for the box.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "compiler/passes/form_surface_bounds.h"
#include "tests/exec/compiled_stage.h"
#include "texture/pyramid.h"
#include "texture/sample.h"

namespace openfab::testing {

namespace {

constexpr int32_t kArgs = 9;  // u, v, width, du and dv along three axes
constexpr size_t kBoxes = 240;
constexpr int32_t kPoints = 40;

struct Boxes {
    StageInputs inputs;
    std::vector<std::array<std::array<float, 2>, kArgs>> ends;
};

Boxes make_boxes(uint32_t seed) {
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    Boxes out;
    for (size_t k = 0; k < kBoxes; ++k) {
        std::array<std::array<float, 2>, kArgs> box{};
        for (int32_t axis = 0; axis < 2; ++axis) {
            const float lo = k % 5 == 0 ? unit() * 3.0f - 1.0f : unit();
            const float size = std::ldexp(unit(), -static_cast<int>(random() % 10));
            box[axis] = {lo, k % 7 == 0 ? lo : lo + size};
        }
        box[2] = {0.0f, k % 3 == 0 ? 2.0f : 1.0f};
        for (size_t arg = 3; arg < kArgs; ++arg) {
            const float size =
                k % 4 == 0 ? 0.0f : std::ldexp(unit(), -2 - static_cast<int>(random() % 9));
            box[arg] = {-size, size * unit()};
        }
        if (k % 40 == 39) box[0][0] = box[0][1] = std::numeric_limits<float>::quiet_NaN();
        out.ends.push_back(box);
    }
    out.inputs.elements = static_cast<int32_t>(kBoxes);
    for (int32_t arg = 0; arg < kArgs; ++arg) {
        for (size_t end = 0; end < 2; ++end) {
            std::vector<uint32_t> bits;
            for (const auto& box : out.ends) {
                bits.push_back(std::bit_cast<uint32_t>(box[arg][end]));
            }
            out.inputs.set(end == 0 ? OPENFAB_ARG_SURFACE_IN_LO : OPENFAB_ARG_SURFACE_IN_HI, 0, arg,
                           bits);
        }
    }
    out.inputs.set(OPENFAB_ARG_FRAME, OPENFAB_FRAME_MAX_DISPLACEMENT, 0,
                   {std::bit_cast<uint32_t>(std::numeric_limits<float>::infinity())});
    return out;
}

/// Lookups inside each box, as a surface run of kPoints coordinates per box.
StageInputs make_points(const Boxes& boxes, uint32_t seed) {
    std::mt19937 random(seed);
    StageInputs inputs;
    inputs.elements = static_cast<int32_t>(kBoxes) * kPoints;
    for (size_t arg = 0; arg < kArgs; ++arg) {
        std::vector<uint32_t> bits;
        for (const auto& box : boxes.ends) {
            const auto [lo, hi] = box[arg];
            for (int32_t k = 0; k < kPoints; ++k) {
                const float t = static_cast<float>(random() >> 8) * 0x1p-24f;
                const float inside = std::clamp(lo + (hi - lo) * t, lo, hi);
                const float value = random() % 3 == 0 ? (random() % 2 == 0 ? lo : hi) : inside;
                bits.push_back(std::bit_cast<uint32_t>(value));
            }
        }
        inputs.set(OPENFAB_ARG_SURFACE_IN, 0, static_cast<int32_t>(arg), bits);
    }
    return inputs;
}

float as_float(uint32_t bits) {
    return std::bit_cast<float>(bits);
}

TEST(SampleBound, HoldsEverySample) {
    const ir::Stage stage = make_displacing_stage(kArgs);
    const ir::Stage bounds = passes::form_surface_bounds(stage);
    ASSERT_EQ(ir::verify(bounds), "");
    const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(bounds);
    ASSERT_NE(compiled, nullptr);
    uint32_t seed = 1;
    for (int32_t wrap = 0; wrap < 4; ++wrap) {
        for (int32_t filter = 0; filter < 3; ++filter, ++seed) {
            Boxes boxes = make_boxes(seed);
            StageInputs points = make_points(boxes, seed);
            // Sizes that do not halve evenly, so that levels do not align.
            points.textures = {make_texture(149, 83, 1, wrap, filter, seed, 0.9f)};
            boxes.inputs.textures = points.textures;
            const StageResults ends = compiled->run(compiled->isas()[0], boxes.inputs);
            expect_equal(bounds, ends, *compiled, boxes.inputs);
            const std::vector<uint32_t> values = interpret(stage, points)[0];
            size_t narrow = 0;
            for (size_t k = 0; k < values.size(); ++k) {
                const float lo = as_float(ends[0][k / kPoints]);
                const float hi = as_float(ends[1][k / kPoints]);
                ASSERT_TRUE(lo <= as_float(values[k]) && as_float(values[k]) <= hi)
                    << "wrap " << wrap << " filter " << filter << " box " << k / kPoints << ": "
                    << as_float(values[k]) << " is outside " << lo << " .. " << hi;
                ASSERT_TRUE(lo >= 0.0f && hi <= 1.0f) << "texels are in [0, 1]";
                narrow += hi - lo < 0.6f ? 1 : 0;
            }
            // The whole image would contain everything, too.
            EXPECT_GT(narrow * 20, values.size()) << "wrap " << wrap << " filter " << filter;
        }
    }
}

// Of pictures with alpha, and of those whose coverage stands for it; colours as on white and their own.
TEST(SampleBound, HoldsColorsWithAlpha) {
    uint32_t seed = 100;
    for (const int32_t channel : {0, 3, texture::kOwnColor}) {
        ir::Stage stage = make_displacing_stage(kArgs);
        for (ir::Instr& instr : stage.instrs) {
            if (instr.op == ir::Op::kSample) instr.b = channel;
        }
        const ir::Stage bounds = passes::form_surface_bounds(stage);
        const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(bounds);
        ASSERT_NE(compiled, nullptr);
        for (const auto& [wrap, wrap_v] : {std::array{0, 3}, {3, 1}, {1, 1}, {2, 0}}) {
            for (const bool alpha : {false, true}) {
                SCOPED_TRACE(::testing::Message() << "channel " << channel << " wrap " << wrap
                                                  << " " << wrap_v << " alpha " << alpha);
                Boxes boxes = make_boxes(++seed);
                StageInputs points = make_points(boxes, seed);
                TestTexture picture = make_texture(149, 83, 2, wrap, 1, seed, 0.9f);
                picture.info[texture::kInfoWrapV] = wrap_v;
                picture.info[texture::kInfoAlpha] = alpha ? 1 : 0;
                boxes.inputs.textures = points.textures = {picture};
                const StageResults ends = compiled->run(compiled->isas()[0], boxes.inputs);
                expect_equal(bounds, ends, *compiled, boxes.inputs);
                const std::vector<uint32_t> values = interpret(stage, points)[0];
                size_t known = 0;
                for (size_t k = 0; k < values.size(); ++k) {
                    const float lo = as_float(ends[0][k / kPoints]);
                    const float hi = as_float(ends[1][k / kPoints]);
                    if (std::isnan(lo)) continue;  // unknown: what is hardly there has any colour
                    ++known;
                    ASSERT_TRUE(lo <= as_float(values[k]) && as_float(values[k]) <= hi)
                        << "box " << k / kPoints << ": " << as_float(values[k]) << " is outside "
                        << lo << " .. " << hi;
                }
                EXPECT_GT(known * 20, values.size());
            }
        }
    }
}

TEST(SampleBound, FlatTextureIsOneValue) {
    const ir::Stage bounds = passes::form_surface_bounds(make_displacing_stage(kArgs));
    const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(bounds);
    ASSERT_NE(compiled, nullptr);
    Boxes boxes = make_boxes(99);
    TestTexture flat = make_texture(64, 64, 1, 0, 1, 1);
    std::fill(flat.texels.begin(), flat.texels.end(), 1.0f);
    std::fill(flat.minmax.begin(), flat.minmax.end(), 1.0f);
    boxes.inputs.textures = {flat};
    const StageResults ends = compiled->run(compiled->isas()[0], boxes.inputs);
    for (size_t k = 0; k < kBoxes; ++k) {
        EXPECT_EQ(as_float(ends[0][k]), 1.0f);
        EXPECT_EQ(as_float(ends[1][k]), 1.0f);
    }
}

}  // namespace

}  // namespace openfab::testing
