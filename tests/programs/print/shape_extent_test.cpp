// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// How far a shape reaches, and what lies outside of its box: the same answer at every pitch, the same places on the bed and
// in a grid as a mesh of the same solid, and no voxel that is lost. Twins are meshes and counts by hand.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "program/messages.h"
#include "runtime/part/messages.h"
#include "runtime/pipeline/messages.h"
#include "runtime/solid/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/texture/messages.h"
#include "world/messages.h"

namespace openfab::testing {
namespace {

class ShapeExtent : public ::testing::Test {
  protected:
    struct Printed {
        int exit_code = 0;
        std::string err;
        Vec3i size;
        std::array<double, 2> voxels{};  ///< of `a` and `b`
        bool operator==(const Printed& o) const { return size == o.size && voxels == o.voxels; }
    };

    /// `shape`: a body of functions of float3 p and of a uniform r.
    void write_fablets(const std::string& shape) {
        scratch_.write("f.fl",
                       "import solids;\nfablet F { @uniform { Material m; float r = 3; }\n"
                       "@Shape(@varying { ShapeAttributes attr }) { float3 p = attr.p; " +
                           shape +
                           " }\n@Volume(@varying { VolumeAttributes attr }) { MaterialComposition "
                           "mc; mc.Set(m, 1); return mc; }\n}\nfablet Plain { @uniform { Material "
                           "m; } @Volume(@varying { VolumeAttributes attr }) { "
                           "MaterialComposition mc; mc.Set(m, 1); return mc; } }\n");
    }

    /// Meshes: `thing`, the shape or another mesh, and `cube`, 2 mm.
    std::string world(const std::string& thing, const std::string& rest) const {
        const bool shape = thing.find("\"shape\"") != std::string::npos;
        return R"({"openfab": 1, "printer": "generic",
            "fablets": {"f": {"source": "f.fl", "fablet": "F"}, "plain": {"source": "f.fl", "fablet": "Plain"}},
            "materials": {"a": {"key": "#ff0000"}, "b": {"key": "#00ff00"}},
            "meshes": {"thing": )" +
               thing + R"(, "cube": {"box": [2, 2, 2]}},
            "objects": {"thing": {"mesh": "thing", "fablet": ")" +
               (shape ? "f" : "plain") + R"(", "uniforms": {"m": "a"}},
                        "cube": {"mesh": "cube", "fablet": "plain", "uniforms": {"m": "b"}}},
            )" +
               rest + "}";
    }

    Printed print(const std::string& text, const char* voxel,
                  const std::vector<std::string>& more = {}) {
        scratch_.write("w.fab.json", text);
        std::vector<std::string> argv{program("openfab").string(),
                                      "print",
                                      (scratch_ / "w.fab.json").string(),
                                      "--voxel",
                                      voxel,
                                      "--support",
                                      "off",
                                      "--stats",
                                      (scratch_ / "stats.json").string(),
                                      "-o",
                                      (scratch_ / "out.ofr").string()};
        argv.insert(argv.end(), more.begin(), more.end());
        const Outcome outcome = run(argv, {{{"OPENFAB_CACHE", (scratch_ / "cache").string()},
                                            {"OPENFAB_HELPER", program("openfab").string()}},
                                           {},
                                           {}});
        Printed out;
        out.exit_code = outcome.exit_code;
        out.err = outcome.err;
        if (outcome.exit_code != 0) return out;
        rapidjson::Document document;
        document.Parse(read_file(scratch_ / "stats.json").c_str());
        const auto& size = document["size_voxels"];
        for (int a = 0; a < 3; ++a)
            out.size[a] = size[static_cast<rapidjson::SizeType>(a)].GetInt();
        const auto& voxels = document["voxels_by_material"];
        for (size_t m = 0; m < 2; ++m) {
            const char* name = m == 0 ? "a" : "b";
            if (voxels.HasMember(name)) out.voxels[m] = voxels[name].GetDouble();
        }
        return out;
    }

    ScratchFolder scratch_;
};

std::string shape(const std::string& box) {
    return R"({"shape": "f", "box_mm": )" + box + "}";
}
constexpr const char* kRoomy = "[[-7, -8, -10], [9, 8, 8]]";
constexpr const char* kBuild = R"("build": [{"object": "thing"}])";

/// Counts the voxels of a pitch at whose centres a function is negative, in a box around 0.
double count(double pitch, double half, const std::function<double(const Vec3d&)>& f) {
    const int n = static_cast<int>(std::ceil(half / pitch));
    double inside = 0;
    for (int z = -n; z < n; ++z) {
        for (int y = -n; y < n; ++y) {
            for (int x = -n; x < n; ++x)
                inside += f({(x + 0.5) * pitch, (y + 0.5) * pitch, (z + 0.5) * pitch}) < 0;
        }
    }
    return inside;
}

// Whether a shape leaves its box is the same at every pitch, and one that touches it does not.
TEST_F(ShapeExtent, OpennessIsThatOfTheBox) {
    write_fablets("return length(p) - r;");
    const std::string box = shape("[[-5, -5, -5], [5, 5, 5]]");
    for (const char* voxel : {"0.8mm", "0.4mm", "0.2mm"}) {
        SCOPED_TRACE(voxel);
        for (const char* radius : {"5.3", "5.15", "5.01"}) {
            const Printed open =
                print(world(box, kBuild), voxel, {"--set", std::string("thing.r=") + radius});
            EXPECT_EQ(open.exit_code, 1) << radius;
            EXPECT_THAT(open.err, Says(solid::messages::kShapeOpen));
        }
        const double pitch = std::stod(voxel);
        for (const double radius : {5.0, 4.7}) {
            const Printed closed =
                print(world(box, kBuild), voxel, {"--set", fmt::format("thing.r={}", radius)});
            EXPECT_EQ(closed.exit_code, 0) << closed.err;
            EXPECT_EQ(closed.voxels[0],
                      count(pitch, 6, [&](const Vec3d& p) { return length(p) - radius; }));
        }
    }
}

// No number, a second period, a hollow in an all-solid space: outside of the box nothing is asked.
TEST_F(ShapeExtent, NothingIsEvaluatedOutsideOfTheBox) {
    const std::array bodies = {
        "return max(length(p) - 3, 0 - sqrt(25 - p.x * p.x) - 1);",
        "float3 q = p - float3(0, 0, 8 * floor(p.z / 8 + 0.5)); return length(q) - 3;",
        "return max(abs(p.x), max(abs(p.y), abs(p.z))) > 3.9 ? -1 : length(p) - 3;",
    };
    for (const char* body : bodies) {
        write_fablets(body);
        for (const char* voxel : {"1mm", "0.7mm", "0.3mm", "0.1mm"}) {
            SCOPED_TRACE(std::string(body) + voxel);
            const bool narrow = std::strstr(body, "3.9") != nullptr;
            const Printed made = print(world(shape(narrow ? "[[-3.8, -3.8, -3.8], [3.8, 3.8, 3.8]]"
                                                          : "[[-5, -5, -3.5], [5, 5, 3.5]]"),
                                             kBuild),
                                       voxel);
            EXPECT_EQ(made.exit_code, 0) << made.err;
            EXPECT_EQ(made.voxels[0],
                      count(std::stod(voxel), 4, [](const Vec3d& p) { return length(p) - 3; }));
        }
    }
}

// A rod, a foot and a plate of one voxel reach beyond the rest; corners of voxels are on their faces.
TEST_F(ShapeExtent, WhatIsOneVoxelThickIsWhole) {
    const auto box = [](const Vec3d& p, const Vec3d& at, const Vec3d& half) {
        return std::max({std::fabs(p.x - at.x) - half.x, std::fabs(p.y - at.y) - half.y,
                         std::fabs(p.z - at.z) - half.z});
    };
    const char* body =
        "float ball = length(p - float3(0, 1, 0)) - 2;"
        "float3 a = abs(p - float3(0.5, -2, 0.5)) - float3(HALF, 4, HALF);"
        "float3 b = abs(p - float3(-0.5, 1, -3.5)) - float3(HALF, HALF, 2);"
        "float3 c = abs(p - float3(4.5, 1, 0)) - float3(HALF, 2, 2);"
        "float d = min(min(ball, max(a.x, max(a.y, a.z))), min(max(b.x, max(b.y, b.z)), "
        "max(c.x, max(c.y, c.z))));";
    for (const double half : {0.5, 0.3}) {
        const double expected = count(1, 7, [&](const Vec3d& p) {
            return std::min(
                {length(p - Vec3d{0, 1, 0}) - 2, box(p, {0.5, -2, 0.5}, {half, 4, half}),
                 box(p, {-0.5, 1, -3.5}, {half, half, 2}), box(p, {4.5, 1, 0}, {half, 2, 2})});
        });
        for (const char* returned : {"return d;", "return d < 0 ? -0.5 : 0.5;"}) {
            std::string text = body;
            for (size_t at = text.find("HALF"); at != std::string::npos; at = text.find("HALF"))
                text.replace(at, 4, fmt::format("{}", half));
            write_fablets(text + returned);
            SCOPED_TRACE(text + returned);
            const Printed made = print(world(shape("[[-7, -7, -7], [7, 7, 7]]"), kBuild), "1mm");
            EXPECT_EQ(made.voxels[0], expected) << made.err;
            EXPECT_EQ(made.size.y, 9);
        }
    }
}

// Bounds of the value are unknown in a loop: what is thin and apart is found by its voxels.
TEST_F(ShapeExtent, WhatBoundsDoNotTellIsFoundByItsVoxels) {
    write_fablets(
        "float d = length(p) - 1; float at = -5.05; float end = r + 1;"
        "@bound(64) while (at < end) { float3 q = abs(p - float3(at, 0.05, 0.05)) - 0.05; d = "
        "min(d, max(q.x, max(q.y, q.z))); "
        "at += 3; } return d;");
    const Printed made = print(world(shape("[[-8, -8, -8], [8, 8, 8]]"), kBuild), "0.1mm");
    ASSERT_EQ(made.exit_code, 0) << made.err;
    // Grains of one voxel at x = -5.05, -2.05, 0.95 and 3.95.
    EXPECT_EQ(made.size.x, 91);
}

// On the bed, in a grid and in rows like a mesh of the same solid.
TEST_F(ShapeExtent, StandsWhereAMeshStands) {
    write_fablets("return max(abs(p.x - 1) - r, max(abs(p.y) - 2, abs(p.z + 1) - 4));");
    const std::array builds = {
        R"("build": [{"object": "thing", "translate_mm": [0, 0]}, {"object": "cube", "translate_mm": [9, 0, 0]}])",
        R"("build": [{"object": "thing", "translate_mm": [0, 0], "rotate_deg": [90, 0, 0]}, {"object": "cube", "translate_mm": [9, 0, 0]}])",
        R"("build": [{"object": "thing", "translate_mm": [0, 0], "scale": [1, 2, 0.5]}, {"object": "cube", "translate_mm": [9, 0, 0]}])",
        R"("build": [{"object": "thing", "translate_mm": [0, 0], "grid": {"count": [3, 2], "spacing_mm": 2}}])",
        R"("arrange": {"columns": 2, "spacing_mm": 1}, "build": [{"object": "thing"}, {"object": "cube"}, {"object": "thing"}])",
        R"("groups": {"g": [{"object": "thing"}, {"object": "cube", "translate_mm": [9, 0, 0]}]},
           "build": [{"group": "g", "translate_mm": [0, 0]}])",
    };
    // The box of the mesh is where that of the shape is.
    const std::string mesh =
        R"({"extrusion": {"polygons": [[[-2, -2], [4, -2], [4, 2], [-2, 2]]], "height": 8}})";
    for (const char* build : builds) {
        SCOPED_TRACE(build);
        const Printed made = print(world(shape(kRoomy), build), "0.5mm");
        // The extrusion begins at z = 0, the shape at -5.
        std::string moved = build;
        const Printed twin = print(world(mesh, moved), "0.5mm");
        ASSERT_EQ(made.exit_code, 0) << made.err;
        ASSERT_EQ(twin.exit_code, 0) << twin.err;
        if (moved.find("groups") != std::string::npos) {
            // There the cube stays 5 mm above the shape's lowest point.
            EXPECT_EQ(made.size.z, 16);
            continue;
        }
        EXPECT_EQ(made.voxels, twin.voxels);
        EXPECT_EQ(made.size.z, twin.size.z);
        // What is turned reaches elsewhere in y.
        if (moved.find("rotate") == std::string::npos) {
            EXPECT_EQ(made.size, twin.size);
        }
    }
}

// Placements that are stretched along axes of their own share a stage, and differ in nothing but the stretch.
TEST_F(ShapeExtent, EachStretchHasAnExtentOfItsOwn) {
    write_fablets("return max(length(p.yz) - 1, abs(p.x) - 6);");
    scratch_.write("w.fab.json", world(shape(kRoomy), R"("build": [
        {"object": "thing", "matrix": [[1.04, 0.01, 0, 0], [0.01, 1, 0, 0], [0, 0, 1, 0]]},
        {"object": "thing", "matrix": [[1, 0.01, 0, 0], [0.01, 1.04, 0, 30], [0, 0, 1, 0]]}])"));
    const Outcome outcome =
        run({program("openfab").string(), "print", (scratch_ / "w.fab.json").string(), "--extents",
             (scratch_ / "extents.json").string()},
            {{{"OPENFAB_CACHE", (scratch_ / "cache").string()}}, {}, {}});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    rapidjson::Document document;
    document.Parse(read_file(scratch_ / "extents.json").c_str());
    // A corner is at (6, 1), which the matrix moves.
    constexpr double kReach[2][2] = {{6 * 1.04 + 0.01, 6 * 0.01 + 1}, {6 + 0.01, 6 * 0.01 + 1.04}};
    for (rapidjson::SizeType i = 0; i < 2; ++i) {
        for (rapidjson::SizeType a = 0; a < 2; ++a)
            EXPECT_NEAR(document[i]["extent_mm"][1][a].GetDouble(), kReach[i][a], 2e-3) << i << a;
    }
}

// Uniforms of a placement, of groups around it and of the command line count.
TEST_F(ShapeExtent, StandsByItsOwnUniforms) {
    write_fablets("return length(p) - r;");
    const std::string cube = R"({"object": "cube", "translate_mm": [9, 0, 0]})";
    const auto height = [&](const std::string& rest, const std::vector<std::string>& more = {}) {
        const Printed made = print(world(shape(kRoomy), rest), "0.5mm", more);
        EXPECT_EQ(made.exit_code, 0) << made.err;
        return made.size.z;
    };
    EXPECT_EQ(
        height(R"("build": [{"object": "thing", "translate_mm": [0, 0], "uniforms": {"r": 5}}, )" +
               cube + "]"),
        20);
    const std::string group =
        R"("groups": {"g": [{"object": "thing", "translate_mm": [0, 0]}], "h": [{"group": "g", "uniforms": {"thing.r": 4}}]}, )";
    EXPECT_EQ(height(group + R"("build": [{"group": "g"}, )" + cube + "]"), 12);
    EXPECT_EQ(height(group + R"("build": [{"group": "h"}, )" + cube + "]"), 16);
    EXPECT_EQ(
        height(group + R"("build": [{"group": "h", "uniforms": {"thing.r": 2}}, )" + cube + "]"),
        8);
    EXPECT_EQ(
        height(group + R"("build": [{"group": "h"}, )" + cube + "]", {"--set", "thing.r=2.5"}), 10);
}

// Without the centre of a voxel in it, a part is told and left out; the rest prints.
TEST_F(ShapeExtent, WhatIsThinnerThanAVoxelIsTold) {
    write_fablets("return max(abs(p.z - 3.03) - 0.1, length(p.xy) - r);");
    const std::string both =
        R"("build": [{"object": "thing"}, {"object": "cube", "translate_mm": [7, 0, 0]}])";
    const Printed coarse = print(world(shape(kRoomy), both), "0.8mm");
    ASSERT_EQ(coarse.exit_code, 0) << coarse.err;
    EXPECT_THAT(coarse.err, Says(pipeline::messages::kPartSize, "thing", "0", "*", "*", "0.25"));
    EXPECT_EQ(coarse.voxels[0], 0);
    EXPECT_GT(coarse.voxels[1], 0);
    const Printed fine = print(world(shape(kRoomy), both), "0.1mm");
    ASSERT_EQ(fine.exit_code, 0) << fine.err;
    EXPECT_GT(fine.voxels[0], 0);
    const Printed alone = print(world(shape(kRoomy), R"("build": [{"object": "thing"}])"), "0.8mm");
    EXPECT_THAT(alone.err, Says(program::messages::kNothingPrinted));
    EXPECT_THAT(alone.err, ::testing::HasSubstr("is 7.5 x 7.5 x 0.25 voxels\n"));
    // A thousandth of a voxel is found, too.
    write_fablets("return max(abs(p.z - 3.03) - 0.0004, length(p.xy) - r);");
    EXPECT_EQ(print(world(shape(kRoomy), both), "0.8mm").exit_code, 0);
}

// A key of a texture, an object or a mesh that nothing would read.
TEST_F(ShapeExtent, KeysWithoutEffectAreTold) {
    std::string header = "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2, 2), }";
    header.resize(117, ' ');
    header += '\n';
    scratch_.write("v.npy", std::string("\x93NUMPY\x01\x00", 8) +
                                std::string{static_cast<char>(header.size()), 0} + header +
                                "\xff\xff\xff\xff\xff\xff\xff\xff");
    scratch_.write("g.nrrd",
                   "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n12345678");
    scratch_.write("p.pgm", "P5 2 2 255\nabcd");
    scratch_.write("f.fl",
                   "fablet V { @uniform { ImageTexture3D t; Material m; } @Volume(@varying { "
                   "VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, "
                   "t.Sample1(attr.voxelCenter, 0) + 0.1); return mc; } }\n"
                   "fablet P { @uniform { ImageTexture2D t; Material m; } @Volume(@varying { "
                   "VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, "
                   "t.Sample1(attr.voxelCenter.xy, 0) + 0.1); return mc; } }\n");
    const auto attempt = [&](const std::string& texture, const char* fablet = "V",
                             const std::string& object = "") {
        return print(
            R"({"openfab": 1, "printer": "generic", "fablets": {"f": {"source": "f.fl", "fablet": ")" +
                std::string(fablet) +
                R"("}}, "materials": {"a": {"key": "#ff0000"}}, "meshes": {"c": {"box": [2, 2, 2]}}, "textures": {"t": )" +
                texture +
                R"(}, "objects": {"o": {"mesh": "c", "fablet": "f", "uniforms": {"m": "a", "t": "t"})" +
                object + R"(}}, "build": [{"object": "o"}]})",
            "1mm");
    };
    const struct {
        const char *texture, *fablet, *object, *told;
    } all[] = {
        {R"({"file": "v.npy", "pitch_mm": 0.5})", "V", "", tools::messages::kPitchWithoutEffect},
        {R"({"file": "g.nrrd", "pitch_mm": 0.5})", "V", "", tools::messages::kPitchWithoutEffect},
        {R"({"file": "v.npy", "unit": "cm"})", "V", "", tools::messages::kKeyWithoutEffect},
        {R"({"file": "v.npy", "field": "x"})", "V", "", tools::messages::kKeyWithoutEffect},
        {R"({"file": "v.npy", "outside": 2})", "V", "", tools::messages::kKeyWithoutEffect},
        {R"({"file": "g.nrrd", "field": "x"})", "V", "", tools::messages::kKeyWithoutEffect},
        {R"({"file": "g.nrrd", "outside": 2})", "V", "", tools::messages::kKeyWithoutEffect},
        {R"({"file": "p.pgm", "field": "x"})", "V", "", tools::messages::kKeyWithoutEffect},
        {R"({"file": "p.pgm", "unit": "cm"})", "V", "", tools::messages::kKeyWithoutEffect},
        {R"({"file": "p.pgm", "outside": 2})", "V", "", tools::messages::kKeyWithoutEffect},
        {R"({"file": "p.pgm", "segment": "x"})", "P", "", part::messages::kKeyOfVolume},
        {R"({"file": "p.pgm", "phase": 1})", "P", "", part::messages::kKeyOfVolume},
        {R"({"file": "p.pgm", "spacing_mm": 2})", "P", "", part::messages::kKeyOfVolume},
        {R"({"file": "v.npy"})", "V", R"(, "repair": "winding")",
         world::messages::kRepairWithoutFile},
    };
    for (const auto& one : all) {
        const Printed refused = attempt(one.texture, one.fablet, one.object);
        EXPECT_EQ(refused.exit_code, 1) << one.texture;
        EXPECT_THAT(refused.err, Says(one.told));
    }
    EXPECT_EQ(attempt(R"({"file": "v.npy", "spacing_mm": 0.5, "origin_mm": [0, 0, 0]})").exit_code,
              0);
    EXPECT_EQ(attempt(R"({"file": "g.nrrd", "unit": "mm"})").exit_code, 0);
    EXPECT_EQ(attempt(R"({"file": "p.pgm", "wrap": "clamp"})", "P").exit_code, 0);
    const Printed bounded = attempt(R"({"file": "v.npy"})", "V", R"(, "max_displacement_mm": 0.5)");
    EXPECT_EQ(bounded.exit_code, 0);
    EXPECT_THAT(bounded.err, Says(openfab::program::messages::kBoundWithoutEffect, "o", "V"));
}

}  // namespace
}  // namespace openfab::testing
