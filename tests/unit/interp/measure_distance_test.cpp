// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/interp/measure_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "compiler/frontend/frontend.h"

namespace openfab::interp {
namespace {

/// Measures a shape of `float3 p`.
std::optional<NoDistance> measure(const std::string& value,
                                  const std::string& uniforms = "float r = 6;") {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add(
        "shape.fl", "import solids;\nfablet A {\n    @uniform { " + uniforms +
                        " }\n    @Shape(@varying { ShapeAttributes attr }) [[ distance ]] {\n"
                        "        float3 p = attr.p;\n        return " +
                        value + ";\n    }\n}\n");
    const auto module = frontend::compile_to_ir(sources, file, sink);
    EXPECT_TRUE(module) << value;
    return module ? measure_distance(module->fablets[0]) : std::nullopt;
}

TEST(MeasureDistance, FindsNothingAtDistances) {
    for (const char* value :
         {"solid_ball(p, r)", "solid_torus(p, r, 2)", "solid_box(p, float3(8, 6, 4), 1)", "p.z - 3",
          "solid_box(p, float3(80, 60, 4), 0)",
          "solid_round_cone(p, float3(-4, -4, -4), float3(4, 4, 4), 1, 3)",
          "solid_union(solid_ball(p - float3(r, 0, 0), 2), solid_ball(p + float3(r, 0, 0), 3))",
          "solid_ball(p, 200 * r / 6)"})
        EXPECT_FALSE(measure(value)) << value;
}

TEST(MeasureDistance, FindsWhatChangesTooFast) {
    for (const char* value :
         {"2 * solid_ball(p, r)", "dot(p, p) - r * r", "p.x * p.y - 3", "length(p) < r ? -1 : 1"}) {
        const auto found = measure(value);
        ASSERT_TRUE(found) << value;
        ASSERT_TRUE(found->other) << value;
        const auto& q = *found->other;
        const float apart =
            std::hypot(found->at[0] - q[0], found->at[1] - q[1], found->at[2] - q[2]);
        EXPECT_GT(std::abs(found->value - found->then), apart) << value;
    }
}

TEST(MeasureDistance, FindsWhatIsTooSmall) {
    for (const char* value :
         {"solid_ball(p, r) / 2", "dot(sin(p), cos(p.yzx)) / 3", "length(p / float3(1, 2, 3)) - 1",
          // Inside the lens of both the nearest point of one ball is inside the other.
          "solid_union(solid_ball(p - float3(r / 2, 0, 0), r), solid_ball(p + float3(r / 2, 0, 0), "
          "r))",
          "max(max(abs(p.x), abs(p.y)), abs(p.z)) - r"}) {
        const auto found = measure(value);
        ASSERT_TRUE(found) << value;
        EXPECT_FALSE(found->other) << value;
        EXPECT_GT(found->share, 0.05F) << value;
    }
}

TEST(MeasureDistance, AsksNothingThatItDoesNotKnow) {
    EXPECT_FALSE(measure("2 * solid_ball(p, r)", "float r;"));
    EXPECT_FALSE(measure("2 * scan.Sample1(p, 0)", "ImageTexture3D scan;"));
    EXPECT_FALSE(measure("length(p) + 1"));
}

}  // namespace
}  // namespace openfab::interp
