// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstring>

#include "base/messages.h"
#include "mesh/model/messages.h"
#include "mesh/read/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {
namespace {

std::string binary_stl(const Mesh& mesh, const std::string& head = "made by a test") {
    std::string bytes = head;
    bytes.resize(80);
    append(&bytes, static_cast<uint32_t>(mesh.triangles.size()));
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int i = 0; i < 3; ++i)
            append(&bytes, 0.0f);
        for (int32_t v : mesh.triangles[t]) {
            const Vec3d& p = mesh.positions[v];
            for (int a = 0; a < 3; ++a)
                append(&bytes, static_cast<float>(p[a]));
        }
        append(&bytes, static_cast<uint16_t>(t));
    }
    return bytes;
}

std::string ascii_stl(const Mesh& mesh, const std::string& name) {
    std::string text = "solid " + name + "\n";
    for (const auto& t : mesh.triangles) {
        text += "  facet normal 0 0 nan\n    outer loop\n";
        for (int32_t v : t) {
            const Vec3d& p = mesh.positions[v];
            text += fmt::format("      vertex {} {} {:e}\n", p.x, p.y, p.z);
        }
        text += "    endloop\n  endfacet\n";
    }
    return text + "endsolid " + name + "\n";
}

TEST(Stl, ReadsBinaryFilesAndTheirExtraBytes) {
    // Some programs write binary files that start with "solid".
    for (const char* head : {"made by a test", "solid of some program"}) {
        const Result<LoadedMesh> loaded = parse_bytes(binary_stl(testing::cube(10), head), "a.STL");
        ASSERT_TRUE(loaded) << loaded.error().text();
        EXPECT_EQ(loaded->mesh.positions.size(), 8u);
        EXPECT_NEAR(testing::signed_volume(loaded->mesh), 1000, 1e-9);
        ASSERT_NE(loaded->mesh.find("attribute"), nullptr);
        EXPECT_EQ(loaded->mesh.find("attribute")->faces[11], 11);
        EXPECT_TRUE(loaded->warnings.empty());
        EXPECT_EQ(loaded->unit_mm, 1);
    }
}

TEST(Stl, ReadsAsciiFilesWithSolidsAsGroups) {
    Mesh second = testing::cube(5);
    for (Vec3d& p : second.positions)
        p.x += 20;
    const std::string text = ascii_stl(testing::cube(10), "a big one") + ascii_stl(second, "b");
    const Result<LoadedMesh> loaded = parse_bytes(text, "a.stl");
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_NEAR(testing::signed_volume(loaded->mesh), 1125, 1e-9);
    ASSERT_NE(loaded->mesh.find("face"), nullptr);
    EXPECT_EQ(loaded->mesh.find("face")->faces[0], 0);
    EXPECT_EQ(loaded->mesh.find("face")->faces[23], 1);
    EXPECT_EQ(loaded->groups,
              (std::vector<std::pair<std::string, int32_t>>{{"a big one", 0}, {"b", 1}}));
    MeshOptions options;
    options.groups = {{"a big one", 7}, {"b", -3}};
    options.groups_attribute = "kind";
    const Result<LoadedMesh> mapped = parse_bytes(text, "a.stl", options);
    ASSERT_TRUE(mapped) << mapped.error().text();
    EXPECT_EQ(mapped->mesh.find("kind")->faces[0], 7);
    EXPECT_EQ(mapped->mesh.find("kind")->faces[23], -3);
    EXPECT_THAT(mapped->warnings, ::testing::IsEmpty());
    // A name that no face is in, and an attribute that no face gets, are told.
    options.groups->emplace("c", 1);
    const Result<LoadedMesh> more = parse_bytes(text, "a.stl", options);
    ASSERT_TRUE(more) << more.error().text();
    EXPECT_THAT(more->warnings, ::testing::ElementsAre(::testing::AllOf(
                                    ::testing::HasSubstr("maps `c`"),
                                    ::testing::HasSubstr("the file has `a big one`, `b`"))));
    // So is one that has no faces.
    const std::string with_empty = text + "solid c\nendsolid c\n";
    const Result<LoadedMesh> empty = parse_bytes(with_empty, "a.stl", options);
    ASSERT_TRUE(empty) << empty.error().text();
    EXPECT_THAT(empty->warnings, ::testing::ElementsAre(::testing::HasSubstr("maps `c`")));
    MeshOptions named;
    named.groups_attribute = "kind";
    const Result<LoadedMesh> plain = parse_bytes(binary_stl(testing::cube(10)), "a.stl", named);
    ASSERT_TRUE(plain) << plain.error().text();
    EXPECT_EQ(plain->mesh.find("kind"), nullptr);
    EXPECT_THAT(plain->warnings,
                ::testing::ElementsAre(::testing::HasSubstr("`groups_attribute` of mesh")));
}

// What differs by less than a number of millimetres can say is equal once the part is moved.
TEST(Stl, JoinsCornersThatAMoveMakesEqual) {
    std::string bytes = binary_stl(testing::cube(10));
    const float tiny = 1e-30f;
    size_t raised = 0;
    for (size_t facet = 0; facet < 6; ++facet) {
        for (size_t corner = 0; corner < 3; ++corner) {
            char* const z = bytes.data() + 84 + facet * 50 + 12 + corner * 12 + 8;
            float value = 0;
            std::memcpy(&value, z, sizeof value);
            if (value != 0) continue;
            std::memcpy(z, &tiny, sizeof tiny);
            ++raised;
        }
    }
    ASSERT_GT(raised, 0u);
    const Result<LoadedMesh> apart = parse_bytes(bytes, "a.stl");
    ASSERT_FALSE(apart);
    EXPECT_TRUE(testing::says(apart.error().text(), messages::kNotClosed)) << apart.error().text();
    MeshOptions options;
    options.origin_mm = {0, 0, -5};
    const Result<LoadedMesh> moved = parse_bytes(bytes, "a.stl", options);
    ASSERT_TRUE(moved) << moved.error().text();
    EXPECT_EQ(moved->mesh.positions.size(), 8u);
    EXPECT_NEAR(testing::signed_volume(moved->mesh), 1000, 1e-9);
}

TEST(Stl, NamesWhatIsWrong) {
    const std::string text = ascii_stl(testing::cube(10), "c");
    std::string bad = text;
    bad.replace(bad.find("vertex 10"), 9, "vertex 1O");
    EXPECT_THAT(parse_error(bad, "a.stl"), testing::Says(openfab::messages::kNotANumber, "1O"));
    EXPECT_TRUE(parse_error(bad, "a.stl").starts_with("a.stl:"));
    EXPECT_EQ(parse_error(text.substr(0, text.find("endloop")), "a.stl"),
              "a.stl:7:5: " + fmt::format(messages::kEndsBeforeWord, "endloop") + "; " +
                  messages::kWasCutShort);
    EXPECT_EQ(parse_error("solid x\n  frog\n", "a.stl"),
              "a.stl:2:3: " + fmt::format(messages::kOtherWordThanFacet, "frog"));
    EXPECT_EQ(parse_error("solid x\nendsolid x\n", "a.stl"),
              fmt::format(messages::kMeshNoFaces, "a.stl", "part"));
    const std::string binary = binary_stl(testing::cube(10));
    EXPECT_EQ(parse_error(binary.substr(0, 300), "a.stl"),
              fmt::format(messages::kBinaryStlCutShort, "a.stl", 12, 4));
    EXPECT_THAT(parse_error("nothing", "a.stl"), testing::Says(messages::kNotStl));
    std::string infinite = binary;
    const float inf = HUGE_VALF;
    std::memcpy(infinite.data() + 84 + 50 + 12, &inf, 4);
    EXPECT_EQ(parse_error(infinite, "a.stl"), fmt::format(messages::kCornerNotFinite, "a.stl", 2));
}

TEST(Stl, SurvivesDamage) {
    survive_damage(binary_stl(testing::cube(10)), "a.stl", 400);
    survive_damage(ascii_stl(testing::cube(10), "c"), "a.stl", 400);
}

}  // namespace
}  // namespace openfab::mesh
