// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "base/at.h"
#include "compiler/graph/editor.h"

namespace openfab::graph {

void Editor::put(const Node& node, const Port& port, const std::string& text) {
    const bool joined = node.kind == NodeKind::kOperator || node.kind == NodeKind::kCall;
    // Beside an operator, and before a member, an expression of several operands stands in brackets.
    const bool operand =
        node.kind == NodeKind::kOperator && node.title != "[ ]" && node.title != "{ }";
    const bool object = joined && node.title.starts_with(".") && &port == node.ports.data();
    const bool write_object =
        node.kind == NodeKind::kWrite && node.title.starts_with(".") && &port == node.ports.data();
    const bool brackets = (operand || object || write_object) && !is_operand(text);
    rewrite_.replace(port.span, brackets ? "(" + text + ")" : text);
}

Result<void> Editor::set() {
    const Result<const Port*> port = find_port();
    if (!port) return port.error();
    if (const std::string why = why_no_expression(action_.text); !why.empty())
        return user_error(why);
    put(**find_node(action_.node), **port, action_.text);
    return {};
}

bool Editor::depends(int node, int on) const {
    std::vector<int> todo{node};
    std::set<int> seen;
    while (!todo.empty()) {
        const int one = todo.back();
        todo.pop_back();
        if (one == on) return true;
        if (!seen.insert(one).second) continue;
        for (const Port& port : tab_->nodes[static_cast<size_t>(one)].ports) {
            if (port.from.exists()) todo.push_back(port.from.node);
        }
    }
    return false;
}

Result<std::string> Editor::declare(const Source& value, uint32_t at) {
    const Node& node = tab_->nodes[static_cast<size_t>(value.node)];
    const std::string& type = node.outputs[static_cast<size_t>(value.output)].type;
    if (!can_be_declared(type)) {
        return user_error(fmt::format(
            "`{}` cannot be named: no variable holds {}", node.title,
            type.empty() ? std::string("a value of unknown type") : fmt::format("`{}`", type)));
    }
    const std::string name = rewrite_.fresh_name(name_for(node));
    const std::string text = rewrite_.expression(node.span);
    rewrite_.replace(node.span, name);
    rewrite_.insert(at, fmt::format("{} {} = {};\n", type, name, text));
    return name;
}

void Editor::keep(const Node& node, const Port& port) {
    if (!port.from.exists() || node.statement < 0) return;
    const Node& old = tab_->nodes[static_cast<size_t>(port.from.node)];
    const bool nested = !old.is_root && old.kind != NodeKind::kInput &&
                        old.span.begin >= port.span.begin && old.span.end <= port.span.end;
    if (!nested) return;
    // What cannot be declared is lost with its wire; undo brings it back.
    (void)declare(port.from, tab_->statements[static_cast<size_t>(node.statement)].lead);
}

Result<void> Editor::move_before(const std::set<uint32_t>& needed, int from, int statement) {
    const std::vector<Statement>& all = tab_->statements;
    std::set<uint32_t> wanted = needed;
    std::set<int> moved;
    // From the last to the first: what a moved statement reads is needed, too.
    for (int i = from; i >= statement; --i) {
        const Statement& one = at(all, i);
        const bool gives =
            std::any_of(one.writes.begin(), one.writes.end(),
                        [&](uint32_t variable) { return wanted.contains(variable); });
        if (!gives) continue;
        if (!one.is_simple || i == statement) {
            return user_error(
                fmt::format("the value is set after the place where it is wanted, by `{}`",
                            source(one.span).substr(0, source(one.span).find('\n'))),
                "move that up in the text");
        }
        moved.insert(i);
        wanted.insert(one.reads.begin(), one.reads.end());
    }
    for (int i = statement; i <= from; ++i) {
        if (moved.contains(i)) continue;
        for (const uint32_t variable : at(all, i).writes) {
            if (!wanted.contains(variable)) continue;
            return user_error("a value that this needs changes on the way down to it",
                              "give what it was a name of its own first");
        }
    }
    const uint32_t to = all[static_cast<size_t>(statement)].lead;
    for (const int i : moved) {
        const Statement& one = at(all, i);
        const std::string text = rewrite_.text({server::Analysis::kDocument, one.lead, one.tail});
        rewrite_.remove_line(one.lead, one.tail);
        rewrite_.insert(to, text + "\n");
    }
    return {};
}

Result<std::string> Editor::name_in(const Source& value, int statement) {
    const Node& node = tab_->nodes[static_cast<size_t>(value.node)];
    if (static_cast<size_t>(value.output) >= node.outputs.size())
        return user_error("there is no such output");
    const Output& output = node.outputs[static_cast<size_t>(value.output)];
    if (node.kind == NodeKind::kInput) {
        const std::map<uint32_t, Source>& before =
            tab_->statements[static_cast<size_t>(statement)].before;
        if (before.contains(node.declared.begin) && node.role != "attribute") {
            return user_error(fmt::format("`{}` has another value by then", node.title),
                              "give what it was a name of its own first");
        }
        return node.title;
    }
    if (output.variable != 0) {
        if (node.statement < statement) {
            const auto& before = tab_->statements[static_cast<size_t>(statement)].before;
            const auto held = before.find(output.variable);
            if (held != before.end() && held->second == value) return output.name;
            // It changes on the way: what it was gets a name where it is made.
            if (!can_be_declared(output.type))
                return user_error(fmt::format("`{}` has another value by then", output.name));
            const std::string name = rewrite_.fresh_name(output.name);
            rewrite_.insert(tab_->statements[static_cast<size_t>(node.statement)].tail,
                            fmt::format("\n{} {} = {};\n", output.type, name, output.name));
            return name;
        }
        if (Result<void> moved = move_before({output.variable}, node.statement, statement); !moved)
            return moved.error();
        return output.name;
    }
    if (node.statement <= statement)
        return declare(value, tab_->statements[static_cast<size_t>(node.statement)].lead);
    // Of a later statement only what this expression reads has to come with it.
    std::set<uint32_t> needed;
    for (const check::Use& use : analysis_.names()) {
        const bool inside = use.span.file == server::Analysis::kDocument &&
                            use.span.begin >= node.span.begin && use.span.end <= node.span.end;
        if (inside && use.declared.file == server::Analysis::kDocument &&
            use.kind == check::UseKind::kSymbol)
            needed.insert(use.declared.begin);
    }
    if (Result<void> moved = move_before(needed, node.statement - 1, statement); !moved)
        return moved.error();
    return declare(value, tab_->statements[static_cast<size_t>(statement)].lead);
}

Result<void> Editor::connect() {
    const Result<const Port*> port = find_port();
    if (!port) return port.error();
    const Result<const Node*> from = find_node(action_.from);
    if (!from) return from.error();
    const Node& node = **find_node(action_.node);
    if (depends(action_.from, action_.node))
        return user_error("that would make a loop: what the wire comes from needs this node");
    const Source value{action_.from, action_.output};
    if ((*port)->from == value && (*port)->suffix.empty()) return {};
    const Result<std::string> name = name_in(value, node.statement);
    if (!name) return name.error();
    if ((*port)->from.node != action_.from) keep(node, **port);
    put(node, **port, *name);
    return {};
}

Result<void> Editor::disconnect() {
    const Result<const Port*> port = find_port();
    if (!port) return port.error();
    const Node& node = **find_node(action_.node);
    if (!(*port)->from.exists()) return {};
    const std::string type = (*port)->wants.empty() ? (*port)->type : (*port)->wants;
    const std::string zero = zero_of(zero_of(type).empty() ? (*port)->type : type);
    if (zero.empty()) {
        return user_error(fmt::format("an input of type `{}` cannot be without a wire", type),
                          "connect another one to it");
    }
    keep(node, **port);
    put(node, **port, zero);
    return {};
}

}  // namespace openfab::graph
