// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/edit.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <random>

#include "compiler/graph/picture.h"
#include "tests/unit/graph/drawn.h"

namespace openfab::graph {
namespace {

Action action(const std::string& what) {
    Action out;
    out.what = what;
    out.tab = 0;
    return out;
}

/// Returns what an action makes of a text, or why it is refused.
std::string after(const std::string& text, const Action& action) {
    const Drawn drawn(text);
    const Result<std::string> made = edited(drawn.analysis, drawn.graph, action);
    if (!made) return made.error().text();
    const server::Analysis again({}, *made, {});
    if (const Result<void> fine = still_fine(drawn.analysis, again); !fine)
        return fine.error().text();
    return *made;
}

/// Returns the lines of a volume stage's body.
std::string body(const std::string& text) {
    const size_t at = text.find("    {\n        ");
    return at == std::string::npos ? text
                                   : text.substr(at + 6, text.find("\n    }\n", at) - at - 6);
}

TEST(Edit, AValueIsReplacedAndNothingElse) {
    Action one = action("set");
    one.node = node_of(Drawn(kBall), "smoothstep");
    one.port = 0;
    one.text = "0.25";
    std::string wanted = kBall;
    wanted.replace(wanted.find("smoothstep(0.5"), 14, "smoothstep(0.25");
    EXPECT_EQ(after(kBall, one), wanted);
    one.text = "0.25)";
    EXPECT_EQ(after(kBall, one), "the brackets do not match");
    one.text = "core";
    EXPECT_NE(after(kBall, one).find("Material"), std::string::npos) << "the compiler's own words";
}

TEST(Edit, AnExpressionBesideAnOperatorStandsInBrackets) {
    Action one = action("set");
    one.node = node_of(Drawn(kBall), "/");
    one.port = 1;
    one.text = "skin + 1";
    EXPECT_NE(after(kBall, one).find("/ (skin + 1)"), std::string::npos) << after(kBall, one);
}

TEST(Edit, CommentsOfAReplacedValueStay) {
    std::string text = kBall;
    text.replace(text.find(" / skin"), 7, " // mm\n / /* of it */ skin");
    Action one = action("delete");
    one.node = node_of(Drawn(text), "/");
    EXPECT_NE(after(text, one).find("-distance(attr.voxelCenter) /* mm */ /* of it */);"),
              std::string::npos)
        << after(text, one);
}

TEST(Edit, AnInsertedFunctionTakesWhatTheWireBrought) {
    Action one = action("insert");
    one.node = node_of(Drawn(kBall), "smoothstep");
    one.port = 2;
    one.signature = "T abs(T x)";
    EXPECT_NE(
        after(kBall, one)
            .find("smoothstep(0.5, 1, abs(-distance(attr.voxelCenter) / skin)); // 0 outside"),
        std::string::npos)
        << after(kBall, one);
}

TEST(Edit, AFunctionOfTheLibraryComesWithItsImport) {
    Action one = action("add");
    one.module = "lattice";
    one.signature = "float gyroid(float3 p, float3 cell)";
    const Drawn drawn(kBall);
    for (const Entry& entry : entries_of(drawn.analysis)) {
        if (entry.name == "gyroid") one.signature = entry.signature;
    }
    const std::string made = after(kBall, one);
    EXPECT_NE(made.find("import lattice;"), std::string::npos) << made;
    EXPECT_NE(made.find("float gyroid_value = gyroid(attr.voxelCenter, 6);"), std::string::npos)
        << made;
    EXPECT_EQ(made.find("// A ball."), 0U) << "comments stay\n" << made;
}

TEST(Edit, PastedStatementsGetNamesOfTheirOwn) {
    Action one = action("paste");
    one.text = "float t = skin; // copied\nfloat u = t + skin;";
    const std::string made = after(kBall, one);
    EXPECT_NE(made.find("float t2 = skin; // copied\n        float u = t2 + skin;\n"),
              std::string::npos)
        << made;
    EXPECT_LT(made.find("float t2"), made.find("return mc;"));
    one.text = "float u = t;";
    EXPECT_NE(after(kBall, one).find("float u = t;"), std::string::npos) << "what is there is used";
    one.text = "} float t = 1; {";
    EXPECT_EQ(after(kBall, one), "the brackets do not match");
    one.text = "nothing(1);";
    EXPECT_NE(after(kBall, one).find("nothing"), std::string::npos) << "the compiler's own words";
    EXPECT_EQ(after(kBall, one).find("fablet"), std::string::npos) << after(kBall, one);
}

TEST(Edit, AConnectedNestedValueGetsAName) {
    const Drawn drawn(kBall);
    Action one = action("connect");
    one.from = node_of(drawn, "/");
    one.node = node_of(drawn, "-");
    // The second `-` is `1 - t`.
    const std::vector<Node>& nodes = drawn.graph.tabs[0].nodes;
    for (size_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].title == "-" && nodes[i].ports.size() == 2) one.node = static_cast<int>(i);
    }
    one.port = 0;
    const std::string made = after(kBall, one);
    EXPECT_NE(made.find("float ratio = -distance(attr.voxelCenter) / skin;\n        // How deep it "
                        "is.\n        float t = "
                        "smoothstep(0.5, 1, ratio);"),
              std::string::npos)
        << made;
    EXPECT_NE(made.find("mc.Set(shell, ratio - t);"), std::string::npos) << made;
    std::swap(one.from, one.node);
    one.port = 0;
    EXPECT_NE(after(kBall, one).find("loop"), std::string::npos);
}

TEST(Edit, WhatComesTooLateIsMovedWithItsComments) {
    const std::string text = R"(fablet F {
    @uniform { Material a, b; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float one = attr.voxelCenter.x;
        mc.Set(a, one);
        // Later.
        float base = attr.voxelCenter.y; // y
        float two = base * 2;
        mc.Set(b, two);
        return mc;
    }
}
)";
    const Drawn drawn(text);
    const std::vector<Node>& nodes = drawn.graph.tabs[0].nodes;
    Action one = action("connect");
    for (size_t i = 0; i < nodes.size(); ++i) {
        if (!nodes[i].outputs.empty() && nodes[i].outputs[0].name == "two")
            one.from = static_cast<int>(i);
        if (nodes[i].title == ".Set" && one.node < 0) one.node = static_cast<int>(i);
    }
    one.port = 2;
    EXPECT_EQ(body(after(text, one)), R"(        MaterialComposition mc;
        float one = attr.voxelCenter.x;
        // Later.
        float base = attr.voxelCenter.y; // y
        float two = base * 2;
        mc.Set(a, two);
        mc.Set(b, two);
        return mc;)");
}

TEST(Edit, ADeletedNodeLetsItsFirstInputThrough) {
    Action one = action("delete");
    one.node = node_of(Drawn(kBall), "smoothstep");
    EXPECT_NE(after(kBall, one).find("float t = 0.5; // 0 outside"), std::string::npos)
        << after(kBall, one);
    one.node = node_of(Drawn(kBall), ".Set");
    EXPECT_EQ(after(kBall, one).find("mc.Set(core"), std::string::npos);
    one.node = node_of(Drawn(kBall), "return");
    EXPECT_NE(after(kBall, one).find("the result stays"), std::string::npos);
}

TEST(Edit, ChosenNodesBecomeAFunction) {
    const Drawn drawn(kBall);
    Action one = action("group");
    one.nodes = {node_of(drawn, "smoothstep"), node_of(drawn, "/")};
    one.text = "depth";
    const std::string made = after(kBall, one);
    EXPECT_NE(made.find("    float depth(float negative)\n    {\n        return smoothstep(0.5, 1, "
                        "negative / skin);\n    }\n"),
              std::string::npos)
        << made;
    EXPECT_NE(made.find("float t = depth(-distance(attr.voxelCenter)); // 0 outside"),
              std::string::npos)
        << made;
}

TEST(Edit, UniformsAreMadeNamedAndDeleted) {
    Action one = action("expose");
    one.node = node_of(Drawn(kBall), "smoothstep");
    one.port = 1;
    one.text = "full";
    const std::string made = after(kBall, one);
    EXPECT_NE(made.find("        Material core, shell;\n        float full = 1;\n    }"),
              std::string::npos)
        << made;
    EXPECT_NE(made.find("smoothstep(0.5, full, "), std::string::npos) << made;
    Action gone = action("delete_uniform");
    gone.uniform = 0;
    EXPECT_NE(after(made, gone).find("is used 1 times"), std::string::npos);
    Action added = action("add_uniform");
    added.fablet = 0;
    added.type = "float";
    added.text = "extra";
    const std::string more = after(kBall, added);
    EXPECT_NE(more.find("float extra = 0;"), std::string::npos) << more;
    gone.uniform = 3;
    EXPECT_EQ(after(more, gone), kBall);
    Action renamed = action("rename_uniform");
    renamed.uniform = 0;
    renamed.text = "hide";
    EXPECT_NE(after(kBall, renamed).find("/ hide)"), std::string::npos);
}

TEST(Edit, RandomEditsLeaveProgramsThatCheck) {
    constexpr int kEdits = 200;
    std::mt19937 random(20261126);
    const auto any = [&](size_t n) { return static_cast<int>(random() % std::max<size_t>(n, 1)); };
    std::string text = kBall;
    int made = 0;
    std::map<std::string, int> done;
    for (int tries = 0; made < kEdits && tries < 20 * kEdits; ++tries) {
        constexpr size_t kLongest = 6000;
        if (text.size() > kLongest) text = kBall;
        const Drawn drawn(text);
        ASSERT_FALSE(has_errors(drawn.analysis.diagnostics())) << text;
        const std::vector<Entry> entries = entries_of(drawn.analysis);
        const char* const whats[] = {"set",    "connect", "disconnect", "insert", "add",
                                     "delete", "name",    "group",      "expose", "default"};
        Action one = action(whats[any(std::size(whats))]);
        one.tab = any(drawn.graph.tabs.size());
        const Tab& tab = drawn.graph.tabs[static_cast<size_t>(one.tab)];
        one.node = any(tab.nodes.size());
        one.port = any(tab.nodes[static_cast<size_t>(one.node)].ports.size());
        one.from = any(tab.nodes.size());
        one.uniform = any(drawn.graph.uniforms.size());
        one.text = one.what == "set" || one.what == "default" ? std::to_string(any(9))
                                                              : "it" + std::to_string(any(99));
        for (int n = any(3) + 1; n > 0; --n)
            one.nodes.push_back(any(tab.nodes.size()));
        const Entry& entry = entries[static_cast<size_t>(any(entries.size()))];
        one.signature = entry.signature;
        one.module = entry.module;
        const Result<std::string> after = edited(drawn.analysis, drawn.graph, one);
        if (!after) {
            EXPECT_NE(after.error().code, ErrorCode::kInternal) << one.what << "\n" << text;
            continue;
        }
        const Drawn again(*after);
        // The compiler may refuse what fits by its types only.
        if (!still_fine(drawn.analysis, again.analysis)) {
            EXPECT_TRUE(again.graph.is_whole) << one.what << " makes what does not parse\n"
                                              << *after;
            continue;
        }
        EXPECT_EQ(tokens_of(Written(again).all()), tokens_of(*after));
        EXPECT_NE(after->find("// A ball."), std::string::npos) << one.what << "\n" << *after;
        ++done[one.what];
        ++made;
        text = *after;
    }
    EXPECT_EQ(made, kEdits);
    EXPECT_GE(done.size(), 9U);
    for (const auto& [what, count] : done)
        std::printf("%s %d\n", what.c_str(), count);
}

}  // namespace
}  // namespace openfab::graph
