// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "base/messages.h"
#include "mesh/read/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/threemf_package.h"

namespace openfab::mesh {
namespace {

std::string package(const std::string& model, const PackageFiles& more = {}) {
    return threemf_package(model, more);
}

/// A box of 1 x 2 x 3 with materials on the first triangles.
std::string box_mesh() {
    std::string text = "<mesh><vertices>";
    for (int v = 0; v < 8; ++v) {
        text += fmt::format(R"(<vertex x="{}" y=" {} " z="{}"/>)",
                            v == 1 || v == 2 || v == 5 || v == 6 ? 1 : 0,
                            v == 2 || v == 3 || v == 6 || v == 7 ? 2 : 0, v >= 4 ? "3e0" : "0");
    }
    text += "</vertices><triangles>";
    const int faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                             {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    for (int f = 0; f < 6; ++f) {
        const auto& c = faces[f];
        const std::string properties = f == 0   ? R"( pid="5" p1="1")"
                                       : f == 1 ? R"( pid="8" p1="0" p2="1" p3="0")"
                                                : R"( pid="8" p1="1")";
        text +=
            fmt::format(R"(<triangle v1="{}" v2="{}" v3="{}"{}/>)", c[0], c[1], c[2], properties);
        text += fmt::format(R"(<triangle v1="{}" v2="{}" v3="{}"/>)", c[0], c[2], c[3]);
    }
    return text + "</triangles></mesh>";
}

constexpr const char* kHead =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<model unit="centimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
 xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
 xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06" requiredextensions="m p">
<resources>
<basematerials id="5"><base name="PLA red" displaycolor="#ff0000"/><base name="PLA blue" displaycolor="#0000FFFF"/></basematerials>
<m:colorgroup id="6"><m:color color="#FF8000"/><m:color color="#000000FF"/></m:colorgroup>
<m:texture2dgroup id="7" texid="99"><m:tex2coord u="0.25" v="0.75"/><m:tex2coord u="1" v="0"/></m:texture2dgroup>
<m:multiproperties id="8" pids="5 6 7"><m:multi pindices="0 0 0"/><m:multi pindices="0 1 1"/></m:multiproperties>
)";

std::string two_boxes() {
    return std::string(kHead) + R"(<object id="1" name="box" pid="8" pindex="1">)" + box_mesh() +
           R"(</object>
<object id="2" type="support">)" +
           box_mesh() + R"(</object>
<object id="3" name="pair"><components>
<component objectid="1"/>
<component objectid="1" transform="-1 0 0 0 1 0 0 0 1 5 0 0"/></components></object>
</resources><build><item objectid="3" transform="0 1 0 -1 0 0 0 0 1 0 0 10"/><item objectid="2"/></build></model>)";
}

TEST(Threemf, PlacesComponentsInTheFilesUnit) {
    const Result<LoadedMesh> loaded = parse_bytes(package(two_boxes()), "a.3mf");
    ASSERT_TRUE(loaded) << loaded.error().text();
    const Mesh& mesh = loaded->mesh;
    EXPECT_EQ(loaded->unit_mm, 10);
    EXPECT_EQ(mesh.triangles.size(), 24u);
    EXPECT_NEAR(testing::signed_volume(mesh), 2 * 6000, 1e-6);
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    // The pair's x reaches 5 and becomes y; y becomes -x.
    EXPECT_EQ(box.lo, (Vec3d{-20, 0, 100}));
    EXPECT_EQ(box.hi, (Vec3d{0, 50, 130}));
    EXPECT_EQ(loaded->groups,
              (std::vector<std::pair<std::string, int32_t>>{{"PLA blue", 0}, {"PLA red", 1}}));
    EXPECT_EQ(mesh.find("face")->faces[0], 0);
    EXPECT_EQ(mesh.find("face")->faces[1], 1);
    EXPECT_EQ(mesh.find("face")->faces[12], 0);
}

TEST(Threemf, ABuildWithoutItemsIsTold) {
    std::string model = two_boxes();
    const size_t from = model.find("<build"), to = model.find("</build>");
    ASSERT_NE(to, std::string::npos);
    model.replace(from, to - from, "<build>");
    const Result<LoadedMesh> loaded = parse_bytes(package(model), "a.3mf");
    ASSERT_FALSE(loaded);
    EXPECT_NE(
        loaded.error().text().find("a.3mf: the build has no items, so that nothing is printed; "
                                   "add objects to the build"),
        std::string::npos)
        << loaded.error().text();
}

TEST(Threemf, MakesABodyOfEachPlacedObject) {
    const MeshSource source = read_source(package(two_boxes()));
    ASSERT_EQ(source.bodies.size(), 2u);
    for (size_t body = 0; body < 2; ++body) {
        EXPECT_EQ(source.bodies[body].name, "box");
        EXPECT_EQ(source.bodies[body].role, BodyRole::kPart);
        EXPECT_EQ(source.bodies[body].assembly, 0);
    }
    EXPECT_EQ(&body_of(source, 11), &source.bodies[0]);
    EXPECT_EQ(&body_of(source, 12), &source.bodies[1]);
    EXPECT_EQ(source.groups[source.face_groups[0]].names,
              (std::vector<std::string>{"pair", "box"}));
    EXPECT_EQ(told(source),
              told_line(fmt::format(messages::kObjectsOfType, "support"), "1, object 2",
                        messages::kObjectTypeHelp) +
                  told_line(messages::kPicturesNotDefined, "1, 3D/3dmodel.model, group 7",
                            messages::kPicturesNotDefinedHelp));
}

TEST(Threemf, ReadsColorsAndTextureCoordinates) {
    std::string model = two_boxes();
    for (size_t at = 0; (at = model.find(R"( pid="5" p1="1")", at)) != std::string::npos;)
        model.erase(at, 15);
    const Result<LoadedMesh> loaded = parse_bytes(package(model), "a.3mf");
    ASSERT_TRUE(loaded) << loaded.error().text();
    const auto value = [&](const char* name, size_t triangle, size_t corner, size_t component) {
        const MeshAttribute& a = *loaded->mesh.find(name);
        return a
            .values[static_cast<size_t>(a.corners[triangle][corner] * a.components) + component];
    };
    ASSERT_NE(loaded->mesh.find("color"), nullptr);
    ASSERT_NE(loaded->mesh.find("uv"), nullptr);
    EXPECT_EQ(value("color", 0, 0, 0), 0);  // the object's own
    EXPECT_EQ(value("color", 2, 0, 0), 1);
    EXPECT_NEAR(value("color", 2, 0, 1), 0.2158605f, 1e-6f);
    EXPECT_EQ(value("color", 2, 1, 0), 0);
    EXPECT_EQ(value("uv", 2, 2, 0), 0.25f);
    EXPECT_EQ(value("uv", 2, 2, 1), 0.75f);
    // In the mirrored one corners 2 and 3 are swapped, and so are their values.
    EXPECT_EQ(value("uv", 14, 1, 1), 0.75f);
    EXPECT_EQ(value("uv", 14, 2, 1), 0);
}

TEST(Threemf, FindsObjectsInOtherParts) {
    const std::string other = std::string(kHead) + R"(<object id="7" name="far">)" + box_mesh() +
                              "</object></resources></model>";
    const std::string root =
        std::string(kHead) +
        R"(<object id="1"><components><component p:path="/3D/Objects/a.model" objectid="7"/>
</components></object></resources><build><item objectid="1"/></build></model>)";
    const Result<LoadedMesh> loaded =
        parse_bytes(package(root, {{"3D/Objects/a.model", other}}), "a.3mf");
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_NEAR(testing::signed_volume(loaded->mesh), 6000, 1e-6);
    EXPECT_THAT(
        parse_error(package(root), "a.3mf"),
        testing::Says(messages::kEntryWrong, "*", "/3D/Objects/a.model", messages::kEntryMissing));
}

std::string with(const std::string& from, const std::string& to) {
    std::string model = two_boxes();
    const size_t at = model.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return package(model.replace(at, from.size(), to));
}

TEST(Threemf, NamesWhatIsWrong) {
    EXPECT_THAT(parse_error("PK but no more", "a.3mf"), testing::Says(messages::kNotZip));
    const std::string good = package(two_boxes());
    EXPECT_THAT(parse_error(good.substr(0, good.size() - 30), "a.3mf"),
                testing::Says(messages::kNotZip));
    EXPECT_EQ(parse_error(with("v1=\"0\"", "v1=\"8\""), "a.3mf"),
              "a.3mf: /3D/3dmodel.model: " + fmt::format(messages::kTriangleOfNoVertex, 1, 8, 8));
    EXPECT_EQ(parse_error(with("unit=\"centimeter\"", "unit=\"cubit\""), "a.3mf"),
              "a.3mf: /3D/3dmodel.model:2:1: " + fmt::format(messages::kUnknownUnit, "cubit"));
    EXPECT_THAT(parse_error(with("\"m p\"", "\"m q\""), "a.3mf"),
                testing::Says(messages::kRequiresThreemfExtension, "q"));
    EXPECT_NE(parse_error(with("</vertices>", "</vertexes>"), "a.3mf").find("mismatched tag"),
              std::string::npos);
    EXPECT_THAT(parse_error(with("<item objectid=\"3\"", "<item objectid=\"4\""), "a.3mf"),
                testing::Says(messages::kNoSuchObject, 4));
    EXPECT_THAT(
        parse_error(with("<component objectid=\"1\"/>", "<component objectid=\"3\"/>"), "a.3mf"),
        testing::Says(messages::kNestedTooDeep, 32));
    EXPECT_THAT(
        parse_error(with("<model ", "<!DOCTYPE model [<!ENTITY a \"b\">]><model "), "a.3mf"),
        testing::Says(openfab::messages::kDocumentType));
    std::string damaged = good;
    damaged[damaged.find("3D/3dmodel.model") + 200] ^= 0x55;
    EXPECT_THAT(parse_error(damaged, "a.3mf"), testing::Says(messages::kEntryDamaged));
}

TEST(Threemf, ComponentsThatMultiplyAreRefused) {
    // Each object is twice the one before: 2^30 boxes.
    std::string model = std::string(kHead) + "<object id=\"100\">" + box_mesh() + "</object>";
    for (int i = 101; i < 131; ++i)
        model += fmt::format(
            R"(<object id="{0}"><components><component objectid="{1}"/><component objectid="{1}"/></components></object>)",
            i, i - 1);
    model += R"(</resources><build><item objectid="130"/></build></model>)";
    EXPECT_THAT(parse_error(package(model), "a.3mf"),
                testing::Says(messages::kTooManyObjects, 100000));
}

TEST(Threemf, SurvivesDamage) {
    survive_damage(package(two_boxes()), "a.3mf", 300);
    // Damage to the model within a sound archive.
    const std::string model = two_boxes();
    std::mt19937 random(5);
    int meshes = 0;
    for (int i = 0; i < 400; ++i) {
        std::string damaged = model;
        for (int k = 0; k < 2; ++k)
            damaged[random() % damaged.size()] = "0123456789-<>/\"= ape"[random() % 20];
        meshes += parse_bytes(package(damaged), "a.3mf").has_value();
    }
    EXPECT_GT(meshes, 0);
}

}  // namespace
}  // namespace openfab::mesh
