// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Compiled fablets through the whole pipeline against the plain reference
// (tests/support/reference/pipeline.h): bit-identical voxels on small worlds.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "tests/property/pipeline/reference_check.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/places/places.h"

namespace openfab {
namespace {

using testing::compile;
using testing::Compiled;

const Compiled& postcard() {
    static const Compiled compiled =
        compile(testing::source_dir() / "gallery" / "magic_postcard" / "magic_postcard.fl");
    return compiled;
}
const Compiled& fablets() {
    static const Compiled compiled =
        compile(testing::source_dir() / "tests/property/pipeline/fablets.fl");
    return compiled;
}

const Compiled& queries() {
    static const Compiled compiled =
        compile(testing::source_dir() / "tests/property/pipeline/queries.fl");
    return compiled;
}

const Compiled& rules() {
    static const Compiled compiled =
        compile(testing::source_dir() / "tests/property/pipeline/dither_rules.fl");
    return compiled;
}

/// A picture with soft and hard edges and noise, linear values in [0, 1].
std::shared_ptr<const texture::Pyramid> picture(int32_t width, int32_t height, uint32_t seed,
                                                int32_t wrap, int32_t filter) {
    std::mt19937 random(seed);
    std::vector<float> texels;
    for (int32_t y = 0; y < height; ++y) {
        for (int32_t x = 0; x < width; ++x) {
            const float noise = static_cast<float>(random() % 1000) / 1000.0f;
            const float wave =
                0.5f + 0.5f * std::sin(static_cast<float>(x) * 0.7f + static_cast<float>(y) * 0.3f);
            texels.push_back(x * 3 > width     ? 0.6f * wave + 0.4f * noise
                             : (x + y) % 7 < 2 ? 1.0f
                                               : 0.0f);
        }
    }
    return texture::Pyramid::from_texels(width, height, 1, texels, wrap, filter);
}

/// Noise in a box of the part, in mm; a table instead reads 0 to 1 along each axis.
std::shared_ptr<const texture::Pyramid> volume(const Vec3i& size,
                                               const texture::VolumeDomain& place, uint32_t seed,
                                               int32_t wrap, int32_t filter) {
    std::mt19937 random(seed);
    std::vector<float> texels;
    for (int32_t k = 0; k < size.x * size.y * size.z; ++k)
        texels.push_back(static_cast<float>(random() % 1000) / 1000.0f);
    return texture::Pyramid::from_volume(size, 1, place, texels, wrap, filter);
}

uint32_t bits(float value) {
    uint32_t out;
    static_assert(sizeof out == sizeof value);
    __builtin_memcpy(&out, &value, sizeof out);
    return out;
}

struct TestPart {
    const Compiled* compiled;
    std::string fablet;
    mesh::Mesh mesh;
    testing::PartOptions options;
};

Affine3d turned(double degrees, const Vec3d& axis, const Vec3d& scale, const Vec3d& translation) {
    const double angle = degrees * std::acos(-1.0) / 180, c = std::cos(angle), s = std::sin(angle);
    const Vec3d a = axis * (1 / length(axis));
    Affine3d out;
    out.m = {
        c + a.x * a.x * (1 - c),       a.x * a.y * (1 - c) - a.z * s, a.x * a.z * (1 - c) + a.y * s,
        a.y * a.x * (1 - c) + a.z * s, c + a.y * a.y * (1 - c),       a.y * a.z * (1 - c) - a.x * s,
        a.z * a.x * (1 - c) - a.y * s, a.z * a.y * (1 - c) + a.x * s, c + a.z * a.z * (1 - c)};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            out.m[static_cast<size_t>(row * 3 + column)] *= scale[column];
    }
    out.t = translation;
    return out;
}

struct Made {
    std::vector<part::Part> parts;
    std::vector<const ir::Fablet*> sources;
};

Made make(const std::vector<TestPart>& tests) {
    Made made;
    for (const TestPart& test : tests) {
        EXPECT_NE(test.compiled->program, nullptr);
        if (test.compiled->program == nullptr) return {};
        made.parts.push_back(
            testing::make_part(test.compiled->table(test.fablet), test.mesh, test.options));
        made.sources.push_back(&test.compiled->source(test.fablet));
    }
    return made;
}

void expect_reference(const std::vector<TestPart>& tests, const Vec3d& pitch_mm, uint64_t seed) {
    const Made made = make(tests);
    testing::expect_reference(made.parts, made.sources, pitch_mm, seed);
}

void expect_reference_and_support(const std::vector<TestPart>& tests, const Vec3d& pitch_mm,
                                  uint64_t seed, double reach_mm) {
    const Made made = make(tests);
    testing::expect_reference_and_support(made.parts, made.sources, pitch_mm, seed, reach_mm);
}

TestPart postcard_part(double width, double height, const Affine3d& transform = {}) {
    // border, textureDepth, maxThickness
    return {
        &postcard(), "MagicPostcard", testing::card(width, height, 1.1),
        testing::PartOptions{.transform = transform,
                             .uniform_values = {bits(0.1f), bits(0.15f), bits(0.3f), bits(0.8f)},
                             .textures = {picture(37, 23, 1, 0, 1), picture(29, 31, 2, 0, 1)},
                             .slot_material = {1, 2},
                             .max_displacement_mm = 0.8}};
}

TEST(Pipeline, PostcardIsTheReference) {
    expect_reference({postcard_part(3.1, 2.3)}, {0.11, 0.21, 0.07}, 1);
}

TEST(Pipeline, APostcardAtAnAngleIsTheReference) {
    expect_reference({postcard_part(2.4, 2.0, turned(33, {1, 2, 0.5}, {1, 1, 1}, {40, -30, 12}))},
                     {0.13, 0.17, 0.09}, 2);
}

TEST(Pipeline, ShellByDistanceIsTheReference) {
    expect_reference({{&fablets(), "Shell", testing::torus(2.0, 0.8, 24, 12), {}}},
                     {0.12, 0.1, 0.08}, 3);
}

TEST(Pipeline, PatternByPositionIsTheReference) {
    expect_reference({{&fablets(),
                       "Checks",
                       testing::cube(2.5),
                       {.transform = turned(20, {0, 0, 1}, {1, 1.3, 0.8}, {5, 5, 0})}}},
                     {0.1, 0.1, 0.1}, 4);
}

TEST(Pipeline, TextureUnderTheSkinIsTheReference) {
    testing::PartOptions options;
    options.textures = {picture(64, 48, 3, 1, 1)};
    expect_reference({{&fablets(), "Skin", testing::sphere(1.6, 20, 12), options}},
                     {0.1, 0.13, 0.07}, 5);
}

TEST(Pipeline, BumpsOnASphereAreTheReference) {
    testing::PartOptions options;
    options.textures = {picture(32, 32, 4, 1, 0)};
    options.max_displacement_mm = 0.4;
    expect_reference({{&fablets(), "Bumps", testing::sphere(1.2, 12, 8), options}},
                     {0.12, 0.12, 0.12}, 6);
}

TEST(Pipeline, FacesOfADisplacedBoxAreTheReference) {
    testing::PartOptions options;
    options.slot_material = {1, 2, 3};
    options.max_displacement_mm = 0.2;
    const TestPart part{&fablets(), "Faces", testing::card(6, 4, 3.2), options};
    expect_reference({part}, {0.11, 0.16, 0.07}, 11);
}

TEST(Pipeline, SlabsOfADisplacedPartCanBePrintedAgain) {
    testing::PartOptions options;
    options.textures = {picture(32, 32, 4, 1, 0)};
    options.max_displacement_mm = 0.4;
    const Made made =
        make({{&fablets(), "Bumps", testing::sphere(1.2, 12, 8), options}, postcard_part(2, 1.6)});
    testing::expect_slabs_outlive_an_interrupt(made.parts, {0.08, 0.08, 0.05});
    testing::expect_repeated_slabs_are_equal_work(made.parts, {0.08, 0.08, 0.05});
}

TEST(Pipeline, LoopsInBothStagesAreTheReference) {
    testing::PartOptions options;
    options.textures = {picture(24, 24, 5, 1, 0)};
    options.max_displacement_mm = 0.3;
    expect_reference({{&fablets(), "Fractal", testing::sphere(1.1, 12, 8), options}},
                     {0.1, 0.1, 0.1}, 9);
}

TEST(Pipeline, OverlappingPartsOfDifferentPriorityAreTheReference) {
    testing::PartOptions above;
    above.priority = 2;
    above.transform = turned(10, {1, 0, 0}, {1, 1, 1}, {0.7, 0.4, 0.3});
    above.instance = 1;
    testing::PartOptions hole;
    hole.priority = 5;
    hole.transform.t = {1.2, 1.2, -0.5};
    hole.instance = 2;
    expect_reference({{&fablets(), "Checks", testing::cube(2.2), {}},
                      {&fablets(), "Shell", testing::sphere(1.3, 16, 10), above},
                      {&fablets(), "Hole", testing::cube(0.6), hole}},
                     {0.1, 0.12, 0.09}, 7);
}

TEST(Pipeline, AMirroredPartIsTheReference) {
    expect_reference({postcard_part(2.2, 1.6, turned(0, {0, 0, 1}, {-1, 1, 1}, {3, 3, 3}))},
                     {0.11, 0.12, 0.1}, 8);
}

TEST(Pipeline, QueriesAtAnyPointAreTheReference) {
    testing::PartOptions options;
    options.textures = {picture(32, 32, 4, 1, 0)};
    options.max_displacement_mm = 0.4;
    options.transform = turned(40, {1, 0.3, 0.2}, {1, 1.2, 0.9}, {2, 1, 7});
    expect_reference({{&queries(), "Wander", testing::sphere(1.2, 12, 8), options}},
                     {0.14, 0.12, 0.12}, 9);
}

TEST(Pipeline, DistanceToOtherObjectsIsTheReference) {
    testing::PartOptions body, first, second;
    body.priority = 3;
    body.objects = {{1}, {1, 2}, {0}};
    first.instance = 1;
    first.transform = turned(65, {1, 2, 3}, {0.8, 1.5, 1}, {0.8, 0.6, 0.4});
    first.objects = {{0}, {0}, {2}};
    second.instance = 2;
    second.transform = turned(0, {0, 0, 1}, {-1, 1, 1}, {2.4, 1.1, 0.9});
    second.objects = {{0, 1}, {2}, {1}};
    expect_reference({{&queries(), "Neighbours", testing::cube(2.2), body},
                      {&queries(), "Neighbours", testing::torus(0.9, 0.4, 16, 8), first},
                      {&queries(), "Neighbours", testing::sphere(0.8, 12, 8), second}},
                     {0.12, 0.14, 0.12}, 10);
}

TEST(Pipeline, QueriesInALoopAreTheReference) {
    expect_reference({{&queries(), "Walk", testing::torus(1.6, 0.7, 20, 10), {}}},
                     {0.13, 0.12, 0.11}, 11);
}

/// Of the 8 blocks in a row 5 go through the segments at once.
TEST(Pipeline, SegmentsOfManySlotsAreTheReference) {
    testing::PartOptions options;
    options.slot_material = {1, 3, 2, 4, 0, 1, 1, 2, 3, 4, 2, 0, 3, 1, 4, 4, 2, 3};
    expect_reference({{&queries(), "Layers", testing::torus(1.6, 0.7, 20, 10), options}},
                     {0.08, 0.12, 0.11}, 12);
}

TEST(Pipeline, VolumesAreTheReference) {
    testing::PartOptions options;
    options.textures = {
        volume({9, 7, 8}, {{-1, -1.5f, -0.5f}, {2, 3, 2.5f}, false}, 1, 2, 0),
        volume({5, 4, 3}, {{-0.125f, -0.166f, -0.25f}, {1.25f, 1.333f, 1.5f}, true}, 2, 1, 1)};
    options.max_displacement_mm = 0.3;
    options.transform = turned(25, {0.2, 1, 0.1}, {1.1, 1, 0.9}, {-3, 2, 5});
    expect_reference({{&queries(), "Cloud", testing::sphere(1.3, 12, 8), options}},
                     {0.12, 0.11, 0.13}, 12);
}

TEST(Pipeline, DitherRulesAreTheReference) {
    testing::PartOptions ruled, walked, plain;
    ruled.slot_material = {3, 1, 2, 1, 0};
    ruled.uniform_values = {bits(0.7f), 3};
    ruled.transform = turned(20, {0, 0, 1}, {1, 1, 1}, {5, 5, 0});
    walked.slot_material = {2, 4};
    walked.instance = 1;
    walked.transform.t = {7.5, 5, 0};
    plain.priority = 2;
    plain.instance = 2;
    plain.transform.t = {6, 5, 0.4};
    expect_reference({{&rules(), "Ruled", testing::cube(2.2), ruled},
                      {&rules(), "Walked", testing::sphere(1.2, 16, 10), walked},
                      {&fablets(), "Checks", testing::cube(0.9), plain}},
                     {0.1, 0.12, 0.09}, 13);
}

// The library's rule against the runtime's own code, and a rule against none.
TEST(Pipeline, ARuleDoesWhatTheSameBuiltInDoes) {
    testing::PartOptions largest, plain;
    largest.slot_material = {3, 1, 2, 1, 0};
    plain.transform.t = {1.8, 0.1, 0.2};
    plain.priority = 1;
    const Made made = make({{&rules(), "Largest", testing::cube(2.2), largest},
                            {&fablets(), "Hole", testing::sphere(0.8, 16, 10), plain}});
    testing::expect_same_dithers(made.parts, {0.1, 0.12, 0.09}, 15, {"own", "majority"}, true);
    testing::expect_same_dithers(made.parts, {0.1, 0.12, 0.09}, 15, {"own", "blue_noise"}, false);
}

// The mask of every side, and that inside, are what the runtime's own code takes.
TEST(Pipeline, ARuleThatKnowsItsSidesIsBlueNoise) {
    testing::PartOptions box;
    box.slot_material = {3, 1, 2};
    box.uniform_values = {21, 17, 0};
    const Made made = make({{&rules(), "Boxed", testing::cube(2.2), box}});
    for (const uint64_t seed : {0, 77}) {
        testing::expect_same_dithers(made.parts, {0.1, 2.2 / 18, 0.07}, seed, {"own", "blue_noise"},
                                     true);
    }
    testing::expect_same_dithers(made.parts, {0.1, 2.2 / 17, 0.07}, 77, {"own", "blue_noise"},
                                 false);
}

TEST(Pipeline, ARuleOfOneMixtureIsTheReference) {
    testing::PartOptions options;
    options.slot_material = {2, 1};
    expect_reference({{&rules(), "Uniform", testing::cube(2.8), options}}, {0.1, 0.09, 0.08}, 14);
}

// Displaced parts are supported according to their displacement bounds: never less than they need,
// and no more than their greatest displacement above or beside them.

TEST(PipelineSupport, OfAPostcardAtAnAngleIsNeverLess) {
    expect_reference_and_support(
        {postcard_part(2.4, 2.0, turned(33, {1, 2, 0.5}, {1, 1, 1}, {40, -30, 12}))},
        {0.17, 0.19, 0.12}, 2, 0.8);
}

TEST(PipelineSupport, OfBumpsOutwardIsNeverLess) {
    testing::PartOptions options;
    options.textures = {picture(32, 32, 4, 1, 0)};
    options.max_displacement_mm = 0.4;
    // A table over it, mirrored and stretched, of another displaced part.
    testing::PartOptions above = options;
    above.transform = turned(15, {1, 0.2, 0}, {-1.4, 1.2, 0.5}, {0.9, 0.2, 2.4});
    above.instance = 1;
    expect_reference_and_support({{&fablets(), "Bumps", testing::sphere(1.2, 12, 8), options},
                                  {&fablets(), "Bumps", testing::torus(1.1, 0.4, 12, 8), above}},
                                 {0.17, 0.16, 0.15}, 6, 0.4 * 1.4);
}

// Ripples both ways, and holes of a part of higher priority, which are void that is supported.
TEST(PipelineSupport, OfRipplesWithHolesIsNeverLess) {
    testing::PartOptions options;
    options.textures = {picture(24, 24, 5, 1, 0)};
    options.max_displacement_mm = 0.3;
    testing::PartOptions hole;
    hole.priority = 5;
    hole.transform.t = {-0.3, -0.4, -0.2};
    hole.instance = 1;
    expect_reference_and_support({{&fablets(), "Fractal", testing::sphere(1.1, 12, 8), options},
                                  {&fablets(), "Hole", testing::cube(0.7), hole}},
                                 {0.1, 0.1, 0.1}, 9, 2 * 0.3);
}

// Displaced and undisplaced parts share the map, and the displaced one has slack above.
TEST(PipelineSupport, OfDisplacedPartsAmongOthersIsNeverLess) {
    testing::PartOptions ball;
    ball.textures = {picture(32, 32, 4, 1, 0)};
    ball.max_displacement_mm = 0.35;
    ball.transform.t = {1.3, 1.2, 0.9};
    testing::PartOptions shelf;
    shelf.instance = 1;
    shelf.priority = 1;
    shelf.transform = turned(20, {0.1, 1, 0}, {1.5, 1, 0.3}, {-1.5, 0.3, 2.6});
    expect_reference_and_support({{&fablets(), "Bumps", testing::sphere(0.8, 12, 8), ball},
                                  {&fablets(), "Checks", testing::cube(1.8), shelf}},
                                 {0.1, 0.12, 0.09}, 3, 0.35);
}

}  // namespace
}  // namespace openfab
