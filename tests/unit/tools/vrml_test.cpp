// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// VRML files as programs write them: places, colours and pictures of what is read, and the OBJ made of it.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <random>

#include "base/color.h"
#include "mesh/load/load_mesh.h"
#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/texture/guarded.h"
#include "tools/vrml/messages.h"
#include "tools/vrml/scene.h"
#include "tools/vrml/wavefront.h"

namespace openfab::tools {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::FloatNear;
using ::testing::HasSubstr;
using testing::Says;
namespace fs = std::filesystem;

constexpr const char* kCube =
    "coord DEF P Coordinate { point [0 0 0, 2 0 0, 2 2 0, 0 2 0, 0 0 2, 2 0 2, 2 2 2, 0 2 2] }\n"
    "coordIndex [3 2 1 0 -1, 4 5 6 7 -1, 0 1 5 4 -1, 1 2 6 5 -1, 2 3 7 6 -1, 3 0 4 7 -1]";

std::string shape(const std::string& appearance, const std::string& more = {}) {
    return fmt::format(
        "Shape {{ appearance Appearance {{ {} }} geometry IndexedFaceSet {{ {} {} }} }}\n",
        appearance, kCube, more);
}

class VrmlFiles : public ::testing::Test {
  protected:
    Result<Scene> read(const std::string& text, const std::string& head = "#VRML V2.0 utf8") {
        scratch_.write("part.wrl", head + "\n" + text);
        return read_scene(scratch_ / "part.wrl");
    }
    Scene scene(const std::string& text) {
        Result<Scene> found = read(text);
        if (!found) ADD_FAILURE() << found.error().text();
        return found ? std::move(*found) : Scene();
    }
    mesh::LoadedBodies bodies(const std::string& text) {
        fs::create_directories(scratch_ / "made");
        const Result<void> written =
            write_wavefront(scene(text), scratch_.path(), scratch_ / "made/part.obj");
        EXPECT_TRUE(written) << written.error().text();
        mesh::MeshOptions options;
        options.name = "part";
        Result<mesh::LoadedBodies> loaded = mesh::load_bodies(scratch_ / "made/part.obj", options);
        if (!loaded) ADD_FAILURE() << loaded.error().text();
        return loaded ? std::move(*loaded) : mesh::LoadedBodies();
    }
    static double volume(const SceneShape& shape) {
        double sum = 0;
        for (const auto& t : shape.triangles)
            sum += dot(t[0].position, cross(t[1].position, t[2].position)) / 6;
        return sum;
    }

    testing::ScratchFolder scratch_;
};

TEST_F(VrmlFiles, ShapesAreAtTheirPlaceAndOutward) {
    const std::string cube = shape("material Material { diffuseColor 1 0 0 }");
    // Scaled, mirrored, turned a quarter about z, moved; a named node around names the shape.
    const Scene found = scene(
        "DEF Left Transform { translation 10 0 0 rotation 0 0 1 1.5707963267948966 scale 1 2 3 "
        "children [" +
        cube + "] }\nTransform { scale -1 1 1 children [" + cube + "] }\n" +
        shape("material Material {}", "ccw FALSE"));
    ASSERT_EQ(found.shapes.size(), 3u);
    EXPECT_EQ(found.shapes[0].name, "Left");
    EXPECT_NEAR(volume(found.shapes[0]), 8 * 6, 1e-4);
    EXPECT_NEAR(volume(found.shapes[1]), 8, 1e-5);
    EXPECT_NEAR(volume(found.shapes[2]), -8, 1e-5);  // as the file says: it is inside out
    Box3d box;
    for (const auto& t : found.shapes[0].triangles) {
        for (const SceneCorner& c : t)
            box.add(c.position);
    }
    EXPECT_NEAR(box.lo.x, 6, 1e-5);
    EXPECT_NEAR(box.hi.x, 10, 1e-5);
    EXPECT_NEAR(box.hi.y, 2, 1e-5);
    EXPECT_NEAR(box.hi.z, 6, 1e-5);
    EXPECT_THAT(found.shapes[0].triangles[0][0].color, ElementsAre(1, 0, 0));
    EXPECT_THAT(found.notes, ElementsAre());
}

TEST_F(VrmlFiles, PrimitivesAreSolids) {
    const Scene found = scene(
        "Shape { geometry Box { size 1 2 3 } }\nShape { geometry Sphere { radius 2 } }\n"
        "Shape { geometry Cylinder { radius 1 height 4 } }\nShape { geometry Cone {} }\n");
    ASSERT_EQ(found.shapes.size(), 4u);
    EXPECT_NEAR(volume(found.shapes[0]), 6, 1e-5);
    // Of chords, somewhat less than the round ones.
    const double round[] = {4.0 / 3 * M_PI * 8, M_PI * 4, M_PI * 2 / 3};
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_LT(volume(found.shapes[i + 1]), round[i]);
        EXPECT_GT(volume(found.shapes[i + 1]), 0.985 * round[i]);
    }
}

TEST_F(VrmlFiles, ColoursOfFacesAndVertices) {
    const std::string faces =
        "color Color { color [1 0 0, 0 1 0, 0 0 1, 1 1 0, 0 1 1, 1 0 1] } colorPerVertex FALSE";
    const std::string corners =
        "color Color { color [1 0 0, 0 1 0, 0 0 1, 1 1 0, 0 1 1, 1 0 1, 0 0 0, 0.5 0.5 0.5] }";
    const Scene found = scene(shape("material Material {}", faces) + shape("", corners));
    ASSERT_EQ(found.shapes.size(), 2u);
    EXPECT_THAT(found.shapes[0].triangles[1][2].color, ElementsAre(1, 0, 0));
    EXPECT_THAT(found.shapes[0].triangles[2][0].color, ElementsAre(0, 1, 0));
    for (const auto& t : found.shapes[1].triangles) {
        for (const SceneCorner& c : t) {
            const bool first = c.position == Vec3d{0, 0, 0}, last = c.position == Vec3d{0, 2, 2};
            if (first) {
                EXPECT_THAT(c.color, ElementsAre(1, 0, 0));
            } else if (last) {
                EXPECT_THAT(c.color, Each(FloatNear(0.5F, 0.01F)));
            }
        }
    }
}

TEST_F(VrmlFiles, ElevationGridsHaveTheirColours) {
    // Three columns of 2 along x, two rows of 3 along z.
    const auto grid = [](const std::string& more) {
        return "Shape { appearance Appearance { material Material { diffuseColor 0.5 0.5 0.5 } } "
               "geometry "
               "ElevationGrid { xDimension 3 zDimension 2 xSpacing 2 zSpacing 3 height [0 1 2 1 0 "
               "3] " +
               more + " } }\n";
    };
    const std::string six = "color Color { color [1 0 0, 0 1 0, 0 0 1, 1 1 0, 0 1 1, 1 0 1] }";
    const Scene found =
        scene(grid(six) + grid("colorPerVertex FALSE " + six) + grid("") + grid("ccw FALSE") +
              "Transform { translation 9 0 0 children [" + grid(six) + "] }");
    ASSERT_EQ(found.shapes.size(), 5u);
    const std::array<float, 3> colors[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                                           {1, 1, 0}, {0, 1, 1}, {1, 0, 1}};
    const auto number = [](const SceneCorner& c, double left) {
        return static_cast<size_t>(std::lround((c.position.x - left) / 2 + c.position.z));
    };
    for (const size_t s : {size_t{0}, size_t{4}}) {
        for (const auto& t : found.shapes[s].triangles) {
            for (const SceneCorner& c : t)
                EXPECT_EQ(c.color, colors[number(c, s == 0 ? 0 : 9)]);
        }
    }
    for (const auto& t : found.shapes[1].triangles) {
        const double left = std::min({t[0].position.x, t[1].position.x, t[2].position.x});
        for (const SceneCorner& c : t)
            EXPECT_EQ(c.color, colors[left < 1 ? 0 : 1]);
    }
    EXPECT_THAT(found.shapes[2].triangles[0][0].color, Each(0.5F));
    for (const size_t s : {size_t{2}, size_t{3}}) {
        for (const auto& t : found.shapes[s].triangles) {
            const Vec3d normal =
                cross(t[1].position - t[0].position, t[2].position - t[0].position);
            EXPECT_EQ(normal.y > 0, s == 2);
        }
    }
    // The library would read what is behind its colours.
    EXPECT_THAT(read(grid("color Color { color [1 0 0] }")).error().text(),
                HasSubstr(messages::kNoSuchColour));
    const std::string beyond =
        "colorPerVertex FALSE color Color { color [1 0 0] } colorIndex [0 0 0 0 0 9000]";
    EXPECT_THAT(read(shape("", beyond)).error().text(), HasSubstr(messages::kNoSuchColour));
}

TEST_F(VrmlFiles, BecomeObjFilesThatAreRead) {
    const std::string moved =
        "Transform { translation 5 0 0 children [" +
        shape("material Material { diffuseColor 0.5 0 1 transparency 0.25 }") + "] }\n";
    const std::string faces =
        "color Color { color [1 0 0, 0 1 0, 0 0 1, 1 1 0, 0 1 1, 1 0 1] } colorPerVertex FALSE";
    const mesh::LoadedBodies found = bodies(moved + shape("", faces));
    ASSERT_EQ(found.bodies.size(), 2u);
    for (const mesh::LoadedMesh& body : found.bodies)
        EXPECT_EQ(body.mesh.triangles.size(), 12u);
    const mesh::Look& plain = found.looks[0];
    ASSERT_TRUE(plain.color);
    EXPECT_NEAR((*plain.color)[0], srgb_to_linear(0.5), 1e-3);
    EXPECT_NEAR(plain.alpha, 0.75, 1e-6);
    EXPECT_TRUE(found.looks[1].vertex_colors);
    EXPECT_NE(found.bodies[1].mesh.find("color"), nullptr);
}

TEST_F(VrmlFiles, PicturesAreFilesBelow) {
    scratch_.write("skin.ppm", "P6 1 1 255\nabc");
    fs::create_directories(scratch_ / "maps");
    scratch_.write("maps/b.ppm", "P6 1 1 255\nabc");
    const std::string coordinates =
        "texCoord TextureCoordinate { point [0 0, 1 0, 1 1, 0 1] }\n"
        "texCoordIndex [0 1 2 3 -1, 0 1 2 3 -1, 0 1 2 3 -1, 0 1 2 3 -1, 0 1 2 3 -1, 0 1 2 3 -1]";
    const auto with = [&](const std::string& url) {
        return shape("texture ImageTexture { url \"" + url + "\" }", coordinates);
    };
    const std::string text =
        with("skin.ppm") + with("maps/b.ppm") + shape("") + with("../up.ppm") + with("gone.ppm");
    const Scene found = scene(text);
    ASSERT_EQ(found.shapes.size(), 5u);
    EXPECT_EQ(found.shapes[0].picture, "skin.ppm");
    EXPECT_EQ(found.shapes[1].picture, "maps/b.ppm");
    EXPECT_EQ(found.shapes[2].picture, "");
    EXPECT_EQ(found.shapes[3].picture + found.shapes[4].picture, "");
    ASSERT_EQ(found.notes.size(), 2u);
    EXPECT_THAT(found.notes[0], Says(messages::kPictureElsewhere, "*", "../up.ppm"));
    EXPECT_THAT(found.shapes[0].triangles[0][0].uv, ElementsAre(0, 0));
    const mesh::LoadedBodies made = bodies(text);
    EXPECT_TRUE(fs::exists(scratch_ / "made/maps/b.ppm"));
    ASSERT_TRUE(made.looks[0].picture);
    EXPECT_EQ(made.looks[0].picture->wrap[0], mesh::PictureWrap::kRepeat);
    // Of several names the first that is there; a picture that does not repeat.
    const Scene several = scene(shape(
        "texture ImageTexture { url [\"gone.png\", \"skin.ppm\"] repeatS FALSE repeatT FALSE }",
        coordinates));
    EXPECT_EQ(several.shapes[0].picture, "skin.ppm");
    EXPECT_TRUE(several.shapes[0].clamps);
    EXPECT_THAT(several.notes, ElementsAre());
    EXPECT_EQ(made.looks[0].picture->name, "skin.ppm");
}

TEST_F(VrmlFiles, WhatIsLeftOutIsTold) {
    scratch_.write("other.wrl", "#VRML V2.0 utf8\n" + shape(""));
    const Scene found =
        scene(shape("") + "Inline { url \"other.wrl\" }\n" +
              "Shape { geometry IndexedLineSet { coord Coordinate { point [0 0 0, 1 0 0, 1 1 0] } "
              "coordIndex [0 1 2 -1] } }\n" +
              "Shape { geometry Text { string \"flat\" } }\n" +
              shape("texture PixelTexture { image 1 1 3 0xff0000 }"));
    EXPECT_EQ(found.shapes.size(), 2u);
    ASSERT_EQ(found.notes.size(), 4u);
    EXPECT_THAT(found.notes[0], Says(messages::kLinesLeftOut, "part.wrl", "2"));
    EXPECT_THAT(found.notes[1], Says(messages::kOtherFilesLeftOut, "part.wrl", "1"));
    EXPECT_THAT(found.notes[2], Says(messages::kTextsLeftOut, "part.wrl", "1"));
    EXPECT_THAT(found.notes[3], Says(messages::kPixelsLeftOut, "part.wrl", "1"));
}

TEST_F(VrmlFiles, OfVersion1) {
    const Result<Scene> found =
        read("Separator { Material { diffuseColor 0 0 1 } Cube { width 2 height 4 depth 6 } }\n",
             "#VRML V1.0 ascii");
    ASSERT_TRUE(found) << found.error().text();
    ASSERT_EQ(found->shapes.size(), 1u);
    EXPECT_NEAR(volume(found->shapes[0]), 48, 1e-4);
    EXPECT_THAT(found->shapes[0].triangles[0][0].color, ElementsAre(0, 0, 1));
}

TEST_F(VrmlFiles, AreRefusedByName) {
    EXPECT_THAT(read("", "this is none").error().text(), HasSubstr("part.wrl: "));
    EXPECT_THAT(read("Group {}").error().text(), HasSubstr(messages::kNoFaces));
    const Result<Scene> damaged = read(shape("").substr(0, 150));
    ASSERT_FALSE(damaged);
    EXPECT_THAT(damaged.error().text(), HasSubstr("part.wrl: "));
    EXPECT_FALSE(read_scene(scratch_ / "gone.wrl"));
}

// In a jail, as the program reads: what ends Coin is an error, too.
TEST_F(VrmlFiles, DamagedOnesAreErrors) {
    const std::string whole =
        "#VRML V2.0 utf8\n" +
        shape(
            "material Material { diffuseColor 1 0 0 } texture ImageTexture { url \"a.png\" }",
            "color Color { color [1 0 0, 0 1 0] } colorPerVertex FALSE colorIndex [0 1 0 1 0 1]") +
        "PROTO Ball [ field SFFloat r 1 ] { Shape { geometry Sphere { radius IS r } } }\n"
        "Transform { rotation 0 0 1 0.5 scale 1 2 3 children [ Ball { r 2 } Ball { r 3 } ] }\n"
        "Shape { geometry Extrusion { crossSection [0 0, 1 0, 1 1, 0 0] spine [0 0 0, 0 1 0] } }\n"
        "Shape { geometry ElevationGrid { xDimension 2 zDimension 2 height [0 1 2 3] } }\n";
    constexpr int64_t kBytes = 500'000'000;
    const int many = testing::long_run() ? 5000 : 150;
    int wrong = 0;
    for (int seed = 0; seed < many; ++seed) {
        std::mt19937_64 random(static_cast<uint64_t>(seed));
        scratch_.write("part.wrl", testing::mutate(whole, true, &random));
        const fs::path file = scratch_ / "part.wrl";
        const Result<void> made = guarded(
            kBytes, file,
            [&]() -> Result<void> {
                const Result<Scene> found = read_scene(file);
                if (!found) return found.error();
                return write_wavefront(*found, scratch_.path(), scratch_ / "made.obj");
            },
            scratch_ / "made.obj");
        if (made) continue;
        ++wrong;
        EXPECT_NE(made.error().code, ErrorCode::kInternal) << "seed " << seed;
        EXPECT_FALSE(made.error().text().empty()) << "seed " << seed;
    }
    EXPECT_GT(wrong, many / 20);
    EXPECT_LT(wrong, many);
}

}  // namespace
}  // namespace openfab::tools
