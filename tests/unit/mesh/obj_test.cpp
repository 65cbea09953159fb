// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/obj.h"
#include "mesh/load/load_mesh.h"
#include "mesh/model/messages.h"
#include "mesh/read/messages.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "base/messages.h"
#include "mesh/check/mesh_check.h"
#include "mesh/read/obj_lines.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"

namespace openfab::mesh {
namespace {

// A cube of 10 mm with a uv for each corner, normals by side and two groups.
constexpr const char* kCube = R"(# a cube
v 0 0 0
v 10 0 0
v 10 10 0
v 0 10 0
v 0 0 10
v 10 0 10
v 10 10 10
v 0 10 10
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 -1
vn 0 0 1
vn 0 -1 0
vn 1 0 0
vn 0 1 0
vn -1 0 0
g back
f 1/1/1 4/4/1 3/3/1 2/2/1
g front
f 5/1/2 6/2/2 7/3/2 8/4/2
g sides
usemtl white
f 1/1/3 2/2/3 6/3/3 5/4/3
f 2/1/4 3/2/4 7/3/4 6/4/4
f -6/1/-2 -5/2/-2 -1/3/-2 \
  -2/4/-2
f 4/1/6 1/2/6 5/3/6 8/4/6
)";

MeshOptions options() {
    MeshOptions o;
    o.name = "part";
    return o;
}

Result<LoadedMesh> parse(const std::string& text, const MeshOptions& o = options()) {
    return parse_mesh(text, "m.obj", o);
}

std::string error_of(const std::string& text, const MeshOptions& o = options()) {
    const Result<LoadedMesh> loaded = parse(text, o);
    return loaded ? "no error" : loaded.error().text();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(Obj, ReadsPositionsAttributesAndGroups) {
    MeshOptions o = options();
    o.groups = {{"front", 0}, {"back", 1}, {"sides", 2}};
    o.unit_mm = 25.4;
    const Result<LoadedMesh> loaded = parse(kCube, o);
    ASSERT_TRUE(loaded) << loaded.error().text();
    const Mesh& mesh = loaded->mesh;
    EXPECT_EQ(mesh.positions.size(), 8u);
    EXPECT_EQ(mesh.positions[6], (Vec3d{254, 254, 254}));
    EXPECT_EQ(mesh.triangles.size(), 12u);
    EXPECT_NEAR(testing::signed_volume(mesh), 254.0 * 254 * 254, 1e-6);
    EXPECT_EQ(mesh.find("face")->faces, (std::vector<int32_t>{1, 1, 0, 0, 2, 2, 2, 2, 2, 2, 2, 2}));
    const MeshAttribute& uv = *mesh.find("uv");
    EXPECT_EQ(uv.components, 2);
    EXPECT_EQ(uv.corners[0], (std::array<int32_t, 3>{0, 3, 2}));
    const MeshAttribute& n = *mesh.find("n");
    EXPECT_EQ(n.corners[8], (std::array<int32_t, 3>{4, 4, 4}));
    EXPECT_EQ(n.values[4 * 3 + 1], 1);
    EXPECT_TRUE(loaded->warnings.empty());
}

TEST(Obj, NamesTheLineOfWhatIsWrong) {
    EXPECT_EQ(error_of(replaced(kCube, "v 10 0 0", "v 10 x 0")),
              "m.obj:3:6: " + fmt::format(openfab::messages::kNotANumber, "x"));
    EXPECT_EQ(error_of(replaced(kCube, "v 10 0 0", "v 10 nan 0")),
              "m.obj:3:6: " + fmt::format(openfab::messages::kNotFinite, "nan"));
    EXPECT_EQ(error_of(replaced(kCube, "v 10 0 0", "v 1e400 0 0")),
              "m.obj:3:3: " + fmt::format(openfab::messages::kNotFinite, "1e400"));
    EXPECT_EQ(error_of(replaced(kCube, "v 10 0 0", "v 10 0")),
              "m.obj:3:1: " + fmt::format(messages::kStatementNumbers, "v", 2) + "; " +
                  fmt::format(messages::kStatementNumbersHelp, "3 to 7"));
    EXPECT_EQ(error_of(replaced(kCube, "f 5/1/2", "f 9/1/2")),
              "m.obj:23:3: " + fmt::format(messages::kCornerOfNoVertex, "9/1/2", 9, 8));
    EXPECT_EQ(error_of(replaced(kCube, "f 5/1/2", "f 0/1/2")),
              "m.obj:23:3: " + fmt::format(messages::kCornerOfNoVertex, "0/1/2", 0, 8));
    EXPECT_EQ(error_of(replaced(kCube, "-2/4/-2", "-9/4/-2")),
              "m.obj:29:3: " + fmt::format(messages::kCornerOfNoVertex, "-9/4/-2", "-9", 8));
    EXPECT_EQ(error_of(replaced(kCube, "f 5/1/2", "f 5;1;2")),
              "m.obj:23:3: " + fmt::format(messages::kNotACorner, "5;1;2") + "; " +
                  messages::kNotACornerHelp);
    EXPECT_EQ(error_of(replaced(kCube, "f 5/1/2 6/2/2 7/3/2 8/4/2", "f 5 6")),
              "m.obj:23:1: " + fmt::format(messages::kFaceOfTooFewCorners, 2) + "; " +
                  messages::kFaceOfTooFewCornersHelp);
    EXPECT_THAT(error_of("solid ascii stl\n"),
                ::testing::AllOf(::testing::HasSubstr("m.obj:1:1: "),
                                 testing::Says(messages::kUnknownStatement, "solid")));
    EXPECT_EQ(error_of(""), fmt::format(messages::kMeshNoFaces, "m.obj", "part"));
}

TEST(Obj, MapsGroupsOrListsThem) {
    MeshOptions o = options();
    o.groups = {{"front", 0}, {"back", 1}};
    EXPECT_EQ(error_of(kCube, o),
              "m.obj:26:1: " + fmt::format(messages::kGroupNotMapped, "`sides`, `white`", "part") +
                  "; " + messages::kFileHas + "`back`, `front`, `sides`, `white`");
    o.groups = {{"front", 0}, {"back", 1}, {"white", 4}};
    ASSERT_EQ(error_of(kCube, o), "no error");
    o.groups = {{"front", 0}, {"back", 1}, {"sides", 2}, {"white", 4}};
    EXPECT_EQ(error_of(kCube, o),
              "m.obj:26:1: " + fmt::format(messages::kFaceInTwoGroups, "sides", 2, "white", 4) +
                  "; " + messages::kFaceInTwoGroupsHelp);
}

TEST(Obj, RefusesOpenMeshesWithCountsAndAPlace) {
    const std::string open = replaced(kCube, "f 5/1/2 6/2/2 7/3/2 8/4/2\n", "");
    EXPECT_EQ(error_of(open), "m.obj:25:1: " +
                                  fmt::format(messages::kNotClosed, "part", "4 open edges",
                                              "(10, 0, 10) mm", "(0, 0, 10) mm") +
                                  "; " + messages::kNotClosedHelp);
    const std::string turned =
        replaced(kCube, "f 5/1/2 6/2/2 7/3/2 8/4/2", "f 8/1/2 7/2/2 6/3/2 5/4/2");
    EXPECT_THAT(error_of(turned),
                testing::Says(messages::kNotClosed, "part",
                              fmt::format("4 {} edges", messages::kInconsistentlyOriented)));
    const std::string fin = std::string(kCube) + "v 5 5 20\nf 5 6 9\n";
    EXPECT_THAT(error_of(fin),
                testing::Says(messages::kNotClosed, "part", "2 open edges, 1 non-manifold edge"));
    EXPECT_THAT(error_of("v 0 0 0\nv 5 0 0\nv 0 5 0\nf 1 2 3\nf 3 2 1\n"),
                testing::Says(messages::kEnclosesNoVolume));
    EXPECT_THAT(error_of("v 0 0 0\nv 5 0 0\nf 1 2 2\n"), testing::Says(messages::kNoFaceWithArea));
}

TEST(Obj, WeldsEqualPositionsOnlyWhereTheMeshIsOpen) {
    // Each face with vertices of its own, as many exporters write them.
    const Mesh cube = testing::cube(3);
    std::string text;
    for (const auto& t : cube.triangles) {
        for (int32_t v : t) {
            const Vec3d& p = cube.positions[v];
            text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " +
                    std::to_string(p.z) + "\n";
        }
        text += "f -3 -2 -1\n";
    }
    const Result<LoadedMesh> loaded = parse(text);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_EQ(loaded->mesh.positions.size(), 8u);
    // Two cubes that touch along an edge stay two shells with edges of their own.
    std::string two = kCube;
    std::string second;
    for (int i = 0; i < 8; ++i) {
        second += "v " + std::to_string((i == 1 || i == 2 || i == 5 || i == 6) ? 20 : 10) + " " +
                  std::to_string((i == 2 || i == 3 || i == 6 || i == 7) ? 20 : 10) + " " +
                  (i >= 4 ? "10" : "0") + "\n";
    }
    second +=
        "f 9 12 11 10\nf 13 14 15 16\nf 9 10 14 13\nf 10 11 15 14\nf 11 12 16 15\nf 12 9 13 16\n";
    const Result<LoadedMesh> both = parse(two + second);
    ASSERT_TRUE(both) << both.error().text();
    EXPECT_EQ(both->mesh.positions.size(), 16u);
}

std::string box_text(double lo, double hi, bool outward, int first) {
    std::string text;
    for (int i = 0; i < 8; ++i) {
        const auto at = [&](bool high) { return std::to_string(high ? hi : lo) + " "; };
        text += "v " + at(i == 1 || i == 2 || i == 5 || i == 6) +
                at(i == 2 || i == 3 || i == 6 || i == 7) + at(i >= 4) + "\n";
    }
    const int faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                             {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    for (const auto& f : faces) {
        text += "f";
        for (int k = 0; k < 4; ++k)
            text += " " + std::to_string(first + f[outward ? k : 3 - k]);
        text += "\n";
    }
    return text;
}

TEST(Obj, TurnsInsideOutShellsButKeepsCavities) {
    const Result<LoadedMesh> hollow = parse(box_text(0, 10, true, 1) + box_text(2, 8, false, 9));
    ASSERT_TRUE(hollow);
    EXPECT_NEAR(testing::signed_volume(hollow->mesh), 1000 - 216, 1e-9);
    EXPECT_TRUE(hollow->warnings.empty());

    const Result<LoadedMesh> turned = parse(box_text(0, 10, false, 1));
    ASSERT_TRUE(turned);
    EXPECT_NEAR(testing::signed_volume(turned->mesh), 1000, 1e-9);
    ASSERT_EQ(turned->warnings.size(), 1u);
    EXPECT_THAT(turned->warnings[0],
                testing::Says(messages::kShellsInsideOut, "*m.obj:9:1", "part", "a shell"));

    // Side by side, one of them inverted.
    const Result<LoadedMesh> beside = parse(box_text(0, 10, true, 1) + box_text(12, 18, false, 9));
    ASSERT_TRUE(beside);
    EXPECT_NEAR(testing::signed_volume(beside->mesh), 1216, 1e-9);
}

TEST(Obj, WarnsAboutOddSizesAndLeftOutAttributes) {
    MeshOptions o = options();
    o.unit_mm = 1000;
    const Result<LoadedMesh> large = parse(kCube, o);
    ASSERT_TRUE(large);
    ASSERT_EQ(large->warnings.size(), 1u);
    EXPECT_THAT(large->warnings[0], testing::Says(messages::kMeshSizeUnlikely));
    o.unit_mm = 1e6;
    EXPECT_THAT(error_of(kCube, o), testing::Says(messages::kMeshTooLargeHelp));

    const Result<LoadedMesh> partial =
        parse(replaced(kCube, "f 5/1/2 6/2/2 7/3/2 8/4/2", "f 5//2 6//2 7//2 8//2"));
    ASSERT_TRUE(partial);
    EXPECT_EQ(partial->mesh.find("uv"), nullptr);
    EXPECT_NE(partial->mesh.find("n"), nullptr);
    ASSERT_EQ(partial->warnings.size(), 1u);
    EXPECT_THAT(partial->warnings[0],
                testing::Says(messages::kAttributeOfSomeFaces, "*m.obj:23:1", "part", "uv"));
}

TEST(Obj, ReadsTheUnitOfAComment) {
    const auto unit = [](const std::string& comment) {
        const Result<LoadedMesh> loaded = parse(comment + "\n" + kCube);
        if (!loaded || loaded->unit_note != messages::kUnitOfFile) return 0.0;
        return loaded->unit_mm;
    };
    EXPECT_EQ(unit("# Units: cm"), 10);
    EXPECT_EQ(unit("#units = millimeters\r"), 1);
    EXPECT_EQ(unit("# File units = inches"), 25.4);
    EXPECT_EQ(unit("# Units: in"), 25.4);
    EXPECT_EQ(unit("# units are in meters"), 1000);
    EXPECT_EQ(unit("# unit cm\n# unit mm"), 10);
    for (const char* other : {"# the unit of this is cm", "# units", "# unit test 1 mm",
                              "# 12 units", "# unit: furlong", "# cm"})
        EXPECT_EQ(unit(other), 0) << other;
    MeshOptions given = options();
    given.unit_mm = 1;
    EXPECT_EQ(parse(std::string("# Units: cm\n") + kCube, given)->unit_note,
              messages::kUnitAsAsked);
}

TEST(Obj, NamesPlacesAsTheFileHasThem) {
    // Without its back.
    std::string open = std::string("# Units: cm\n") + kCube;
    open = replaced(open, "f 1/1/1 4/4/1 3/3/1 2/2/1\n", "");
    EXPECT_THAT(error_of(open), testing::Says(messages::kPlaceInFile));
    open = replaced(open, "# Units: cm", "# Units: mm");
    EXPECT_THAT(error_of(open), ::testing::Not(testing::Says(messages::kPlaceInFile)))
        << error_of(open);
}

#ifndef OPENFAB_SANITIZED  // is about effort: smaller ones are read the same way
/// A polygon of a thousand teeth between two of its corners.
std::string comb(int corners, bool nested) {
    std::string vertices, face = "f";
    for (int i = 0; i < corners; ++i) {
        const double depth = 0.5 + 0.001 * (i % 7);
        vertices += i % 2 == 0 ? fmt::format("v {} 0 0\n", i)
                    // All teeth overlap: everything is near everything.
                    : nested ? fmt::format("v {} {} 0\n", corners - i, 100 + i)
                             : fmt::format("v {} {} 0\n", i, depth);
        face += fmt::format(" {}", i + 1);
    }
    return vertices + fmt::format("v {} 900 0\nv -9 900 0\n", corners + 9) + face +
           fmt::format(" {} {}\n", corners + 1, corners + 2);
}

/// What takes more steps than kTriangulationEffort is refused, whatever the machine.
TEST(Obj, LargePolygonsTakeLittleEffort) {
    for (const bool nested : {false, true}) {
        std::string text = comb(4094, nested);
        const std::string face = text.substr(text.rfind("f "));
        while (text.size() < 1'000'000)
            text += face;
        const std::string message = error_of(text);
        EXPECT_EQ(message.find("too many corners; split them into triangles where the mesh is "
                               "made") != std::string::npos,
                  nested)
            << message;
    }
}
#endif

TEST(Obj, SplitsQuadsThatShareADiagonalApart) {
    // A pillow of two quads over the same four corners: split along one diagonal, both would be the
    // same two triangles.
    const Result<LoadedMesh> pillow =
        parse("v 0 0 0\nv 9 0 3\nv 9 9 0\nv 0 9 3\nf 1 2 3 4\nf 1 4 3 2\n");
    ASSERT_TRUE(pillow) << pillow.error().text();
    EXPECT_TRUE(count_edges(pillow->mesh).fine());
    EXPECT_EQ(pillow->mesh.triangles.size(), 4u);
}

TEST(Obj, SurvivesDamage) {
    std::mt19937 random(1);
    const std::string text = kCube;
    for (int i = 0; i < 3000; ++i) {
        std::string damaged = text;
        for (int k = 0; k < 3; ++k) {
            const char letters[] = "vfgn/-1290 .e#\n\\\0\xff";
            damaged[random() % damaged.size()] = letters[random() % (sizeof letters - 1)];
        }
        damaged.resize(random() % damaged.size() + 1);
        (void)error_of(damaged);  // any result but a crash
    }
}

TEST(Obj, DividesTextsBetweenTheirLines) {
    struct Line {
        int32_t number;
        std::vector<std::string_view> tokens;
        std::string_view comment;
        bool operator==(const Line&) const = default;
    };
    const auto add_lines = [](std::string_view text, const ObjPart& part, std::vector<Line>* out) {
        ObjLines lines(text, part.begin, part.end, static_cast<int32_t>(part.before.newlines) + 1);
        while (lines.next_or_comment())
            out->push_back({lines.line(), lines.tokens(), lines.comment()});
    };
    const char* const pieces[] = {"v 1 2 3", " vt 0 1", "vn 0 0 1",      "f 1 2 3", "fo 1 2 3 \\",
                                  "\\",      "\\\r",    "# comment \\",  "# unit",  "",
                                  "vnx v",   "o\\",     "\tf -1 \\\r\r", "g a b"};
    std::mt19937 random(11);
    for (int round = 0; round < 2000; ++round) {
        std::string text;
        for (unsigned n = random() % 40; n > 0; --n)
            text += std::string(pieces[random() % std::size(pieces)]) +
                    (random() % 4 == 0 ? "\r\n" : "\n");
        if (random() % 2 == 0 && !text.empty()) text.pop_back();
        std::vector<Line> whole, divided;
        add_lines(text, {0, text.size(), {}, {}}, &whole);
        size_t end = 0, vertices = 0, uv = 0, normals = 0, faces = 0;
        for (const ObjPart& part : divide_obj(text, 1 + random() % 50)) {
            ASSERT_EQ(part.begin, end);
            ASSERT_EQ(part.before.vertices, vertices);
            ASSERT_EQ(part.before.uv, uv);
            ASSERT_EQ(part.before.normals, normals);
            ASSERT_EQ(part.before.faces, faces);
            const size_t first = divided.size();
            add_lines(text, part, &divided);
            for (size_t i = first; i < divided.size(); ++i) {
                if (divided[i].tokens.empty()) continue;
                const std::string_view word = divided[i].tokens[0];
                vertices += word == "v";
                uv += word == "vt";
                normals += word == "vn";
                faces += word == "f" || word == "fo";
            }
            end = part.end;
        }
        EXPECT_EQ(end, text.size());
        ASSERT_EQ(divided, whole) << text;
    }
}

TEST(Obj, ReadsLongTextsAsShortOnes) {
    // Boxes in a row; faces refer to vertices by either kind of number, and groups last longer than
    // a part of the text.
    constexpr int kBoxes = 16'000;
    std::string text;
    for (int b = 0; b < kBoxes; ++b) {
        if (b % 5000 == 0) text += fmt::format("g row{}\n", b / 5000);
        const std::string box = box_text(0, 1, true, b % 2 == 0 ? 1 + b * 8 : -8);
        for (size_t at = 0; at < box.size();) {
            const size_t line = box.find('\n', at) + 1;
            text += box[at] == 'v'
                        ? fmt::format("v {}{}", b * 2, box.substr(at + 10, line - at - 10))
                        : box.substr(at, line - at);
            at = line;
        }
        if (b % 100 == 0) text += "f -8 -7 -5 # a triangle\n";
    }
    ASSERT_GT(text.size(), 5'000'000u);
    const Result<MeshSource> read = parse_obj(text, "m.obj");
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->mesh.positions.size(), 8u * kBoxes);
    ASSERT_EQ(read->mesh.triangles.size(), 12u * kBoxes + kBoxes / 100);
    ASSERT_EQ(read->groups.size(), 4u);
    size_t t = 0;
    int32_t line = 0;
    for (int b = 0; b < kBoxes; ++b) {
        line += b % 5000 == 0;
        EXPECT_EQ(read->mesh.positions[static_cast<size_t>(b) * 8 + 4], (Vec3d{b * 2.0, 0, 1}));
        for (int face = 0; face < 6; ++face) {
            ASSERT_EQ(read->origin.lines[t], line + 9 + face);
            ASSERT_EQ(read->face_groups[t], b / 5000);
            const auto& first = read->mesh.triangles[t];
            ASSERT_EQ(*std::min_element(first.begin(), first.end()) / 8, b);
            t += 2;
        }
        line += 14;
        if (b % 100 != 0) continue;
        ++line;
        ASSERT_EQ(read->origin.lines[t], line);
        ASSERT_EQ(read->mesh.triangles[t++], (std::array<int32_t, 3>{b * 8, b * 8 + 1, b * 8 + 3}));
    }
    EXPECT_EQ(error_of(text + "  f 1 2 128001 4\nv x\n"),
              fmt::format("m.obj:{}:9: ", line + 1) +
                  fmt::format(messages::kCornerOfNoVertex, 128001, 128001, 128000));
    // The first of several mistakes, whichever part is read first.
    const size_t middle = text.find("g row2");
    EXPECT_EQ(
        error_of(text.substr(0, middle) + "f 1 2\n" + text.substr(middle) + "v x\n"),
        fmt::format("m.obj:{}:1: ", 1 + std::count(text.begin(), text.begin() + middle, '\n')) +
            fmt::format(messages::kFaceOfTooFewCorners, 2) + "; " +
            messages::kFaceOfTooFewCornersHelp);
}

TEST(Obj, ReadsMeshesOfOthers) {
    const std::filesystem::path data = testing::source_dir() / "tests/data";
    MeshOptions o = options();
    o.unit_mm = 100;  // some are of unit size
    const std::pair<const char*, size_t> closed[] = {
        {"spot", 5856}, {"scorpion", 12626}, {"koala", 7116}, {"goathead", 5522}};
    for (const auto& [name, triangles] : closed) {
        const Result<LoadedMesh> loaded =
            load_mesh(data / "meshes" / (std::string(name) + ".obj"), o);
        ASSERT_TRUE(loaded) << loaded.error().text();
        EXPECT_EQ(loaded->mesh.triangles.size(), triangles) << name;
        EXPECT_GT(testing::signed_volume(loaded->mesh), 0) << name;
    }
    const std::pair<const char*, const char*> broken[] = {
        {"cube_no_bottom", ": 8 open edges, one"},
        {"plane_holes", ": 341 open edges, one"},
        {"fins", ": 176 open edges, 48 non-manifold edges"},
        {"open_tubes", ": 42 open edges, one"},
        {"flat_sheet", ": 64 open edges, one"}};
    for (const auto& [name, counts] : broken) {
        const Result<LoadedMesh> loaded =
            load_mesh(data / "broken_meshes" / (std::string(name) + ".obj"), o);
        ASSERT_FALSE(loaded) << name;
        EXPECT_NE(loaded.error().text().find(counts), std::string::npos) << loaded.error().text();
    }
}

}  // namespace
}  // namespace openfab::mesh
