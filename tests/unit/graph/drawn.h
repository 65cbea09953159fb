// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Graphs of texts, and texts written from graphs alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/graph/graph.h"

namespace openfab::graph {

struct Drawn {
    explicit Drawn(const std::string& text, const std::filesystem::path& file = {})
        : analysis(file, text, {}), graph(graph_of(analysis)) {}
    server::Analysis analysis;
    Graph graph;
};

inline std::string tokens_of(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string out;
    for (const syntax::Token& token : syntax::lex(sources, sources.add("test.fl", text), &sink))
        out += std::string(token.text) + "\n";
    return out;
}

/// Writes text from the graph alone: a node is its own text with what its ports hold in their places.
class Written {
  public:
    explicit Written(const Drawn& drawn) : drawn_(drawn) {}

    std::string all() {
        const std::string_view text = drawn_.analysis.sources().text(server::Analysis::kDocument);
        std::string out;
        uint32_t at = 0;
        std::vector<const Tab*> tabs;
        for (const Tab& tab : drawn_.graph.tabs)
            tabs.push_back(&tab);
        std::sort(tabs.begin(), tabs.end(),
                  [](const Tab* a, const Tab* b) { return a->open.begin < b->open.begin; });
        for (const Tab* tab : tabs) {
            tab_ = tab;
            for (const Statement& statement : tab->statements) {
                EXPECT_LE(at, statement.span.begin);
                out += text.substr(at, statement.span.begin - at);
                out += part(statement.span, nodes_at(statement.span));
                at = statement.span.end;
            }
        }
        return out + std::string(text.substr(at));
    }

  private:
    /// Nodes in a span, outermost first, that are in no other one.
    std::vector<const Node*> nodes_at(const source::Span& span) const {
        std::vector<const Node*> out;
        for (const Node& node : tab_->nodes) {
            const bool inside =
                node.statement >= 0 && node.span.begin >= span.begin && node.span.end <= span.end;
            const bool nested =
                std::any_of(tab_->nodes.begin(), tab_->nodes.end(), [&](const Node& other) {
                    return &other != &node && other.statement == node.statement &&
                           other.span.begin <= node.span.begin && other.span.end >= node.span.end &&
                           !(other.span == node.span && &other > &node);
                });
            if (inside && !nested) out.push_back(&node);
        }
        std::sort(out.begin(), out.end(),
                  [](const Node* a, const Node* b) { return a->span.begin < b->span.begin; });
        return out;
    }

    std::string part(const source::Span& span, const std::vector<const Node*>& nodes) {
        const std::string_view text = drawn_.analysis.sources().text(server::Analysis::kDocument);
        std::string out;
        uint32_t at = span.begin;
        for (const Node* node : nodes) {
            EXPECT_LE(at, node->span.begin);
            out += text.substr(at, node->span.begin - at);
            out += node_text(*node);
            at = node->span.end;
        }
        return out + std::string(text.substr(at, span.end - at));
    }

    std::string node_text(const Node& node) {
        const std::string_view text = drawn_.analysis.sources().text(server::Analysis::kDocument);
        std::string out;
        uint32_t at = node.span.begin;
        for (const Port& port : node.ports) {
            if (port.span.file != server::Analysis::kDocument) continue;
            EXPECT_LE(at, port.span.begin) << node.title;
            out += text.substr(at, port.span.begin - at);
            const Node* from =
                port.from.exists() ? &tab_->nodes[static_cast<size_t>(port.from.node)] : nullptr;
            const bool nested = from != nullptr && from->kind != NodeKind::kInput &&
                                from->span.begin >= port.span.begin &&
                                from->span.end <= port.span.end;
            if (nested) {
                EXPECT_TRUE(port.object == from->span || from->span == port.span) << node.title;
                out += text.substr(port.span.begin, from->span.begin - port.span.begin);
                out += node_text(*from);
                out += text.substr(from->span.end, port.span.end - from->span.end);
            } else {
                out += text.substr(port.span.begin, port.span.end - port.span.begin);
            }
            at = port.span.end;
        }
        return out + std::string(text.substr(at, node.span.end - at));
    }

    const Drawn& drawn_;
    const Tab* tab_ = nullptr;
};

inline const char* const kBall = R"(// A ball.
fablet Ball {
    @uniform {
        float skin = 0.5; // mm
        Material core, shell;
    }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        // How deep it is.
        float t = smoothstep(0.5, 1, -distance(attr.voxelCenter) / skin); // 0 outside
        mc.Set(core, t);
        mc.Set(shell, 1 - t);
        return mc;
    }
}
)";

inline int node_of(const Drawn& drawn, const std::string& title, int tab = 0) {
    const std::vector<Node>& nodes = drawn.graph.tabs[static_cast<size_t>(tab)].nodes;
    for (size_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].title == title) return static_cast<int>(i);
    }
    ADD_FAILURE() << "no node " << title;
    return -1;
}

}  // namespace openfab::graph
