// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What STL files hold in practice: each is carried over, or told.

#include "mesh/read/messages.h"
#include "mesh/read/stl.h"

#include <cstring>

#include "base/messages.h"
#include "tests/unit/mesh/features.h"

namespace openfab::mesh {
namespace {

std::string solid(const std::string& name, const std::string& end = "\n") {
    std::string text = "solid " + name + end;
    for (const char* third : {"0 9 0", "0 0 9"})
        text += "facet normal 0 0 1" + end + "outer loop" + end + "vertex 0 0 0" + end +
                "vertex 9 0 0" + end + "vertex " + third + end + "endloop" + end + "endfacet" + end;
    return text + "endsolid " + name + end;
}

std::string binary(std::string header, const std::vector<uint16_t>& attributes) {
    header.resize(80, ' ');
    const auto count = static_cast<uint32_t>(attributes.size());
    header.append(reinterpret_cast<const char*>(&count), 4);
    for (const uint16_t value : attributes) {
        const float corners[12] = {0, 0, 1, 0, 0, 0, 9, 0, 0, 0, 9, 0};
        header.append(reinterpret_cast<const char*>(corners), sizeof corners);
        header.append(reinterpret_cast<const char*>(&value), 2);
    }
    return header;
}

TEST(StlFeatures, AreCarriedOverOrTold) {
    const auto has = [](const char* bodies) {
        return [=](const MeshSource& m) { return bodies_of(m) == bodies; };
    };
    const auto color = [](size_t triangle, double r, double g, double b) {
        return [=](const MeshSource& m) {
            return near(value_at(m, "color", triangle, 1, 0), r) &&
                   near(value_at(m, "color", triangle, 1, 1), g) &&
                   near(value_at(m, "color", triangle, 1, 2), b) &&
                   look_of(m, triangle).vertex_colors;
        };
    };
    const std::string magics("COLOR=\xFF\0\0\xFF,MATERIAL=", 20);
    const std::string meshlab("COLOR=\x7F\x7F\x7F MATERIAL=\x7F\x7F\x7F \x7F\x7F\x7F ", 27);
    const std::string clear("COLOR=\xFF\0\0\x80", 10);
    check_features(
        parse_stl, "m.stl",
        {{"one solid", solid("part one"), {}, "", 0, has("part one")},
         {"a solid without a name", solid(""), {}, "", 0, has("")},
         {"several",
          solid("a") + solid("b") + "solid none\nendsolid none\n",
          {},
          "",
          0,
          has("a, b")},
         {"several of one name", solid("a") + solid("a"), {}, "", 0, has("a, a")},
         {"byte order mark", "\xEF\xBB\xBF" + solid("a"), {}, "", 0, has("a")},
         {"carriage returns alone", solid("a", "\r") + solid("b", "\r"), {}, "", 0, has("a, b")},
         {"carriage returns and line feeds",
          solid("a", "\r\n") + solid("b", "\r\n"),
          {},
          "",
          0,
          has("a, b")},
         {"Latin-1", solid("caf\xE9"), {}, "", 0, has("café")},
         {"binary",
          binary("a", {0, 0}),
          {},
          "",
          0,
          [](const MeshSource& m) { return m.looks.empty() && m.mesh.attributes.empty(); }},
         {"binary that begins with solid",
          binary("solid a", {0, 0}),
          {},
          "",
          0,
          [](const MeshSource& m) { return m.mesh.triangles.size() == 2; }},
         {"values of no colour",
          binary("a", {1, 2}),
          {},
          "",
          0,
          [](const MeshSource& m) {
              return m.looks.empty() && m.mesh.find("attribute")->faces[1] == 2;
          }},
         {"colours of VisCAM",
          binary("a", {0x8000 | 31 << 10, 0x8000 | 31}),
          {},
          "",
          0,
          [=](const MeshSource& m) { return color(0, 1, 0, 0)(m) && color(1, 0, 0, 1)(m); }},
         {"some colours of VisCAM",
          binary("a", {0x8000 | 31 << 5, 0}),
          {},
          "",
          0,
          [=](const MeshSource& m) {
              return color(0, 0, 1, 0)(m) && look_of(m, 1).name == "none";
          }},
         {"one colour of all",
          binary("a", {0x8000 | 31 << 10, 0x8000 | 31 << 10}),
          {},
          "",
          0,
          [](const MeshSource& m) {
              return look_of(m, 1).color == std::array{1.0, 0.0, 0.0} &&
                     m.mesh.find("color") == nullptr;
          }},
         {"colours of Magics",
          binary(magics, {0x8000, 31 << 10}),
          {},
          "",
          0,
          [=](const MeshSource& m) { return color(0, 1, 0, 0)(m) && color(1, 0, 0, 1)(m); }},
         {"red of Magics",
          binary(magics, {0x8000, 31}),
          {},
          "",
          0,
          [=](const MeshSource& m) { return color(1, 1, 0, 0)(m); }},
         {"the colour of the header alone",
          binary(magics, {0x8000, 0x8000}),
          {},
          "",
          0,
          [](const MeshSource& m) {
              return look_of(m, 0).color == std::array{1.0, 0.0, 0.0};
          }},
         {"the header's colour without any of facets",
          binary(magics, {0, 0}),
          {},
          "",
          0,
          [](const MeshSource& m) {
              return look_of(m, 0).color == std::array{1.0, 0.0, 0.0};
          }},
         {"MeshLab's, without colours",
          binary(meshlab, {0, 0}),
          {},
          "",
          0,
          [](const MeshSource& m) { return m.looks.empty() && m.mesh.attributes.empty(); }},
         {"MeshLab's, with colours",
          binary(meshlab, {0x8000 | 31, 0x8000 | 31 << 10}),
          {},
          "",
          0,
          [=](const MeshSource& m) { return color(0, 1, 0, 0)(m) && color(1, 0, 0, 1)(m); }},
         {"MeshLab's, with some",
          binary(meshlab, {0x8000 | 31 << 5, 0}),
          {},
          "",
          0,
          [=](const MeshSource& m) {
              return color(0, 0, 1, 0)(m) && look_of(m, 1).name == "none";
          }},
         {"marked facets of several colours",
          binary(magics, {0x8000 | 31 << 5, 0x8000 | 31 << 10}),
          {},
          "",
          0,
          [=](const MeshSource& m) { return color(0, 0, 1, 0)(m) && color(1, 0, 0, 1)(m); }},
         {"transparency of the header",
          binary(clear, {0x8000, 0x8000}),
          {},
          messages::kTransparencyOfHeader,
          1,
          {}}});
}

TEST(StlFeatures, RefuseUtf16) {
    const Result<MeshSource> read = parse_stl(std::string("\xFF\xFEs\0o\0l\0i\0d\0", 12), "m.stl");
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().text(),
              "m.stl:1:1: " + fmt::format(openfab::messages::kWideText, "UTF-16") + "; " +
                  openfab::messages::kWideTextHelp);
}

}  // namespace
}  // namespace openfab::mesh
