// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "mesh/model/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {
namespace {

/// A tetrahedron of this size, in two groups and two materials.
std::string tetrahedron(double size) {
    return fmt::format(
        "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\n"
        "g low\nusemtl red\nf 1 3 2\ng high\nf 1 2 4\nusemtl blue\nf 2 3 4\nf 1 4 3\n",
        size);
}

TEST(LoadMesh, GuessesMetresWithAWarning) {
    const Result<LoadedMesh> small = parse_bytes(tetrahedron(0.05), "a.obj");
    ASSERT_TRUE(small);
    EXPECT_EQ(small->unit_mm, 1000);
    EXPECT_EQ(small->unit_note, messages::kUnitFromSize);
    EXPECT_EQ(small->mesh.positions[1], (Vec3d{50, 0, 0}));
    EXPECT_EQ(small->warnings, (std::vector<std::string>{fmt::format(
                                   messages::kUnitGuessed, "a.obj", "part", 0.05, 0.05, 0.05)}));
    MeshOptions options;
    options.unit_mm = 1;
    const Result<LoadedMesh> as_asked = parse_bytes(tetrahedron(0.05), "a.obj", options);
    ASSERT_TRUE(as_asked);
    EXPECT_EQ(as_asked->mesh.positions[1], (Vec3d{0.05, 0, 0}));
    ASSERT_EQ(as_asked->warnings.size(), 1u);
    EXPECT_THAT(as_asked->warnings[0], testing::Says(messages::kMeshSizeUnlikely));
    const Result<LoadedMesh> usual = parse_bytes(tetrahedron(50), "a.obj");
    ASSERT_TRUE(usual);
    EXPECT_EQ(usual->unit_mm, 1);
    EXPECT_TRUE(usual->warnings.empty());
}

/// As glTF is read: right-handed, without rounding, normals too.
TEST(LoadMesh, StandsUpWhatHasYUp) {
    const std::string text =
        "v 0 0 0\nv 5 0 0\nv 0 7 0\nv 0 0 9\nvn 0 0 -1\nvn 0.6 0.8 0\n"
        "f 1//1 3//1 2//1\nf 1//2 2//2 4//2\nf 2//2 3//2 4//2\nf 1//2 4//2 3//2\n";
    MeshOptions options;
    options.y_up = true;
    const Result<LoadedMesh> mesh = parse_bytes(text, "a.obj", options);
    ASSERT_TRUE(mesh) << mesh.error().text();
    EXPECT_EQ(mesh->mesh.positions,
              (std::vector<Vec3d>{{0, 0, 0}, {5, 0, 0}, {0, 0, 7}, {0, -9, 0}}));
    EXPECT_EQ(mesh->checks.turned, 0);
    EXPECT_EQ(mesh->mesh.find("n")->values, (std::vector<float>{0, 1, 0, 0.6F, 0, 0.8F}));
    EXPECT_TRUE(format_says_up("a.GLB"));
    EXPECT_FALSE(format_says_up("a.obj"));
}

TEST(LoadMesh, NumbersMaterialsElseGroups) {
    using Numbers = std::vector<std::pair<std::string, int32_t>>;
    const Result<LoadedMesh> materials = parse_bytes(tetrahedron(5), "a.obj");
    ASSERT_TRUE(materials);
    EXPECT_EQ(materials->groups, (Numbers{{"red", 0}, {"blue", 1}}));
    EXPECT_EQ(materials->mesh.find("face")->faces, (std::vector<int32_t>{0, 0, 1, 1}));
    std::string text = tetrahedron(5);
    for (const char* line : {"usemtl red\n", "usemtl blue\n"})
        text.erase(text.find(line), std::string(line).size());
    const Result<LoadedMesh> groups = parse_bytes(text, "a.obj");
    ASSERT_TRUE(groups);
    EXPECT_EQ(groups->groups, (Numbers{{"low", 0}, {"high", 1}}));
    for (const char* line : {"g low\n", "g high\n"})
        text.erase(text.find(line), std::string(line).size());
    const Result<LoadedMesh> none = parse_bytes(text, "a.obj");
    ASSERT_TRUE(none);
    EXPECT_TRUE(none->groups.empty());
    EXPECT_EQ(none->mesh.find("face"), nullptr);
}

TEST(LoadMesh, RefusesOtherExtensions) {
    EXPECT_TRUE(is_mesh_file("X.PLY"));
    EXPECT_FALSE(is_mesh_file("x.step"));
    EXPECT_FALSE(is_mesh_file("obj"));
    EXPECT_THAT(parse_error("", "a.step"), testing::Says(messages::kNoMeshExtension, "*a.step"));
    const Result<LoadedMesh> missing = load_mesh("nowhere/a.stl", {});
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::kUserInput);
}

}  // namespace
}  // namespace openfab::mesh
