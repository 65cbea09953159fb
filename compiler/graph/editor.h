// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Carries out one action: private to compiler/graph. Values and wires are in edit_wires.cpp, nodes in edit_nodes.cpp,
// uniforms in edit_uniforms.cpp, functions made of nodes in edit_group.cpp.

#include <optional>
#include <set>
#include <string>
#include <utility>

#include "compiler/graph/edit.h"
#include "compiler/graph/rewrite.h"

namespace openfab::graph {

class Editor {
  public:
    Editor(const server::Analysis& analysis, const Graph& graph, const Action& action)
        : analysis_(analysis), graph_(graph), action_(action), rewrite_(analysis) {}
    Result<void> apply();
    Result<std::string> made() { return rewrite_.made(); }

  private:
    // edit_wires.cpp
    Result<void> set();
    Result<void> connect();
    Result<void> disconnect();
    /// Puts a text into a port, in brackets where it needs them.
    void put(const Node& node, const Port& port, const std::string& text);
    /// Makes a variable of what stands in a port, if it computes something: work is not lost with its wire.
    void keep(const Node& node, const Port& port);
    /// Returns a name by which a value can be used in a statement; declares one, and moves what comes too late.
    Result<std::string> name_in(const Source& value, int statement);
    Result<std::string> declare(const Source& value, uint32_t at);
    Result<void> move_before(const std::set<uint32_t>& needed, int from, int statement);
    bool depends(int node, int on) const;

    // edit_nodes.cpp
    Result<void> insert();
    Result<void> add();
    Result<void> paste();
    Result<void> remove();
    Result<void> name();
    Result<const Entry*> entry();
    Result<std::string> call(const Entry& entry, int given, const std::string& text);
    /// `before`: how many parameters of its type come before it.
    std::string argument(const Parameter& parameter, int before = 0) const;
    std::string place() const;
    /// The one after `before` others of the type, or the last.
    std::optional<std::string> uniform_of(std::string_view type, int before = 0) const;
    Result<void> rename(uint32_t declared, const std::string& name);
    uint32_t insertion(int before) const;

    // edit_uniforms.cpp
    Result<void> set_default();
    Result<void> expose();
    Result<void> add_uniform();
    Result<void> delete_uniform();
    Result<void> rename_uniform();
    Result<const Uniform*> uniform() const;
    Result<void> declare_uniform(int fablet, const std::string& text);

    // edit_group.cpp
    Result<void> group();

    Result<const Tab*> find_tab() const;
    Result<const Node*> find_node(int node) const;
    Result<const Port*> find_port() const;
    std::string source(const source::Span& span) const {
        return std::string(analysis_.sources().text(span));
    }

    const server::Analysis& analysis_;
    const Graph& graph_;
    const Action& action_;
    Rewrite rewrite_;
    const Tab* tab_ = nullptr;
    std::vector<Entry> entries_;
};

/// A name for what a node computes: `edge` of `voronoi_edge`, `sum` of `+`.
std::string name_for(const std::string& title);
std::string name_for(const Node& node);
/// Whether a variable can be declared with this type and a value.
bool can_be_declared(const std::string& type);

}  // namespace openfab::graph
