// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Mixtures of two materials: the amount of the second is as its meaning says, and both are 1 together, whatever they get.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <random>
#include <vector>

#include "tests/unit/interp/fixture.h"
#include "texture/pyramid.h"

namespace openfab::testing {
namespace {

/// The amounts of a and b that an expression of `p` and `t` gives. The picture has three texels side by side: black, white,
/// and black that covers a quarter.
std::array<float, 2> mixed(const std::string& expression, std::array<float, 3> p, float t) {
    const ir::Fablet fablet = compile(
        "import mix;\nfablet T { @uniform { float3 p; float t; ImageTexture2D map; Material a, b; "
        "}\n@Volume() { return " +
        expression + "; } }");
    MapEnvironment env;
    for (int axis = 0; axis < 3; ++axis)
        env.set(OPENFAB_ARG_UNIFORM, axis, 0, p.at(static_cast<size_t>(axis)));
    env.set(OPENFAB_ARG_UNIFORM, 3, 0, t);
    Picture picture(3, 1, 4, {0, 0, 0, 1, 1, 1, 1, 1, 0.75F, 0.75F, 0.75F, 0.25F},
                    texture::kWrapRepeat, texture::kFilterNearest);
    picture.info[texture::kInfoAlpha] = 1;
    env.pictures.push_back(std::move(picture));
    const std::vector<uint32_t> bits = interp::evaluate(fablet.volume, env);
    return {std::bit_cast<float>(bits.at(0)), std::bit_cast<float>(bits.at(1))};
}

TEST(Mix, TheSecondIsAsThePatternSaysAndBothFillThePart) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> dice(-6, 6);
    for (int i = 0; i < 40; ++i) {
        const std::array<float, 3> p{dice(random), dice(random), dice(random)};
        const float t = dice(random);
        const auto within = [](double v) { return std::clamp(v, 0.0, 1.0); };
        const std::pair<std::string, double> cases[] = {
            {"mix_pattern(a, b, t)", within(t)},
            {"mix_field(a, b, t)", within((t + 1.0) / 2)},
            {"mix_field(a, b, t, 2, 4)", within((t - 2.0) / 2)},
            {"mix_depth(a, b, t)", within(-t / 3.0)},
            {"mix_depth(a, b, t, 5)", within(-t / 5.0)},
            {"mix_depth(a, mix_pattern(a, b, 0.25), t)", 0.25 * within(-t / 3.0)},
            {"mix_height(a, b, p)", within((p[2] + 5.0) / 10)},
            {"mix_height(a, b, p, 0, 2)", within(p[2] / 2.0)}};
        for (const auto& [expression, second] : cases) {
            const std::array<float, 2> amounts = mixed(expression, p, t);
            EXPECT_NEAR(amounts[1], second, 2e-6) << expression << " at " << t << ", " << p[2];
            EXPECT_NEAR(amounts[0] + amounts[1], 1, 2e-6) << expression;
        }
    }
}

TEST(Mix, APictureIsInkWhereItIsDarkAndCovers) {
    const float ink[] = {1, 0, 0.25F};
    for (int texel = 0; texel < 3; ++texel) {
        const auto u = static_cast<float>(texel) / 3 + 1.F / 6;
        const std::array<float, 2> amounts = mixed("mix_picture(a, b, map, p.xy)", {u, 0.5F, 0}, 0);
        EXPECT_NEAR(amounts[1], ink[texel], 1e-6) << texel;
        EXPECT_NEAR(amounts[0] + amounts[1], 1, 1e-6);
    }
}

}  // namespace
}  // namespace openfab::testing
