// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "base/color.h"
#include "mesh/read/messages.h"
#include "tests/support/meshes/zip_archive.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Says;

/// A tetrahedron with its corners at 0 and `side` along each axis; `more` is in each vertex.
std::string vertices(double side, const std::vector<std::string>& more = {"", "", "", ""}) {
    std::string out = "<vertices>";
    const double corners[4][3] = {{0, 0, 0}, {side, 0, 0}, {0, side, 0}, {0, 0, side}};
    for (size_t v = 0; v < 4; ++v)
        out += fmt::format(
            "<vertex><coordinates><x>{}</x><y> {} </y><z>{}</z></coordinates>{}</vertex>\n",
            corners[v][0], corners[v][1], corners[v][2], more[v]);
    return out + "</vertices>";
}

std::string volume(const std::string& attributes = {}, const std::string& more = {},
                   const std::string& of_first = {}) {
    std::string out = fmt::format("<volume{}>{}", attributes, more);
    const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    for (size_t f = 0; f < 4; ++f)
        out += fmt::format("<triangle><v1>{}</v1><v2>{}</v2><v3>{}</v3>{}</triangle>\n",
                           faces[f][0], faces[f][1], faces[f][2], f == 0 ? of_first : "");
    return out + "</volume>";
}

std::string object(int id, const std::string& mesh, const std::string& more = {}) {
    return fmt::format("<object id=\"{}\">{}<mesh>{}</mesh></object>\n", id, more, mesh);
}

std::string amf(const std::string& content, const std::string& attributes = {}) {
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<amf{} version=\"1.1\">{}</amf>\n", attributes,
        content);
}

std::string color(double r, double g, double b) {
    return fmt::format("<color><r>{}</r><g>{}</g><b>{}</b></color>", r, g, b);
}

Box3d box_of(const Mesh& mesh) {
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    return box;
}

LoadedBodies bodies(const std::string& bytes) {
    const std::string file = ::testing::TempDir() + "bodies.amf";
    std::ofstream(file, std::ios::binary) << bytes;
    MeshOptions options;
    options.name = "part";
    Result<LoadedBodies> loaded = load_bodies(file, options);
    if (!loaded) ADD_FAILURE() << loaded.error().text();
    return loaded ? std::move(*loaded) : LoadedBodies();
}

TEST(Amf, HasItsUnitAndPlainOrZippedTheSameMesh) {
    const std::string plain = amf(object(0, vertices(2) + volume()), " unit=\"inch\"");
    for (const std::string& bytes : {plain, testing::zip_archive({{"part.AMF", plain}})}) {
        const Result<LoadedMesh> loaded = parse_bytes(bytes, "a.amf");
        ASSERT_TRUE(loaded) << loaded.error().text();
        EXPECT_EQ(loaded->mesh.triangles.size(), 4u);
        EXPECT_DOUBLE_EQ(loaded->unit_mm, 25.4);
        EXPECT_DOUBLE_EQ(box_of(loaded->mesh).hi.x, 50.8);
    }
}

TEST(Amf, ConstellationsPlaceWhatTheyHave) {
    // Of a turn about x and then y, the corner on y comes to z by the first, and to x by the second.
    const std::string placed =
        "<constellation id=\"7\">"
        "<instance objectid=\"1\"><deltax>10</deltax><rx>90</rx><ry>90</ry></instance>"
        "<instance objectid=\"1\"><deltay>-5</deltay></instance></constellation>"
        "<constellation id=\"8\"><instance "
        "objectid=\"7\"><deltaz>3</deltaz></instance></constellation>";
    const LoadedBodies found =
        bodies(amf(object(1, vertices(2) + volume()) + object(2, vertices(1) + volume()) + placed));
    ASSERT_EQ(found.bodies.size(), 3u);
    const Box3d turned = box_of(found.bodies[0].mesh);
    EXPECT_NEAR(turned.lo.x, 10, 1e-12);
    EXPECT_NEAR(turned.hi.x, 12, 1e-12);
    EXPECT_NEAR(turned.lo.y, -2, 1e-12);
    EXPECT_NEAR(turned.lo.z, 1, 1e-12);
    EXPECT_NEAR(turned.hi.z, 3, 1e-12);
    EXPECT_DOUBLE_EQ(box_of(found.bodies[1].mesh).lo.y, -5);
    // In no constellation: where it is.
    EXPECT_DOUBLE_EQ(box_of(found.bodies[2].mesh).hi.x, 1);
    EXPECT_EQ(found.bodies[0].assembly, found.bodies[1].assembly);
}

// Slic3r and PrusaSlicer write angles in radians, and elements that the format does not have.
TEST(Amf, InstancesOfSlicers) {
    const std::string instance =
        "<constellation id=\"1\"><instance "
        "objectid=\"0\"><deltax>10</deltax><rz>1.5707963267948966</rz>"
        "<scalex>2</scalex><scaley>3</scaley><scalez>0.5</scalez><mirrorx>-1</mirrorx><mirrory>1</"
        "mirrory>"
        "<mirrorz>1</mirrorz><printable>1</printable></instance>"
        "<instance objectid=\"0\"><printable>0</printable></instance></constellation>";
    const std::string one = object(0, vertices(2) + volume()) + instance;
    for (const char* program : {"<metadata type=\"cad\">PrusaSlicer 2.5.0</metadata>",
                                "<metadata type=\"cad\">Slic3r 1.3.0</metadata>",
                                "<metadata type=\"slic3rpe_amf_version\">1</metadata>"}) {
        const LoadedBodies found = bodies(amf(program + one));
        ASSERT_EQ(found.bodies.size(), 1u);
        // x becomes 0 to -4, y 0 to 6, and a quarter turn brings y to -x and x to y.
        const Box3d box = box_of(found.bodies[0].mesh);
        EXPECT_NEAR(box.lo.x, 4, 1e-12);
        EXPECT_NEAR(box.hi.x, 10, 1e-12);
        EXPECT_NEAR(box.lo.y, -4, 1e-12);
        EXPECT_NEAR(box.hi.y, 0, 1e-12);
        EXPECT_NEAR(box.hi.z, 1, 1e-12);
        EXPECT_GT(testing::signed_volume(found.bodies[0].mesh), 0);
        ASSERT_EQ(found.left_out.size(), 1u);
        EXPECT_EQ(found.left_out[0].what, messages::kItemsSwitchedOff);
    }
    // In other programs' files angles are degrees.
    const LoadedBodies found = bodies(amf(one));
    ASSERT_EQ(found.bodies.size(), 1u);
    EXPECT_NEAR(box_of(found.bodies[0].mesh).hi.y, 6, 0.2);
    const std::string all =
        "<constellation id=\"1\"><instance objectid=\"0\"><scale>4</scale>"
        "</instance></constellation>";
    EXPECT_NEAR(box_of(bodies(amf(object(0, vertices(2) + volume()) + all)).bodies[0].mesh).hi.y, 8,
                1e-12);
}

TEST(Amf, MaterialsAreLooks) {
    const std::string materials =
        "<material id=\"1\"><metadata type=\"name\">hard</metadata>" + color(1, 0, 0.5) +
        "</material><material id=\"2\"><metadata type=\"name\">soft</metadata></material>"
        "<material id=\"3\"><metadata type=\"name\">mid</metadata><composite materialid=\"1\">0.6"
        "</composite><composite materialid=\"2\"> 0.2 </composite></material>";
    const LoadedBodies found =
        bodies(amf(object(0, vertices(2) + volume(" materialid=\"1\"")) +
                   object(1, vertices(2) + volume(" materialid=\"3\""),
                          "<metadata type=\"name\">bar</metadata>") +
                   materials +
                   "<constellation id=\"5\"><instance objectid=\"0\"><deltax>9</deltax>"
                   "</instance></constellation>"));
    ASSERT_EQ(found.bodies.size(), 2u);
    ASSERT_EQ(found.looks.size(), 3u);
    const Look& hard = found.looks[0];
    EXPECT_EQ(hard.name, "hard");
    EXPECT_TRUE(hard.is_material);
    ASSERT_TRUE(hard.color);
    EXPECT_THAT(*hard.color, ElementsAre(1, 0, DoubleNear(srgb_to_linear(0.5), 1e-12)));
    const auto mixed = std::find_if(found.looks.begin(), found.looks.end(),
                                    [](const Look& look) { return look.name == "mid"; });
    ASSERT_NE(mixed, found.looks.end());
    ASSERT_EQ(mixed->mixture.size(), 2u);
    EXPECT_EQ(found.looks[static_cast<size_t>(mixed->mixture[0].first)].name, "hard");
    EXPECT_DOUBLE_EQ(mixed->mixture[0].second, 0.75);
    EXPECT_EQ(found.bodies[1].body, "bar");
}

// Triangle, vertex, volume, object, material: the first that there is counts.
TEST(Amf, ColoursOfTheSmallestCount) {
    const auto look_of = [](const std::string& content) {
        const LoadedBodies found = bodies(amf(content));
        return found.looks.empty() ? Look() : found.looks[0];
    };
    const std::string material = "<material id=\"1\">" + color(0, 0, 1) + "</material>";
    const std::string of_object =
        object(0, vertices(2) + volume(" materialid=\"1\""), color(0, 1, 0));
    EXPECT_THAT(*look_of(of_object + material).color, ElementsAre(0, 1, 0));
    const std::string of_volume =
        object(0, vertices(2) + volume(" materialid=\"1\"", color(1, 1, 0)), color(0, 1, 0));
    EXPECT_THAT(*look_of(of_volume + material).color, ElementsAre(1, 1, 0));

    const std::vector<std::string> four{color(1, 0, 0), color(0, 1, 0), color(0, 0, 1),
                                        color(1, 1, 1)};
    const Result<LoadedMesh> loaded = parse_bytes(
        amf(object(0, vertices(2, four) + volume("", "", color(0.5, 0.5, 0.5)), color(0, 1, 0))),
        "a.amf");
    ASSERT_TRUE(loaded) << loaded.error().text();
    const MeshAttribute* const colors = loaded->mesh.find("color");
    ASSERT_NE(colors, nullptr);
    const auto value = [&](size_t triangle, size_t corner) {
        const auto at = static_cast<size_t>(colors->corners[triangle][corner]) * 3;
        return std::array<float, 3>{colors->values[at], colors->values[at + 1],
                                    colors->values[at + 2]};
    };
    const auto grey = static_cast<float>(srgb_to_linear(0.5));
    for (size_t c = 0; c < 3; ++c)
        EXPECT_THAT(value(0, c), ElementsAre(grey, grey, grey));
    EXPECT_THAT(value(1, 0), ElementsAre(1, 0, 0));
    EXPECT_THAT(value(1, 1), ElementsAre(0, 1, 0));
    EXPECT_THAT(value(1, 2), ElementsAre(1, 1, 1));
}

TEST(Amf, WhatASlicerSaysOfVolumes) {
    const auto type = [](const char* key, const char* value) {
        return fmt::format("<metadata type=\"{}\">{}</metadata>", key, value);
    };
    const LoadedBodies found = bodies(
        amf(object(0, vertices(2) + volume("", type("slic3r.extruder", "2")) +
                          volume("", type("slic3r.volume_type", "NegativeVolume")) +
                          volume("", type("slic3r.modifier", "1")) + volume(" type=\"support\""))));
    ASSERT_EQ(found.bodies.size(), 2u);
    EXPECT_EQ(found.looks[0].name, "extruder 2");
    EXPECT_EQ(found.bodies[1].role, BodyRole::kNegative);
    ASSERT_EQ(found.left_out.size(), 2u);
    EXPECT_EQ(found.left_out[0].what, messages::kAmfModifiers);
    EXPECT_EQ(found.left_out[1].what, messages::kAmfSupports);
}

TEST(Amf, WhatIsLeftOutIsTold) {
    const std::string curved = "<normal><nx>0</nx><ny>0</ny><nz>1</nz></normal>";
    const std::string formula =
        "<material id=\"1\"><color><r>x/2</r><g>0</g><b>0</b></color></material>"
        "<material id=\"2\"><composite materialid=\"1\">sin(x)</composite></material>";
    const LoadedBodies found = bodies(
        amf(object(0, vertices(2, {curved, curved, "", ""}) +
                          volume(" materialid=\"2\"", "",
                                 "<texmap rtexid=\"1\" gtexid=\"1\" btexid=\"1\"></texmap>")) +
            formula +
            "<texture id=\"1\" width=\"1\" height=\"1\" depth=\"1\" type=\"grayscale\">/w=="
            "</texture>"));
    std::vector<std::string> told;
    for (const LeftOut& left : found.left_out)
        told.push_back(fmt::format("{} {}", left.what, left.count));
    EXPECT_THAT(told,
                ::testing::UnorderedElementsAre(fmt::format("{} 2", messages::kAmfCurves),
                                                fmt::format("{} 2", messages::kAmfPictures),
                                                fmt::format("{} 1", messages::kAmfColourFormulas),
                                                fmt::format("{} 1", messages::kAmfShareFormulas)));
}

TEST(Amf, ErrorsSayWhere) {
    const std::string good = object(0, vertices(2) + volume());
    EXPECT_THAT(parse_error("<model/>", "a.amf"), HasSubstr(messages::kNoAmf));
    EXPECT_THAT(parse_error(amf(good, " unit=\"furlong\""), "a.amf"),
                Says(messages::kAmfUnit, "furlong"));
    std::string wrong = amf(good);
    wrong.replace(wrong.find("<x>2</x>"), 8, "<x>2,5</x>");
    EXPECT_THAT(parse_error(wrong, "a.amf"), Says(messages::kAmfNoNumber, "2,5"));
    EXPECT_THAT(parse_error(wrong, "a.amf"), HasSubstr("a.amf:3:"));
    wrong = amf(good);
    wrong.replace(wrong.find("<v2>2</v2>"), 10, "<v2>9</v2>");
    EXPECT_THAT(parse_error(wrong, "a.amf"), Says(messages::kAmfNoVertex, "9", "0", "4"));
    wrong = amf(good);
    wrong.replace(wrong.find("<x>2</x>"), 8, "");
    EXPECT_THAT(parse_error(wrong, "a.amf"), Says(messages::kAmfVertex, "1", "0"));
    EXPECT_THAT(parse_error(amf(good + good), "a.amf"), Says(messages::kAmfIdTwice, "0"));
    EXPECT_THAT(parse_error(amf(object(0, vertices(2) + volume(" materialid=\"4\""))), "a.amf"),
                Says(messages::kAmfNoMaterial, "4"));
    const std::string circle =
        "<constellation id=\"5\"><instance objectid=\"6\"/></constellation>"
        "<constellation id=\"6\"><instance objectid=\"5\"/></constellation>";
    EXPECT_THAT(parse_error(amf(good + circle), "a.amf"), HasSubstr(messages::kAmfCircle));
    EXPECT_THAT(parse_error(amf(good + "<constellation id=\"5\"><instance objectid=\"9\"/>"
                                       "</constellation>"),
                            "a.amf"),
                Says(messages::kNoSuchObject, "9"));
    EXPECT_THAT(parse_error(amf(""), "a.amf"), HasSubstr("it has no triangles"));
    EXPECT_THAT(parse_error(testing::zip_archive({{"a.txt", "x"}}), "a.amf"),
                Says(messages::kAmfNotInArchive, "a.amf"));
}

// Constellations that repeat each other a million times are refused before their memory is taken.
TEST(Amf, RepeatedConstellationsAreBounded) {
    std::string content = object(0, vertices(2) + volume());
    for (int level = 1; level <= 20; ++level) {
        content += fmt::format("<constellation id=\"{}\">", level);
        for (int k = 0; k < 4; ++k)
            content += fmt::format("<instance objectid=\"{}\"/>", level - 1);
        content += "</constellation>";
    }
    EXPECT_THAT(parse_error(amf(content), "a.amf"), Says(messages::kTooManyObjects, "100000"));
}

TEST(Amf, SurvivesDamage) {
    const std::vector<std::string> four{color(1, 0, 0), "", color(0, 0, 1), color(1, 1, 1)};
    survive_damage(amf(object(0, vertices(2, four) + volume(" materialid=\"1\"")) +
                       "<material id=\"1\">" + color(0, 0, 1) +
                       "</material>"
                       "<constellation id=\"7\"><instance objectid=\"0\"><rx>90</rx></instance>"
                       "</constellation>"),
                   "a.amf", 3000);
}

}  // namespace
}  // namespace openfab::mesh
