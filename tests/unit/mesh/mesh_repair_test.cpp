// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Repairs of broken meshes: the generalised winding number of the result is an integer everywhere,
// and over flat holes it classifies points like that of the broken mesh.

#include "mesh/check/mesh_repair.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "mesh/check/mesh_check.h"
#include "mesh/load/load_mesh.h"
#include "mesh/model/messages.h"
#include "mesh/model/primitives.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "world/world.h"

namespace openfab::mesh {
namespace {

#ifdef OPENFAB_SANITIZED
constexpr int kRounds = 12;
#else
constexpr int kRounds = 30;
#endif

using ::testing::AllOf;
namespace fs = std::filesystem;

/// Generalised winding number, by the solid angle of each triangle (Van Oosterom and Strackee).
double winding(const Mesh& mesh, const Vec3d& p) {
    double sum = 0;
    for (const auto& t : mesh.triangles) {
        Vec3d v[3];
        double l[3];
        for (size_t c = 0; c < 3; ++c) {
            v[c] = mesh.positions[t[c]] - p;
            l[c] = length(v[c]);
        }
        const double over = l[0] * l[1] * l[2] + dot(v[0], v[1]) * l[2] + dot(v[1], v[2]) * l[0] +
                            dot(v[2], v[0]) * l[1];
        sum += 2 * std::atan2(dot(v[0], cross(v[1], v[2])), over);
    }
    return sum / (4 * std::numbers::pi);
}

double volume(const Mesh& mesh) {
    double sum = 0;
    for (const auto& t : mesh.triangles) {
        const auto at = [&](size_t c) { return mesh.positions[t[c]]; };
        sum += dot(at(0), cross(at(1), at(2))) / 6;
    }
    return sum;
}

MeshSource source_of(Mesh mesh) {
    MeshSource source;
    source.mesh = std::move(mesh);
    source.mesh.name = "m";
    source.origin.file = "m.obj";
    return source;
}

/// A cube of 10 mm around the origin, 12 triangles.
Mesh cube() {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.push_back({i & 1 ? 5.0 : -5.0, i & 2 ? 5.0 : -5.0, i & 4 ? 5.0 : -5.0});
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

void add(Mesh* to, const Mesh& from, const Vec3d& offset) {
    const auto first = static_cast<int32_t>(to->positions.size());
    for (const Vec3d& p : from.positions)
        to->positions.push_back(p + offset);
    for (const auto& t : from.triangles)
        to->triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

Mesh repaired(Mesh mesh) {
    MeshSource source = source_of(std::move(mesh));
    EXPECT_FALSE(count_edges(source.mesh).fine());
    Result<void> done = prepare_mesh(&source, true);
    EXPECT_TRUE(done) << done.error().text();
    EXPECT_TRUE(count_edges(source.mesh).fine());
    return source.mesh;
}

std::mt19937 random_numbers(7);

Vec3d random_point(double reach) {
    std::uniform_real_distribution<double> range(-reach, reach);
    return {range(random_numbers), range(random_numbers), range(random_numbers)};
}

TEST(MeshRepair, ABoxWithoutAFace) {
    for (size_t face = 0; face < 6; ++face) {
        Mesh open = cube();
        open.triangles.erase(open.triangles.begin() + static_cast<std::ptrdiff_t>(2 * face),
                             open.triangles.begin() + static_cast<std::ptrdiff_t>(2 * face + 2));
        const Mesh mesh = repaired(open);
        EXPECT_NEAR(volume(mesh), 1000, 1e-9);
        // Over a flat hole the caps are where the generalised number passes a half.
        for (int i = 0; i < 300; ++i) {
            const Vec3d p = random_point(7);
            const double closed = winding(mesh, p);
            EXPECT_NEAR(closed, std::round(closed), 1e-9);
            EXPECT_EQ(closed > 0.5, winding(open, p) > 0.5);
        }
    }
}

TEST(MeshRepair, TurnedTriangles) {
    for (size_t t = 0; t < 12; ++t) {
        Mesh mesh = cube();
        std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
        EXPECT_NEAR(volume(repaired(mesh)), 1000, 1e-9);
    }
    Mesh half = cube();
    for (size_t t = 0; t < 7; ++t)
        std::swap(half.triangles[t][0], half.triangles[t][1]);
    half.triangles.pop_back();
    EXPECT_NEAR(volume(repaired(half)), 1000, 1e-9);
}

TEST(MeshRepair, CubesThatShareAnEdgeOrAVertex) {
    for (const Vec3d& offset : {Vec3d{10, 10, 0}, Vec3d{0, 10, 10}, Vec3d{-10, 0, 10}}) {
        Mesh two = cube();
        add(&two, cube(), offset);
        // With a common edge, the welded form has four triangles at it.
        std::swap(two.triangles[3][0], two.triangles[3][1]);
        MeshSource source = source_of(two);
        ASSERT_TRUE(prepare_mesh(&source, true));
        EXPECT_NEAR(volume(source.mesh), 2000, 1e-9);
        EXPECT_EQ(source.checks.shells, 2) << "each sheet along the edge stays with its own cube";
    }
}

/// A vertex in the middle of an edge that only one side has.
TEST(MeshRepair, TJunctions) {
    Mesh mesh = cube();
    mesh.positions.push_back({0, -5, -5});
    mesh.triangles[0] = {0, 2, 8};
    mesh.triangles.push_back({8, 2, 1});
    const Mesh closed = repaired(mesh);
    EXPECT_NEAR(volume(closed), 1000, 1e-9);
    EXPECT_EQ(closed.positions.size(), 9u);
}

TEST(MeshRepair, SeamsThatNearlyMeet) {
    Mesh mesh;
    const Mesh whole = cube();
    for (size_t t = 0; t < 12; ++t) {
        for (size_t c = 0; c < 3; ++c)
            mesh.positions.push_back(whole.positions[static_cast<size_t>(whole.triangles[t][c])] +
                                     random_point(3e-5));
        const auto first = static_cast<int32_t>(3 * t);
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    const Mesh closed = repaired(mesh);
    EXPECT_EQ(closed.positions.size(), 8u);
    EXPECT_EQ(closed.triangles.size(), 12u);
    EXPECT_NEAR(volume(closed), 1000, 0.1);
}

/// Two voxels that touch along an edge, between plates: its ends join the sheets.
TEST(MeshRepair, SheetsThatTouchAlongAnEdge) {
    Mesh mesh;
    const Mesh one = cube();
    for (const Vec3d& at : {Vec3d{0, 0, 0}, Vec3d{10, 10, 0}})
        add(&mesh, one, at);
    for (double z : {-10.0, 10.0}) {
        for (double x : {0.0, 10.0}) {
            for (double y : {0.0, 10.0})
                add(&mesh, one, {x, y, z});
        }
    }
    std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
    // Walls between cubes are dropped: two triangles over the same corners enclose nothing.
    const Mesh closed = repaired(mesh);
    EXPECT_NEAR(volume(closed), 10'000, 1e-9);
}

/// However a ball is damaged, the result is closed, and equals the ball away from the damage.
TEST(MeshRepair, RandomDamage) {
    const auto below = [&](size_t end) { return static_cast<size_t>(random_numbers() % end); };
    for (int round = 0; round < kRounds; ++round) {
        Mesh mesh = make_sphere(20);
        mesh.attributes.clear();
        const size_t damages = 1 + below(40);
        for (size_t i = 0; i < damages; ++i) {
            const size_t t = below(mesh.triangles.size());
            switch (below(4)) {
                case 0:
                    mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t));
                    break;
                case 1:
                    std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
                    break;
                case 2:
                    mesh.triangles.push_back(mesh.triangles[t]);
                    break;
                default:
                    mesh.triangles[t][below(3)] =
                        static_cast<int32_t>(below(mesh.positions.size()));
            }
        }
        MeshSource source = source_of(mesh);
        Result<void> done = prepare_mesh(&source, true);
        ASSERT_TRUE(done) << done.error().text();
        ASSERT_TRUE(count_edges(source.mesh).fine());
        for (int i = 0; i < 20; ++i) {
            const double w = winding(source.mesh, random_point(11));
            ASSERT_NEAR(w, std::round(w), 1e-6) << round;
        }
    }
}

TEST(MeshRepair, CapsHaveAttributesOfTheRim) {
    Mesh open = cube();
    MeshAttribute uv{"uv", false, 2, {}, {}, {}}, face{"face", true, 1, {}, {}, {}};
    open.triangles.resize(10);
    for (const auto& t : open.triangles) {
        uv.corners.push_back(t);
        face.faces.push_back(t[0]);
    }
    for (const Vec3d& p : open.positions) {
        uv.values.push_back(static_cast<float>(p.y));
        uv.values.push_back(static_cast<float>(p.z));
    }
    open.attributes = {uv, face};
    const Mesh mesh = repaired(open);
    ASSERT_EQ(mesh.triangles.size(), 14u);
    const MeshAttribute& found = *mesh.find("uv");
    ASSERT_EQ(found.corners.size(), 14u);
    for (size_t t = 10; t < 14; ++t) {
        for (size_t c = 0; c < 3; ++c) {
            const Vec3d& p = mesh.positions[static_cast<size_t>(mesh.triangles[t][c])];
            const auto v = static_cast<size_t>(found.corners[t][c]);
            EXPECT_NEAR(found.values[2 * v], p.y, 1e-5);
            EXPECT_NEAR(found.values[2 * v + 1], p.z, 1e-5);
        }
    }
    EXPECT_EQ(mesh.find("face")->faces.size(), 14u);
}

TEST(MeshRepair, TellsWhatItDid) {
    Mesh open = cube();
    open.triangles.resize(10);
    MeshSource source = source_of(open);
    ASSERT_TRUE(prepare_mesh(&source, true));
    ASSERT_EQ(source.warnings.size(), 1u);
    EXPECT_THAT(source.warnings[0],
                AllOf(testing::Says(messages::kNotClosedRepaired, "m.obj", "m", "4 open edges"),
                      testing::Says(messages::kHolesClosed, 1, "", "14.14", "(5, 0, 0) mm")));
}

TEST(MeshRepair, FlatSheetsAreStillRefused) {
    Mesh sheet;
    sheet.positions = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    MeshSource source = source_of(sheet);
    Result<void> done = prepare_mesh(&source, true);
    ASSERT_FALSE(done);
    EXPECT_THAT(done.error().text(), testing::Says(messages::kEnclosesNoVolume));
}

/// One object that requests it is enough.
TEST(MeshRepair, IsAskedForByAnObject) {
    const testing::TempFolder folder;
    std::string obj;
    const Mesh whole = cube();
    for (const Vec3d& p : whole.positions)
        obj += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) +
               "\n";
    for (size_t t = 0; t < 10; ++t) {
        const auto& v = whole.triangles[t];
        obj += "f " + std::to_string(v[0] + 1) + " " + std::to_string(v[1] + 1) + " " +
               std::to_string(v[2] + 1) + "\n";
    }
    folder.write("open.obj", obj);
    const auto load = [&](const std::string& repair) {
        return world::load_world(folder.write("w.fab.json", R"({"openfab": 1,
            "fablets": {"f": {"source": "f.fl", "fablet": "F"}},
            "meshes": {"m": {"file": "open.obj"}},
            "objects": {"a": {"mesh": "m", "fablet": "f"},
                        "b": {"mesh": "m", "fablet": "f")" + repair +
                                                                R"(}},
            "build": [{"object": "b"}]})"));
    };
    folder.write("f.fl", "");
    const Result<world::World> refused = load("");
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().text(), testing::Says(messages::kNotClosedHelp));
    const Result<world::World> world = load(R"(, "repair": "winding")");
    ASSERT_TRUE(world) << world.error().text();
    ASSERT_EQ(world->meshes.size(), 1u);
    EXPECT_TRUE(count_edges(world->meshes[0]).fine());
    ASSERT_EQ(world->warnings.size(), 1u);
    EXPECT_THAT(world->warnings[0], testing::Says(messages::kNotClosedRepaired));
}

TEST(MeshRepair, BrokenMeshesOfOthers) {
    const fs::path folder = testing::source_dir() / "tests/data/broken_meshes";
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        MeshOptions options;
        options.name = entry.path().stem().string();
        ASSERT_FALSE(load_mesh(entry.path(), options)) << entry.path();
        options.repair = true;
        Result<LoadedMesh> mesh = load_mesh(entry.path(), options);
        if (options.name == "flat_sheet") {
            ASSERT_FALSE(mesh);
            EXPECT_THAT(mesh.error().text(), testing::Says(messages::kEnclosesNoVolume));
            continue;
        }
        ASSERT_TRUE(mesh) << mesh.error().text();
        EXPECT_TRUE(count_edges(mesh->mesh).fine()) << entry.path();
        Box3d box;
        for (const Vec3d& p : mesh->mesh.positions)
            box.add(p);
        for (int i = 0; i < 10; ++i) {
            Vec3d p = random_point(0.5);
            for (int a = 0; a < 3; ++a)
                p[a] = box.center()[a] + p[a] * box.size()[a];
            const double w = winding(mesh->mesh, p);
            EXPECT_NEAR(w, std::round(w), 1e-6) << entry.path();
        }
    }
}

}  // namespace
}  // namespace openfab::mesh
