// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The rules of stdlib/dither.fl, interpreted voxel by voxel.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>

#include "abi/voxel_hash.h"
#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/interp/evaluate.h"
#include "compiler/ir/ir.h"
#include "tests/support/reference/blue_noise.h"

namespace openfab {
namespace {

/// A voxel of 0.1 x 0.07 x 0.03 mm.
class RuleVoxel final : public interp::Environment {
  public:
    uint32_t input(int32_t kind, int32_t a, int32_t /*b*/) const override {
        const auto index = static_cast<size_t>(a);
        switch (kind) {
            case ir::kVoxelIndex:
                return static_cast<uint32_t>(at.at(index));
            case OPENFAB_ARG_FRACTION:
                return static_cast<uint32_t>(fractions.at(index));
            case OPENFAB_ARG_GRID:
                return abi::fold_seed(5);
            case OPENFAB_ARG_BLUE_NOISE:
                return static_cast<uint32_t>(reference::blue_noise_threshold(
                    {at[0], at[1], at[2]}, static_cast<dither::BlueNoiseFace>(a),
                    abi::fold_seed(5)));
            case OPENFAB_ARG_FRAME:
                return std::bit_cast<uint32_t>(kSize.at(index - OPENFAB_FRAME_VOXEL_SIZE));
            default:
                ADD_FAILURE() << "a rule read input " << kind;
                return 0;
        }
    }
    interp::TextureView texture(int32_t) const override { return {}; }

    static constexpr std::array<float, 3> kSize{0.1F, 0.07F, 0.03F};
    std::array<int32_t, 3> at{};
    std::vector<int32_t> fractions;
};

/// Returns the rule `expression` of a fablet with three materials.
std::optional<ir::Stage> rule(const std::string& expression) {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add("test.fl",
                                      "import dither;\nfablet T { @uniform { Material a, b, c; }\n"
                                      "@Volume() { MaterialComposition mc; return mc; }\n"
                                      "@Dither(@varying { DitherAttributes attr }) { return " +
                                          expression + "; } }\n");
    const auto module = frontend::compile_to_ir(sources, file, sink);
    EXPECT_TRUE(module.has_value()) << expression << '\n' << diag::render_text(sink, sources);
    if (!module) return std::nullopt;
    return module->fablets[0].dither;
}

/// A fablet of three materials with the members `stages`, after the front end.
std::optional<ir::Module> with_rule(const std::string& stages, const std::string& module,
                                    const std::string& name, std::string* said) {
    source::SourceManager sources;
    diag::Sink sink;
    sources.replace("/rules/screens.fl", module);
    const uint32_t file =
        sources.add("test.fl",
                    "fablet T { @uniform { Material a, b, c; }\n"
                    "@Volume() { MaterialComposition mc; return mc; }\n" +
                        stages + "}\nint mine(DitherAttributes v) { return 9; }\n");
    const frontend::DitherRule rule{"/rules/screens.fl", name};
    std::string fault;
    auto made = frontend::compile_to_ir(sources, file, sink, {.dither = &rule}, &fault);
    *said = fault + diag::render_text(sink, sources);
    return made;
}

int32_t choose(const ir::Stage& stage, const RuleVoxel& voxel) {
    return static_cast<int32_t>(interp::evaluate(stage, voxel)[0]);
}

TEST(DitherRules, KeepTheMeanOfEachMaterial) {
    constexpr int32_t kSide = 100;
    for (const char* expression : {"dither_dots(attr, 1, 0.4)", "dither_lines(attr, 0.9, 1.1)",
                                   "dither_scatter(attr)", "dither_blue_noise(attr, 0)",
                                   "dither_threshold(attr, (int)(hash(attr.voxel) * 70000))"}) {
        const auto stage = rule(expression);
        ASSERT_TRUE(stage);
        RuleVoxel voxel;
        for (const std::vector<int32_t>& mixture :
             {std::vector<int32_t>{0, 65535 / 2, 65535 - 65535 / 2, 0},
              {3000, 0, 20000, 42535},
              {65535 - 700, 300, 0, 400}}) {
            voxel.fractions = mixture;
            std::array<int32_t, 4> counts{};
            for (voxel.at[1] = 0; voxel.at[1] < kSide; ++voxel.at[1]) {
                for (voxel.at[0] = 0; voxel.at[0] < kSide; ++voxel.at[0])
                    ++counts.at(static_cast<size_t>(choose(*stage, voxel)));
            }
            for (size_t m = 0; m < counts.size(); ++m) {
                const double asked = mixture[m] / 65535.0, got = counts[m] / double{kSide * kSide};
                EXPECT_NEAR(got, asked,
                            std::string(expression).find("threshold") == 7 ? 0.07 : 0.02)
                    << expression << ", material " << m;
                EXPECT_EQ(mixture[m] == 0, counts[m] == 0) << expression << ", material " << m;
            }
        }
    }
}

TEST(DitherRules, MajorityIsTheFirstOfTheLargest) {
    const auto stage = rule("dither_majority(attr)");
    ASSERT_TRUE(stage);
    std::mt19937 random(3);
    RuleVoxel voxel;
    for (int k = 0; k < 2000; ++k) {
        voxel.fractions.assign(4, 0);
        for (int32_t& fraction : voxel.fractions)
            fraction = static_cast<int32_t>(random() % 4) * 100;
        const auto largest = std::max_element(voxel.fractions.begin(), voxel.fractions.end());
        ASSERT_EQ(choose(*stage, voxel), largest - voxel.fractions.begin());
    }
}

TEST(DitherRules, AThresholdTakesTheFirstSumAboveIt) {
    const auto stage = rule("dither_threshold(attr, attr.voxel.x)");
    ASSERT_TRUE(stage);
    RuleVoxel voxel;
    voxel.fractions = {0, 1000, 0, 64535};
    for (const auto& [threshold, number] :
         {std::pair{0, 1}, {999, 1}, {1000, 3}, {65534, 3}, {65535, 3}, {1 << 30, 3}, {-5, 1}}) {
        voxel.at[0] = threshold;
        EXPECT_EQ(choose(*stage, voxel), number) << threshold;
    }
}

TEST(DitherRules, OfAModuleAreThoseOfAFabletThatCallsThem) {
    // The fablet's own functions do not stand in for the module's.
    const std::string module =
        "import dither;\nfloat _side() { return 0.6; }\n"
        "int mine(DitherAttributes v) { return dither_dots(v, _side(), 0.3); }\n";
    std::string said;
    const auto made = with_rule("", module, "mine", &said);
    ASSERT_TRUE(made) << said;
    ASSERT_TRUE(made->fablets[0].has_dither);
    const auto own = rule("dither_dots(attr, 0.6, 0.3)");
    ASSERT_TRUE(own);
    EXPECT_EQ(ir::dump(made->fablets[0].dither), ir::dump(*own));

    // A fablet that has a rule keeps it.
    const auto kept =
        with_rule("@Dither(@varying { DitherAttributes attr }) { return attr.count - 1; }", module,
                  "mine", &said);
    ASSERT_TRUE(kept) << said;
    RuleVoxel voxel;
    voxel.fractions = {1, 65534, 0, 0};
    EXPECT_EQ(choose(kept->fablets[0].dither, voxel), 3);
}

TEST(DitherRules, OfAModuleAreRefusedWithAPlace) {
    const auto refusal = [](const std::string& module, const std::string& name) {
        std::string said;
        EXPECT_FALSE(with_rule("", module, name, &said)) << module;
        return said;
    };
    const std::string two =
        "int one(DitherAttributes v) { return 0; }\nint two(DitherAttributes v) { return 1; }\n"
        "float three(DitherAttributes v) { return 1; }\nint _four(DitherAttributes v) { return 1; "
        "}\n";
    EXPECT_NE(refusal(two, "tow").find("no function `tow`"), std::string::npos);
    EXPECT_NE(refusal(two, "tow").find("of module `screens` are `one`, `two`\n"),
              std::string::npos);
    EXPECT_NE(refusal(two, "_four").find("no function `_four`"), std::string::npos);
    EXPECT_NE(refusal(two, "three").find("screens.fl:3:7: error: `three` is to be a dither rule"),
              std::string::npos);
    EXPECT_NE(refusal("int side() { return 1; }\n", "dots").find("has no dither rule: write "),
              std::string::npos);
    EXPECT_NE(refusal("fablet F { @Volume() { MaterialComposition mc; return mc; } }\n", "dots")
                  .find("module `screens` holds a fablet"),
              std::string::npos);
    EXPECT_NE(refusal("int dots(DitherAttributes v) { return v; }\n", "dots").find("screens.fl:1:"),
              std::string::npos);
    // What a rule may not do.
    EXPECT_NE(refusal("int dots(DitherAttributes v) { return (int)distance(float3(0)); }\n", "dots")
                  .find("error"),
              std::string::npos);
}

}  // namespace
}  // namespace openfab
