// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/find_jumps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/interp/fixture.h"

namespace openfab::testing {
namespace {

using passes::JumpKind;

/// The text at the jumps of a body that returns an amount, with the kinds and uniforms of each.
std::vector<std::string> jumps_of(const std::string& body) {
    const std::string text =
        "fablet A { @uniform { float u = 1; float3 v = float3(1, 2, 3); int n = 2; Material m, "
        "other; }\n"
        "float f(float3 p) { " +
        body +
        " }\n"
        "@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc;"
        " mc.Set(m, f(attr.voxelCenter)); mc.Set(other, 1.0); return mc; } }";
    std::vector<std::string> out;
    for (const passes::Jump& jump : passes::find_jumps(compile(text))) {
        std::string found = text.substr(jump.span.begin, jump.span.end - jump.span.begin) + " by";
        for (const std::string& name : jump.uniforms)
            found += " " + name;
        out.push_back(found);
    }
    return out;
}

TEST(FindJumps, NamesWhatDecidesAndTheUniforms) {
    using ::testing::ElementsAre;
    EXPECT_THAT(jumps_of("return p.x < u ? 1 : 0;"), ElementsAre("p.x < u by u"));
    EXPECT_THAT(jumps_of("if (dot(p, v) > u) return 2; return 1;"),
                ElementsAre("dot(p, v) > u by u v"));
    EXPECT_THAT(jumps_of("return floor(p.x * u);"), ElementsAre("floor(p.x * u) by u"));
    EXPECT_THAT(jumps_of("return fmod(abs(p.x * u), 0.5);"),
                ElementsAre("fmod(abs(p.x * u), 0.5) by u"));
    EXPECT_THAT(jumps_of("return hash(int(p.x * u));"), ElementsAre("p.x * u by u"));
    EXPECT_THAT(jumps_of("return cellular(p * u).z;"), ElementsAre("cellular(p * u) by u"));
    EXPECT_THAT(jumps_of("return step(u, p.x);"), ElementsAre("step(u, p.x) by u"));
    EXPECT_THAT(jumps_of("float s = 0; @bound(9) while (s < u) s += 0.1 + abs(p.x); return s;"),
                ElementsAre("s < u by u"));
}

TEST(FindJumps, NamesWhereTheBorderOfThePartMoves) {
    const std::string volume =
        "@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, w); "
        "return mc; } }";
    const std::string uniforms = "fablet A { @uniform { float u = 1; float w = 1; Material m; }\n";
    for (const char* stage :
         {"@Shape(@varying { ShapeAttributes attr }) { return length(attr.p) - u * u; }\n",
          "@Surface(@varying { SurfaceAttributes attr }) { return attr.n * u; }\n"}) {
        const std::vector<passes::Jump> jumps =
            passes::find_jumps(compile(uniforms + stage + volume));
        ASSERT_EQ(jumps.size(), 1U) << stage;
        EXPECT_EQ(jumps[0].kind, JumpKind::kBorder);
        EXPECT_EQ(jumps[0].uniforms, std::vector<std::string>{"u"});
    }
}

TEST(FindJumps, FindsNoneWhereNothingJumpsWithAUniform) {
    for (const char* smooth :
         {"return u * p.x;", "return p.x > 0 ? u : 2 * u;",
          "return min(u, p.x) + max(p.y, u) + abs(u * p.z);", "return p.x < u ? p.x : u;",
          "return u * p.x < 0 ? -(u * p.x) : u * p.x;", "return saturate(u * p.x);",
          "return smoothstep(0.0, u, p.x);",
          "return noise(p * u) + simplex(p * u) + cellular(p * u).x;", "return u * floor(p.x);",
          "return n > 2 ? u : 1;", "return length(p - v);"})
        EXPECT_TRUE(jumps_of(smooth).empty()) << smooth;
}

}  // namespace
}  // namespace openfab::testing
