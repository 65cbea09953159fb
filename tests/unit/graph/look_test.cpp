// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/places/places.h"

namespace openfab::graph {
namespace {

namespace fs = std::filesystem;

const char* const kLookedAt = R"(fablet Ball {
    @uniform {
        float skin = 0.5;
        Material core, shell;
    }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = smoothstep(0.5, 1, -distance(attr.voxelCenter) / skin); // 0 outside
        bool deep = t > 0.5;
        mc.Set(core, deep ? 1 : t);
        mc.Set(shell, 1 - t);
        return mc;
    }
}
)";

struct Looked {
    Looked(const std::string& text, const fs::path& file, int tab, const std::vector<int>& nodes)
        : analysis(file, text, {}),
          graph(graph_of(analysis)),
          looks(looks_of(analysis, graph, tab, nodes)) {}
    int node(const std::string& title) const {
        const std::vector<Node>& nodes = graph.tabs[0].nodes;
        const auto found = std::find_if(nodes.begin(), nodes.end(),
                                        [&](const Node& one) { return one.title == title; });
        return static_cast<int>(found - nodes.begin());
    }
    server::Analysis analysis;
    Graph graph;
    Result<Looks> looks;
};

TEST(Look, AVariableIsPrintedBehindItsStatementAndANestedValueBeforeIt) {
    const Looked drawn(kLookedAt, {}, 0, {});
    ASSERT_TRUE(drawn.looks);
    const std::string& text = drawn.looks->text;
    const std::string step = std::to_string(drawn.node("smoothstep"));
    const std::string ratio = std::to_string(drawn.node("/"));
    EXPECT_NE(text.find("/ skin); printf(\"=" + step + " %.9g\", t); // 0 outside"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("printf(\"=" + ratio + " %.9g\", -distance(attr.voxelCenter) / skin);"),
              std::string::npos)
        << text;
    EXPECT_LT(text.find("printf(\"=" + ratio + " "), text.find("float t")) << text;
    EXPECT_NE(text.find("{ printf(\"@%d %.9g\", attr.instance, attr.buildPosition);"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("((deep) ? 1 : 0)"), std::string::npos) << text;
    EXPECT_NE(text.find("%.9g %.9g\", mc.Get(core), mc.Get(shell));"), std::string::npos) << text;
    EXPECT_TRUE(drawn.looks->has_places);
    EXPECT_EQ(drawn.looks->materials, (std::vector<std::string>{"core", "shell"}));
}

TEST(Look, OnlyWhatIsAskedForIsPrinted) {
    const Looked all(kLookedAt, {}, 0, {});
    const int step = all.node("smoothstep");
    const Looked one(kLookedAt, {}, 0, {step});
    ASSERT_TRUE(one.looks);
    ASSERT_EQ(one.looks->values.size(), 1U);
    EXPECT_EQ(one.looks->values[0].node, step);
    EXPECT_EQ(one.looks->values[0].type, "float");
    EXPECT_FALSE(looks_of(one.analysis, one.graph, 7, {}));
}

TEST(Look, PointsOfASurfaceAreTheirOwnPlaces) {
    std::string text = kLookedAt;
    text.insert(
        text.find("    @Volume"),
        "    @Surface(@varying { SurfaceAttributes attr })\n    {\n        float h = attr.p.x;\n"
        "        return attr.n * h;\n    }\n");
    const Looked drawn(text, {}, 0, {});
    ASSERT_TRUE(drawn.looks);
    EXPECT_EQ(drawn.graph.tabs[0].name, "@Surface");
    EXPECT_FALSE(drawn.looks->has_places);
    EXPECT_EQ(drawn.looks->text.find("buildPosition"), std::string::npos);
    EXPECT_NE(drawn.looks->text.find(" %.9g\", h);"), std::string::npos) << drawn.looks->text;
}

TEST(Look, OverTheSurfaceOnlyVoxelsNearItPrint) {
    const Looked drawn(kLookedAt, {}, 0, {});
    const Result<Looks> near = looks_of(drawn.analysis, drawn.graph, 0, {}, {0.25, {}});
    ASSERT_TRUE(near);
    EXPECT_NE(near->text.find("{ bool openfab_shown = -distance(attr.voxelCenter) < 0.25; if "
                              "(openfab_shown) printf(\"@%d %.9g\", "),
              std::string::npos)
        << near->text;
    EXPECT_EQ(near->text.find("; printf("), std::string::npos) << "one is not bound to it";
    const Result<JsonValue> asked =
        parse_json(R"({"within_mm": [null, [-0.5, 1], null]})", "action");
    ASSERT_TRUE(asked);
    const Result<Looks> row = looks_of(drawn.analysis, drawn.graph, 0, {}, looked_where(*asked));
    ASSERT_TRUE(row);
    EXPECT_NE(row->text.find("bool openfab_shown = attr.buildPosition.y >= -0.5 && "
                             "attr.buildPosition.y < 1;"),
              std::string::npos)
        << row->text;
    const server::Analysis after({}, near->text, {});
    EXPECT_FALSE(has_errors(after.diagnostics()));
}

TEST(Look, EveryFabletWithPrintsIsOneWithoutErrors) {
    int values = 0;
    for (const char* folder : {"gallery", "tools/openfab"}) {
        for (const auto& entry : fs::recursive_directory_iterator(testing::source_dir() / folder)) {
            if (entry.path().extension() != ".fl") continue;
            std::ifstream in(entry.path(), std::ios::binary);
            const std::string text(std::istreambuf_iterator<char>(in), {});
            const Looked drawn(text, entry.path(), 0, {});
            if (has_errors(drawn.analysis.diagnostics())) continue;  // a part of another file
            for (size_t tab = 0; tab < drawn.graph.tabs.size(); ++tab) {
                const Result<Looks> looks =
                    looks_of(drawn.analysis, drawn.graph, static_cast<int>(tab), {});
                const std::string& name = drawn.graph.tabs[tab].name;
                if (!drawn.graph.tabs[tab].is_stage || !looks) continue;
                values += static_cast<int>(looks->values.size());
                const server::Analysis after(entry.path(), looks->text, {});
                for (const diag::Diagnostic& one : after.diagnostics())
                    EXPECT_NE(one.severity, diag::Severity::kError)
                        << entry.path() << " " << name << ": " << one.message << "\n"
                        << looks->text;
            }
        }
    }
    EXPECT_GT(values, 500);
}

}  // namespace
}  // namespace openfab::graph
