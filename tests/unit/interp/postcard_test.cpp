// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The paper's postcard, evaluated point by point against its source.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "tests/support/places/places.h"
#include "tests/unit/interp/fixture.h"

namespace openfab::testing {
namespace {

ir::Fablet postcard() {
    std::ifstream in(source_dir() / "gallery/magic_postcard/magic_postcard.fl", std::ios::binary);
    return compile({std::istreambuf_iterator<char>(in), {}});
}

MapEnvironment environment() {
    MapEnvironment env;
    env.set(OPENFAB_ARG_UNIFORM, 0, 0, 0.1f);  // border
    env.set(OPENFAB_ARG_UNIFORM, 1, 0, 0.2f);
    env.set(OPENFAB_ARG_UNIFORM, 2, 0, 0.25f);  // textureDepth
    env.set(OPENFAB_ARG_UNIFORM, 3, 0, 2.0f);   // maxThickness
    env.pictures.emplace_back(1, 1, 1, std::vector<float>{0.75f}, 0, 1);
    env.pictures.emplace_back(1, 1, 1, std::vector<float>{0.36f}, 0, 1);
    return env;
}

std::vector<float> surface(float u, float v, int32_t face) {
    const ir::Fablet fablet = postcard();
    MapEnvironment env = environment();
    env.set(OPENFAB_ARG_SURFACE_IN, 0, 0, u);
    env.set(OPENFAB_ARG_SURFACE_IN, 0, 1, v);
    env.set(OPENFAB_ARG_SURFACE_IN, 1, 0, face);
    for (int32_t axis = 0; axis < 3; ++axis) {
        env.set(OPENFAB_ARG_SURFACE_ATTR, OPENFAB_SURFACE_N, axis, axis == 2 ? -1.0f : 0.0f);
    }
    std::vector<float> out;
    for (uint32_t bits : interp::evaluate(fablet.surface, env))
        out.push_back(as_float(bits));
    EXPECT_EQ(env.sample_count, face == 1 ? 1 : 0);
    return out;
}

std::vector<float> volume(int32_t face, float distance) {
    const ir::Fablet fablet = postcard();
    MapEnvironment env = environment();
    env.set(OPENFAB_ARG_NEAREST, 0, 0, 0.5f);
    env.set(OPENFAB_ARG_NEAREST, 0, 1, 0.5f);
    env.set(OPENFAB_ARG_NEAREST, 1, 0, face);
    env.set(OPENFAB_ARG_DISTANCE, 0, 0, distance);
    std::vector<float> out;
    for (uint32_t bits : interp::evaluate(fablet.volume, env))
        out.push_back(as_float(bits));
    EXPECT_EQ(env.sample_count, face == 0 && std::fabs(distance) <= 0.25f ? 1 : 0);
    return out;
}

TEST(Postcard, TheBackIsThickestInItsBorder) {
    EXPECT_EQ(surface(0.05f, 0.5f, 1)[2], -2.0f);
    EXPECT_EQ(surface(0.5f, 0.9f, 1)[2], -2.0f);
    EXPECT_EQ(surface(0.95f, 0.5f, 1)[2], -2.0f);
}

TEST(Postcard, TheBackCarriesThePicture) {
    EXPECT_EQ(surface(0.5f, 0.5f, 1)[2], -(std::sqrt(1 - 0.36f) * 2.0f));
}

TEST(Postcard, FrontAndSidesStay) {
    for (int32_t face : {0, 2, 5}) {
        const std::vector<float> out = surface(0.5f, 0.5f, face);
        EXPECT_EQ(std::vector<float>(out.begin(), out.begin() + 3), (std::vector<float>{0, 0, 0}));
    }
}

TEST(Postcard, AttributesPassThrough) {
    const std::vector<float> out = surface(0.25f, 0.5f, 1);
    EXPECT_EQ(out[3], 0.25f);
    EXPECT_EQ(out[4], 0.5f);
    EXPECT_EQ(std::bit_cast<int32_t>(out[5]), 1);
}

TEST(Postcard, TheFrontMixesByThePicture) {
    EXPECT_EQ(volume(0, -0.25f), (std::vector<float>{0.75f, 0.25f}));
    EXPECT_EQ(volume(0, 0.1f), (std::vector<float>{0.75f, 0.25f}));
}

TEST(Postcard, TheRestIsWhite) {
    EXPECT_EQ(volume(0, -0.3f), (std::vector<float>{1, 0}));
    EXPECT_EQ(volume(1, 0.0f), (std::vector<float>{1, 0}));
}

}  // namespace
}  // namespace openfab::testing
