// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <random>
#include <sstream>

#include "base/color.h"
#include "mesh/read/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Says;

/// A cube of 2 with a comment, blank lines and faces of four corners; `faces` are behind their corners.
std::string cube(const std::string& header, const std::vector<std::string>& of_vertices = {},
                 const std::vector<std::string>& of_faces = {}) {
    std::string out = header + "\n# made by a test\n\n8 6 12\n";
    for (size_t v = 0; v < 8; ++v)
        out += fmt::format("{} {} {}{}\n", 2 * (v & 1), v & 2, (v & 4) / 2,
                           v < of_vertices.size() ? of_vertices[v] : "");
    const char* const faces[] = {"0 2 3 1", "4 5 7 6", "0 1 5 4", "2 6 7 3", "0 4 6 2", "1 3 7 5"};
    for (size_t f = 0; f < 6; ++f)
        out += fmt::format("4  {}{} # a face\n", faces[f], f < of_faces.size() ? of_faces[f] : "");
    return out;
}

Mesh read(const std::string& text) {
    const Result<LoadedMesh> loaded = parse_bytes(text, "a.off");
    if (!loaded) ADD_FAILURE() << loaded.error().text();
    return loaded ? loaded->mesh : Mesh();
}

std::array<float, 3> color_at(const Mesh& mesh, size_t triangle, size_t corner) {
    const MeshAttribute* const colors = mesh.find("color");
    if (colors == nullptr || colors->corners[triangle][corner] < 0) return {-1, -1, -1};
    const auto at = static_cast<size_t>(colors->corners[triangle][corner]) * 3;
    return {colors->values[at], colors->values[at + 1], colors->values[at + 2]};
}

TEST(Off, PolygonsAreTriangulated) {
    for (const char* header : {"OFF", "COFF", ""}) {
        const Mesh mesh = read(cube(header));
        EXPECT_EQ(mesh.triangles.size(), 12u);
        EXPECT_TRUE(count_edges(mesh).fine());
    }
    // The numbers may be on the line of the word.
    std::string text = cube("OFF");
    text.replace(0, text.find("8 6"), "OFF ");
    EXPECT_EQ(read(text).triangles.size(), 12u);
    text.replace(0, 4, "\t OFF");  // and without a blank
    EXPECT_EQ(read(text).triangles.size(), 12u);
}

TEST(Off, ColoursOfVerticesAndFaces) {
    std::vector<std::string> bytes, parts;
    for (int v = 0; v < 8; ++v) {
        bytes.push_back(fmt::format(" {} 128 0 255", v == 0 ? 255 : 0));
        parts.push_back(fmt::format(" {} 0.5 0 1", v == 0 ? 1 : 0));
    }
    const auto half = static_cast<float>(srgb_to_linear(0.5)),
               of_byte = static_cast<float>(srgb_to_linear(128.0 / 255));
    for (const char* header : {"COFF", "OFF"}) {
        EXPECT_THAT(color_at(read(cube(header, bytes)), 0, 0), ElementsAre(1, of_byte, 0));
        EXPECT_THAT(color_at(read(cube(header, parts)), 0, 0), ElementsAre(1, half, 0));
    }
    // A face's own go first; others keep those of their vertices.
    const Mesh mixed = read(cube("COFF", bytes, {" 0 0 255"}));
    EXPECT_THAT(color_at(mixed, 0, 0), ElementsAre(0, 0, 1));
    EXPECT_THAT(color_at(mixed, 1, 0), ElementsAre(0, 0, 1));
    EXPECT_THAT(color_at(mixed, 4, 0), ElementsAre(1, of_byte, 0));
    // Only integers of 0 and 1: no face is a hundredth of black.
    const Result<LoadedMesh> loaded = parse_bytes(cube("OFF", {}, {" 1 0 0", " 0 1 0"}), "a.off");
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_THAT(color_at(loaded->mesh, 0, 0), ElementsAre(1, 0, 0));
    // What has no colour is white, as in other formats.
    EXPECT_THAT(color_at(loaded->mesh, 11, 0), ElementsAre(1, 1, 1));
    ASSERT_FALSE(loaded->warnings.empty());
    EXPECT_THAT(loaded->warnings[0], Says(messages::kOffUnitColours, "a.off"));
}

TEST(Off, NormalsAndCoordinatesArePassedOver) {
    std::vector<std::string> more;
    for (int v = 0; v < 8; ++v)
        more.push_back(fmt::format(" 0 0 1 0.25 0.5 {} 1 {} 0.75", v == 0 ? 1 : 0, v / 8.0));
    const Mesh mesh = read(cube("STCNOFF", more));
    EXPECT_THAT(color_at(mesh, 0, 0), ElementsAre(static_cast<float>(srgb_to_linear(0.25)),
                                                  static_cast<float>(srgb_to_linear(0.5)), 1));
    const MeshAttribute* const uv = mesh.find("uv");
    ASSERT_NE(uv, nullptr);
    const auto at = static_cast<size_t>(uv->corners[0][1]) * 2;
    EXPECT_EQ(uv->values[at], 2 / 8.0f);
    EXPECT_EQ(uv->values[at + 1], 0.75f);
}

TEST(Off, WhatIsLeftOutIsTold) {
    std::string text = cube("OFF", {}, {" 3"});
    text.replace(text.find("8 6 12"), 6, "8 7 12");
    text += "2 0 1\nOFF\n";
    const Result<LoadedMesh> loaded = parse_bytes(text, "a.off");
    ASSERT_TRUE(loaded) << loaded.error().text();
    std::vector<std::string> told;
    for (const LeftOut& left : loaded->left_out)
        told.push_back(left.what);
    EXPECT_THAT(told,
                ElementsAre(messages::kOffColourMap, messages::kOffEdges, messages::kOffMore));
}

TEST(Off, ErrorsSayWhere) {
    const auto with = [](const std::string& from, const std::string& to) {
        std::string text = cube("OFF");
        return text.replace(text.find(from), from.size(), to);
    };
    EXPECT_THAT(parse_error("OFF BINARY\n", "a.off"), HasSubstr(messages::kOffBinary));
    EXPECT_THAT(parse_error("4OFF\n", "a.off"), HasSubstr(messages::kOffDimensions));
    EXPECT_THAT(parse_error("nOFF 3\n", "a.off"), HasSubstr(messages::kOffDimensions));
    EXPECT_THAT(parse_error("{ LIST }\n", "a.off"), Says(messages::kOffName, "{"));
    EXPECT_THAT(parse_error("OFF\n", "a.off"), HasSubstr(messages::kOffCounts));
    EXPECT_THAT(parse_error(with("8 6 12", "8 6000000 12"), "a.off"),
                Says(messages::kOffTooMany, "6e+06", "faces"));
    EXPECT_THAT(parse_error(with("0 0 0\n", "0 0 zero\n"), "a.off"),
                HasSubstr("a.off:5:1: `zero` is not a number"));
    EXPECT_THAT(parse_error(with("0 0 0\n", "0 0\n"), "a.off"),
                Says(messages::kOffVertex, "2", "3"));
    EXPECT_THAT(parse_error(with("0 2 3 1", "0 2 3 8"), "a.off"),
                Says(messages::kOffNoVertex, "8", "8"));
    EXPECT_THAT(parse_error(with("4  0 2 3 1", "5  0 2 3 1"), "a.off"),
                Says(messages::kOffFace, "4"));
    std::string cut = cube("OFF");
    cut.resize(cut.find("4  1 3 7 5"));
    EXPECT_THAT(parse_error(cut, "a.off"), Says(messages::kOffEndsEarly, "5", "6", "faces"));
}

/// A tetrahedron's words in any lines: `more` is what each vertex has behind its position.
std::string scattered(const std::string& header, const std::string& more, std::mt19937* random) {
    std::string text = header;
    const auto gap = [&] {
        const char* const gaps[] = {" ", " ", "\t", "\n", "\n\n", " # 1 2\n", "  \r\n"};
        return gaps[(*random)() % 7];
    };
    const auto add = [&](const std::string& words) {
        std::istringstream in(words);
        for (std::string word; in >> word;)
            text += gap() + word;
    };
    add("4 4 6");
    for (const char* place : {"0 0 0", "4 0 0", "0 4 0", "0 0 4"})
        add(place + more);
    for (const char* face : {"3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3"})
        add(face);
    return text + "\n";
}

TEST(Off, ItemsLieOnAnyLines) {
    std::mt19937 random(3);
    for (int i = 0; i < 300; ++i) {
        const std::pair<const char*, const char*> kinds[] = {
            {"OFF", ""}, {"off", ""}, {"NOFF", " 0 0 1"}, {"Coff", " 1.0 0.5 0 1"}};
        const auto& [header, more] = kinds[i % 4];
        const std::string text = scattered(header, more, &random);
        SCOPED_TRACE(text);
        const Mesh mesh = read(text);
        ASSERT_EQ(mesh.triangles.size(), 4u);
        EXPECT_TRUE(count_edges(mesh).fine());
        EXPECT_EQ(mesh.positions.size(), 4u);
        if (i % 4 == 3)
            EXPECT_THAT(color_at(mesh, 0, 0),
                        ElementsAre(1, static_cast<float>(srgb_to_linear(0.5)), 0));
        else
            EXPECT_EQ(mesh.find("color"), nullptr);
    }
    // All on one line; faces with a colour end with their line.
    EXPECT_EQ(
        read("OFF 4 4 6 0 0 0 4 0 0 0 4 0 0 0 4 3 0 2 1 3 0 1 3 3 0 3 2 3 1 2 3").triangles.size(),
        4u);
    const Mesh colored = read(
        "OFF\n4 4 6\n0 0 0 4 0 0\n0 4 0 0 0 4\n3 0 2 1 255 0 0\n3 0 1 3\n3\n0 3 2 255 0 0\n3 1 2 3 "
        "0 0 255\n");
    EXPECT_THAT(color_at(colored, 0, 0), ElementsAre(1, 0, 0));
    EXPECT_THAT(color_at(colored, 1, 0), ElementsAre(1, 1, 1));
    EXPECT_THAT(color_at(colored, 3, 0), ElementsAre(0, 0, 1));
}

TEST(Off, NumbersThatAreNoColoursAreNotTakenForThem) {
    std::vector<std::string> normals;
    for (int v = 0; v < 8; ++v)
        normals.push_back(v == 0 ? " -0.6 -0.6 -0.5" : " 0.6 0.6 0.5");
    const Result<LoadedMesh> loaded = parse_bytes(cube("OFF", normals), "a.off");
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_EQ(loaded->mesh.find("color"), nullptr);
    ASSERT_EQ(loaded->left_out.size(), 1u);
    EXPECT_EQ(loaded->left_out[0].what, messages::kOffNegativeColours);
    EXPECT_THAT(parse_error(cube("OFF", {" 1 2"}), "a.off"), Says(messages::kOffVertex, "5", "3"));
    EXPECT_THAT(parse_error(cube("OFF", {}, {" 1 2"}), "a.off"),
                Says(messages::kOffFaceColour, "2"));
    EXPECT_THAT(parse_error("OFF BINARY\n" + std::string(40, '\xff'), "a.off"),
                HasSubstr(messages::kOffBinary));
}

TEST(Off, SurvivesDamage) {
    std::vector<std::string> colors;
    for (int v = 0; v < 8; ++v)
        colors.push_back(fmt::format(" {} 128 0 255", v));
    survive_damage(cube("COFF", colors, {" 1 2 3"}), "a.off", 3000);
}

}  // namespace
}  // namespace openfab::mesh
