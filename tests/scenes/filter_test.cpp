// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A fine picture on a curved surface: every voxel under the skin of a sphere with a 4k checkerboard
// shows the picture's mean over the voxel. Checks finer than a voxel do not alias, and edges of
// coarse ones are not blurred by more than a voxel.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/scenes/scene_fixture.h"

namespace openfab::testing {
namespace {

constexpr int kWidth = 4096, kHeight = 2048;
constexpr int kFine = 2, kCoarse = 64;  ///< edges of a check, texels
constexpr double kRadius = 10, kPitch = 0.1, kSkin = 0.15;
constexpr int kLevels = 9;  ///< a fablet with many materials to choose from compiles slowly

/// Texel (i, j), j upwards: fine checks on one half of the sphere, coarse ones on the other.
int checker(int i, int j) {
    const int edge = i < kWidth / 2 ? kFine : kCoarse;
    return (i / edge + j / edge) & 1;
}

std::string picture() {
    std::string text = fmt::format("P5\n{} {}\n255\n", kWidth, kHeight);
    for (int j = kHeight - 1; j >= 0; --j)
        for (int i = 0; i < kWidth; ++i)
            text += static_cast<char>(checker(i, j) * 255);
    return text;
}

/// Longitude and latitude are u and v; the poles are caps of triangles with no area in uv.
std::string sphere() {
    constexpr int kAround = 256, kUp = 128;
    std::string text;
    for (int b = 0; b <= kUp; ++b) {
        for (int a = 0; a <= kAround; ++a) {
            const double lon = 2 * std::numbers::pi * (a % kAround) / kAround;
            const double lat = std::numbers::pi * (static_cast<double>(b) / kUp - 0.5);
            const double ring = b == 0 || b == kUp ? 0 : kRadius * std::cos(lat);
            text += fmt::format("v {} {} {}\nvt {} {}\n", ring * std::cos(lon),
                                ring * std::sin(lon), kRadius * std::sin(lat),
                                static_cast<double>(a) / kAround, static_cast<double>(b) / kUp);
        }
    }
    const auto corner = [](int a, int b) {
        // Vertices on the seam and at the poles are shared; their texture coordinates are not.
        const int vertex = b * (kAround + 1) + (b == 0 || b == kUp ? 0 : a % kAround) + 1;
        return fmt::format(" {}/{}", vertex, b * (kAround + 1) + a + 1);
    };
    for (int b = 0; b < kUp; ++b) {
        for (int a = 0; a < kAround; ++a) {
            if (b > 0) text += "f" + corner(a, b) + corner(a + 1, b) + corner(a, b + 1) + "\n";
            if (b < kUp - 1)
                text += "f" + corner(a + 1, b) + corner(a + 1, b + 1) + corner(a, b + 1) + "\n";
        }
    }
    return text;
}

/// Each grey level has its own material, so nothing is dithered.
std::string fablet() {
    return fmt::format(R"(
fablet Skin {{
    @uniform {{ Material body; Material levels[{}]; ImageTexture2D picture; }}
    @Surface(@varying {{ SurfaceAttributes attr, float2 uv = float2(0, 0), out float2 uvOut }})
    {{
        uvOut = uv;
        return 0;
    }}
    @Volume(@varying {{ VolumeAttributes attr, @nearest float2 uv }})
    {{
        MaterialComposition mc;
        if (-distance(attr.voxelCenter) < {})
            mc.Set(levels[(int)round(saturate(picture.Sample1(uv, 0)) * {})], 1);
        else
            mc.Set(body, 1);
        return mc;
    }}
}}
)",
                       kLevels, kSkin, kLevels - 1);
}

std::string world() {
    std::string materials = R"("body": {"key": "#ff0000"})", levels;
    for (int k = 0; k < kLevels; ++k) {
        materials += fmt::format(R"(, "grey{}": {{"key": "#{:02x}{:02x}{:02x}"}})", k, k, k, k);
        levels += fmt::format(R"({}"grey{}")", k > 0 ? ", " : "", k);
    }
    return fmt::format(R"({{
    "openfab": 1,
    "printer": "generic",
    "fablets": {{"skin": {{"source": "skin.fl", "fablet": "Skin"}}}},
    "materials": {{{}}},
    "textures": {{"picture": {{"file": "checks.pgm"}}}},
    "meshes": {{"ball": {{"file": "ball.obj", "unit": "mm"}}}},
    "objects": {{"ball": {{"mesh": "ball", "fablet": "skin",
        "uniforms": {{"body": "body", "levels": [{}], "picture": "picture"}}}}}},
    "build": [{{"object": "ball"}}]
}})",
                       materials, levels);
}

/// The picture under a point, by the sphere's own formula.
int under(const Vec3d& p) {
    const double turn = 0.5 / std::numbers::pi;
    const double lon = std::atan2(p.y, p.x) * turn;
    const double lat = std::asin(p.z / std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z));
    const int i = std::clamp(static_cast<int>((lon < 0 ? lon + 1 : lon) * kWidth), 0, kWidth - 1);
    const int j = std::clamp(static_cast<int>((lat * 2 * turn + 0.5) * kHeight), 0, kHeight - 1);
    return checker(i, j);
}

/// Over the voxel, 4 x 4 x 4 samples.
double supersampled(const Vec3d& middle) {
    int sum = 0;
    for (int k = 0; k < 64; ++k) {
        const auto off = [&](int shift) { return ((k >> shift & 3) - 1.5) / 4 * kPitch; };
        sum += under({middle.x + off(0), middle.y + off(2), middle.z + off(4)});
    }
    return sum / 64.0;
}

TEST(Filter, CheckerboardOnASphere) {
    const ScratchFolder scratch;
    scratch.write("checks.pgm", picture());
    scratch.write("ball.obj", sphere());
    scratch.write("skin.fl", fablet());
    scratch.write("ball.fab.json", world());
    const Outcome printed =
        run({program("openflc").string(), "run", (scratch / "skin.fl").string(),
             (scratch / "ball.fab.json").string(), "--voxel", fmt::format("{}mm", kPitch), "-o",
             (scratch / "ball.ofr").string(), "--progress", "none",
             // The compiler is in the same process; with sanitizers it alone takes 1.2 GB.
             "--memory", "6GB"},
            {{{"OPENFAB_CACHE", (scratch / "cache").string()},
              {"OPENFAB_HELPER", program("openfab").string()}},
             {},
             {}});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const Voxels voxels = read_ofr(scratch / "ball.ofr");
    std::vector<int> level(voxels.materials.size() + 1, -1);
    for (size_t m = 0; m < voxels.materials.size(); ++m) {
        const std::string& name = voxels.materials[m];
        if (name.starts_with("grey")) level[m + 1] = std::stoi(name.substr(4));
    }
    struct Errors {
        double sum = 0, squares = 0, worst = 0;
        int64_t count = 0;
        void add(double e) {
            sum += e;
            squares += e * e;
            worst = std::max(worst, std::abs(e));
            ++count;
        }
        double mean() const { return sum / static_cast<double>(count); }
        double deviation() const { return std::sqrt(squares / static_cast<double>(count)); }
    } fine, coarse, inside;
    for (int32_t z = voxels.slice_begin; z < voxels.slice_end; ++z) {
        for (int32_t y = 0; y < voxels.size.y; ++y) {
            for (int32_t x = 0; x < voxels.size.x; ++x) {
                const int grey = level[voxels.at(x, y, z)];
                if (grey < 0) continue;
                const auto at = [](int32_t k, double o) { return o + (k + 0.5) * kPitch; };
                const Vec3d q = {at(x, voxels.origin_mm.x), at(y, voxels.origin_mm.y),
                                 at(z, voxels.origin_mm.z)};
                // Towards the poles and at the meridians where the halves meet, the picture differs
                // from the formula.
                const double lon = std::atan2(q.y, q.x);
                if (std::abs(q.z) > 0.7 * kRadius || std::abs(std::sin(lon)) < 0.05) continue;
                const double got = static_cast<double>(grey) / (kLevels - 1);
                const double want = supersampled(q);
                (lon > 0 ? fine : coarse).add(got - want);
                if (lon > 0) continue;
                // A voxel whose neighbourhood lies in one check must have its colour.
                bool one = true;
                for (int k = 0; k < 27 && one; ++k) {
                    const Vec3d n = {q.x + (k % 3 - 1) * kPitch, q.y + (k / 3 % 3 - 1) * kPitch,
                                     q.z + (k / 9 - 1) * kPitch};
                    one = under(n) == (want > 0.5);
                }
                if (one) inside.add(got - want);
            }
        }
    }
    EXPECT_GT(fine.count, 50'000);
    EXPECT_GT(coarse.count, 50'000);
    EXPECT_GT(inside.count, 20'000);
    // Levels alone make a deviation of 0.036; 64 samples of fine checks one of up to 0.06.
    for (const Errors& errors : {fine, coarse}) {
        EXPECT_LT(std::abs(errors.mean()), 0.01);
        EXPECT_LT(errors.deviation(), 0.06);
        EXPECT_LT(errors.worst, 0.25);
    }
    EXPECT_EQ(inside.worst, 0);
}

}  // namespace
}  // namespace openfab::testing
