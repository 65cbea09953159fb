// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Worlds of nested groups, with scale, shear and mirroring, from the file to the voxels:
// bit-identical to the plain reference.

#include <gtest/gtest.h>

#include <filesystem>

#include "runtime/part/bind.h"
#include "tests/property/pipeline/reference_check.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/places/places.h"
#include "world/world.h"

namespace openfab {
namespace {

constexpr const char* kHead = R"({
  "openfab": 1,
  "fablets": {"ripples": {"source": "w.fl", "fablet": "Ripples"}, "checks": {"source": "w.fl", "fablet": "Checks"}},
  "materials": {"w": {"key": "#ffffff"}, "k": {"key": "#000000"}, "r": {"key": "#ff0000"}, "g": {"key": "#00ff00"}},
  "meshes": {"box": {"box": [1.2, 0.9, 0.8]}, "pin": {"cylinder": [0.5, 1]}, "ball": {"sphere": 1.1}},
  "objects": {
    "box": {"mesh": "box", "fablet": "checks", "uniforms": {"a": "w", "b": "k"}},
    "pin": {"mesh": "pin", "fablet": "checks", "priority": 2, "uniforms": {"a": "r", "b": "g", "size": 0.2}},
    "ball": {"mesh": "ball", "fablet": "ripples", "priority": 1, "uniforms": {"core": "w", "shell": "r"}}
  },
)";

/// `reach_mm` 0: without support.
void expect_world(const std::string& rest, const Vec3d& pitch_mm, uint64_t seed, size_t count,
                  double reach_mm = 0) {
    static const testing::Compiled compiled =
        testing::compile(testing::source_dir() / "tests/property/pipeline/worlds.fl");
    ASSERT_NE(compiled.program, nullptr);
    const testing::TempFolder folder;
    const Result<world::World> world = world::load_world(folder.write("w.fab.json", kHead + rest));
    ASSERT_TRUE(world) << world.error().text();
    const Result<std::vector<part::Part>> parts = part::bind(*world, compiled.program->fablets());
    ASSERT_TRUE(parts) << parts.error().text();
    EXPECT_EQ(parts->size(), count);
    std::vector<const ir::Fablet*> sources;
    for (const part::Part& part : *parts)
        sources.push_back(&compiled.source(part.fablet->name));
    if (reach_mm > 0) {
        testing::expect_reference_and_support(*parts, sources, pitch_mm, seed, reach_mm);
    } else {
        testing::expect_reference(*parts, sources, pitch_mm, seed);
    }
}

TEST(Worlds, NestedGroupsWithScaleAndMirrorAreTheReference) {
    expect_world(R"("groups": {
        "pair": [{"object": "box"}, {"object": "pin", "rotate_deg": [30, 0, 10], "translate_mm": [0.4, 0, 0.2]}],
        "four": [{"group": "pair", "rotate_deg": [0, 0, 35]},
                 {"group": "pair", "scale": [-1, 1.2, 0.9], "translate_mm": [1.1, 0.3, 0.1], "uniforms": {"pin.size": 0.33}}]},
      "build": [{"group": "four"}, {"group": "four", "scale": [1, -0.8, 1], "rotate_deg": [20, 0, 0], "translate_mm": [0.2, 1.4, 0.7]}]})",
                 {0.1, 0.11, 0.09}, 3, 8);
}

TEST(Worlds, ShearedInstancesOfADisplacedShapeAreTheReference) {
    // Four with one shear, one with its mirror image, two of them rotated: they share what they
    // can.
    expect_world(R"("groups": {
        "leaning": [{"object": "ball", "matrix": [1, 0.35, 0, 0, 0, 1, 0.2, 0, 0, 0, 0.9, 0]}]},
      "build": [{"group": "leaning", "grid": {"count": [2, 1], "spacing_mm": 0.1}},
                {"group": "leaning", "rotate_deg": [0, 0, 90], "translate_mm": [0.3, 1.5, 0.4]},
                {"group": "leaning", "scale": [1, 1, -1], "translate_mm": [1.2, 1.1]},
                {"object": "box", "uniforms": {"size": 0.27}, "translate_mm": [0.9, 0.6, 0.2]}]})",
                 {0.12, 0.1, 0.11}, 4, 5);
}

TEST(Worlds, TouchingInstancesOfAGridAreTheReference) {
    expect_world(
        R"("build": [{"object": "box", "rotate_deg": [0, 0, 15], "translate_mm": [0.03, 0.07],
        "grid": {"count": [2, 2, 2], "step_mm": [1.1591, 0.31058, 0.8]}}]})",
        {0.1, 0.1, 0.1}, 5, 8);
}

TEST(Worlds, SupportOfShearedAndMirroredInstancesIsNeverLess) {
    expect_world(R"("groups": {
        "leaning": [{"object": "ball", "matrix": [1, 0.35, 0, 0, 0, 1, 0.2, 0, 0, 0, 0.9, 0]}],
        "lamp": [{"group": "leaning", "translate_mm": [0, 0, 1.5]},
                 {"object": "pin", "rotate_deg": [30, 0, 10], "translate_mm": [1.1, 0.2, 0.4]}]},
      "build": [{"group": "lamp"},
                {"group": "lamp", "scale": [1.1, 1, -1], "rotate_deg": [0, 70, 90], "translate_mm": [1.2, 1.5, 0.7]}]})",
                 {0.12, 0.1, 0.11}, 4, 4, 0.15);
}

}  // namespace
}  // namespace openfab
