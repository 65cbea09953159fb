// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The standard library through the interpreter: each function stays in the range that its comment
// states and reaches its ends, and known values are reproduced.

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <random>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/frontend/modules.h"
#include "compiler/interp/evaluate.h"
#include "compiler/passes/attach_footprints.h"
#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

double value(const std::string& modules, const std::string& expression) {
    return LibraryFunction::of(modules, expression)({});
}

struct Range {
    const char* modules;
    const char* expression;
    float low, high;
    float reach;  ///< how close sampled values come to both ends, as a fraction of the range
};

constexpr Range kRanges[] = {
    {"lattice", "gyroid(p, 7)", -1.5F, 1.5F, 0.02F},
    {"lattice", "schwarz_p(p, 7)", -3, 3, 0.05F},
    {"lattice", "schwarz_d(p, 7)", -1.4143F, 1.4143F, 0.02F},
    {"lattice", "neovius(p, 7)", -13, 13, 0.05F},
    {"lattice", "gyroid_distance(p, 7)", -3, 3, 0.5F},
    {"lattice", "schwarz_p_distance(p, 7)", -6, 6, 0.5F},
    {"lattice", "schwarz_d_distance(p, 7)", -3, 3, 0.5F},
    {"lattice", "neovius_distance(p, 7)", -25, 25, 0.5F},
    {"lattice", "strut_cubic(p, 7, 0.5)", -0.5F, 0.87F * 7, 0.3F},
    {"lattice", "strut_bcc(p, 7, 0.5)", -0.5F, 0.87F * 7, 0.6F},
    {"lattice", "strut_fcc(p, 7, 0.5)", -0.5F, 0.87F * 7, 0.7F},
    {"lattice", "strut_octet(p, 7, 0.5)", -0.5F, 0.87F * 7, 0.85F},
    {"lattice", "rods_straight(p, 5, 1)", -1, 0.71F * 5, 0.3F},
    {"lattice", "rods_hexagonal(p, 5, 1)", -1, 0.58F * 5, 0.5F},
    {"lattice", "rods_helical(p, 5, 1.5, 8, 0.6)", -0.6F, 6, 0.5F},
    {"grade", "grade_linear(p.x, -20, 20)", 0, 1, 0},
    {"grade", "grade_smooth(p.x, -20, 20)", 0, 1, 0},
    {"grade", "grade_smoother(p.x, 20, -20)", 0, 1, 0},
    {"grade", "grade_steps(p.x, -20, 20, 5)", 0, 1, 0},
    {"grade", "grade_power(t, 2.2)", 0, 1, 0.01F},
    {"grade", "grade_sigmoid(p.x, 0, 4)", 0, 1, 0.01F},
    {"grade", "grade_radial(p, 0, 5, 25)", 0, 1, 0},
    {"grade", "grade_axial(p, 0, float3(0, 0, 1), 2, 20)", 0, 1, 0},
    {"grade", "grade_between_points(p, -9, float3(9, 5, 2))", 0, 1, 0},
    {"grade", "dot(grade_weights3(t), 1)", 0.9999F, 1.0001F, 1},
    {"grade", "dot(grade_weights4(t), 1)", 0.9999F, 1.0001F, 1},
    {"grade", "grade_stops(p.x, float4(-20, -5, 5, 20), float4(0, 3, 1, 2))", 0, 3, 0.05F},
    {"foam", "foam_voids_cubic(p, 6, 2)", -2, 3.2F, 0.2F},
    {"foam", "foam_voids_bcc(p, 6, 2)", -2, 1.36F, 0.2F},
    {"foam", "foam_voids_fcc(p, 6, 2)", -2, 1.01F, 0.2F},
    {"foam", "foam_voids_random(p, 6, 2, 1u)", -2, 4, 0.3F},
    {"lens", "asphere_sag(length(p.xy), 60, 0, 0)", 0, 60, 0.9F},
    {"lens", "lens_array_square(p.xy, 4, 1.8, 3, -2)", 0, 0.6F, 0.3F},
    {"lens", "lens_array_hex(p.xy, 4, 1.8, 3, -2)", 0, 0.6F, 0.3F},
    {"lens", "lens_baffle_square(p.xy, 4, 1)", -0.5F, 1.5F, 0.05F},
    {"lens", "lens_baffle_hex(p.xy, 4, 1)", -0.51F, 1.5F, 0.05F},
    {"pattern", "stripes_soft(p.x, 5, 0.4, 0.5)", 0, 1, 0},
    {"pattern", "triangle_wave(p.x, 5)", 0, 1, 0.01F},
    {"pattern", "checks(p, 3)", 0, 1, 0},
    {"pattern", "bricks(p.xy, float2(6, 3), 1)", 0, 1, 0},
    {"pattern", "voronoi_edge(p, 5, 1u)", 0, 5, 0.4F},
    {"pattern", "voronoi_cell(p, 5, 1u)", 0, 1, 0.02F},
    {"pattern", "cells(p, 5, 1u)", 0, 1, 0.02F},
    {"halftone", "bayer8((int)floor(p.x), (int)floor(p.y))", 0.5F / 64, 63.5F / 64, 0},
    {"halftone", "halftone_scatter(p, 0.1, 1u)", 0, 1, 0.01F},
    {"mapping", "map_weights(p, 4).y", 0, 1, 0.01F},
    {"mapping", "dot(map_weights(p, 1 + 15 * t), 1)", 0.999999F, 1.000001F, 1},
    {"mapping", "map_side(p)", 0, 5, 0},
    {"marble", "marble(p, 9, 2, 8, 4)", 0, 1, 0.01F},
    {"marble", "marble_veins(p, 9, 2, 8, 4, 0.2)", 0, 1, 0.05F},
    {"wood", "wood_rings(p, 3, 1)", 0, 1, 0.02F},
    {"wood", "wood_grain(p, 0.5)", 0, 1, 0.4F},
    {"wood", "wood(p, 3, 1)", 0, 1, 0.2F},
    {"color", "srgb_to_linear(t) - t", -0.35F, 0.001F, 0.3F},
    {"color", "linear_to_srgb(srgb_to_linear(t)) - t", -1e-5F, 1e-5F, 1},
    {"color", "length(hsv_to_rgb(rgb_to_hsv(saturate(p))) - saturate(p))", 0, 1e-6F, 1},
    {"color", "length(lab_to_rgb(rgb_to_lab(saturate(p))) - saturate(p))", 0, 1e-4F, 1},
    {"color", "dot(ink_limit(rgb_to_cmyk(saturate(p), 1.5, 0.5), 0.9), 1)", 0, 0.9001F, 0.01F},
    {"lattice", "iwp(p, 7)", -5, 3, 0.02F},
    {"lattice", "frd(p, 7)", -7, 2, 0.08F},
    {"lattice", "fischer_koch_s(p, 7)", -1.4143F, 1.4143F, 0.02F},
    {"lattice", "lidinoid(p, 7)", -1.3501F, 1.1501F, 0.02F},
    {"lattice", "split_p(p, 7)", -1.8F, 1.81F, 0.02F},
    {"lattice", "iwp_distance(p, 7)", -0.28F * 7, 0.28F * 7, 0.15F},
    {"lattice", "frd_distance(p, 7)", -0.28F * 7, 0.28F * 7, 0.15F},
    {"lattice", "fischer_koch_s_distance(p, 7)", -0.16F * 7, 0.16F * 7, 0.05F},
    {"lattice", "lidinoid_distance(p, 7)", -0.14F * 7, 0.14F * 7, 0.1F},
    {"lattice", "split_p_distance(p, 7)", -0.17F * 7, 0.17F * 7, 0.15F},
    {"struts", "strut_kelvin(p, 7, 0.5, 0.5)", -1.5F, 7, 0.8F},
    {"struts", "strut_diamond(p, 7, 0.5, 0.5)", -1.5F, 7, 0.7F},
    {"struts", "strut_fluorite(p, 7, 0.5, 0.5)", -2.33F, 7, 0.8F},
    {"struts", "plates_octet(p, 7, 1)", -0.5F, 1.53F, 0.15F},
    {"struts", "honeycomb(p.xy, 7, 1)", -0.5F, 0.5F * 7, 0.5F},
    {"conformal", "cells_fit(20, 1 + 9 * t)", 1, 10, 0.01F},
};

TEST(Stdlib, FunctionsStayInTheirRangesAndFillThem) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> place(-30, 30);
    std::uniform_real_distribution<float> unit(0, 1);
    for (const Range& range : kRanges) {
        const LibraryFunction function = LibraryFunction::of(range.modules, range.expression);
        double least = 1e30;
        double most = -1e30;
        for (int i = 0; i < 1500; ++i) {
            const Vec p = {place(random), place(random), place(random)};
            const double v = function(p, unit(random));
            ASSERT_FALSE(std::isnan(v)) << range.expression;
            least = std::min(least, v);
            most = std::max(most, v);
        }
        const float slack = 1e-5F * (range.high - range.low);
        EXPECT_GE(least, range.low - slack) << range.expression;
        EXPECT_LE(most, range.high + slack) << range.expression;
        const float reach = range.reach * (range.high - range.low) + slack;
        EXPECT_LE(least, range.low + reach) << range.expression;
        EXPECT_GE(most, range.high - reach) << range.expression;
    }
}

TEST(Stdlib, KnownValues) {
    EXPECT_NEAR(value("color", "rgb_to_lab(1).x"), 100, 1e-3);
    EXPECT_NEAR(value("color", "rgb_to_lab(float3(1, 0, 0)).x"), 53.24, 0.02);
    EXPECT_NEAR(value("color", "rgb_to_lab(float3(1, 0, 0)).y"), 80.09, 0.05);
    EXPECT_NEAR(value("color", "srgb_to_linear(0.5)"), 0.21404, 1e-5);
    EXPECT_NEAR(value("color", "hsv_to_rgb(float3(0.5, 1, 1)).y"), 1, 1e-6);
    EXPECT_NEAR(value("color", "rgb_to_cmyk(float3(1, 1, 0.0316), 1.5, 1).z"), 1, 1e-3);
    EXPECT_NEAR(value("lens", "asphere_sag(3, 5, 0, 0)"), 1, 1e-6);     // a ball
    EXPECT_NEAR(value("lens", "asphere_sag(2, 4, -1, 0)"), 0.5, 1e-6);  // r^2 / 2R
    EXPECT_NEAR(value("foam", "foam_radius_bcc(2, 0.68017)"), 0.866, 1e-3);
    EXPECT_EQ(value("shell", "shell_index(-2.5, 1)"), 2);
    EXPECT_EQ(value("shell", "shell_onion(-0.5, 1) + 2 * shell_onion(-1.5, 1)"), 1);
    EXPECT_EQ(value("halftone", "bayer8(0, 0)"), 0.5F / 64);
    // Like F, Z is not its own mirror image.
    EXPECT_EQ(value("pattern", "glyph(float2(1.9, 2), 7, GLYPH_Z)"), 1);
    EXPECT_EQ(value("pattern", "glyph(float2(-1.9, 2), 7, GLYPH_Z)"), 0);
    EXPECT_EQ(value("pattern", "arrow(float2(4, 0), 5, 1) + arrow(float2(-1, 0), 5, 1)"), 1);
}

/// Where edges of a box of pictures meet, both sides are exactly at a border.
TEST(Stdlib, PicturesEndAtTheEdgesOfTheirBox) {
    for (const char* side :
         {"MAP_FRONT", "MAP_RIGHT", "MAP_BACK", "MAP_LEFT", "MAP_TOP", "MAP_BOTTOM"}) {
        for (const char* component : {"x", "y"}) {
            for (int corner = 0; corner < 8; ++corner) {
                const std::string at = std::string("map_on_side(float3(") +
                                       ((corner & 1) != 0 ? "0.35, " : "-0.35, ") +
                                       ((corner & 2) != 0 ? "1.65, " : "-1.65, ") +
                                       ((corner & 4) != 0 ? "4.05)" : "-4.05)") + ", " + side +
                                       ", float3(0.7, 3.3, 8.1))." + component;
                const double v = value("mapping", "" + at + "");
                EXPECT_TRUE(v == 0 || v == 1) << at << " is " << v;
            }
        }
    }
    // Of equal components z goes first, then y; signs do not matter.
    EXPECT_EQ(value("mapping", "map_side(float3(1, -1, -1))"), 5);
    EXPECT_EQ(value("mapping", "map_side(float3(-1, -1, 0.5))"), 0);
    EXPECT_EQ(value("mapping", "map_weights(0, 4).z"), 1);
    EXPECT_EQ(value("mapping", "map_weights(float3(0, 0.6, 0.8), 1).x"), 0) << "edge on";
}

/// p is a varying here, at place (x, y, z) with the axes' changes; the normal is the uniform.
class Place : public PointEnvironment {
  public:
    std::array<float, 3> at{};
    uint32_t input(int32_t kind, int32_t a, int32_t b) const override {
        if (kind == OPENFAB_ARG_NEAREST) return std::bit_cast<uint32_t>(at.at(size_t(b)));
        if (kind == OPENFAB_ARG_NEAREST_GRAD)
            return std::bit_cast<uint32_t>(b / 3 == b % 3 ? 1.0F : 0.0F);
        return PointEnvironment::input(kind, a, b);
    }
};

/// For a viewer who faces a side, pictures are upright and read from left to right, and the
/// footprint is that of the side.
TEST(Stdlib, PicturesOfABoxStandUprightOnEachSide) {
    const std::string text =
        "import mapping;\nfablet T { @uniform { float3 n; float t; Material m; ImageTexture2D map; "
        "}\n"
        "@Volume(@varying { VolumeAttributes attr, @nearest float3 q }) { MaterialComposition mc;\n"
        "mc.Set(m, map.Sample1(map_box(q, n, float3(8, 5, 2)), 0)); return mc; } }\n";
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add("test.fl", text);
    auto module = frontend::compile_to_ir(sources, file, sink);
    ASSERT_TRUE(module) << diag::render_text(sink, sources);
    ir::Stage& stage = module->fablets[0].volume;
    passes::attach_footprints(&stage);
    const ir::Instr* look = nullptr;
    for (const ir::Instr& instr : stage.instrs)
        look = instr.op == ir::Op::kSample ? &instr : look;
    ASSERT_NE(look, nullptr);
    struct Side {
        std::array<float, 3> normal, right, up;
    };
    const Side sides[] = {
        {{0.2F, -1, 0.3F}, {1, 0, 0}, {0, 0, 1}}, {{1, 0.9F, -0.3F}, {0, 1, 0}, {0, 0, 1}},
        {{0.2F, 1, 0.3F}, {-1, 0, 0}, {0, 0, 1}}, {{-1, 0.2F, 0.3F}, {0, -1, 0}, {0, 0, 1}},
        {{0.2F, 0.9F, 1}, {1, 0, 0}, {0, 1, 0}},  {{0.2F, 0.9F, -1}, {1, 0, 0}, {0, -1, 0}}};
    constexpr std::array<float, 3> kSize{8, 5, 2};
    for (const Side& side : sides) {
        Place place;
        place.values = {side.normal[0], side.normal[1], side.normal[2], 0};
        place.at = {1.5F, -0.7F, 0.4F};
        const std::vector<uint32_t> all = interp::evaluate_all(stage, place);
        const auto argument = [&](size_t i) { return std::bit_cast<float>(all[look->args[i]]); };
        float u = 0.5F, v = 0.5F;
        for (size_t a = 0; a < 3; ++a) {
            u += side.right[a] * place.at[a] / kSize[a];
            v += side.up[a] * place.at[a] / kSize[a];
            EXPECT_EQ(argument(4 + a), side.right[a] / kSize[a]) << "axis " << a;
            EXPECT_EQ(argument(7 + a), side.up[a] / kSize[a]) << "axis " << a;
        }
        EXPECT_NEAR(argument(1), u, 1e-6F);
        EXPECT_NEAR(argument(2), v, 1e-6F);
        // Right x up points out of the side.
        const float out =
            side.normal[0] * (side.right[1] * side.up[2] - side.right[2] * side.up[1]) +
            side.normal[1] * (side.right[2] * side.up[0] - side.right[0] * side.up[2]) +
            side.normal[2] * (side.right[0] * side.up[1] - side.right[1] * side.up[0]);
        EXPECT_GT(out, 0);
    }
}

// Inks are those of an opaque picture times alpha, and the rest is bare.
TEST(Stdlib, SkinOfLeavesBareWhatAPictureDoesNotCover) {
    source::SourceManager sources;
    diag::Sink sink;
    const auto module = frontend::compile_to_ir(
        sources,
        sources.add("test.fl",
                    "import color;\n"
                    "fablet T { @uniform { float3 p; float t; Material c, m, y, k, w, b; }\n"
                    "@Volume() { return skin_of(c, m, y, k, w, b, float4(p, t), 1.2); } }\n"),
        sink);
    ASSERT_TRUE(module) << diag::render_text(sink, sources);
    const ir::Stage& stage = module->fablets[0].volume;
    const auto amounts = [&](float alpha) {
        PointEnvironment point;
        point.values = {0.25F, 0.5F, 0.9F, alpha};
        std::vector<float> out;
        for (const uint32_t bits : interp::evaluate(stage, point))
            out.push_back(std::bit_cast<float>(bits));
        return out;
    };
    const std::vector<float> opaque = amounts(1);
    ASSERT_EQ(opaque.size(), 6U);
    const std::array density = {0.60206F / 1.2F, 0.30103F / 1.2F, 0.045757F / 1.2F};
    for (size_t ink = 0; ink < 3; ++ink)
        EXPECT_NEAR(opaque[ink] + opaque[3], density[ink], 1e-4F);
    EXPECT_NEAR(opaque[3], 0.8F * density[2], 1e-4F);
    EXPECT_EQ(opaque[5], 0);
    for (const float alpha : {0.0F, 0.25F, 0.5F, 1.0F}) {
        const std::vector<float> some = amounts(alpha);
        for (size_t slot = 0; slot < 5; ++slot)
            EXPECT_FLOAT_EQ(some[slot], opaque[slot] * alpha);
        EXPECT_EQ(some[5], 1 - alpha);
    }
}

/// The fraction of space where the gyroid lies below gyroid_level(fraction) is that fraction.
TEST(Stdlib, GyroidLevels) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> place(0, 10);
    for (float fraction : {0.15F, 0.3F, 0.5F, 0.8F}) {
        const LibraryFunction function =
            LibraryFunction::of("lattice", "gyroid(p, 10) < gyroid_level(t) ? 1 : 0");
        int below = 0;
        constexpr int kSamples = 20'000;
        for (int i = 0; i < kSamples; ++i) {
            const Vec p = {place(random), place(random), place(random)};
            below += function(p, static_cast<double>(fraction)) > 0 ? 1 : 0;
        }
        EXPECT_NEAR(static_cast<float>(below) / kSamples, fraction, 0.02) << fraction;
    }
}

}  // namespace
}  // namespace openfab::testing
