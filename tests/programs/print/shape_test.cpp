// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Shapes as a user writes them: volumes against closed forms, what a shape may ask (a scan, a picture, another
// object), the same bits for threads, slices and instruction sets, and the messages of shapes that are no solids.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "base/vec.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

constexpr const char* kMaterials =
    R"("materials": {"White": {"key": "#ffffff"}, "Black": {"key": "#000000"}})";

class Shape : public ::testing::Test {
  protected:
    struct Printed {
        std::string hash;
        double white = 0, black = 0;  ///< voxels
        double solid() const { return white + black; }
    };

    RunOptions environment() const {
        return {{{"OPENFAB_CACHE", (scratch_ / "cache").string()},
                 {"OPENFAB_HELPER", program("openfab").string()}},
                {},
                {}};
    }

    /// `uniforms`: declarations; `bound`: their values as members of JSON; `more`: of the world.
    void write(const std::string& shape, const std::string& volume = "mc.Set(white, 1);",
               const std::string& box = "[[-9, -9, -9], [9, 9, 9]]",
               const std::string& uniforms = "", const std::string& bound = "",
               const std::string& more = "", const std::string& objects = "",
               const std::string& core = R"({"box": [6, 6, 6]})") {
        scratch_.write(
            "f.fl",
            "import solids;\nfablet F {\n@uniform { Material white, black; " + uniforms +
                "}\n@Shape(@varying { ShapeAttributes attr }) " + shape +
                "\n@Volume(@varying { VolumeAttributes attr }) { MaterialComposition "
                "mc; float3 p = attr.voxelCenter; " +
                volume +
                " return mc; }\n}\nfablet Plain { @uniform { Material m; } @Volume(@varying { "
                "VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; } "
                "}\n");
        scratch_.write(
            "w.fab.json",
            R"({"openfab": 1, "printer": "generic", "fablets": {"f": {"source": "f.fl", "fablet": "F"},
            "plain": {"source": "f.fl", "fablet": "Plain"}}, )" +
                std::string(kMaterials) + more +
                R"(, "meshes": {"body": {"shape": "f", "box_mm": )" + box + R"(}, "core": )" +
                core + R"(}, "objects": {"body": {"mesh": "body", "fablet": "f",
            "uniforms": {"white": "White", "black": "Black")" +
                bound + "}}" + objects + R"(}, "build": [{"object": "body"}]})");
    }

    Outcome attempt(const std::vector<std::string>& more = {}, const char* voxel = "0.1mm",
                    const char* output = "out.ofr") {
        std::vector<std::string> argv{program("openfab").string(),
                                      "print",
                                      (scratch_ / "w.fab.json").string(),
                                      "--voxel",
                                      voxel,
                                      "--stats",
                                      (scratch_ / "stats.json").string(),
                                      "-o",
                                      (scratch_ / output).string()};
        argv.insert(argv.end(), more.begin(), more.end());
        return run(argv, environment());
    }

    Printed print(const std::vector<std::string>& more = {}, const char* voxel = "0.1mm",
                  const char* output = "out.ofr") {
        const Outcome outcome = attempt(more, voxel, output);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        Printed out;
        rapidjson::Document document;
        document.Parse(read_file(scratch_ / "stats.json").c_str());
        if (document.HasParseError() || outcome.exit_code != 0) return out;
        out.hash = document["hash"].GetString();
        const auto& voxels = document["voxels_by_material"];
        if (voxels.HasMember("White")) out.white = voxels["White"].GetDouble();
        if (voxels.HasMember("Black")) out.black = voxels["Black"].GetDouble();
        return out;
    }

    /// A level set of a ball of 6 mm: distances on a lattice of 0.5 mm.
    void write_scan() {
        constexpr int kSize = 37;
        std::string text = fmt::format(
            "NRRD0004\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: {0} {0} {0}\nspace "
            "directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)\nspace origin: (-9,-9,-9)\nendian: "
            "little\nencoding: raw\n\n",
            kSize);
        for (int z = 0; z < kSize; ++z) {
            for (int y = 0; y < kSize; ++y) {
                for (int x = 0; x < kSize; ++x) {
                    const Vec3d p{0.5 * x - 9, 0.5 * y - 9, 0.5 * z - 9};
                    const auto value = static_cast<float>(length(p) - 6);
                    text.append(reinterpret_cast<const char*>(&value), sizeof value);
                }
            }
        }
        scratch_.write("ball.nrrd", text);
    }

    ScratchFolder scratch_;
};

constexpr double kVoxel = 0.1 * 0.1 * 0.1;

TEST_F(Shape, AScanIsAShapeInOneLine) {
    write_scan();
    write("{ return scan.Sample1(attr.p, 0); }", "mc.Set(white, 1);", "[[-8, -8, -8], [8, 8, 8]]",
          "ImageTexture3D scan;", R"(, "scan": "scan")",
          R"(, "textures": {"scan": {"file": "ball.nrrd", "wrap": "clamp"}})");
    // Cells of 0.5 mm are chords of 0.02 mm at most.
    const double ball = 4.0 / 3 * M_PI * 216;
    EXPECT_NEAR(print().white * kVoxel / ball, 1, 0.01);
}

TEST_F(Shape, APictureRaisesIt) {
    // A picture of one grey, whose value is a height; binary PGM is read like any picture.
    std::string picture = "P5\n8 8\n255\n";
    picture.append(64, static_cast<char>(128));
    scratch_.write("grey.pgm", picture);
    write("{ return length(attr.p) - 5 - 2 * map.Sample1(attr.p.xy * 0.05, 0); }",
          "mc.Set(white, 1);", "[[-9, -9, -9], [9, 9, 9]]", "ImageTexture2D map;",
          R"(, "map": "map")", R"(, "textures": {"map": {"file": "grey.pgm", "space": "data"}})");
    const double r = 5 + 2 * 128 / 255.0;
    EXPECT_NEAR(print().white * kVoxel / (4.0 / 3 * M_PI * r * r * r), 1, 1e-3);
}

TEST_F(Shape, ASkinOfItsOwnDistanceIsAShell) {
    // Not declared: the surface is diced. Between balls of 6 and of 5.
    write("{ return 3 * (length(attr.p) - 6); }", "mc.Set(distance(p) > -1 ? black : white, 1);");
    const Printed printed = print();
    const auto ball = [](double r) { return 4.0 / 3 * M_PI * r * r * r; };
    EXPECT_NEAR(printed.solid() * kVoxel / ball(6), 1, 5e-4);
    EXPECT_NEAR(printed.white * kVoxel / ball(5), 1, 2e-3);
}

TEST_F(Shape, SameBitsHoweverItIsPrinted) {
    write_scan();
    write(
        "{ float3 p = attr.p; float d = distance_to(core, p); return "
        "solid_difference_smooth(scan.Sample1(p, 0), d - 0.5 + 0.2 * sin(3 * p.x) * sin(2 * p.z), "
        "0.6); "
        "}",
        "float t = saturate(-distance(p)); mc.Set(black, 1 - t); mc.Set(white, t);",
        "[[-8, -8, -8], [8, 8, 8]]", "ImageTexture3D scan; Object core; ",
        R"(, "scan": "scan", "core": "core")",
        R"(, "textures": {"scan": {"file": "ball.nrrd", "wrap": "clamp"}})",
        R"(, "core": {"mesh": "core", "fablet": "plain", "uniforms": {"m": "White"}})");
    const char* voxel = "0.2mm";
    const std::string once = print({"--threads", "1"}, voxel).hash;
    ASSERT_FALSE(once.empty());
    EXPECT_EQ(print({"--threads", "3"}, voxel).hash, once);
    EXPECT_EQ(print({"--threads", "2", "--no-cull"}, voxel).hash, once);
    EXPECT_EQ(print({"--memory", "150MB"}, voxel).hash, once);
    for (const char* isa : {"sse41", "avx2"})
        EXPECT_EQ(print({"--isa", isa}, voxel).hash, once) << isa;
    // Slices of two runs, merged.
    print({}, voxel);
    const std::string whole = read_file(scratch_ / "out.ofr");
    print({"--slices", "0:21"}, voxel, "low.ofr");
    print({"--slices", "21:53"}, voxel, "high.ofr");
    const std::string low = (scratch_ / "low.ofr").string(),
                      high = (scratch_ / "high.ofr").string(),
                      both = (scratch_ / "both.ofr").string();
    const Outcome merged =
        run({program("openfab").string(), "merge", low, high, "-o", both}, environment());
    ASSERT_EQ(merged.exit_code, 0) << merged.err;
    EXPECT_TRUE(read_file(both) == whole);
}

TEST_F(Shape, WhatIsNoSolidIsTold) {
    struct Bad {
        const char *shape, *box, *told;
    };
    const Bad all[] = {
        {"{ return length(attr.p) - 6; }", "[[-4, -9, -9], [9, 9, 9]]", "is open"},
        {"{ return -1; }", "[[-9, -9, -9], [9, 9, 9]]", "is open"},
        {"{ return length(attr.p) + 1; }", "[[-9, -9, -9], [9, 9, 9]]", "nowhere negative"},
        {"{ return sqrt(attr.p.x) + length(attr.p) - 6; }", "[[-9, -9, -9], [9, 9, 9]]",
         "is no number (NaN)"},
        {"{ return length(attr.p) - 6; }", "[[-9, -9, -9], [1e30, 9, 9]]", "box_mm"},
        {"{ return length(attr.p) - 6; }", "[[9, -9, -9], [-9, 9, 9]]", "box_mm"},
        {"{ return length(attr.p) - 60000; }", "[[-70000, -70000, -70000], [70000, 70000, 70000]]",
         ""},
    };
    for (const Bad& bad : all) {
        SCOPED_TRACE(std::string(bad.shape) + bad.box);
        write(bad.shape, "mc.Set(white, 1);", bad.box);
        const Outcome outcome = attempt({"--memory", "300MB"}, "0.25mm");
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(bad.told));
        EXPECT_LT(outcome.peak_rss_bytes, 400'000'000);
    }
}

// Its surface stage hands something on, and moves nothing.
TEST_F(Shape, AsksForWhatItsSurfaceStageLeavesWhereItIs) {
    const auto with = [&](const char* bound) {
        write(
            "{ return distance_to(core, attr.p) - 1; }", "mc.Set(white, 1);",
            "[[-7, -7, -7], [7, 7, 7]]", "Object core; ", R"(, "core": "core")", "",
            fmt::format(
                R"(, "core": {{"mesh": "core", "fablet": "moved", {} "uniforms": {{"m": "White"}}}})",
                bound));
        std::string source = read_file(scratch_ / "f.fl");
        source +=
            "fablet Moved { @uniform { Material m; } @Surface(@varying { SurfaceAttributes attr }) "
            "{ return 0.2 * attr.n; } @Volume(@varying { VolumeAttributes attr }) { "
            "MaterialComposition mc; mc.Set(m, 1); return mc; } }\n";
        scratch_.write("f.fl", source);
        std::string world = read_file(scratch_ / "w.fab.json");
        world.insert(world.find(R"("plain")"),
                     R"("moved": {"source": "f.fl", "fablet": "Moved"}, )");
        scratch_.write("w.fab.json", world);
    };
    with("");
    const Outcome refused = attempt();
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, HasSubstr(R"(say `"max_displacement_mm": 0` of the object)"));
    with(R"("max_displacement_mm": 0,)");
    // A cube of 6 and what is within 1 mm of it.
    const double cube = 216 + 216 + 3 * M_PI * 6 + 4.0 / 3 * M_PI;
    EXPECT_NEAR(print().white * kVoxel / cube, 1, 2e-3);
}

// The planner counts the trees of what a shape asks: 60,000 triangles in a memory that holds them.
TEST_F(Shape, MemoryCountsWhatAShapeAsks) {
    std::string obj;
    constexpr int kAround = 240, kUp = 120;
    for (int i = 0; i <= kUp; ++i) {
        for (int k = 0; k < kAround; ++k) {
            const double a = M_PI * i / kUp, b = 2 * M_PI * k / kAround;
            obj += fmt::format("v {:.6f} {:.6f} {:.6f}\n", 5 * std::sin(a) * std::cos(b),
                               5 * std::sin(a) * std::sin(b), -5 * std::cos(a));
        }
    }
    for (int i = 0; i < kUp; ++i) {
        for (int k = 0; k < kAround; ++k) {
            const int a = i * kAround + k + 1, b = i * kAround + (k + 1) % kAround + 1;
            if (i > 0) obj += fmt::format("f {} {} {}\n", a, b, b + kAround);
            if (i + 1 < kUp) obj += fmt::format("f {} {} {}\n", a, b + kAround, a + kAround);
        }
    }
    scratch_.write("ball.obj", obj);
    write("{ return distance_to(core, attr.p) - 1; }", "mc.Set(white, 1);",
          "[[-7, -7, -7], [7, 7, 7]]", "Object core; ", R"(, "core": "ball")", "",
          R"(, "ball": {"mesh": "core", "fablet": "plain", "uniforms": {"m": "White"}})",
          R"({"file": "ball.obj", "unit": "mm"})");
    const Printed printed = print({}, "0.2mm");
    EXPECT_NEAR(printed.white * 0.008 / (4.0 / 3 * M_PI * 216), 1, 5e-3);
    const Outcome small = attempt({"--memory", "20MB", "--threads", "1"}, "0.2mm");
    EXPECT_EQ(small.exit_code, 1);
    EXPECT_THAT(small.err, HasSubstr("--memory"));
}

}  // namespace
}  // namespace openfab::testing
