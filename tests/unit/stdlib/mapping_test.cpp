// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Pictures on the sides of a box, blended: what covers is weighed, what is clear has no colour.

#include <array>
#include <bit>
#include <vector>

#include "tests/unit/interp/fixture.h"
#include "texture/pyramid.h"

namespace openfab::testing {
namespace {

/// The components of a function's value at p, of a surface that faces n, of a picture of three texels
/// side by side: red, half covering green, and nothing.
std::vector<float> mapped(const std::string& function, int components, std::array<float, 3> p,
                          std::array<float, 3> n) {
    std::string text =
        "import mapping;\nfablet T { @uniform { float3 p, n; ImageTexture2D map; Material";
    for (int c = 0; c < components; ++c)
        text += (c > 0 ? ", m" : " m") + std::to_string(c);
    text += "; }\n@Volume() { MaterialComposition mc; float" + std::to_string(components) +
            " v = " + function + "(map, p, n, float3(3, 3, 3), 1);\n";
    for (int c = 0; c < components; ++c)
        text += "mc.Set(m" + std::to_string(c) + ", v[" + std::to_string(c) + "]);\n";
    const ir::Fablet fablet = compile(text + "return mc; } }");
    MapEnvironment env;
    for (int a = 0; a < 3; ++a) {
        env.set(OPENFAB_ARG_UNIFORM, a, 0, p.at(static_cast<size_t>(a)));
        env.set(OPENFAB_ARG_UNIFORM, 3 + a, 0, n.at(static_cast<size_t>(a)));
    }
    // Colours are stored over white.
    Picture picture(3, 1, 4, {1, 0, 0, 1, 0.5F, 1, 0.5F, 0.5F, 1, 1, 1, 0}, texture::kWrapRepeat,
                    texture::kFilterNearest);
    picture.info[texture::kInfoAlpha] = 1;
    env.pictures.push_back(std::move(picture));
    std::vector<float> out;
    for (const uint32_t bits : interp::evaluate(fablet.volume, env))
        out.push_back(std::bit_cast<float>(bits));
    return out;
}

void expect(const std::vector<float>& found, const std::vector<float>& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (size_t c = 0; c < found.size(); ++c)
        EXPECT_NEAR(found[c], expected[c], 1e-6F) << c;
}

TEST(Mapping, TriplanarWithAlphaWeighsWhatCovers) {
    const auto alpha = [](std::array<float, 3> p, std::array<float, 3> n) {
        return mapped("map_triplanar_alpha", 4, p, n);
    };
    // One side alone: as the picture is. On the right u goes with y, on the back against x.
    expect(alpha({0, -1, 0}, {1, 0, 0}), {1, 0, 0, 1});
    expect(alpha({0, 0, 0}, {1, 0, 0}), {0, 1, 0, 0.5F});
    expect(alpha({0, 1, 0}, {1, 0, 0}), {0, 0, 0, 0});
    expect(alpha({1, 0, 0}, {0, 1, 0}), {1, 0, 0, 1});
    // Between two: green of the right covers a half, red of the back all.
    expect(alpha({1, 0, 0}, {1, 1, 0}), {2.F / 3, 1.F / 3, 0, 0.75F});
    // Red and nothing: the colour is red, of which there is half.
    expect(alpha({1, 1, 0}, {1, 1, 0}), {1, 0, 0, 0.5F});
    // By how much the surface faces each.
    expect(alpha({1, 1, 0}, {3, 1, 0}), {1, 0, 0, 0.25F});
    // On a normal of length 0 as on the top, where u goes with x.
    expect(alpha({-1, 1, 0}, {0, 0, 0}), {1, 0, 0, 1});
}

TEST(Mapping, TriplanarWithoutAlphaIsOverWhite) {
    const auto color = [](std::array<float, 3> p, std::array<float, 3> n) {
        return mapped("map_triplanar", 3, p, n);
    };
    expect(color({0, -1, 0}, {1, 0, 0}), {1, 0, 0});
    expect(color({0, 0, 0}, {1, 0, 0}), {0.5F, 1, 0.5F});
    expect(color({1, 0, 0}, {1, 1, 0}), {0.75F, 0.5F, 0.25F});
    expect(color({1, 1, 0}, {3, 1, 0}), {1, 0.75F, 0.75F});
}

}  // namespace
}  // namespace openfab::testing
