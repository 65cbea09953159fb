// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Which bodies a file has, what each is made of, and which lies in which.

#include "mesh/load/bodies.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mesh/check/nesting.h"
#include "mesh/load/face_numbers.h"
#include "tests/support/meshes/meshes.h"

namespace openfab::mesh {
namespace {

/// Collects cubes, or faces of cubes, as a reader would.
class Builder {
  public:
    int32_t look(const std::string& name) {
        Look added;
        added.name = name;
        source_.looks.push_back(added);
        return static_cast<int32_t>(source_.looks.size()) - 1;
    }
    int32_t body(const std::string& name, BodyRole role = BodyRole::kPart) {
        source_.bodies.push_back({name, role, 0});
        return static_cast<int32_t>(source_.bodies.size()) - 1;
    }
    /// Adds the triangles first ... last - 1 of a cube.
    void cube(double side, const Vec3d& at, int32_t body, int32_t look, bool inside_out = false,
              size_t first = 0, size_t last = 12) {
        const Mesh cube = testing::cube(side);
        const auto base = static_cast<int32_t>(source_.mesh.positions.size());
        for (const Vec3d& p : cube.positions) {
            source_.mesh.positions.push_back(p + at);
            source_.part_of_vertex.push_back(body);
        }
        FaceGroup group;
        group.body = body;
        group.look = look;
        const int32_t g = source_.group_index(group);
        for (size_t t = first; t < last; ++t) {
            auto [a, b, c] = cube.triangles[t];
            if (inside_out) std::swap(b, c);
            source_.mesh.triangles.push_back({base + a, base + b, base + c});
            source_.face_groups.push_back(g);
        }
    }
    MeshSource& source() { return source_; }

  private:
    MeshSource source_;
};

std::vector<std::string> names(const FoundBodies& found) {
    std::vector<std::string> out;
    for (const FoundBody& body : found.bodies)
        out.push_back(body.name);
    return out;
}
using Names = std::vector<std::string>;

TEST(Bodies, AreThoseOfTheFileWithNamesOfTheirOwn) {
    Builder b;
    const int32_t red = b.look("red");
    for (int i = 0; i < 3; ++i)
        b.cube(10, {10.0 * i, 0, 0}, b.body(i == 1 ? "" : "PLA"), red);
    const FoundBodies found = find_bodies(b.source());
    EXPECT_EQ(names(found), (Names{"PLA", "body", "PLA 2"}));
    const std::vector<MeshSource> split = split_bodies(b.source(), found, {2, 0});
    ASSERT_EQ(split.size(), 2u);
    EXPECT_EQ(split[0].mesh.positions.size(), 8u);
    EXPECT_EQ(split[0].mesh.triangles.size(), 12u);
    EXPECT_NEAR(testing::signed_volume(split[0].mesh), 1000, 1e-9);
    EXPECT_EQ(split[0].mesh.positions[0].x, 20);
    EXPECT_EQ(split[1].mesh.positions[0].x, 0);
    EXPECT_EQ(split[1].groups.size(), 1u);
}

TEST(Bodies, OfOneNameAreToldApartByClosedLooks) {
    Builder b;
    const int32_t red = b.look("red"), blue = b.look("blue"), grey = b.look("grey");
    const int32_t both = b.body("");
    b.cube(10, {0, 0, 0}, both, red);
    b.cube(10, {10, 0, 0}, both, blue);
    EXPECT_EQ(names(find_bodies(b.source())), (Names{"red", "blue"}));
    // A cube of two looks is one body, also beside another.
    const int32_t mixed = b.body("mixed");
    b.cube(10, {40, 0, 0}, mixed, red, false, 0, 2);
    b.cube(10, {40, 0, 0}, mixed, grey, false, 2, 12);
    EXPECT_EQ(names(find_bodies(b.source())), (Names{"red", "blue", "mixed"}));
}

TEST(Bodies, OpenUnitsThatShareEdgesAreOne) {
    Builder b;
    const int32_t label = b.body("label"), box = b.body("box"), other = b.body("other");
    b.cube(10, {0, 0, 0}, label, -1, false, 0, 2);
    b.cube(10, {0, 0, 0}, box, -1, false, 2, 12);
    b.cube(10, {10, 0, 0}, other, -1);
    const FoundBodies found = find_bodies(b.source());
    EXPECT_EQ(names(found), (Names{"label", "other"}));
    EXPECT_TRUE(found.bodies[0].joined);
    const std::vector<MeshSource> split = split_bodies(b.source(), found, {0});
    EXPECT_EQ(split[0].mesh.triangles.size(), 12u);
    EXPECT_TRUE(split[0].part_of_vertex.empty()) << "so that their seam is welded";
}

TEST(Bodies, AHollowBelongsToWhatItIsIn) {
    for (const bool whole_inside_out : {false, true}) {
        Builder b;
        const int32_t outer = b.body("outer"), hollow = b.body("hollow"), core = b.body("core");
        b.cube(20, {0, 0, 0}, outer, -1, whole_inside_out);
        b.cube(6, {7, 7, 7}, hollow, -1, !whole_inside_out);
        b.cube(6, {7, 7, 7}, core, -1, whole_inside_out);
        const FoundBodies found = find_bodies(b.source());
        EXPECT_EQ(names(found), (Names{"outer", "core"})) << whole_inside_out;
    }
}

TEST(Bodies, OnlyPartsAreOneMesh) {
    Builder b;
    b.cube(10, {0, 0, 0}, b.body("part"), -1);
    b.cube(4, {3, 3, 3}, b.body("hole", BodyRole::kNegative), -1);
    b.cube(4, {13, 3, 3}, b.body("blocker", BodyRole::kNotPrinted), -1);
    const FoundBodies found = find_bodies(b.source());
    keep_parts(found, &b.source());
    EXPECT_EQ(b.source().mesh.triangles.size(), 12u);
    ASSERT_EQ(b.source().warnings.size(), 1u);
    EXPECT_NE(b.source().warnings[0].find("`hole`, `blocker`"), std::string::npos);
}

/// The pieces of a mesh of cubes, by their lowest corner and side.
Nesting nesting_of(const std::vector<std::pair<double, Vec3d>>& cubes) {
    Builder b;
    std::vector<int32_t> pieces;
    for (const auto& [side, at] : cubes) {
        b.cube(side, at, b.body(""), -1);
        pieces.resize(pieces.size() + 12, static_cast<int32_t>(pieces.size() / 12));
    }
    return *find_nesting(b.source().mesh, pieces, static_cast<int32_t>(cubes.size()));
}

TEST(Nesting, IsWhatLiesInsideAndNotWhatTouches) {
    const Nesting nested =
        nesting_of({{20, {}}, {6, {7, 7, 7}}, {2, {9, 9, 9}}, {20, {20, 0, 0}}, {20, {18, 30, 0}}});
    EXPECT_TRUE(nested.inside[0].empty());
    EXPECT_EQ(nested.inside[1], (std::vector<int32_t>{0}));
    EXPECT_EQ(nested.inside[2], (std::vector<int32_t>{0, 1}));
    EXPECT_TRUE(nested.inside[3].empty());
    EXPECT_TRUE(nested.overlaps.empty());
    // In a corner, whose faces it shares.
    EXPECT_EQ(nesting_of({{20, {}}, {6, {}}}).inside[1], (std::vector<int32_t>{0}));
    const Nesting across = nesting_of({{20, {}}, {20, {10, 1, 1}}, {20, {}}});
    EXPECT_TRUE(across.inside[1].empty());
    EXPECT_EQ(across.overlaps, (std::vector<std::pair<int32_t, int32_t>>{{0, 1}, {0, 2}, {1, 2}}));
}

TEST(FaceNumbers, TellLooksOfOneNameApart) {
    Builder b;
    b.look("PLA"), b.look("PLA");
    for (int32_t look : {1, 0}) {
        FaceGroup group;
        group.material = "PLA";
        group.look = look;
        for (int t = 0; t < 6; ++t)
            b.source().face_groups.push_back(b.source().group_index(group));
    }
    b.source().mesh = testing::without(testing::cube(10), "face");
    const Result<FaceNumbers> numbers = number_faces(&b.source(), {});
    ASSERT_TRUE(numbers);
    EXPECT_EQ(numbers->look_of, (std::vector<int32_t>{1, 0}));
    EXPECT_EQ(b.source().mesh.find("face")->faces,
              (std::vector<int32_t>{0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1}));
}

TEST(FaceNumbers, PartialAttributesAreFilledWhereLooksSayWhoUsesThem) {
    for (const bool known : {true, false}) {
        Builder b;
        b.look("label"), b.look("plain");
        if (known) {
            b.source().looks[0].picture.emplace();
            b.source().looks[1].vertex_colors = true;
        }
        b.source().mesh = testing::without(testing::cube(10), "face");
        for (MeshAttribute& a : b.source().mesh.attributes) {
            for (size_t t = 0; t < 12; ++t) {
                if (t > 5) a.corners[t] = {-1, -1, -1};
            }
        }
        for (size_t t = 0; t < 12; ++t) {
            FaceGroup group;
            group.look = t > 7 ? 1 : 0;
            b.source().face_groups.push_back(b.source().group_index(group));
        }
        part_bare_faces(&b.source());
        // Of the label two triangles have no coordinates.
        EXPECT_EQ(b.source().looks.size(), known ? 3u : 2u);
        EXPECT_EQ(b.source().left_out.size(), known ? 1u : 0u);
        complete_attributes(b.source().looks, &b.source());
        EXPECT_EQ(b.source().mesh.find("uv") != nullptr, known);
        EXPECT_EQ(b.source().mesh.find("n"), nullptr);
        EXPECT_EQ(b.source().warnings.size(), known ? 1u : 2u);
    }
}

}  // namespace
}  // namespace openfab::mesh
