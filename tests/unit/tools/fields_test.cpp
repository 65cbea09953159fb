// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Functions, level sets and volumetric data of 3MF as text of OpenFL.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "mesh/read/beams_text.h"
#include "mesh/read/threemf_shapes.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/threemf_package.h"
#include "tools/fields/fablet_text.h"
#include "tools/fields/lattice_text.h"
#include "tools/fields/messages.h"
#include "tools/fields/node_text.h"

namespace openfab::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int64_t kMemory = 100'000'000;
constexpr const char* kSpaces =
    R"(xmlns:v="http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01" xmlns:i="http://schemas.3mf.io/3dmanufacturing/implicit/2023/12" requiredextensions="v i")";

/// A node with inputs "NAME=NODE.OUTPUT", all scalars unless they are "v:…", "m:…" or "r:…".
std::string node(const std::string& kind, const std::string& name,
                 const std::vector<std::pair<std::string, std::string>>& inputs,
                 const std::string& attributes = "", const std::string& output = "result") {
    std::string in;
    for (const auto& [port, from] : inputs)
        in += fmt::format(R"(<i:scalarref identifier="{}" ref="{}"/>)", port, from);
    return fmt::format(
        R"(<i:{0} identifier="{1}" {2}><i:in>{3}</i:in><i:out><i:scalar identifier="{4}"/></i:out></i:{0}>)",
        kind, name, attributes, in, output);
}

std::string function(int id, const std::string& inputs, const std::string& nodes,
                     const std::string& outputs, const std::string& name = "") {
    return fmt::format(
        R"(<i:implicitfunction id="{}" displayname="{}"><i:in>{}</i:in>{}<i:out>{}</i:out></i:implicitfunction>)",
        id, name, inputs, nodes, outputs);
}

constexpr const char* kPos = R"(<i:vector identifier="pos"/>)";
constexpr const char* kShape = R"(<i:scalarref identifier="shape" ref="{}"/>)";

/// A ball of radius 4 as function 5.
std::string ball() {
    return function(5, kPos,
                    node("length", "len", {{"A", "inputs.pos"}}) +
                        node("constant", "r", {}, R"(value="4")", "value") +
                        node("subtraction", "sub", {{"A", "len.result"}, {"B", "r.value"}}),
                    fmt::format(fmt::runtime(kShape), "sub.result"), "ball");
}

std::string level_set(const std::string& resources, const std::string& attributes,
                      const std::string& mesh = mesh::threemf_cube(-5, 5)) {
    return mesh::threemf_model(
        resources + R"(<object id="2" type="model">)" + mesh + "</object>" +
            fmt::format(
                R"(<object id="3" name="thing" type="model"><v:levelset functionid="5" channel="shape" meshid="2" {}/></object>)",
                attributes),
        R"(<item objectid="3" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>)", kSpaces);
}

Result<mesh::ReadThreemfShapes> read(const std::string& model) {
    static std::string bytes;
    bytes = mesh::threemf_package(model);
    return mesh::parse_threemf_shapes(bytes, "a.3mf", kMemory);
}

Result<FieldFablet> fablet(const std::string& model) {
    const Result<mesh::ReadThreemfShapes> shapes = read(model);
    if (!shapes) return shapes.error();
    EXPECT_EQ(shapes->level_sets.size(), 1u);
    if (shapes->level_sets.empty()) return user_error("none");
    return level_set_fablet(shapes->level_sets[0], {}, "a.3mf", "Thing");
}

std::string error_of(const std::string& model) {
    const Result<FieldFablet> made = fablet(model);
    return made ? "" : made.error().text();
}

TEST(Fields, ANodeIsALine) {
    const Result<FieldFablet> made = fablet(level_set(ball(), R"(meshbboxonly="true")"));
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_THAT(made->source, HasSubstr("    float ball_5_shape(float3 pos_in)\n    {\n"
                                        "        float len_v = length(pos_in);\n"
                                        "        float r_v = 4;\n"
                                        "        float sub_v = len_v - r_v;\n"
                                        "        return sub_v;\n    }\n"));
    // The item moves it by 10.
    EXPECT_THAT(made->source, HasSubstr("return p + float3(-10, 0, 0);"));
    EXPECT_THAT(made->source, HasSubstr("float3 d = abs(q - float3(0, 0, 0)) - float3(5, 5, 5);"));
    EXPECT_THAT(made->source, HasSubstr("float level = ball_5_shape(q);"));
    ASSERT_TRUE(made->box_mm);
    EXPECT_NEAR(made->box_mm->lo.x, 5, 0.1);
    EXPECT_NEAR(made->box_mm->hi.x, 15, 0.1);
    EXPECT_TRUE(made->notes.empty());
}

// `max(x, y)` is y where x is undefined; a function then has no value, but its fallback.
TEST(Fields, WhatIsUndefinedStaysSo) {
    const auto made = [](const char* root, const char* attributes, const char* top = "max") {
        const Result<FieldFablet> text = fablet(level_set(
            function(5, kPos,
                     node("length", "len", {{"A", "inputs.pos"}}) +
                         node(root, "root", {{"A", "len.result"}}) +
                         node("constant", "r", {}, R"(value="4")", "value") +
                         node(top, "top", {{"A", "root.result"}, {"B", "r.value"}}) +
                         node("clamp", "within",
                              {{"A", "top.result"}, {"min", "r.value"}, {"max", "root.result"}}),
                     fmt::format(fmt::runtime(kShape), "within.result"), "f"),
            attributes));
        EXPECT_TRUE(text) << text.error().text();
        return text ? text->source : "";
    };
    const std::string text = made("sqrt", R"(meshbboxonly="true")");
    EXPECT_THAT(text, HasSubstr("select(root_v == root_v, max(root_v, r_v), root_v)"));
    EXPECT_THAT(text,
                HasSubstr("select(r_v == r_v, select(top_v == top_v, max(r_v, min(top_v, root_v)), "
                          "top_v), r_v)"));
    EXPECT_THAT(text, HasSubstr("return max((isnan(level) ? 0 : level), bounds(q));"));
    EXPECT_THAT(made("sqrt", R"(meshbboxonly="true" fallbackvalue="-1")"),
                HasSubstr("return max((isnan(level) ? -1 : level), bounds(q));"));
    EXPECT_THAT(made("sqrt", "", "sign"),
                HasSubstr("= select(root_v == root_v, sign(root_v), root_v);"));
    EXPECT_THAT(
        made("sqrt", "", "pow"),
        HasSubstr("select(r_v == r_v, select(root_v == root_v, pow(root_v, r_v), root_v), r_v)"));
    // What is defined everywhere is as before.
    EXPECT_THAT(made("abs", R"(meshbboxonly="true")"), HasSubstr("top_v = max(root_v, r_v);"));
}

TEST(Fields, AConvexMeshBoundsByItsPlanesAndAnotherByItself) {
    const std::string tetra =
        R"(<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="9" y="0" z="0"/><vertex x="0" y="9" z="0"/><vertex x="0" y="0" z="9"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="1" v2="2" v3="3"/><triangle v1="2" v2="0" v3="3"/></triangles></mesh>)";
    const Result<FieldFablet> convex = fablet(level_set(ball(), "", tetra));
    ASSERT_TRUE(convex) << convex.error().text();
    EXPECT_THAT(convex->source, HasSubstr("d = max(d, dot(q, float3(-1, 0, 0)) - 0);"));
    EXPECT_TRUE(convex->box_mm);

    // A vertex inside the hull.
    const std::string dented =
        R"(<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="9" y="0" z="0"/><vertex x="0" y="9" z="0"/><vertex x="0" y="0" z="9"/><vertex x="2" y="2" z="2"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="1" v2="2" v3="4"/><triangle v1="2" v2="3" v3="4"/><triangle v1="3" v2="1" v3="4"/><triangle v1="2" v2="0" v3="3"/></triangles></mesh>)";
    const Result<FieldFablet> other = fablet(level_set(ball(), "", dented));
    ASSERT_TRUE(other) << other.error().text();
    EXPECT_FALSE(other->box_mm);
    ASSERT_EQ(other->meshes.size(), 1u);
    EXPECT_THAT(other->meshes[0].obj, HasSubstr("v 19 0 0\n"));
    EXPECT_THAT(other->source, HasSubstr("if (!(level < 0)) return mc;"));
    EXPECT_THAT(other->source, Not(HasSubstr("@Shape")));
    ASSERT_EQ(other->notes.size(), 1u);
    EXPECT_THAT(other->notes[0], testing::Says(messages::kBoundNotConvex, "object `thing`"));
}

TEST(Fields, WhatIsWrongHasItsPlace) {
    const auto graph = [](const std::string& nodes, const std::string& out) {
        return level_set(function(5, kPos, nodes, fmt::format(fmt::runtime(kShape), out), "f"), "");
    };
    EXPECT_THAT(error_of(graph(
                    node("abs", "a", {{"A", "b.result"}}) + node("sin", "b", {{"A", "a.result"}}),
                    "b.result")),
                ::testing::HasSubstr("a.3mf: " + fmt::format(messages::kTheNamedFunction, 5, "f") +
                                     fmt::format(messages::kTheNode, "", "b") + ": " +
                                     fmt::format(messages::kDependsOnItself, "", "b <- a <- b")));
    EXPECT_THAT(error_of(graph(node("abs", "a", {{"A", "lenght.result"}}) +
                                   node("length", "length", {{"A", "inputs.pos"}}),
                               "a.result")),
                ::testing::HasSubstr(
                    "node `a`: " + fmt::format(messages::kNoSuchNode, "lenght.result", "lenght")));
    EXPECT_THAT(error_of(graph(node("sine", "a", {{"A", "inputs.pos"}}), "a.result")),
                ::testing::HasSubstr("node `a`: " + fmt::format(messages::kUnknownNode, "sine")));
    EXPECT_THAT(error_of(graph(node("abs", "a", {{"A", "inputs.p"}}), "a.result")),
                testing::Says(messages::kNoInput, "inputs.p", "p"));
    EXPECT_THAT(error_of(graph(node("addition", "a", {{"A", "inputs.pos"}}), "a.result")),
                ::testing::HasSubstr("node `a`: " +
                                     fmt::format(messages::kNodeNeedsInput, "addition", "B")));
    EXPECT_THAT(error_of(graph(node("length", "a", {{"A", "c.value"}}) +
                                   node("constant", "c", {}, R"(value="1")", "value"),
                               "a.result")),
                testing::Says(
                    fmt::format(messages::kTheNode, "{}", "a") + ": " + messages::kInputANotVector,
                    "*", messages::kAScalar));
    EXPECT_THAT(
        error_of(graph(node("abs", "a", {{"A", "inputs.pos"}}), "a.result")),
        testing::Says(messages::kOutputIsGiven, "shape", messages::kAScalar, messages::kAVector));
    EXPECT_THAT(error_of(graph(node("constant", "c", {}, R"(value="one")", "value"), "c.value")),
                HasSubstr("3dmodel.model:"));
    EXPECT_THAT(error_of(level_set("", "")),
                ::testing::HasSubstr(messages::kLevelSetOf + std::string("object `thing`: ") +
                                     fmt::format(messages::kNoSuchFunction, 5)));
    EXPECT_THAT(error_of(level_set(ball(), R"(volumeid="77")")),
                testing::Says(messages::kNoSuchVolumeData, "77"));
    EXPECT_THAT(error_of(level_set(R"(<v:functionfromimage3d id="5" image3did="9"/>)", "")),
                ::testing::HasSubstr(fmt::format(messages::kTheFunction, 5) + ": " +
                                     fmt::format(messages::kNoSuchImage, 9)));
    EXPECT_THAT(
        error_of(level_set(
            R"(<v:image3d id="9"><v:imagestack rowcount="2" columncount="2" sheetcount="2"><v:imagesheet path="/a.png"/></v:imagestack></v:image3d><v:functionfromimage3d id="5" image3did="9"/>)",
            "")),
        ::testing::HasSubstr(fmt::format(messages::kTheImage, 9) + ": " +
                             fmt::format(messages::kSheetCount, 2, 1)));
}

TEST(Fields, AFunctionThatCallsItselfIsAnError) {
    const std::string call =
        R"(<i:constresourceid identifier="f" value="{}"><i:out><i:resourceid identifier="value"/></i:out></i:constresourceid>
<i:functioncall identifier="c"><i:in><i:resourceref identifier="functionID" ref="f.value"/><i:vectorref identifier="pos" ref="inputs.pos"/></i:in><i:out><i:scalar identifier="shape"/></i:out></i:functioncall>)";
    const std::string out = fmt::format(fmt::runtime(kShape), "c.shape");
    EXPECT_THAT(error_of(level_set(function(5, kPos, fmt::format(fmt::runtime(call), 6), out) +
                                       function(6, kPos, fmt::format(fmt::runtime(call), 5), out),
                                   "")),
                ::testing::HasSubstr(fmt::format(messages::kTheFunction, 5) + ": " +
                                     fmt::format(messages::kCallsItself, "", "5 -> 6 -> 5")));
    // A function as an input of another.
    const std::string apply =
        R"(<i:functioncall identifier="c"><i:in><i:resourceref identifier="functionID" ref="inputs.what"/><i:vectorref identifier="pos" ref="inputs.pos"/></i:in><i:out><i:scalar identifier="shape"/></i:out></i:functioncall>)";
    const std::string caller =
        R"(<i:constresourceid identifier="f" value="7"/><i:constresourceid identifier="g" value="8"/>
<i:functioncall identifier="c"><i:in><i:resourceref identifier="functionID" ref="f.value"/><i:resourceref identifier="what" ref="g.value"/><i:vectorref identifier="pos" ref="inputs.pos"/></i:in><i:out><i:scalar identifier="shape"/></i:out></i:functioncall>)";
    std::string eight = ball();
    eight.replace(eight.find("id=\"5\""), 6, "id=\"8\"");
    const Result<FieldFablet> made = fablet(level_set(
        function(5, kPos, caller, out) +
            function(7, std::string(kPos) + R"(<i:resourceid identifier="what"/>)", apply, out) +
            eight,
        ""));
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_THAT(made->source, HasSubstr("float c_shape = ball_8_shape(pos_in);"));
}

TEST(Fields, LongChainsOfNodesAreNoRecursion) {
    std::string nodes = node("length", "n0", {{"A", "inputs.pos"}});
    constexpr int kCount = 20000;
    for (int i = 1; i < kCount; ++i)
        nodes += node("abs", fmt::format("n{}", i), {{"A", fmt::format("n{}.result", i - 1)}});
    const Result<FieldFablet> made = fablet(level_set(
        function(5, kPos, nodes,
                 fmt::format(fmt::runtime(kShape), fmt::format("n{}.result", kCount - 1))),
        ""));
    EXPECT_TRUE(made) << made.error().text();
}

TEST(Fields, MixturesColoursAndPropertiesAreStages) {
    const std::string materials =
        R"(<basematerials id="1"><base name="hard" displaycolor="#FF0000"/><base name="soft" displaycolor="#0000FF"/></basematerials>)";
    const std::string data =
        R"(<v:volumedata id="8"><v:composite basematerialid="1"><v:materialmapping functionid="5" channel="shape"/><v:materialmapping functionid="5" channel="shape" fallbackvalue="0.5"/></v:composite><v:property name="x:stiffness" functionid="5" channel="shape" required="true"/></v:volumedata>)";
    const Result<FieldFablet> made =
        fablet(level_set(materials + ball() + data, R"(volumeid="8")"));
    ASSERT_TRUE(made) << made.error().text();
    ASSERT_EQ(made->materials.size(), 2u);
    EXPECT_EQ(made->materials[1].name, "soft");
    EXPECT_EQ(made->materials[1].uniform, "material_1");
    EXPECT_THAT(made->source, HasSubstr("mc.Set(material_1, saturate(isnan(share_1) ? 0.5 : "
                                        "share_1));"));
    EXPECT_THAT(made->source, HasSubstr("float property_x_stiffness(float3 q)"));
    EXPECT_THAT(made->notes, ElementsAre(testing::Says(messages::kPropertyIsFunction, "*",
                                                       "x:stiffness", messages::kRequiredByFile)));
    EXPECT_THAT(
        error_of(level_set(
            materials + ball() +
                R"(<v:volumedata id="8"><v:color functionid="5" channel="shape"/></v:volumedata>)",
            R"(volumeid="8")")),
        testing::Says(messages::kOutputIsAndWants, "shape", messages::kAScalar,
                      std::string(messages::kColourOf) + messages::kLevelSetOf + "object `thing`",
                      messages::kAVector));
}

TEST(Fields, MatricesAreWrittenRowByRow) {
    const NodeKind* kind = find_node_kind("mod");
    ASSERT_NE(kind, nullptr);
    FieldValue out;
    const FieldValue a{"a", mesh::ThreemfType::kMatrix}, b{"b", mesh::ThreemfType::kMatrix};
    EXPECT_TRUE(node_text(*kind, {a, b}, &out).empty());
    EXPECT_EQ(out.text,
              "float4x4(a[0] - b[0] * floor(a[0] / b[0]), a[1] - b[1] * floor(a[1] / b[1]), a[2] - "
              "b[2] * floor(a[2] / b[2]), a[3] - b[3] * floor(a[3] / b[3]))");
    EXPECT_FALSE(node_text(*kind, {a, {"x", mesh::ThreemfType::kScalar}}, &out).empty());
}

TEST(Fields, BeamsThatAFunctionAsksForAreAText) {
    const std::string truss =
        R"(<object id="7" type="model"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="4" y="0" z="0"/></vertices><triangles/>)"
        R"(<b:beamlattice xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02" radius="1" minlength="0.1" cap="butt"><b:beams><b:beam v1="0" v2="1" r1="2" r2="1" cap2="sphere"/></b:beams></b:beamlattice></mesh></object>)";
    const auto asks = [&](int id) {
        return level_set(
            truss +
                function(
                    5, kPos,
                    node("constresourceid", "id", {}, fmt::format("value=\"{}\"", id), "value") +
                        node("beamlattice", "far",
                             {{"beamlattice", "id.value"}, {"pos", "inputs.pos"}}, "", "distance"),
                    fmt::format(fmt::runtime(kShape), "far.distance"), "truss"),
            "");
    };
    const Result<FieldFablet> made = fablet(asks(7));
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_THAT(made->source, HasSubstr("Object lattice_7;"));
    EXPECT_THAT(made->source, HasSubstr("float lattice_7_distance(float3 q)"));
    ASSERT_EQ(made->meshes.size(), 1u);
    EXPECT_TRUE(made->meshes[0].is_beams);
    // The item moves it by 10; a cone that is flat at one end, and has the ball of 1 at the other.
    EXPECT_EQ(
        made->meshes[0].obj,
        "node 10 0 0 0\nnode 14 0 0 0\nnode 14 0 0 1\nends flat dome\nstrut 0 1 2 1\nball 2\n");
    EXPECT_THAT(error_of(asks(2)), testing::Says(messages::kObjectWithoutLattice, 2));
}

TEST(Fields, TextsOfBeamsAreReadAgain) {
    mesh::Beams beams;
    beams.nodes = {{0, 0, 0}, {5, 1, 2}, {5, 5, 0.1}};
    using enum mesh::BeamEnd;
    beams.beams = {{{0, 1}, {1, 0.3f}, {kFlat, kDome}},
                   {{1, 1}, {2, 2}, {kBall, kBall}},
                   {{1, 2}, {1, 1}, {kBall, kBall}},
                   {{2, 0}, {0, 1}, {kDome, kDome}}};
    const Result<mesh::ReadBeams> read = mesh::parse_beams(lattice_text(beams), "a.txt", kMemory);
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->beams.beams.size(), beams.beams.size());
    for (size_t i = 0; i < beams.beams.size(); ++i) {
        const mesh::Beam &one = read->beams.beams[i], &other = beams.beams[i];
        EXPECT_EQ(one.ends, other.ends) << i;
        EXPECT_EQ(one.radii, other.radii) << i;
        for (size_t e = 0; e < 2; ++e) {
            EXPECT_EQ(read->beams.nodes[static_cast<size_t>(one.nodes[e])],
                      beams.nodes[static_cast<size_t>(other.nodes[e])]);
        }
    }
}

TEST(Fields, MemoryIsLimited) {
    const std::string bytes = mesh::threemf_package(level_set(ball(), ""));
    EXPECT_FALSE(mesh::parse_threemf_shapes(bytes, "a.3mf", 3000));
}

}  // namespace
}  // namespace openfab::tools
