// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Placement: groups, grids, transform files, the bed; and which files a world may read.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <random>
#include <set>
#include <sstream>

#include "base/messages.h"
#include "base/polar.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "world/messages.h"
#include "world/transforms_file.h"
#include "world/world.h"

namespace openfab::world {
namespace {

using ::testing::Contains;

namespace fs = std::filesystem;

/// Boxes of 2 x 4 x 6 mm that stand on z = 0, and balls of 2 mm.
std::string world_text(const std::string& groups, const std::string& build) {
    return R"({"openfab": 1, "fablets": {"f": {"source": "f.fl", "fablet": "F"}},
"meshes": {"box": {"box": [2, 4, 6]}, "ball": {"sphere": 2}},
"objects": {"box": {"mesh": "box", "fablet": "f"}, "ball": {"mesh": "ball", "fablet": "f"}},
)" + (groups.empty() ? "" : "\"groups\": " + groups + ",\n") +
           "\"build\": " + build + "}";
}

class BuildTest : public ::testing::Test {
  protected:
    Result<World> load(const std::string& groups, const std::string& build,
                       const FileRules& rules = {}) {
        return load_world(folder_.write("w.fab.json", world_text(groups, build)), rules);
    }
    std::vector<Placement> placements(const std::string& groups, const std::string& build) {
        Result<World> world = load(groups, build);
        if (!world) {
            ADD_FAILURE() << world.error().text();
            return {};
        }
        return world->build;
    }
    std::string error_of(const std::string& groups, const std::string& build) {
        const Result<World> world = load(groups, build);
        if (world) return "no error";
        const std::string file = (folder_.path() / "w.fab.json").string();
        return world.error().text().starts_with(file) ? world.error().text().substr(file.size() + 1)
                                                      : world.error().text();
    }

    testing::TempFolder folder_;
};

TEST_F(BuildTest, NestedGroupsMultiplyTheirTransforms) {
    // In any order; the outer transform is applied last.
    const std::vector<Placement> all = placements(
        R"({"pair": [{"group": "leaf", "translate_mm": [10, 0, 0]}, {"group": "leaf", "scale": [-1, 1, 1]}],
            "leaf": [{"object": "box", "rotate_deg": [0, 0, 90], "translate_mm": [1, 2, 3]}, {"object": "ball"}]})",
        R"([{"group": "pair", "scale": 2, "translate_mm": [0, 0, 5]}, {"object": "ball"}])");
    ASSERT_EQ(all.size(), 5u);
    EXPECT_EQ(all[0].object, 0);
    EXPECT_EQ(all[1].object, 1);
    // (1, 0, 0) rotated to (0, 1, 0), moved to (1, 3, 3), to (11, 3, 3), scaled by 2 and lifted.
    EXPECT_EQ(all[0].transform.apply({1, 0, 0}), (Vec3d{22, 6, 11}));
    EXPECT_EQ(all[1].transform.apply({1, 0, 0}), (Vec3d{22, 0, 5}));
    EXPECT_EQ(all[2].transform.apply({1, 0, 0}), (Vec3d{-2, 6, 11}));
    EXPECT_EQ(all[4].transform.apply({1, 0, 0}), (Vec3d{1, 0, 0}));
}

TEST_F(BuildTest, AShearIsAMatrixInAGroup) {
    const std::vector<Placement> all = placements(
        R"({"g": [{"object": "box", "matrix": [1, 0.5, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}]})",
        R"([{"group": "g", "scale": [1, 1, -3]}])");
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].transform.apply({1, 2, 3}), (Vec3d{2, 2, -9}));
}

// As other programs write transforms: rotations, alone and times a scale, to four decimals or more.
TEST_F(BuildTest, FourDecimalsOfARotationAreOne) {
    const double angles[] = {0.1, 0.62, 1.9, 2.7};
    for (const int decimals : {4, 5, 6}) {
        std::string lines, matrices;
        for (const double scale : {1.0, 0.72}) {
            for (const double a : angles) {
                const double c = scale * std::cos(a), s = scale * std::sin(a);
                const std::string line = fmt::format(
                    "{:.{}f}, {:.{}f}, 0, 1,  {:.{}f}, {:.{}f}, 0, 2,  0, 0, {:.{}f}, 3", c,
                    decimals, -s, decimals, s, decimals, c, decimals, scale, decimals);
                lines += line + '\n';
                matrices += fmt::format(R"({}{{"object": "box", "matrix": [{}]}})",
                                        matrices.empty() ? "" : ", ", line);
            }
        }
        folder_.write("t.txt", lines);
        for (const std::string& build :
             {std::string(R"({"object": "box", "transforms": "t.txt"})"), matrices}) {
            const std::string text = world_text("", "[" + build + "]");
            const Result<World> world = load_world(folder_.write("w.fab.json", text));
            ASSERT_TRUE(world) << world.error().text();
            ASSERT_EQ(world->build.size(), 8u);
            std::set<std::array<double, 9>> shapes;
            for (size_t i = 0; i < 8; ++i) {
                const Affine3d& transform = world->build[i].transform;
                shapes.insert(polar_factors(transform.m)->s);
                const double scale = i < 4 ? 1 : 0.72;
                EXPECT_NEAR(transform.m[0], scale * std::cos(angles[i % 4]),
                            2 * std::pow(10.0, -decimals))
                    << i;
                EXPECT_EQ(transform.t, (Vec3d{1, 2, 3}));
            }
            EXPECT_EQ(shapes.size(), 2u) << decimals;
            EXPECT_THAT(world->warnings,
                        Contains(testing::Says(decimals == 6 ? messages::kTransformsAlikeToSix
                                                             : messages::kTransformsAlikeToFour)));
        }
    }
}

// What is written exactly with few decimals, and what four of them tell from a rotation.
TEST_F(BuildTest, MatricesThatAreMeantStay) {
    const char* const rows[] = {
        "1.0001, 0, 0, 0, 1, 0, 0, 0, 1", "0, 1.2001, 0, 1.2, 0, 0, 0, 0, 1.2",
        "1, 0.002, 0, 0, 1, 0, 0, 0, 1", "0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 1.001",
        "1, 0.000002, 0, 0, 1.000001, 0, 0, 0, 1.000004"};
    for (const char* row : rows) {
        std::array<double, 9> m{};
        std::istringstream in(row);
        std::string moved;
        for (size_t k = 0; k < 9; ++k) {
            in >> m[k];
            in.ignore(1);
            moved += fmt::format("{}{}{}", k == 0 ? "" : ", ", m[k], k % 3 == 2 ? ", 0" : "");
        }
        const std::vector<Placement> all =
            placements("", fmt::format(R"([{{"object": "box", "matrix": [{}]}}])", moved));
        ASSERT_EQ(all.size(), 1u);
        EXPECT_EQ(all[0].transform.m, m) << row;
    }
}

TEST_F(BuildTest, ScalesThatAreMeantStay) {
    const std::vector<Placement> all = placements(
        "",
        R"([{"object": "box", "scale": 1.00001}, {"object": "box", "scale": [0.5, 0.5, 0.500002]},
                {"object": "box", "scale": 0.5}])");
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0].transform.m[0], 1.00001);
    EXPECT_EQ(all[1].transform.m[8], 0.500002);
    EXPECT_EQ(all[2].transform.m[8], 0.5);
}

TEST_F(BuildTest, TwoNumbersStandOnTheBed) {
    const std::vector<Placement> all = placements(
        R"({"tower": [{"object": "box", "translate_mm": [0, 0, 4]}, {"object": "ball", "translate_mm": [0, 0, 20]}]})",
        R"([{"object": "box", "rotate_deg": [90, 0, 0], "translate_mm": [7, 8]},
            {"group": "tower", "translate_mm": [1, 1]},
            {"object": "box", "matrix": [1, 0, 0, 5, 0, 1, 0, 5, 0, 0, 1, -50], "on_bed": true},
            {"object": "box", "on_bed": true, "scale": 3},
            {"object": "box", "translate_mm": [7, 8], "on_bed": false}])");
    ASSERT_EQ(all.size(), 6u);
    // Lying on its side, 4 deep: y from -2 to 2 has become z.
    EXPECT_EQ(all[0].transform.t, (Vec3d{7, 8, 2}));
    // The group as a whole.
    EXPECT_EQ(all[1].transform.t, (Vec3d{1, 1, 0}));
    EXPECT_EQ(all[2].transform.t, (Vec3d{1, 1, 16}));
    EXPECT_EQ(all[3].transform.t, (Vec3d{5, 5, 0}));
    EXPECT_EQ(all[4].transform.t, (Vec3d{0, 0, 0}));
    EXPECT_EQ(all[5].transform.t, (Vec3d{7, 8, 0}));
}

TEST_F(BuildTest, AGridLeavesRoomBetweenBoxes) {
    const std::vector<Placement> all =
        placements("", R"([{"object": "box", "rotate_deg": [0, 0, 90], "translate_mm": [1, 1],
                 "grid": {"count": [3, 2], "spacing_mm": [5, 1, 0]}},
                {"object": "ball", "grid": {"count": [1, 1, 2], "step_mm": -7}}])");
    ASSERT_EQ(all.size(), 8u);
    // 4 along x and 2 along y after rotation; x first.
    EXPECT_EQ(all[1].transform.t, (Vec3d{10, 1, 0}));
    EXPECT_EQ(all[2].transform.t, (Vec3d{19, 1, 0}));
    EXPECT_EQ(all[3].transform.t, (Vec3d{1, 4, 0}));
    EXPECT_EQ(all[7].transform.t, (Vec3d{0, 0, -7}));
}

TEST_F(BuildTest, ArrangedItemsStandInRows) {
    const std::string build =
        R"([{"object": "box", "translate_mm": [70, 80, 90]}, {"object": "ball"},
        {"object": "box", "rotate_deg": [0, 0, 90]}, {"object": "ball", "translate_mm": [5, 5, -5]}])";
    std::string text = world_text("", build);
    text.insert(text.find("\"build\""), R"("arrange": {"columns": 2, "spacing_mm": 3}, )");
    const Result<World> world = load_world(folder_.write("w.fab.json", text));
    ASSERT_TRUE(world) << world.error().text();
    ASSERT_EQ(world->build.size(), 4u);
    // Boxes of 2 x 4 and balls of 2: the second row begins behind the deeper one.
    EXPECT_EQ(world->build[0].transform.t, (Vec3d{1, 2, 0}));
    EXPECT_NEAR(world->build[1].transform.t.x, 6, 1e-12);
    EXPECT_NEAR(world->build[1].transform.t.y, 1, 1e-12);
    EXPECT_EQ(world->build[2].transform.t, (Vec3d{2, 8, 0}));
    EXPECT_NEAR(world->build[3].transform.t.x, 8, 1e-12);
    EXPECT_NEAR(world->build[3].transform.t.z, 0, 1e-12);
    text.insert(text.find("\"build\""), R"("tray": "center", )");
    const Result<World> centred = load_world(folder_.write("w.fab.json", text));
    ASSERT_TRUE(centred) << centred.error().text();
    // 9 wide, 9 deep.
    EXPECT_NEAR(centred->build[0].transform.t.x, 1 - 4.5, 1e-12);
    EXPECT_NEAR(centred->build[0].transform.t.y, 2 - 4.5, 1e-12);
}

TEST_F(BuildTest, AFileOfTransformsPlacesCopies) {
    folder_.write("pins.txt", "# two pins\n1 2 3\n\n0,1,0,9, 1,0,0,8, 0,0,1,7 # mirrored\n");
    const std::vector<Placement> all =
        placements("", R"([{"object": "box", "scale": 2, "transforms": "pins.txt"}])");
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].transform.apply({1, 0, 0}), (Vec3d{3, 2, 3}));
    EXPECT_EQ(all[1].transform.apply({1, 0, 0}), (Vec3d{9, 10, 7}));
}

TEST_F(BuildTest, AFileOfTransformsIsTextOfAnyProgram) {
    // A byte order mark, and carriage returns alone.
    folder_.write("pins.txt",
                  "\xEF\xBB\xBF"
                  "1 2 3 # one\r4 5 6\r");
    const std::string build = R"([{"object": "box", "transforms": "pins.txt"}])";
    const std::vector<Placement> all = placements("", build);
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[1].transform.apply({0, 0, 0}), (Vec3d{4, 5, 6}));
    folder_.write("pins.txt", std::string_view("\xFF\xFE"
                                               "1\0 \0"
                                               "2\0",
                                               8));
    EXPECT_THAT(error_of("", build),
                ::testing::HasSubstr(
                    "pins.txt:1:1: " + fmt::format(openfab::messages::kWideText, "UTF-16") + "; " +
                    openfab::messages::kWideTextHelp))
        << error_of("", build);
}

TEST_F(BuildTest, OverridesOfAGroupNameTheObjectAndWin) {
    const std::vector<Placement> all = placements(
        R"({"g": [{"object": "box", "uniforms": {"n": 1, "m": 2}}, {"object": "ball"}]})",
        R"([{"group": "g", "uniforms": {"box.n": 7}}, {"group": "g"}])");
    ASSERT_EQ(all.size(), 4u);
    const auto value = [&](size_t i, const char* name) {
        return std::get<0>(all[i].overrides.at(name).value).at(0);
    };
    EXPECT_EQ(value(0, "n"), 7);
    EXPECT_EQ(value(0, "m"), 2);
    EXPECT_TRUE(all[1].overrides.empty());
    EXPECT_EQ(value(2, "n"), 1);
}

TEST_F(BuildTest, NamesThePlaceOfWhatIsWrong) {
    folder_.write("bad.txt", "1 2 3\n1 2\n");
    folder_.write("flat.txt", "1 0 0 0 0 0 0 0 0 0 1 0\n");
    folder_.write("none.txt", "# nothing\n");
    const std::string here = folder_.path().string();
    const struct {
        std::string groups, build, message;
    } cases[] = {
        {"", R"([{}])",
         std::string("4:11: build[0] has ") + messages::kNoObjectNoGroup + "; " +
             messages::kNoObjectNoGroupHelp},
        {"", R"([{"object": "box", "group": "g"}])",
         std::string("4:11: build[0] has ") + messages::kObjectAndGroup + "; " +
             messages::kNoObjectNoGroupHelp},
        {"", R"([{"group": "g"}])",
         "4:21: " + fmt::format(messages::kNoSuchGroup, "g") + "; " + messages::kNoGroups},
        {R"({"gear": [{"object": "box"}]})", R"([{"group": "gera"}])",
         "5:21: " + fmt::format(messages::kNoSuchGroup, "gera") + "; " +
             fmt::format(openfab::messages::kDidYouMean, "gear")},
        {R"({"a": [{"group": "b"}], "b": [{"group": "a"}]})", R"([{"object": "box"}])",
         "4:51: " + fmt::format(messages::kGroupHoldsItself, "a")},
        {R"({"a": []})", R"([{"object": "box"}])",
         std::string("4:17: `groups.a` is empty; ") + messages::kMustBePlacements},
        {R"({"a": [{"object": "bax"}]})", R"([{"object": "box"}])",
         "4:29: " + fmt::format(messages::kNoSuchObject, "bax") + "; " +
             fmt::format(openfab::messages::kDidYouMean, "box")},
        {R"({"g": [{"object": "box"}]})", R"([{"group": "g", "uniforms": {"n": 1}}])",
         "5:44: " + fmt::format(messages::kUniformOfNoObject, "n", "build[0]") + "; " +
             messages::kUniformOfNoObjectHelp +
             fmt::format(openfab::messages::kKnownNames, "`box`")},
        {"", R"([{"object": "box", "translate_mm": [1, 2, 3], "on_bed": true}])",
         "4:66: " + fmt::format(messages::kHeightAndOnBed, "build[0]") + "; " +
             messages::kHeightAndOnBedHelp},
        {"", R"([{"object": "box", "grid": {"count": [2, 2]}}])",
         "4:37: " + fmt::format(messages::kGridNeedsSpacing, "`grid` of build[0]")},
        {"", R"([{"object": "box", "grid": {"count": [2, 0], "step_mm": 1}}])",
         "4:51: `count` of `grid` of build[0] is 0; " +
             fmt::format(messages::kMustBetween, 1.0, 100000.0)},
        // The product does not fit 64 bits.
        {R"({"g": [{"object": "box", "grid": {"count": [256, 256], "step_mm": 1}}]})",
         R"([{"group": "g", "grid": {"count": [65536, 65536, 65536], "step_mm": 1}}])",
         "5:34: " + fmt::format(messages::kTooManyPlacements, "4294967296") + "; " +
             fmt::format(messages::kAtMost, 100000)},
        {"", R"([{"object": "box", "grid": {"count": [1000, 1000], "step_mm": 1}}])",
         "4:37: " + fmt::format(messages::kTooManyPlacements, 1000000) + "; " +
             fmt::format(messages::kAtMost, 100000)},
        {"", R"([{"object": "box", "transforms": "gone.txt"}])",
         "4:43: the file of `transforms` of build[0] `" + here + std::string("/gone.txt` ") +
             messages::kDoesNotExist + "; " + messages::kPathsCountFromWorld},
        {"", R"([{"object": "box", "transforms": "bad.txt"}])",
         here + "/bad.txt:2:1: " + fmt::format(messages::kTransformNumbers, 2) + "; " +
             messages::kTransformNumbersHelp},
        {"", R"([{"object": "box", "transforms": "flat.txt"}])",
         here + "/flat.txt:1:1: " + fmt::format(openfab::messages::kTransformFlattens, 0.0) + "; " +
             openfab::messages::kTransformFlattensHelp},
        {"", R"([{"object": "box", "transforms": "none.txt"}])",
         here + fmt::format(messages::kNoTransform, "/none.txt")},
    };
    for (const auto& c : cases)
        EXPECT_EQ(error_of(c.groups, c.build), c.message) << c.groups << c.build;
}

TEST_F(BuildTest, GroupsCannotGrowWithoutBound) {
    // Each contains the previous one ten times: refused before it is expanded.
    std::string ten = "{\"g0\": [{\"object\": \"box\"}]";
    for (int i = 1; i < 12; ++i)
        ten += fmt::format(
            R"(, "g{}": [{{"group": "g{}", "grid": {{"count": [10, 1], "step_mm": 9}}}}])", i,
            i - 1);
    EXPECT_THAT(error_of(ten + "}", R"([{"object": "box"}])"),
                testing::Says(messages::kTooManyPlacements, "*1000000"));
    std::string chain = "{\"g0\": [{\"group\": \"g1\"}]";
    for (int i = 1; i < 100; ++i)
        chain += fmt::format(R"(, "g{}": [{{"group": "g{}"}}])", i, i + 1);
    EXPECT_THAT(error_of(chain + R"(, "g100": [{"object": "box"}]})", R"([{"object": "box"}])"),
                testing::Says(messages::kGroupNestedTooDeep, "*", 64));
    std::string wide =
        R"({"big": [{"object": "box", "grid": {"count": [300, 300], "step_mm": 9}}])";
    for (int i = 0; i < 9; ++i)
        wide += fmt::format(R"(, "copy{}": [{{"group": "big"}}])", i);
    EXPECT_THAT(error_of(wide + "}", R"([{"object": "box"}])"),
                testing::Says(messages::kGroupsHoldTooMuch, 500000));
}

TEST_F(BuildTest, FilesAreReadBelowTheWorldsFolderOnly) {
    const testing::TempFolder other;
    const fs::path outside = other.write("pins.txt", "1 2 3\n");
    const auto build = [](const fs::path& file) {
        return R"([{"object": "box", "transforms": ")" + file.string() + R"("}])";
    };
    const std::string refused = error_of("", build(outside));
    EXPECT_EQ(refused, "4:43: " +
                           fmt::format(messages::kNotBelowFolder,
                                       "the file of `transforms` of build[0]", outside.string()) +
                           "; " +
                           fmt::format(messages::kNotBelowFolderHelp, other.path().string()));
    const fs::path up = fs::path("..") / other.path().filename() / "pins.txt";
    EXPECT_THAT(error_of("", build(up)), testing::Says(messages::kNotBelowFolder));
    // Nor through a link.
    fs::create_directory_symlink(other.path(), folder_.path() / "link");
    EXPECT_THAT(error_of("", build("link/pins.txt")), testing::Says(messages::kNotBelowFolder));
    // A name with the folder's name as prefix is outside.
    const fs::path twin = folder_.path().string() + "2";
    fs::create_directory(twin);
    std::error_code ignored;
    fs::copy_file(outside, twin / "pins.txt", ignored);
    EXPECT_THAT(error_of("", build(twin / "pins.txt")), testing::Says(messages::kNotBelowFolder));
    fs::remove_all(twin);

    EXPECT_TRUE(load("", build(outside), {{other.path()}}));
    folder_.write("inside.txt", "1 2 3\n");
    EXPECT_TRUE(load("", build(folder_.path() / "inside.txt")));
    EXPECT_TRUE(load("", build("../" + folder_.path().filename().string() + "/inside.txt")));
}

TEST_F(BuildTest, AProjectsWorldsReadAllOfIt) {
    fs::create_directory(folder_.path() / "worlds");
    folder_.write("pins.txt", "1 2 3\n");
    const fs::path world = folder_.write(
        "worlds/w.fab.json", world_text("", R"([{"object": "box", "transforms": "../pins.txt"}])"));
    EXPECT_FALSE(load_world(world));
    folder_.write("openfab.project", "");
    EXPECT_TRUE(load_world(world));
}

// A shape's mesh is a box around it; here the shape is a ball of radius r in a box of 20 mm.
TEST_F(BuildTest, ShapesStandByTheirOwnExtents) {
    FileRules rules;
    int asked = 0;
    rules.extent_of = [&](const World& world, const Placement& placed) -> Result<Box3d> {
        ++asked;
        double r = 1;
        for (const UniformBindings* from :
             {&world.objects[static_cast<size_t>(placed.object)].uniforms, &placed.overrides}) {
            if (const auto found = from->find("r"); found != from->end())
                r = std::get<0>(found->second.value).at(0);
        }
        if (!(r > 0)) return user_error("nowhere");
        EXPECT_EQ(placed.transform.t, (Vec3d{}));
        const double x = r * placed.transform.m[0], y = r * placed.transform.m[4],
                     z = r * placed.transform.m[8];
        return Box3d{{-x, -y, -z}, {x, y, z}};
    };
    const auto heights = [&](const std::string& groups, const std::string& build) {
        std::string text = world_text(groups, build);
        const std::string sphere = R"({"sphere": 2})";
        text.replace(text.find(sphere), sphere.size(),
                     R"({"shape": "f", "box_mm": [[-10, -10, -10], [10, 10, 10]]})");
        const Result<World> world = load_world(folder_.write("w.fab.json", text), rules);
        std::vector<double> out;
        if (!world) {
            ADD_FAILURE() << world.error().text();
            return out;
        }
        for (const Placement& placed : world->build)
            out.push_back(placed.transform.t.z);
        return out;
    };
    using Heights = std::vector<double>;
    EXPECT_EQ(heights("", R"([{"object": "ball", "translate_mm": [0, 0]},
                              {"object": "ball", "translate_mm": [0, 0], "scale": [1, 1, 3]},
                              {"object": "ball", "translate_mm": [0, 0], "uniforms": {"r": 4}},
                              {"object": "box", "translate_mm": [9, 0]}])"),
              (Heights{1, 3, 4, 0}));
    EXPECT_EQ(
        heights(
            "",
            R"([{"object": "ball", "uniforms": {"r": 2}, "grid": {"count": [1, 1, 3], "spacing_mm": 0.5}}])"),
        (Heights{0, 4.5, 9}));
    // Overrides of groups count where the placements in them are put, the outermost most.
    const std::string groups =
        R"({"g": [{"object": "ball", "translate_mm": [0, 0]}], "h": [{"group": "g", "uniforms": {"ball.r": 5}}]})";
    EXPECT_EQ(heights(groups,
                      R"([{"group": "g"}, {"group": "h"}, {"group": "g", "uniforms": {"ball.r": 6}},
                                  {"group": "h", "uniforms": {"ball.r": 7}}])"),
              (Heights{1, 5, 6, 7}));
    // What is nowhere solid is an error where it stands, not in a group that nothing uses so.
    const std::string hollow =
        R"({"g": [{"object": "ball", "translate_mm": [0, 0], "uniforms": {"r": 0}}], "h": [{"group": "g"}]})";
    EXPECT_EQ(heights(hollow, R"([{"group": "h", "uniforms": {"ball.r": 2}}])"), (Heights{2}));
    asked = 0;
    heights(
        "",
        R"([{"object": "ball", "translate_mm": [0, 0], "grid": {"count": [30, 30], "spacing_mm": 2}}])");
    EXPECT_EQ(asked, 1);
    std::string text = world_text(hollow, R"([{"group": "h"}])");
    text.replace(text.find(R"({"sphere": 2})"), 13,
                 R"({"shape": "f", "box_mm": [[-10, -10, -10], [10, 10, 10]]})");
    EXPECT_FALSE(load_world(folder_.write("w.fab.json", text), rules));
}

TEST_F(BuildTest, SurvivesDamage) {
    folder_.write("pins.txt", "1 2 3\n4 5 6\n");
    const std::string text = world_text(
        R"({"a": [{"object": "box", "on_bed": true}, {"group": "b", "uniforms": {"ball.n": 1}}],
            "b": [{"object": "ball", "translate_mm": [1, 2], "grid": {"count": [2, 2], "spacing_mm": 1}}]})",
        R"([{"group": "a", "scale": 2, "transforms": "pins.txt"}, {"object": "box", "matrix": [1, 0, 0, 5, 0, 1, 0, 5, 0, 0, 1, 0]}])");
    ASSERT_TRUE(load_world(folder_.write("w.fab.json", text)));
    std::mt19937 random(3);
    int whole = 0;
    for (int i = 0; i < 400; ++i) {
        std::string damaged = text;
        const auto offset = [&] { return random() % damaged.size(); };
        for (unsigned k = 0; k < 1 + random() % 3; ++k) {
            const size_t at = offset();
            if (random() % 3 == 0) {
                damaged[at] = "9-[]{}\"\xff,0e"[random() % 11];
            } else if (random() % 2 == 0) {
                damaged.erase(at, 1 + random() % 6);
            } else {
                damaged.insert(at, damaged.substr(offset(), random() % 30));
            }
        }
        const Result<World> world = load_world(folder_.write("w.fab.json", damaged));
        whole += world ? 1 : 0;
        if (!world) {
            EXPECT_FALSE(world.error().text().empty());
        }
    }
    EXPECT_GT(whole, 0);
}

TEST(TransformsFile, TakesNoNumberForGranted) {
    for (const char* text : {"1 2 x", "1 2 1e7", "nan 0 0", "1 2 3 4", "1,2",
                             "1 0 0 0 0 1 0 0 0 0 1 0 5", "1 2 3\n4 5 6"})
        EXPECT_FALSE(parse_transforms(text, "t.txt", 1)) << text;
    EXPECT_TRUE(parse_transforms("1;2\t3\r\n", "t.txt", 1));
}

}  // namespace
}  // namespace openfab::world
