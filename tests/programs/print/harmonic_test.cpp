// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The module harmonic, printed: against harmonic polynomials on a ball and a box, the potential between two balls,
// and itself with other threads and slices.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {
namespace {

constexpr size_t kHeaderBytes = 128;

/// A print of a fablet whose stage computes `float u`, 0 ... 1, as the share of one of two materials.
class Harmonic : public ::testing::Test {
  protected:
    struct Values {
        std::array<int32_t, 3> shape{};  ///< along z, y, x
        std::vector<float> white, all;   ///< of each voxel: its share, and 0 outside
    };

    RunOptions environment() const {
        return {{{"OPENFAB_CACHE", (scratch_ / "cache").string()},
                 {"OPENFAB_HELPER", program("openfab").string()}},
                {},
                {}};
    }

    void write(const std::string& mesh, const std::string& code, const std::string& core = "",
               const std::string& shape = "") {
        scratch_.write("f.fl",
                       "import harmonic;\nfablet F { @uniform { Material white, black; " +
                           std::string(core.empty() ? "" : "Object core; ") + "}\n" + shape +
                           "@Volume(@varying { VolumeAttributes attr }) { float3 p = "
                           "attr.voxelCenter;\n" +
                           code +
                           "\nMaterialComposition mc; mc.Set(white, u); mc.Set(black, 1 - u); "
                           "return mc; } }\n"
                           "fablet Core { @uniform { Material m; } @Volume(@varying { "
                           "VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); "
                           "return mc; } }\n");
        const std::string object =
            core.empty() ? "" : R"(, "core": {"mesh": "core", "fablet": "core", "priority": 1,
                              "uniforms": {"m": "White"}})";
        scratch_.write(
            "w.fab.json",
            R"({"openfab": 1, "printer": "generic", "fablets": {"f": {"source": "f.fl", "fablet": "F"},
            "core": {"source": "f.fl", "fablet": "Core"}},
            "materials": {"White": {"key": "#ffffff"}, "Black": {"key": "#000000"}},
            "meshes": {"body": )" +
                mesh + (core.empty() ? "" : ", \"core\": " + core) +
                R"(}, "objects": {"body": {"mesh": "body", "fablet": "f", "uniforms": {"white": "White",
            "black": "Black")" +
                (core.empty() ? "" : R"(, "core": "core")") + "}}" + object +
                R"(}, "build": [{"object": "body"})" +
                (core.empty() ? "" : R"(, {"object": "core", "translate_mm": [0, 0, 3]})") + "]}");
    }

    Values print(const std::vector<std::string>& more = {}) {
        std::vector<std::string> argv{program("openfab").string(),
                                      "print",
                                      (scratch_ / "w.fab.json").string(),
                                      "--voxel",
                                      "0.25mm",
                                      "--sampling",
                                      "centre",
                                      "--fractions",
                                      (scratch_ / "f.npy").string()};
        argv.insert(argv.end(), more.begin(), more.end());
        const Outcome outcome = run(argv, environment());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::string file = read_file(scratch_ / "f.npy");
        Values out;
        if (file.size() < kHeaderBytes) return out;
        const size_t at = file.find("'shape': (") + 10;
        EXPECT_EQ(std::sscanf(file.c_str() + at, "%d, %d, %d", &out.shape[0], &out.shape[1],
                              &out.shape[2]),
                  3);
        std::vector<float> both((file.size() - kHeaderBytes) / sizeof(float));
        std::memcpy(both.data(), file.data() + kHeaderBytes, both.size() * sizeof(float));
        for (size_t i = 0; i + 1 < both.size(); i += 2) {
            out.white.push_back(both[i]);
            out.all.push_back(both[i] + both[i + 1]);
        }
        return out;
    }

    /// How far what was printed is from a function of the place from the middle: over all voxels, in cubes of 8³, and
    /// how much more of the function is in the voxels than should be.
    struct Errors {
        double mean = 0, of_a_voxel = 0, of_cubes = 0, slope = 0;
        int64_t voxels = 0, cubes = 0;
    };
    static Errors errors(const Values& got, const std::function<double(const Vec3d&)>& want) {
        Errors e;
        double squares = 0, cube_squares = 0, product = 0, norm = 0;
        const auto [nz, ny, nx] = got.shape;
        const auto cubes = [](int32_t n) { return static_cast<size_t>((n + 7) / 8); };
        std::vector<double> sums(cubes(nz) * cubes(ny) * cubes(nx));
        std::vector<int> counts(sums.size());
        for (int32_t z = 0; z < nz; ++z) {
            for (int32_t y = 0; y < ny; ++y) {
                for (int32_t x = 0; x < nx; ++x) {
                    const auto at = static_cast<size_t>((z * ny + y) * nx + x);
                    if (got.all[at] == 0) continue;
                    const Vec3d p =
                        Vec3d{x - 0.5 * (nx - 1), y - 0.5 * (ny - 1), z - 0.5 * (nz - 1)} * 0.25;
                    const double u = want(p), error = double{got.white[at]} - u;
                    if (std::isnan(u)) continue;
                    e.mean += error;
                    squares += error * error;
                    product += error * (u - 0.5);
                    norm += (u - 0.5) * (u - 0.5);
                    ++e.voxels;
                    const size_t cube =
                        (static_cast<size_t>(z / 8) * cubes(ny) + static_cast<size_t>(y / 8)) *
                            cubes(nx) +
                        static_cast<size_t>(x / 8);
                    sums[cube] += error;
                    ++counts[cube];
                }
            }
        }
        for (size_t k = 0; k < sums.size(); ++k) {
            if (counts[k] < 512) continue;
            ++e.cubes;
            cube_squares += sums[k] * sums[k] / 512 / 512;
        }
        const auto n = static_cast<double>(e.voxels);
        e.mean /= n;
        e.of_a_voxel = std::sqrt(squares / n);
        e.of_cubes = std::sqrt(cube_squares / static_cast<double>(e.cubes));
        e.slope = product / norm;
        return e;
    }

    ScratchFolder scratch_;
};

/// A polynomial, the same in OpenFL and here; both 0 ... 1 on what is tested.
struct Polynomial {
    const char* code;
    double (*value)(const Vec3d&);
};
constexpr Polynomial kPolynomials[] = {
    {"0.5 + 0.1 * x.x", [](const Vec3d& p) { return 0.5 + 0.1 * p.x; }},
    {"0.5 + x.x * x.y * (x.z - 5) / 250",
     [](const Vec3d& p) { return 0.5 + p.x * p.y * p.z / 250; }},
    {"0.5 + (x.x * x.x * x.x * x.x - 6 * x.x * x.x * x.y * x.y + x.y * x.y * x.y * x.y) / 5000",
     [](const Vec3d& p) {
         const double x = p.x * p.x, y = p.y * p.y;
         return 0.5 + (x * x - 6 * x * y + y * y) / 5000;
     }},
};

TEST_F(Harmonic, PolynomialsOnBallAndBox) {
    constexpr int kWalks = 4;
    for (const char* mesh : {R"({"sphere": 10})", R"({"box": [10, 10, 10]})"}) {
        for (const Polynomial& polynomial : kPolynomials) {
            SCOPED_TRACE(std::string(mesh) + " " + polynomial.code);
            write(mesh, fmt::format("float u = 0; for (int k = 0; k < {}; ++k) {{ float3 x = "
                                    "harmonic_point(p, 0.002, k); "
                                    "u += ({}) / {}; }}",
                                    kWalks, polynomial.code, kWalks));
            const Errors e = errors(print(), polynomial.value);
            EXPECT_GT(e.voxels, 30000);
            EXPECT_LT(std::fabs(e.mean), 1e-3);
            // Walks do not know of each other: 1, within a seventh for some thirty cubes.
            EXPECT_LT(e.of_cubes, 1.5 * e.of_a_voxel / std::sqrt(512));
            EXPECT_LT(std::fabs(e.slope), 0.015);
        }
    }
}

// Of the fourth degree: means of 8³ voxels of 16 walks each.
TEST_F(Harmonic, MeansOfCubesAreWithinAThousandth) {
    for (const char* mesh : {R"({"sphere": 10})", R"({"box": [8, 8, 8]})"}) {
        SCOPED_TRACE(mesh);
        const Polynomial& polynomial = kPolynomials[2];
        write(mesh, fmt::format("float u = 0; for (int k = 0; k < 16; ++k) {{ float3 x = "
                                "harmonic_point(p, 0.002, k); u += ({}) / 16; }}",
                                polynomial.code));
        const Errors e = errors(print(), polynomial.value);
        EXPECT_GT(e.cubes, 20);
        EXPECT_LT(e.of_cubes, 1e-3);
        EXPECT_LT(std::fabs(e.mean), 3e-4);
    }
}

// Values are read on the surface, a `stop` of a quarter and a twelfth of the radius from where walks are last.
TEST_F(Harmonic, ErrorsOfALargeStopAreSmall) {
    for (const double stop : {1.2, 0.4}) {
        write(
            R"({"sphere": 10})",
            fmt::format(
                "float u = 0; for (int k = 0; k < 8; ++k) {{ float3 x = nearest(harmonic_point(p, "
                "{}, k)).position; u += ({}) / 8; }}",
                stop, kPolynomials[0].code));
        // A walk that simply stopped there would be off by some 0.5 stop / 5; chance is 0.003.
        EXPECT_LT(std::fabs(errors(print(), kPolynomials[0].value).slope), 0.01) << stop;
    }
}

TEST_F(Harmonic, BetweenTwoBalls) {
    write(R"({"sphere": 10})", "float u = harmonic_share(p, core, 0.002, 3, 4);",
          R"({"sphere": 4})");
    const Errors e = errors(print(), [](const Vec3d& p) {
        const double r = length(p);
        return r < 2.2 || r > 4.95 ? std::nan("") : (1 / r - 1 / 5.0) / (1 / 2.0 - 1 / 5.0);
    });
    EXPECT_GT(e.voxels, 25000);
    EXPECT_LT(std::fabs(e.mean), 1e-3);
    EXPECT_LT(std::fabs(e.slope), 0.01);
}

// Inner edges, where balls are small, and a surface that is bent on a small scale.
TEST_F(Harmonic, PolynomialsInARoughShapeWithInnerEdges) {
    for (const char* body :
         {"max(length(p) - 5, -max(-p.x, -p.y))",
          "length(p) - 4.5 + 0.25 * sin(4 * p.x) * sin(4 * p.y) * sin(4 * p.z)"}) {
        SCOPED_TRACE(body);
        write(
            R"({"shape": "f", "box_mm": [[-5.2, -5.2, -5.2], [5.2, 5.2, 5.2]]})",
            fmt::format("float u = 0; for (int k = 0; k < 4; ++k) {{ float3 x = harmonic_point(p, "
                        "0.01, k); u += ({}) / 4; }}",
                        kPolynomials[0].code),
            "",
            fmt::format("@Shape(@varying {{ ShapeAttributes attr }}) {{ float3 p = attr.p; "
                        "return {}; }}",
                        body));
        const Errors e = errors(print(), kPolynomials[0].value);
        EXPECT_GT(e.voxels, 20000);
        EXPECT_LT(std::fabs(e.mean), 1e-3);
        EXPECT_LT(std::fabs(e.slope), 0.01);
    }
}

TEST_F(Harmonic, AlongALineAndByDistance) {
    write(R"({"box": [10, 6, 6]})",
          "BlendLine line = blend_along(p, float3(3, 0, 0), 0.001); float u = line.share;");
    const Errors line = errors(print(), [](const Vec3d& p) { return 0.5 + p.x / 10; });
    EXPECT_LT(std::fabs(line.mean), 1e-4);
    EXPECT_LT(line.of_a_voxel, 1e-3);
    // Of three, the second nearest at 2, the third, which is left out, at 4: weights of 1 and 1/9.
    write(R"({"box": [4, 4, 4]})",
          "float d[8] = {2, 1, 4, 0, 0, 0, 0, 0}; Blend b = blend_nearest(d, 3, 2); float u = "
          "b.of[1] - b.of[2];");
    const Errors blend = errors(print(), [](const Vec3d& /*p*/) { return 0.9; });
    EXPECT_LT(blend.of_a_voxel, 1e-4);
    // All three equally near, one of two kept: none is preferred.
    write(R"({"box": [4, 4, 4]})",
          "float d[8] = {1, -1, 1, 0, 0, 0, 0, 0}; Blend b = blend_nearest(d, 3, 2); float u = "
          "b.of[1];");
    EXPECT_LT(errors(print(), [](const Vec3d& /*p*/) { return 1.0 / 3; }).of_a_voxel, 1e-4);
}

TEST_F(Harmonic, SameVoxelsForThreadsAndSlices) {
    write(R"({"sphere": 6})",
          "HarmonicEnd end = harmonic_between(p, core, 0.01, 1); float u = end.on_object ? 0.1 : "
          "0.5 + "
          "(end.at.x + harmonic_point(p, 0.02, 2).y) / 16;",
          R"({"sphere": 2})");
    const Values whole = print({"--threads", "1"});
    EXPECT_TRUE(print({"--threads", "3"}).white == whole.white);
    EXPECT_TRUE(print({"--threads", "2", "--isa", "sse41"}).white == whole.white);
    // Where the lattice is not kept.
    EXPECT_TRUE(print({"--threads", "1", "--memory", "90MB"}).white == whole.white);
    const Values some = print({"--slices", "5:14"});
    const size_t slice = some.white.size() / 9;
    EXPECT_TRUE(std::equal(some.white.begin(), some.white.end(),
                           whole.white.begin() + static_cast<ptrdiff_t>(5 * slice)));
}

}  // namespace
}  // namespace openfab::testing
