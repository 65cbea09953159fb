// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Draws one stage or function: private to compiler/graph. Expressions become nodes and ports (expressions.cpp);
// statements say which variable holds what from when on (statement_nodes.cpp).

#include <optional>
#include <set>
#include <string>
#include <utility>

#include "compiler/graph/graph.h"
#include "compiler/server/answers.h"

namespace openfab::graph {

/// What the checker knows of a document, by place.
class Known {
  public:
    explicit Known(const server::Analysis& analysis);
    const server::Analysis& analysis() const { return analysis_; }
    /// Returns what a name refers to, or null.
    const check::Use* use(const source::Span& at) const;
    /// Returns the type of an expression; an error type if it is not known.
    check::Type type(const source::Span& at) const;
    std::string type_name(const source::Span& at) const;
    std::string text(const source::Span& at) const {
        return std::string(analysis_.sources().text(at));
    }

  private:
    using Place = std::pair<uint32_t, uint32_t>;
    const server::Analysis& analysis_;
    std::map<Place, const check::Use*> uses_;
    std::map<Place, check::Type> types_;
};

class TabBuilder {
  public:
    TabBuilder(const Known& known, Tab* tab) : known_(known), tab_(*tab) {}

    /// Draws the statements of a body, whose braces are known.
    void draw(const ast::Stmt& body);
    void set_outputs(std::set<uint32_t> outputs) { out_variables_ = std::move(outputs); }

  private:
    // expressions.cpp
    /// Says what stands in a port.
    void fill(Port* port, const ast::Expr& expr);
    /// Returns what an expression is a value of; nothing for what is not drawn.
    Source value_of(const ast::Expr& expr);
    Source name_value(const ast::Expr& name);
    Source input(const std::string& role, const std::string& title, const std::string& type,
                 const source::Span& declared, const std::string& help);
    Source node_of(const ast::Expr& expr);
    void call_node(const ast::Expr& call, int node);
    void method_node(const ast::Expr& call, int node);
    void add_port(int node, const std::string& label, const std::string& wants,
                  const ast::Expr& expr);
    int add_node(NodeKind kind, const std::string& title, const source::Span& span);
    bool is_attribute(const ast::Expr& member) const;
    /// Returns the variable that an expression is, or is a part of.
    std::optional<uint32_t> variable_of(const ast::Expr& expr) const;

    // statement_nodes.cpp
    void statement(const ast::Stmt& stmt);
    void declaration(const ast::Stmt& stmt);
    void expression(const ast::Stmt& stmt);
    void assignment(const ast::Expr& assign);
    void result(const ast::Stmt& stmt);
    void opaque(const ast::Stmt& stmt);
    void hold(uint32_t variable, const Source& value);
    bool is_drawn(const ast::Stmt& stmt) const;
    bool has_effects(const ast::Expr& expr) const;
    void collect(const ast::Stmt& stmt, std::set<uint32_t>* written) const;
    void collect(const ast::Expr& expr, std::set<uint32_t>* written) const;
    std::vector<uint32_t> out_arguments(const ast::Expr& call) const;
    std::set<uint32_t> variables_read(const source::Span& in) const;
    bool returns(const ast::Stmt& stmt) const;

    Statement& now() { return tab_.statements[at_]; }

    const Known& known_;
    Tab& tab_;
    size_t at_ = 0;
    std::map<uint32_t, Source> held_;
    std::map<uint32_t, std::string> names_;
    std::set<uint32_t> out_variables_;
};

}  // namespace openfab::graph
