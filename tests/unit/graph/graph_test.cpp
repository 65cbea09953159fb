// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/graph.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "base/json.h"
#include "compiler/graph/picture.h"
#include "tests/support/places/places.h"
#include "tests/unit/graph/drawn.h"

namespace openfab::graph {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
}

std::vector<fs::path> fablets_below(const std::vector<std::string>& folders) {
    std::vector<fs::path> out;
    for (const std::string& folder : folders) {
        for (const auto& entry : fs::recursive_directory_iterator(testing::source_dir() / folder)) {
            if (entry.path().extension() == ".fl") out.push_back(entry.path());
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

TEST(Graph, EveryFabletIsWhatItsGraphSays) {
    int nodes = 0;
    for (const fs::path& file : fablets_below({"gallery", "stdlib", "tools/openfab"})) {
        const std::string text = read(file);
        const Drawn drawn(text, file);
        EXPECT_TRUE(drawn.graph.is_whole) << file;
        EXPECT_EQ(tokens_of(Written(drawn).all()), tokens_of(text)) << file;
        for (const Tab& tab : drawn.graph.tabs) {
            EXPECT_FALSE(tab.statements.empty()) << file << ": " << tab.name;
            for (const Node& node : tab.nodes) {
                ++nodes;
                for (const Port& port : node.ports)
                    EXPECT_LT(port.from.node, static_cast<int>(tab.nodes.size()));
            }
        }
        JsonText out;
        write_graph(drawn.analysis, drawn.graph, &out);
        EXPECT_TRUE(parse_json(out.take(), "graph")) << file;
    }
    EXPECT_GT(nodes, 1000);
}

TEST(Graph, WiresAreNamesAndNestedExpressions) {
    const Drawn drawn(kBall);
    ASSERT_EQ(drawn.graph.tabs.size(), 1U);
    const Tab& tab = drawn.graph.tabs[0];
    EXPECT_EQ(tab.name, "@Volume");
    const Node& step = tab.nodes[static_cast<size_t>(node_of(drawn, "smoothstep"))];
    EXPECT_EQ(step.outputs[0].name, "t");
    ASSERT_EQ(step.ports.size(), 3U);
    EXPECT_EQ(step.ports[0].label, "from");
    EXPECT_TRUE(step.ports[0].is_plain);
    EXPECT_EQ(tab.nodes[static_cast<size_t>(step.ports[2].from.node)].title, "/");
    const Node& last = tab.nodes.back();
    EXPECT_EQ(last.kind, NodeKind::kResult);
    // mc goes through both calls of Set.
    const Node& second = tab.nodes[static_cast<size_t>(last.ports[0].from.node)];
    const Node& first = tab.nodes[static_cast<size_t>(second.ports[0].from.node)];
    EXPECT_EQ(first.title, ".Set");
    EXPECT_EQ(tab.nodes[static_cast<size_t>(first.ports[0].from.node)].title,
              "MaterialComposition");
}

TEST(Palette, FunctionsOfTheLibraryHavePictures) {
    const server::Analysis nothing({}, "", {});
    int shown = 0;
    int library = 0;
    for (const Entry& entry : entries_of(nothing)) {
        if (entry.kind != Entry::Kind::kLibrary || entry.module == "voronoi") continue;
        const bool value = entry.result == "float" || entry.result == "float3";
        library += value ? 1 : 0;
        JsonText out;
        ASSERT_TRUE(write_picture(entry.signature, entry.module, &out));
        const Result<JsonValue> json = parse_json(out.take(), "picture");
        ASSERT_TRUE(json);
        const JsonValue* values = member_of(*json, "values");
        if (values == nullptr) continue;
        ++shown;
        const double side = member_of(*json, "side")->number;
        const double channels = member_of(*json, "channels")->number;
        EXPECT_EQ(static_cast<double>(values->items.size()), side * side * channels)
            << entry.signature;
    }
    EXPECT_GT(shown, library / 2) << "of " << library;
    JsonText out;
    ASSERT_TRUE(write_picture("floatN sin(floatN x)", "", &out));
    const Result<JsonValue> sine = parse_json(out.take(), "picture");
    // sin(x / 3) from -12 to 12 mm, a pixel 0.75 mm wide: largest at 1.5 pi.
    const std::vector<JsonValue>& values = member_of(*sine, "values")->items;
    const auto largest = std::max_element(
        values.begin(), values.begin() + 32,
        [](const JsonValue& a, const JsonValue& b) { return a.number < b.number; });
    const double x = (static_cast<double>(largest - values.begin()) + 0.5) / 32 * 24 - 12;
    EXPECT_NEAR(std::sin(x / 3), 1, 0.02);
}

// The page's list of categories names what the picture of each is of.
TEST(Palette, CategoriesHavePictures) {
    const std::string words = read(testing::source_dir() / "tools/viewer/page/palette_words.js");
    const server::Analysis nothing({}, "", {});
    const std::vector<Entry> entries = entries_of(nothing);
    const std::regex shows("shows: \"(\\w+)\"");
    int found = 0;
    for (std::sregex_iterator it(words.begin(), words.end(), shows), end; it != end; ++it) {
        const std::string name = (*it)[1];
        const auto entry = std::find_if(entries.begin(), entries.end(),
                                        [&](const Entry& one) { return one.name == name; });
        ASSERT_NE(entry, entries.end()) << name;
        JsonText out;
        ASSERT_TRUE(write_picture(entry->signature, entry->module, &out));
        const Result<JsonValue> picture = parse_json(out.take(), "picture");
        const JsonValue* values = member_of(*picture, "values");
        ASSERT_NE(values, nullptr) << name;
        std::set<double> tones;
        for (const JsonValue& value : values->items)
            tones.insert(value.number);
        EXPECT_GT(tones.size(), 1U) << name;
        ++found;
    }
    EXPECT_EQ(found, 13);
}

}  // namespace
}  // namespace openfab::graph
