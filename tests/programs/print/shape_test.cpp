// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Shapes as a user writes them: volumes against closed forms, what a shape may ask (a scan, a picture, another
// object), the same bits for threads, slices and instruction sets, and the messages of shapes that are no solids.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "runtime/part/messages.h"
#include "runtime/solid/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

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
        {"{ return length(attr.p) - 6; }", "[[-4, -9, -9], [9, 9, 9]]",
         solid::messages::kShapeOpen},
        {"{ return -1; }", "[[-9, -9, -9], [9, 9, 9]]", solid::messages::kShapeOpen},
        {"{ return length(attr.p) + 1; }", "[[-9, -9, -9], [9, 9, 9]]",
         solid::messages::kNowhereNegative},
        {"{ return sqrt(attr.p.x) + length(attr.p) - 6; }", "[[-9, -9, -9], [9, 9, 9]]",
         solid::messages::kShapeNaN},
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
        EXPECT_THAT(outcome.err, Says(bad.told));
        EXPECT_LT(outcome.peak_rss_bytes, 400'000'000);
    }
}

// An object of another fablet: the shape's uniforms are those that `fablets` gives it, and the message says so.
TEST_F(Shape, AShapeOfAnotherFabletNamesWhereItsUniformsAre) {
    write("{ return length(attr.p) - 6; }");
    std::string text = read_file((scratch_ / "w.fab.json").string());
    const std::string own = R"("fablet": "f",
            "uniforms": {"white": "White", "black": "Black"})";
    text.replace(text.find(own), own.size(), R"("fablet": "plain", "uniforms": {"m": "White"})");
    scratch_.write("w.fab.json", text);
    const Outcome asked = attempt({}, "0.5mm");
    EXPECT_EQ(asked.exit_code, 1);
    EXPECT_THAT(asked.err, Says(part::messages::kNotBound, "body", "Material white", "F"));
    EXPECT_THAT(asked.err, Says(part::messages::kOfShapesFablet, "f", "plain"));
    const std::string given = R"("fablet": "F"})";
    text.replace(text.find(given), given.size(),
                 R"("fablet": "F", "uniforms": {"white": "White", "black": "Black"}})");
    scratch_.write("w.fab.json", text);
    const Outcome done = attempt({}, "0.5mm");
    EXPECT_EQ(done.exit_code, 0) << done.err;
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
    EXPECT_THAT(refused.err, Says(part::messages::kAskedIsDisplacedHelp));
    with(R"("max_displacement_mm": 0,)");
    // A cube of 6 and what is within 1 mm of it.
    const double cube = 216 + 216 + 3 * M_PI * 6 + 4.0 / 3 * M_PI;
    EXPECT_NEAR(print().white * kVoxel / cube, 1, 2e-3);
}

// A disc thinner than a cell, which has no micropolygon, is inside of what is asked.
TEST_F(Shape, AsksWhatIsThinnerThanMicropolygons) {
    write("{ return distance_to(core, attr.p); }", "mc.Set(white, 1);", "[[-8, -8, -8], [8, 8, 8]]",
          "Object core; ", R"(, "core": "core")", "",
          R"(, "core": {"mesh": "core", "fablet": "thin", "uniforms": {"m": "White"}})",
          R"({"shape": "thin", "box_mm": [[-8, -8, -8], [8, 8, 8]]})");
    std::string source = read_file(scratch_ / "f.fl");
    source +=
        "fablet Thin { @uniform { Material m; } @Shape(@varying { ShapeAttributes attr }) { float3 "
        "p "
        "= attr.p; return min(length(p) - 3, max(abs(p.z - 0.05) - 0.02, length(p.xy) - 7)); } "
        "@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); "
        "return "
        "mc; } }\n";
    scratch_.write("f.fl", source);
    std::string world = read_file(scratch_ / "w.fab.json");
    world.insert(world.find(R"("plain")"), R"("thin": {"source": "f.fl", "fablet": "Thin"}, )");
    scratch_.write("w.fab.json", world);
    int64_t inside = 0;
    for (int z = -80; z < 80; ++z) {
        for (int y = -80; y < 80; ++y) {
            for (int x = -80; x < 80; ++x) {
                const double px = 0.1 * x + 0.05, py = 0.1 * y + 0.05, pz = 0.1 * z + 0.05;
                const bool in_ball = px * px + py * py + pz * pz < 9;
                inside += in_ball || (z == 0 && px * px + py * py < 49) ? 1 : 0;
            }
        }
    }
    EXPECT_EQ(print().white, static_cast<double>(inside));
}

/// The codes of a print as an array, and the place of its lowest corner.
struct Array {
    std::array<int, 3> shape{};  ///< along z, y, x
    std::array<double, 3> origin_mm{};
    std::string codes;
};

Array read_array(const std::filesystem::path& file) {
    constexpr size_t kHeaderBytes = 128;
    Array out;
    const std::string bytes = read_file(file);
    const size_t at = bytes.find("'shape': (");
    rapidjson::Document document;
    document.Parse(read_file(file.string() + ".json").c_str());
    if (at == std::string::npos || document.HasParseError()) return out;
    std::sscanf(bytes.c_str() + at + 10, "%d, %d, %d", &out.shape[0], &out.shape[1], &out.shape[2]);
    for (rapidjson::SizeType a = 0; a < 3; ++a)
        out.origin_mm[a] = document["origin_mm"][a].GetDouble();
    out.codes = bytes.substr(kHeaderBytes);
    return out;
}

/// A torus about z, around rings of 4 mm and 1.5 mm, of 2 `around` `across` triangles.
std::string torus_ply(int around, int across) {
    std::string out = fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty "
        "double "
        "y\nproperty double z\nelement face {}\nproperty list uchar int "
        "vertex_indices\nend_header\n",
        around * across, 2 * around * across);
    const auto put = [&](const auto& value) {
        out.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (int i = 0; i < around; ++i) {
        for (int k = 0; k < across; ++k) {
            const double a = 2 * M_PI * i / around, b = 2 * M_PI * k / across;
            const double r = 4 + 1.5 * std::cos(b);
            for (const double x : {r * std::cos(a), r * std::sin(a), 1.5 * std::sin(b)})
                put(x);
        }
    }
    const auto vertex = [&](int i, int k) { return i % around * across + k % across; };
    for (int i = 0; i < around; ++i) {
        for (int k = 0; k < across; ++k) {
            const int a = vertex(i, k), b = vertex(i + 1, k), c = vertex(i + 1, k + 1),
                      d = vertex(i, k + 1);
            for (const std::array<int, 3>& face : {std::array{a, b, c}, std::array{a, c, d}}) {
                put(static_cast<uint8_t>(3));
                for (const int v : face)
                    put(v);
            }
        }
    }
    return out;
}

// A torus as a shape, and as a million triangles: voxels differ from the formula where floats do, and within the
// sagitta of the facets.
TEST_F(Shape, DiffersFromAMillionTrianglesWithinTheirSagitta) {
    constexpr int kAround = 1000, kAcross = 500;
    constexpr double kPitch = 0.05;
    const double sagitta =
        5.5 * (1 - std::cos(M_PI / kAround)) + 1.5 * (1 - std::cos(M_PI / kAcross));
    // Vertices of meshes lie on 1/256 voxel.
    const double snapped = std::sqrt(3.0) * kPitch / 512;
    scratch_.write("torus.ply", torus_ply(kAround, kAcross));
    write("{ return length(float2(length(attr.p.xy) - 4, attr.p.z)) - 1.5; }", "mc.Set(white, 1);",
          "[[-6, -6, -2], [6, 6, 2]]", "", "", "",
          R"(, "ring": {"mesh": "core", "fablet": "plain", "uniforms": {"m": "White"}})",
          R"({"file": "torus.ply", "unit": "mm"})");
    for (const bool mesh : {false, true}) {
        SCOPED_TRACE(mesh);
        if (mesh) {
            std::string world = read_file(scratch_ / "w.fab.json");
            world.replace(world.rfind(R"("body")"), 6, R"("ring")");
            scratch_.write("w.fab.json", world);
        }
        print({}, "0.05mm", "torus.npy");
        const Array got = read_array(scratch_ / "torus.npy");
        ASSERT_EQ(got.codes.size(), static_cast<size_t>(got.shape[0]) *
                                        static_cast<size_t>(got.shape[1]) *
                                        static_cast<size_t>(got.shape[2]));
        int64_t inside = 0, wrong = 0;
        size_t at = 0;
        for (int z = 0; z < got.shape[0]; ++z) {
            for (int y = 0; y < got.shape[1]; ++y) {
                for (int x = 0; x < got.shape[2]; ++x) {
                    const Vec3d p = Vec3d{got.origin_mm[0], got.origin_mm[1], got.origin_mm[2]} +
                                    Vec3d{x + 0.5, y + 0.5, z + 0.5} * kPitch;
                    const double d = std::hypot(std::hypot(p.x, p.y) - 4, p.z) - 1.5;
                    const bool is = got.codes[at++] != 0;
                    inside += is ? 1 : 0;
                    if (is != (d < 0) && std::fabs(d) > (mesh ? sagitta + snapped : 1e-6)) ++wrong;
                }
            }
        }
        EXPECT_EQ(wrong, 0);
        EXPECT_NEAR(
            static_cast<double>(inside) * kPitch * kPitch * kPitch / (2 * M_PI * M_PI * 4 * 2.25),
            1, 1e-3);
    }
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
