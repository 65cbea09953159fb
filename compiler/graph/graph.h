// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A fablet as a graph. The text is the truth and the graph a view of it: every node and every port knows the bytes that
// it stands for, so that each change of the graph is an edit of the text (edit.h). Drawn are the statements of a stage or
// of a function: calls, operators and what variables hold are nodes, names and nested expressions are wires. A statement
// with control flow of its own is one node, with its text.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "compiler/server/analysis.h"

namespace openfab::graph {

enum class NodeKind : uint8_t {
    kInput,     ///< a uniform, constant, varying, parameter or attribute
    kCall,      ///< of a function, a method or a constructor
    kOperator,  ///< also `c ? a : b`, `a[i]`, casts
    kValue,     ///< a variable that holds a number, a list, or what another node gives
    kWrite,     ///< changes a variable: `x += 1`, `v.x = 0`, `mc.Set(a, 1)`
    kOpaque,    ///< statements that are drawn as one
    kResult,    ///< what the stage or function returns
};

/// A value of a node.
struct Source {
    int node = -1;
    int output = 0;
    bool exists() const { return node >= 0; }
    bool operator==(const Source&) const = default;
};

struct Port {
    std::string label;
    std::string type;  ///< of what is in it; empty if that is not known
    std::string
        wants;  ///< what the function takes: `float3`, or a form such as `floatN`; empty if it does not matter
    source::Span
        span;     ///< the expression in it; file 0 of a port that only shows what a statement reads
    Source from;  ///< nothing: the text stands in the port itself
    source::Span object;    ///< of a wire, what the node gives; `span` without the members behind
    std::string suffix;     ///< these members: ".xy"
    bool is_plain = false;  ///< a number, a list of numbers, a truth value
};

struct Output {
    std::string name;  ///< the variable that holds it; empty if none does
    std::string type;
    uint32_t variable = 0;  ///< where that is declared; 0: none
};

struct Node {
    NodeKind kind = NodeKind::kValue;
    std::string role;   ///< of an input: uniform, constant, varying, attribute, parameter, name
    std::string title;  ///< `smoothstep`, `+`, `attr.voxelCenter`
    std::string help;   ///< what is known of it, for people
    source::Span
        span;  ///< the expression; of an opaque one the statement; of an input its declaration
    source::Span declared;  ///< of the function, in whichever file
    int statement = -1;     ///< of the tab; -1: an input
    bool is_root = false;   ///< the whole of what its statement declares or assigns
    std::vector<Port> ports;
    std::vector<Output> outputs;
};

struct Statement {
    source::Span span;       ///< from its first to its last token
    uint32_t lead = 0;       ///< where a statement may be inserted before it: above its comments
    uint32_t tail = 0;       ///< the end of it and of a comment behind it on its line
    bool is_simple = false;  ///< declares one variable, and does nothing else
    std::vector<uint32_t> declares;  ///< the bytes at which its variables are declared
    std::vector<uint32_t> reads;     ///< variables, by where they are declared
    std::vector<uint32_t> writes;
    bool returns = false;
    std::map<uint32_t, Source> before;  ///< what each variable holds before it
};

/// A stage or a function.
struct Tab {
    std::string name;    ///< `@Volume`, `cone`
    std::string fablet;  ///< empty: outside of all
    int fablet_index = -1;
    bool is_stage = false;
    source::Span span;         ///< of the marker or name
    source::Span open, close;  ///< its braces
    std::vector<Statement> statements;
    std::vector<Node> nodes;
    /// What can be connected anywhere in it: inputs that are not nodes, too. Text and type.
    std::vector<Output> inputs;
};

/// A uniform of a fablet; its node is in the tabs that use it.
struct Uniform {
    std::string name, type, fablet;
    source::Span declared;
    source::Span init;  ///< file 0: none
    std::map<std::string, std::string> annotations;
    int uses = 0;
};

struct Graph {
    bool is_whole = true;  ///< all of the text could be parsed
    std::vector<Tab> tabs;
    std::vector<Uniform> uniforms;
};

/// Returns the graph of all stages and functions of a document.
Graph graph_of(const server::Analysis& analysis);

/// Writes a graph and the document's messages. Places are counted in UTF-16 code units, as scripts do.
void write_graph(const server::Analysis& analysis, const Graph& graph, JsonText* out);

/// True where messages hold an error.
bool has_errors(const std::vector<diag::Diagnostic>& messages);

}  // namespace openfab::graph
