// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Compiled stages as nodes of 3MF functions.

#include "tools/fields/function_nodes.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <bit>

#include "tools/fields/fablet_ir.h"
#include "tools/fields/field_model.h"
#include "tools/fields/messages.h"
#include "tools/fields/volume_shares.h"

namespace openfab::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A fablet of a shape and a volume stage of these lines.
FabletIr fablet(const std::string& shape,
                const std::string& volume =
                    "    %0 = const float 1\n"
                    "    output a weight 0 0 %0\n",
                const std::string& head = "") {
    const Result<FabletIr> read =
        read_fablet_ir("fablet Thing\n  counts values 2 textures 0 objects 0 slots 2 void -1\n" +
                       head + "  stage shape\n" + shape + "  stage volume\n" + volume);
    EXPECT_TRUE(read) << read.error().text();
    return read ? *read : FabletIr{};
}

constexpr const char* kPoint =
    "    %0 = input float shape_point 0 0\n    %1 = input float frame 12 0\n"
    "    %2 = add float %0 %1\n";

/// The text of a function whose output is the shape's value.
std::string text_of(const FabletIr& ir, const std::vector<uint32_t>& uniforms = {}) {
    constexpr ValueBounds kSide{-500, 500};
    FunctionNodes nodes({{kSide, kSide, kSide}, {1, 1, 1}});
    nodes.use(uniforms);
    const auto made = nodes.add(ir.shape, {ir.shape.outputs[0].value}, {});
    if (!made) return made.error().message;
    return nodes.text(7, "f", {{"shape", (*made)[0]}});
}

std::string shape_of(const std::string& lines, uint32_t last,
                     const std::vector<uint32_t>& uniforms = {}) {
    return text_of(
        fablet(kPoint + lines + fmt::format("    output value shape_value 0 0 %{}\n", last)),
        uniforms);
}

TEST(FabletIr, IsReadLineByLine) {
    const FabletIr ir = fablet(
        kPoint + std::string("    output value shape_value 0 0 %2\n"),
        "    %0 = const float nan:0x7fc00000\n"
        "    output a weight 1 0 %0\n",
        "  uniform Mode mode value int 1 x 1 at 0 = 2\n  annotation @choices \"A\t0\tfirst\"\n"
        "  uniform float3 size value float 3 x 1 at 1 = 1 2.5 -3\n  shape is a distance\n");
    EXPECT_EQ(ir.name, "Thing");
    EXPECT_EQ(ir.slot_count, 2);
    EXPECT_TRUE(ir.shape_is_distance);
    ASSERT_EQ(ir.uniforms.size(), 2u);
    EXPECT_EQ(ir.uniforms[0].type_name, "Mode\nA\t0\tfirst");
    EXPECT_EQ(ir.uniforms[1].default_bits[1], std::bit_cast<uint32_t>(2.5f));
    EXPECT_EQ(ir.shape.lines.size(), 3u);
    EXPECT_EQ(ir.volume.lines[0].bits, 0x7fc00000u);
    EXPECT_EQ(ir.volume.outputs[0].index, 1);
}

TEST(FabletIr, OtherTextIsAnError) {
    EXPECT_FALSE(read_fablet_ir("nonsense"));
    EXPECT_FALSE(read_fablet_ir("  stage volume\n    %1 = const float 1\n"));
    EXPECT_FALSE(read_fablet_ir("  stage volume\n    %0 = add float %1 %2\n"));
}

TEST(FunctionNodes, TheFrameVanishes) {
    EXPECT_THAT(
        shape_of("    %3 = sin float %2\n", 3),
        HasSubstr(R"(<i:sin identifier="n2"><i:in><i:scalarref identifier="A" ref="point.x"/>)"));
}

TEST(FunctionNodes, UniformsAreNumbers) {
    const std::string text =
        shape_of("    %3 = input float uniform 1 0\n    %4 = sub float %2 %3\n", 4,
                 {0, std::bit_cast<uint32_t>(0.1f)});
    EXPECT_THAT(text, HasSubstr(R"(value="0.1")"));
    EXPECT_THAT(text, HasSubstr("<i:subtraction "));
}

TEST(FunctionNodes, ConditionsAreSelects) {
    // x >= 1 ? x : 2, of which the node asks the other way round.
    const std::string text = shape_of(
        "    %3 = const float 1\n    %4 = ge bool %2 %3\n    %5 = const float 2\n"
        "    %6 = select float %4 %2 %5\n",
        6);
    EXPECT_THAT(
        text,
        HasSubstr(
            R"(<i:scalarref identifier="A" ref="point.x"/><i:scalarref identifier="B" ref="c1.value"/><i:scalarref identifier="C" ref="c2.value"/><i:scalarref identifier="D" ref="point.x"/>)"));
}

// `<` is false where a value is undefined, and so are `>=` and `==`.
TEST(FunctionNodes, ComparisonsWithWhatIsUndefinedAreFalse) {
    const std::string root = "    %3 = sqrt float %2\n    %4 = const float 3\n";
    const std::string end =
        "    %6 = const float 7\n    %7 = const float 9\n    %8 = select float %5 %6 %7\n";
    for (const char* op : {"ge", "le", "eq"}) {
        const std::string text =
            shape_of(root + fmt::format("    %5 = {} bool %3 %4\n", op) + end, 8);
        // The innermost select takes the difference, which is undefined, too, and is not below 1.
        EXPECT_THAT(text, HasSubstr("<i:subtraction")) << op;
        EXPECT_THAT(
            shape_of(fmt::format("    %3 = abs float %2\n    %4 = const float 3\n    %5 = {} bool "
                                 "%3 %4\n",
                                 op) +
                         end,
                     8),
            Not(HasSubstr("<i:subtraction")))
            << op;
    }
    // The larger is the second number where the first is undefined; a node `max` has no value there.
    EXPECT_THAT(shape_of(root + "    %5 = max float %3 %4\n", 5), Not(HasSubstr("<i:max")));
    EXPECT_THAT(shape_of(root + "    %5 = max float %4 %2\n", 5), HasSubstr("<i:max"));
}

TEST(FunctionNodes, IntegersThatWrapAreNamed) {
    const std::string of_uint = "    %5 = convert float %4\n";
    EXPECT_EQ(shape_of("    %3 = convert int %2\n    %4 = convert uint %3\n" + of_uint, 5),
              messages::kCalculatesWithBits);
    EXPECT_EQ(shape_of("    %3 = floor float %2\n    %4 = convert uint %3\n" + of_uint, 5),
              messages::kCalculatesWithBits);
    EXPECT_THAT(shape_of("    %3 = abs float %2\n    %4 = convert uint %3\n" + of_uint, 5),
                HasSubstr("<i:floor"));
    // Sums and products of cells are exact, those of hashes are not.
    const auto product = [&](const std::string& factor) {
        return shape_of("    %3 = convert int %2\n" + factor + "    %6 = convert float %5\n", 6);
    };
    EXPECT_THAT(product("    %4 = const int 3\n    %5 = mul int %3 %4\n"),
                HasSubstr("<i:multiplication"));
    EXPECT_THAT(product("    %4 = const int 1\n    %5 = mul int %3 %3\n"),
                HasSubstr("<i:multiplication"));
    EXPECT_EQ(product("    %4 = const int 60000\n    %5 = mul int %3 %4\n"),
              messages::kCalculatesWithBits);
    EXPECT_EQ(product("    %4 = mul int %3 %3\n    %5 = mul int %4 %3\n"),
              messages::kCalculatesWithBits);
    EXPECT_THAT(product("    %4 = const int 16000000\n    %5 = sub int %4 %3\n"),
                HasSubstr("<i:subtraction"));
    EXPECT_EQ(product("    %4 = const int 16777000\n    %5 = add int %3 %4\n"),
              messages::kCalculatesWithBits);
    // Of floats without bounds.
    EXPECT_EQ(
        shape_of("    %3 = exp float %2\n    %4 = convert int %3\n    %5 = convert float %4\n", 5),
        messages::kCalculatesWithBits);
    EXPECT_THAT(shape_of("    %3 = exp float %2\n    %4 = const float 9\n    %5 = min float %3 %4\n"
                         "    %6 = convert int %5\n    %7 = convert float %6\n",
                         7),
                HasSubstr("<i:floor"));
    // A float has no room for 2^24 + 1.
    EXPECT_EQ(shape_of("    %3 = convert int %2\n    %4 = const int 16777217\n"
                       "    %5 = sub int %3 %4\n    %6 = convert float %5\n",
                       6),
              messages::kCalculatesWithBits);
}

// An integer always is something; a node `floor` has no value there.
TEST(FunctionNodes, WhatIsUndefinedIsTheIntegerZero) {
    const auto picks = [](const std::string& of) {
        const std::string text =
            shape_of(of + "    %4 = convert int %3\n    %5 = convert float %4\n", 5);
        size_t count = 0;
        for (size_t at = 0; (at = text.find("<i:select", at)) != std::string::npos; ++at)
            ++count;
        return count;
    };
    EXPECT_EQ(picks("    %3 = sqrt float %2\n"), 3u);
    EXPECT_EQ(picks("    %3 = abs float %2\n"), 1u);
}

TEST(FunctionNodes, WhatNoFunctionSaysIsNamed) {
    EXPECT_EQ(shape_of("    %3 = const uint 5\n    %4 = noise float 0 %2 %3\n", 4),
              messages::kUsesNoise);
    EXPECT_EQ(shape_of("    %3 = convert int %2\n    %4 = const int 668265263\n"
                       "    %5 = mul int %3 %4\n    %6 = convert float %5\n",
                       6),
              messages::kCalculatesWithBits);
    EXPECT_EQ(shape_of("    %3 = input float instance 0 0\n", 3), messages::kDependsOnPlacement);
    EXPECT_EQ(shape_of("    %3 = const bool true\n    %4 = query bool -1 %3 %2 %2 %2\n"
                       "    %5 = query_result float distance 0 0 %4\n",
                       5),
              messages::kAsksNearestPoint);
}

TEST(VolumeShares, VoidIsWhereAllAmountsAreZero) {
    const std::string outputs = "    output a weight 0 0 %4\n    output b weight 1 0 %5\n";
    const std::string head =
        "    %0 = const float 0\n    %1 = const float 1\n    %2 = input float voxel_coord 0 0\n"
        "    %3 = lt bool %2 %1\n";
    const auto amounts = std::vector<uint32_t>{4, 5};
    const std::string shape = kPoint + std::string("    output value shape_value 0 0 %2\n");
    const FabletIr both = fablet(
        shape, head + "    %4 = select float %3 %1 %0\n    %5 = select float %3 %0 %1\n" + outputs);
    EXPECT_FALSE(may_be_void(both.volume, amounts));
    EXPECT_EQ(only_amount(both.volume, amounts), -1);
    const FabletIr one = fablet(
        shape, head + "    %4 = select float %3 %1 %0\n    %5 = select float %3 %0 %0\n" + outputs);
    EXPECT_TRUE(may_be_void(one.volume, amounts));
    EXPECT_EQ(only_amount(one.volume, amounts), 0);
}

TEST(FieldModel, MixturesAreSharesOrComposites) {
    for (const bool composite : {false, true}) {
        FieldModel model(composite);
        const int materials =
            model.add_materials({{"a & b", {1, 2, 3, 255}}, {"c", {4, 5, 6, 255}}});
        const int volume = model.add_volume(
            {{{9, "share_0", ""}, {9, "share_1", ""}}, {{9, "color", ""}}}, materials);
        model.add_item(
            model.add_level_set("thing", {9, "shape", ""}, model.add_box({{0, 0, 0}, {1, 2, 3}}),
                                true, materials, volume),
            {});
        const std::string text = model.text("it");
        EXPECT_THAT(text, HasSubstr("a &amp; b"));
        EXPECT_THAT(text, HasSubstr("requiredextensions=\"v i\""));
        EXPECT_THAT(text, HasSubstr("meshbboxonly=\"true\""));
        EXPECT_THAT(text, composite
                              ? HasSubstr("<v:materialmapping functionid=\"9\" channel=\"share_1\"")
                              : HasSubstr("<v:property name=\"openfab:share.1\""));
        EXPECT_THAT(text, Not(HasSubstr(composite ? "v:property" : "v:composite")));
    }
}

}  // namespace
}  // namespace openfab::tools
